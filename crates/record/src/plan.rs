//! `isolux-plan/1`: what to measure, in blocks.

mod sweep;

use camino::Utf8Path;
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::document::bounds::within;
use crate::document::{DocumentError, Fault, SourceText, read_text};
use crate::limits::{Limits, LimitsDocument};
use crate::reading::ReadingKind;
use crate::station::valid::block_distance;

pub use sweep::{Mode, Pass, PlaneTarget, RINGS, SPEED_DEG_S, Way, ring};

/// Value of `format` in a plan file.
pub const FORMAT: &str = "isolux-plan/1";

/// More points than this in one block are a slip of the pen.
const MOST_POINTS: usize = 10_000_000;

/// More readings of one point than this take hours and make no mean better.
const MOST_REPEATS: u32 = 10_000;

/// Peaks at which a spectrum has light above its noise and is below saturation, as shares of saturation.
const PEAK_COUNTS_REL: std::ops::RangeInclusive<f64> = 0.02..=0.85;

/// A valid plan: at least one block, every block with its grid spelt out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PlanDocument", into = "PlanDocument")]
pub struct Plan {
    document: PlanDocument,
    blocks: Vec<Block>,
    limits: Limits,
}

/// A plan file as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanDocument {
    /// [`FORMAT`].
    pub format: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What a sound bench keeps; without it the defaults of [`Limits`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitsDocument>,
    /// The blocks, in the order of their measurement.
    #[serde(default)]
    pub block: Vec<BlockDocument>,
}

/// One block as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockDocument {
    /// Unique name.
    pub name: String,
    /// What the detector can see.
    pub kind: ReadingKind,
    /// Which instrument reads.
    #[serde(default)]
    pub instrument: Instrument,
    /// Half-planes, a number or a list.
    #[serde(default, deserialize_with = "one_or_many", skip_serializing_if = "Option::is_none")]
    pub c_deg: Option<Vec<f64>>,
    /// Half-planes `[from, to, step]`, both ends included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c_range: Option<[f64; 3]>,
    /// γ, a number or a list.
    #[serde(default, deserialize_with = "one_or_many", skip_serializing_if = "Option::is_none")]
    pub gamma_deg: Option<Vec<f64>>,
    /// γ `[from, to, step]`, both ends included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma_range: Option<[f64; 3]>,
    /// Distance of the detector; without it the instrument's own of the station.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    /// Order of γ within the half-planes.
    #[serde(default)]
    pub order: Order,
    /// A visit to the reference point (C 0°, γ 0°) before the block, after every so many points, and at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_every: Option<u32>,
    /// At rest, or in motion.
    #[serde(default, skip_serializing_if = "is_default")]
    pub mode: Mode,
    /// Speed of γ in a sweep, °/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_deg_s: Option<f64>,
    /// Half-planes are chosen from those of `c_deg` until this is reached; without it all are swept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<PlaneTarget>,
    /// Rings show first whether the symmetry that the half-planes assume holds: to so much of the largest light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub symmetry_max_rel: Option<f64>,
    /// A second sweep of every half-plane, within the beam, has this speed, °/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beam_speed_deg_s: Option<f64>,
    /// Light below so many digits of the range that a sweep holds is swept again in a more sensitive one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dim_digits: Option<f64>,
    /// Readings a point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<u32>,
    /// Or: readings until the mean's relative standard uncertainty is at most this.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rel: Option<f64>,
    /// Peak of the raw counts of a spectrum that the integration time aims at, as a share of saturation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_counts_rel: Option<f64>,
    /// What a person is asked to do before the block; the axes are stopped while they do it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prompt: Option<String>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Which instrument reads a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instrument {
    /// The lux meter.
    #[default]
    Luxmeter,
    /// The spectroradiometer.
    Spectroradiometer,
}

/// Order of γ within the half-planes of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// γ as the block lists it, in every half-plane.
    #[default]
    Forward,
    /// γ from its last value to its first, in every half-plane.
    Reverse,
    /// Forward in the first half-plane, reverse in the next, and so on: the least travel.
    Serpentine,
    /// Every half-plane forward, then reverse: every direction is read once in each direction of travel.
    Both,
}

/// How often a point is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Repeats {
    /// So many times.
    Exactly(u32),
    /// Until the mean's relative standard uncertainty is at most this fraction.
    Until(f64),
}

/// One valid block.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Block {
    /// Unique name.
    pub name: String,
    /// What the detector can see.
    pub kind: ReadingKind,
    /// Which instrument reads.
    pub instrument: Instrument,
    /// Half-planes in order, degrees.
    pub c_deg: Vec<f64>,
    /// γ in order, degrees.
    pub gamma_deg: Vec<f64>,
    /// Distance of the detector; none: the instrument's own.
    pub distance_mm: Option<f64>,
    /// Order of γ.
    pub order: Order,
    /// Speed of γ in °/s where the block is read in motion.
    pub sweep_deg_s: Option<f64>,
    /// What its half-planes are chosen for, where not all of them are swept.
    pub target: Option<PlaneTarget>,
    /// Largest difference, in shares of the largest light, that rings may show from the symmetry that the half-planes
    /// assume; none where no ring asks.
    pub symmetry_max_rel: Option<f64>,
    /// Speed of a second sweep of every half-plane within the beam, °/s.
    pub beam_speed_deg_s: Option<f64>,
    /// Digits of the range that a sweep holds below which light is swept again in a more sensitive one.
    pub dim_digits: Option<f64>,
    /// Points between two visits to the reference point.
    pub reference_every: Option<u32>,
    /// How often a point is read.
    pub repeats: Repeats,
    /// Peak of the raw counts that a spectrum aims at, as a share of saturation; none: the engine's own.
    pub peak_counts_rel: Option<f64>,
    /// What a person is asked to do first.
    pub prompt: Option<String>,
}

impl Block {
    /// Half-planes that are read at `c_deg`, of the block or some of them, rising in [0, 360): those at γ < 0° lie
    /// opposite.
    pub fn half_planes_deg(&self, c_deg: &[f64]) -> Vec<f64> {
        let reads = |is_side: fn(&f64) -> bool| self.gamma_deg.iter().any(is_side);
        let (here, opposite) = (reads(|gamma| *gamma >= 0.0), reads(|gamma| *gamma < 0.0));
        let of = |c: &f64| {
            let sides = [here.then_some(*c), opposite.then_some(c + 180.0)];
            sides.into_iter().flatten().map(|c| c.rem_euclid(360.0))
        };
        let mut half_planes: Vec<f64> = c_deg.iter().flat_map(of).collect();
        half_planes.sort_by(f64::total_cmp);
        half_planes.dedup();
        half_planes
    }

    /// The sweeps of a block that is read in motion, in their order; none of one that is read at rest.
    pub fn passes(&self) -> Vec<Pass> {
        self.sweep_deg_s.map_or_else(Vec::new, |speed| {
            let rings = match (self.target, self.symmetry_max_rel) {
                (Some(_), _) => sweep::Rings::BehindThePair,
                (None, Some(_)) => sweep::Rings::BehindTheFirst,
                (None, None) => sweep::Rings::None,
            };
            // The pair within the beam is the slow one then.
            let with_slow_pair = self.beam_speed_deg_s.is_none();
            sweep::passes(&self.c_deg, &self.gamma_deg, speed, with_slow_pair, rings)
        })
    }
}

impl Plan {
    /// Reads and validates a plan file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn load(file: &Utf8Path) -> Result<Self, DocumentError> {
        Self::parse(file, &read_text(file)?)
    }

    /// Validates the text of a plan file; `file` is for messages.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        let source = SourceText { file, text };
        Self::try_from(source.parse::<PlanDocument>(FORMAT)?).map_err(|fault| source.locate(&fault))
    }

    /// The blocks, at least one.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Beyond these, readings are measured again or refused.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The file's content, for a copy of it.
    pub fn document(&self) -> &PlanDocument {
        &self.document
    }
}

impl TryFrom<PlanDocument> for Plan {
    type Error = Fault;

    fn try_from(document: PlanDocument) -> Result<Self, Fault> {
        if document.block.is_empty() {
            return Err(Fault::new("block", "the plan has no [[block]]; add one"));
        }
        let mut blocks: Vec<Block> = Vec::with_capacity(document.block.len());
        for (index, block) in document.block.iter().enumerate() {
            let valid = validate(&format!("block.{index}"), block)?;
            if blocks.iter().any(|earlier| earlier.name == valid.name) {
                return Err(Fault::new(
                    format!("block.{index}.name"),
                    format!("`{}` is used twice", valid.name),
                ));
            }
            blocks.push(valid);
        }
        let limits = document
            .limits
            .as_ref()
            .map_or(Ok(Limits::default()), Limits::try_from)?;
        Ok(Self {
            document,
            blocks,
            limits,
        })
    }
}

impl From<Plan> for PlanDocument {
    fn from(plan: Plan) -> Self {
        plan.document
    }
}

fn validate(path: &str, block: &BlockDocument) -> Result<Block, Fault> {
    let key = |name: &str| format!("{path}.{name}");
    if block.name.trim().is_empty() || block.name.chars().any(|c| c.is_control() || c == ',' || c == '"') {
        return Err(Fault::new(
            key("name"),
            "is a word without commas, quotes and line ends",
        ));
    }
    let c_deg = grid(path, ("c_deg", block.c_deg.as_deref()), ("c_range", block.c_range))?;
    let gamma_deg = grid(
        path,
        ("gamma_deg", block.gamma_deg.as_deref()),
        ("gamma_range", block.gamma_range),
    )?;
    if let Some(&outside) = gamma_deg.iter().find(|gamma| gamma.abs() > 180.0) {
        let name = if block.gamma_deg.is_some() {
            "gamma_deg"
        } else {
            "gamma_range"
        };
        return Err(Fault::new(key(name), format!("{outside}° is outside −180°…180°")));
    }
    if c_deg.len().saturating_mul(gamma_deg.len()) > MOST_POINTS {
        return Err(Fault::new(
            path,
            format!("has more than {MOST_POINTS} points; check the steps"),
        ));
    }
    let sweep_deg_s = sweep::speed(path, block, &gamma_deg)?;
    let beam_speed_deg_s = sweep::beam_speed(path, block, sweep_deg_s)?;
    let target = sweep::target(path, block, &c_deg, &gamma_deg)?;
    if let Some(distance) = block.distance_mm {
        block_distance(&key("distance_mm"), distance)?;
    }
    let repeats = match (block.repeats, block.u_rel) {
        (Some(_), Some(_)) => return Err(Fault::new(key("u_rel"), "give `repeats` or `u_rel`, not both")),
        (Some(0), None) => return Err(Fault::new(key("repeats"), "is 0, expected at least 1")),
        (Some(count), None) if count > MOST_REPEATS => {
            let message = format!("is {count}, expected 1 to {MOST_REPEATS}");
            return Err(Fault::new(key("repeats"), message));
        }
        (Some(count), None) => Repeats::Exactly(count),
        (None, Some(u)) if u.is_finite() && u > 0.0 && u < 1.0 => Repeats::Until(u),
        (None, Some(u)) => {
            return Err(Fault::new(
                key("u_rel"),
                format!("is {u}, expected a fraction between 0 and 1"),
            ));
        }
        (None, None) => Repeats::Exactly(1),
    };
    if block.reference_every == Some(0) {
        return Err(Fault::new(
            key("reference_every"),
            "is 0; give the points between two visits, or leave it out",
        ));
    }
    if block.instrument == Instrument::Spectroradiometer && block.reference_every.is_some() {
        return Err(Fault::new(key("reference_every"), "belongs to blocks of the lux meter"));
    }
    if block.reference_every.is_some() && block.kind != ReadingKind::Lit {
        return Err(Fault::new(
            key("reference_every"),
            "belongs to lit blocks: the reference point is a lit reading",
        ));
    }
    if let Some(aim) = block.peak_counts_rel {
        let path = key("peak_counts_rel");
        if block.instrument != Instrument::Spectroradiometer {
            return Err(Fault::new(path, "belongs to blocks of the spectroradiometer"));
        }
        within(&path, aim, PEAK_COUNTS_REL, " of saturation")?;
    }
    if block.prompt.as_ref().is_some_and(|prompt| prompt.trim().is_empty()) {
        return Err(Fault::new(
            key("prompt"),
            "is empty; write what the person is to do, or leave it out",
        ));
    }
    Ok(Block {
        name: block.name.clone(),
        kind: block.kind,
        instrument: block.instrument,
        c_deg,
        gamma_deg,
        distance_mm: block.distance_mm,
        order: block.order,
        sweep_deg_s,
        target,
        symmetry_max_rel: sweep::symmetry_max_rel(path, block)?,
        beam_speed_deg_s,
        dim_digits: sweep::dim_digits(path, block)?,
        reference_every: block.reference_every,
        repeats,
        peak_counts_rel: block.peak_counts_rel,
        prompt: block.prompt.clone(),
    })
}

fn grid(path: &str, list: (&str, Option<&[f64]>), range: (&str, Option<[f64; 3]>)) -> Result<Vec<f64>, Fault> {
    let fault = |name: &str, message: String| Err(Fault::new(format!("{path}.{name}"), message));
    match (list.1, range.1) {
        (Some(_), Some(_)) => fault(range.0, format!("give `{}` or `{}`, not both", list.0, range.0)),
        (None, None) => fault(
            list.0,
            format!("give `{}` = [..] or `{}` = [from, to, step]", list.0, range.0),
        ),
        (Some(angles), None) => {
            if angles.is_empty() {
                return fault(list.0, "is empty".to_owned());
            }
            match angles.iter().find(|angle| !angle.is_finite()) {
                Some(angle) => fault(list.0, format!("{angle} is no angle")),
                None => Ok(angles.to_vec()),
            }
        }
        (None, Some([from, to, step])) => {
            if !(from.is_finite() && to.is_finite() && step.is_finite()) || step == 0.0 {
                return fault(
                    range.0,
                    "is [from, to, step], finite, with a step other than 0".to_owned(),
                );
            }
            let steps = (to - from) / step;
            if steps < -1e-9 {
                return fault(range.0, format!("a step of {step}° never comes from {from}° to {to}°"));
            }
            if steps > MOST_POINTS as f64 {
                return fault(range.0, format!("has more than {MOST_POINTS} angles; check the step"));
            }
            if (steps - steps.round()).abs() > 1e-6 {
                return fault(
                    range.0,
                    format!("steps of {step}° do not lead from {from}° to {to}°; change one of the three"),
                );
            }
            // Multiples, not sums; and the decimals that a person would write.
            Ok((0..=steps.round() as usize)
                .map(|i| ((from + i as f64 * step) * 1e9).round() / 1e9 + 0.0)
                .collect())
        }
    }
}

fn one_or_many<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    struct OneOrMany;
    impl<'de> Visitor<'de> for OneOrMany {
        type Value = Vec<f64>;
        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("an angle in degrees or a list of them")
        }
        fn visit_f64<E>(self, angle: f64) -> Result<Vec<f64>, E> {
            Ok(vec![angle])
        }
        fn visit_i64<E>(self, angle: i64) -> Result<Vec<f64>, E> {
            Ok(vec![angle as f64])
        }
        fn visit_seq<A: SeqAccess<'de>>(self, mut angles: A) -> Result<Vec<f64>, A::Error> {
            let mut list = Vec::new();
            while let Some(angle) = angles.next_element()? {
                list.push(angle);
            }
            Ok(list)
        }
    }
    deserializer.deserialize_any(OneOrMany).map(Some)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 360, 15]
gamma_range = [0.0, 180.0, 2.0]
reference_every = 91
[[block]]
name = "cap"
kind = "capped"
c_deg = 0
gamma_deg = [0.0]
repeats = 20
"#;

    fn complaint(from: &str, to: &str) -> String {
        assert!(PLAN.contains(from));
        Plan::parse(Utf8Path::new("p.toml"), &PLAN.replacen(from, to, 1))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn spells_out_the_grid_of_the_day() {
        let plan = Plan::parse(Utf8Path::new("p.toml"), PLAN).unwrap();
        let illuminated = &plan.blocks()[0];
        assert_eq!((illuminated.c_deg.len(), illuminated.gamma_deg.len()), (25, 91));
        assert_eq!((illuminated.c_deg[24], illuminated.gamma_deg[90]), (360.0, 180.0));
        assert_eq!(plan.blocks()[1].c_deg, [0.0]);
        let tenths = PLAN.replace("[0.0, 180.0, 2.0]", "[-1.0, 1.0, 0.1]");
        let plan = Plan::parse(Utf8Path::new("p.toml"), &tenths).unwrap();
        assert_eq!(
            plan.blocks()[0].gamma_deg[13],
            0.3,
            "decimals as written, not as summed"
        );
        let written = toml::to_string(&plan).unwrap();
        assert_eq!(Plan::parse(Utf8Path::new("again.toml"), &written).unwrap(), plan);
    }

    #[test]
    fn a_block_of_sweeps_has_a_pair_at_two_speeds_and_alternates() {
        let sweeps = PLAN
            .replace("[0, 360, 15]", "[0, 165, 15]")
            .replace(
                "[0.0, 180.0, 2.0]",
                "[-180, 180, 2]\nmode = \"sweep\"\nspeed_deg_s = 8.0",
            )
            .replace("reference_every = 91", "reference_every = 6");
        let plan = Plan::parse(Utf8Path::new("p.toml"), &sweeps).unwrap();
        let passes = plan.blocks()[0].passes();
        assert_eq!(passes.len(), 4 + 11);
        assert_eq!(
            (passes[0].way.moving_deg(), passes[1].way.moving_deg()),
            ([-180.0, 180.0], [180.0, -180.0])
        );
        assert_eq!(
            (passes[2].way.moving_deg(), passes[3].speed_deg_s),
            ([-60.0, 60.0], 4.0)
        );
        assert!(
            passes.windows(2).all(|pair| pair[0].way.sign() == -pair[1].way.sign()),
            "each begins where the last ended"
        );
        // 8 °/s at 40 °/s²: 0.8° of ramp and 2° of cruise.
        assert_eq!(passes[1].ends_deg(40.0), [182.8, -182.8]);
        assert!(plan.blocks()[1].passes().is_empty());
        let written = toml::to_string(&plan).unwrap();
        assert_eq!(Plan::parse(Utf8Path::new("again.toml"), &written).unwrap(), plan);
        for (from, to, word) in [
            ("kind = \"lit\"", "kind = \"baffled\"", "lit readings"),
            ("speed_deg_s = 8.0", "speed_deg_s = 0.0", "above 0"),
            ("speed_deg_s = 8.0", "repeats = 3", "slower"),
            ("speed_deg_s = 8.0", "order = \"reverse\"", "alternate"),
            ("mode = \"sweep\"\n", "", "belongs to blocks"),
            ("[-180, 180, 2]", "[180, -180, -2]", "rising"),
        ] {
            let text = sweeps.replacen(from, to, 1).replace("reference_every = 6\n", "");
            let error = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap_err().to_string();
            assert!(error.contains(word), "{to}: {error}");
        }
    }

    #[test]
    fn second_sweeps_are_slow_enough_and_take_the_place_of_the_slow_pair() {
        let second = PLAN
            .replace("[0, 360, 15]", "[0, 165, 15]")
            .replace(
                "[0.0, 180.0, 2.0]",
                "[-180, 180, 2]\nmode = \"sweep\"\nbeam_speed_deg_s = 6.0\ndim_digits = 20.0",
            )
            .replace("reference_every = 91\n", "");
        let plan = Plan::parse(Utf8Path::new("p.toml"), &second).unwrap();
        let block = &plan.blocks()[0];
        assert_eq!((block.beam_speed_deg_s, block.dim_digits), (Some(6.0), Some(20.0)));
        let passes = block.passes();
        assert_eq!(passes.len(), 2 + 11);
        assert!(passes.iter().all(|pass| pass.speed_deg_s == SPEED_DEG_S));
        let written = toml::to_string(&plan).unwrap();
        assert_eq!(Plan::parse(Utf8Path::new("again.toml"), &written).unwrap(), plan);
        let line = |key: &str| {
            let before = second.lines().position(|line| line.starts_with(key));
            format!("p.toml:{}:", before.unwrap() + 1)
        };
        for (from, to, at, word) in [
            (
                "beam_speed_deg_s = 6.0",
                "beam_speed_deg_s = 9.0",
                "beam_speed",
                "at most 8.40 °/s",
            ),
            (
                "beam_speed_deg_s = 6.0",
                "beam_speed_deg_s = 0.0",
                "beam_speed",
                "above 0",
            ),
            (
                "beam_speed_deg_s = 6.0",
                "beam_speed_deg_s = nan",
                "beam_speed",
                "above 0",
            ),
            ("dim_digits = 20.0", "dim_digits = 0.5", "dim_digits", "1 to 100"),
            ("dim_digits = 20.0", "dim_digits = 1e9", "dim_digits", "1 to 100"),
        ] {
            let text = second.replacen(from, to, 1);
            let error = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap_err().to_string();
            assert!(error.starts_with(&line(at)) && error.contains(word), "{to}: {error}");
        }
        let at_rest = second.replacen("mode = \"sweep\"\n", "", 1);
        for (other, word) in [
            ("dim_digits = 20.0", "beam_speed_deg_s"),
            ("beam_speed_deg_s = 6.0", "dim_digits"),
        ] {
            let text = at_rest.replacen(other, "", 1);
            let error = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("belongs to blocks"), "{error}");
        }
    }

    #[test]
    fn half_planes_are_chosen_from_those_all_round() {
        let chosen = PLAN
            .replace("[0, 360, 15]", "[0, 175, 5]")
            .replace(
                "[0.0, 180.0, 2.0]",
                "[-180, 180, 2]\nmode = \"sweep\"\ntarget = { u_map_rel = 0.02 }",
            )
            .replace("reference_every = 91\n", "");
        let plan = Plan::parse(Utf8Path::new("p.toml"), &chosen).unwrap();
        let block = &plan.blocks()[0];
        assert_eq!(block.target, Some(PlaneTarget::UMapRel(0.02)));
        let passes = block.passes();
        assert_eq!(passes.len(), 4 + RINGS + 35);
        assert!(passes[4].way.half_plane_deg().is_none() && passes[4].ends_deg(40.0)[1] < 365.0);
        let written = toml::to_string(&plan).unwrap();
        assert_eq!(Plan::parse(Utf8Path::new("again.toml"), &written).unwrap(), plan);
        for (from, to, word) in [
            ("u_map_rel = 0.02", "u_map_rel = 0.0", "0.0001 to 0.5"),
            ("u_map_rel = 0.02", "u_mean_rel = 0.02", "u_mean_rel"),
            ("[0, 175, 5]", "[0, 90, 5]", "all round"),
            ("[0, 175, 5]", "[0, 140, 35]", "all round"),
            ("[-180, 180, 2]", "[-90, 180, 2]", "both sides"),
            ("mode = \"sweep\"\n", "", "belongs to blocks"),
        ] {
            let text = chosen.replacen(from, to, 1);
            let error = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap_err().to_string();
            assert!(error.contains(word), "{to}: {error}");
        }
    }

    #[test]
    fn rings_for_a_symmetry_follow_the_first_sweep() {
        let rings = PLAN.replace("[0, 360, 15]", "[0, 90, 15]").replace(
            "[0.0, 180.0, 2.0]",
            "[0, 180, 2]\nmode = \"sweep\"\nsymmetry_max_rel = 0.01",
        );
        let passes = Plan::parse(Utf8Path::new("p.toml"), &rings).unwrap().blocks()[0].passes();
        let is_ring = |pass: &Pass| pass.way.half_plane_deg().is_none();
        assert_eq!(passes.iter().position(is_ring), Some(1));
        assert_eq!(
            (passes.len(), passes.iter().filter(|pass| is_ring(pass)).count()),
            (4 + RINGS + 6, RINGS)
        );
        for (from, to, word) in [
            ("symmetry_max_rel = 0.01", "symmetry_max_rel = 1.0", "0.001 to 0.2"),
            ("mode = \"sweep\"\n", "", "belongs to blocks"),
            (
                "mode = \"sweep\"\n",
                "mode = \"sweep\"\ntarget = { u_map_rel = 0.02 }\n",
                "all round",
            ),
        ] {
            let text = rings.replacen(from, to, 1);
            let error = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap_err().to_string();
            assert!(error.contains(word), "{to}: {error}");
        }
    }

    #[test]
    fn refuses_with_line_and_remedy() {
        assert!(complaint("kind = \"lit\"", "kind = \"light\"").starts_with("p.toml:4:8:"));
        assert!(complaint("[0.0, 180.0, 2.0]", "[0.0, 180.0, 7.0]").starts_with("p.toml:6:1: block.0.gamma_range"));
        assert!(complaint("[0.0, 180.0, 2.0]", "[0.0, 180.0, -2.0]").starts_with("p.toml:6:1:"));
        assert!(complaint("[0.0, 180.0, 2.0]", "[0.0, 190.0, 2.0]").contains("outside"));
        assert!(complaint("[0.0, 180.0, 2.0]", "[0.0, nan, 2.0]").starts_with("p.toml:6:1:"));
        assert!(complaint("repeats = 20", "repeats = 0").starts_with("p.toml:13:1:"));
        assert!(complaint("repeats = 20", "repeats = 4000000000").starts_with("p.toml:13:1: block.1.repeats"));
        assert!(complaint("repeats = 20", "distance_mm = 1e308").contains("expected 1 to 1000000 mm"));
        assert!(complaint("repeats = 20", "distance_mm = inf").starts_with("p.toml:13:1:"));
        assert!(complaint("repeats = 20", "repeat = 20").starts_with("p.toml:13:1: unknown field"));
        assert!(complaint("name = \"cap\"", "name = \"lit\"").contains("used twice"));
        assert!(complaint("gamma_deg = [0.0]\n", "").starts_with("p.toml:8:"));
        assert!(Plan::parse(Utf8Path::new("p.toml"), "format = \"isolux-plan/1\"").is_err());
    }
}
