//! A block that is read in motion: its sweeps of γ, in their order.

use serde::{Deserialize, Serialize};

use super::{BlockDocument, Instrument, Order};
use crate::document::Fault;
use crate::reading::ReadingKind;

/// How a block is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Every direction at rest: the reference.
    #[default]
    Step,
    /// While γ moves through each half-plane.
    Sweep,
}

/// Speed of a block of sweeps where it states none, °/s: run-up and run-out take 4.8° at 40 °/s².
pub const SPEED_DEG_S: f64 = 12.0;
/// The slow pair that separates delay and backlash reaches so far to both sides of γ = 0°, degrees.
const SLOW_REACH_DEG: f64 = 60.0;
/// Share of the block's speed that it has.
const SLOW_SHARE: f64 = 0.5;

/// What a sweep goes along. Run-up and run-out lie outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// γ moves while C rests.
    HalfPlane {
        /// The half-plane, degrees.
        c_deg: f64,
        /// γ from and to, degrees.
        gamma_deg: [f64; 2],
    },
    /// C moves while γ rests.
    Ring {
        /// γ, degrees.
        gamma_deg: f64,
        /// C from and to, degrees.
        c_deg: [f64; 2],
    },
}

impl Way {
    /// From and to of the axis that moves, degrees.
    pub fn moving_deg(&self) -> [f64; 2] {
        match self {
            Self::HalfPlane { gamma_deg, .. } => *gamma_deg,
            Self::Ring { c_deg, .. } => *c_deg,
        }
    }

    /// +1 where the axis that moves goes to larger angles, −1 where to smaller ones.
    pub fn sign(&self) -> f64 {
        let [from, to] = self.moving_deg();
        (to - from).signum()
    }

    /// The half-plane that is swept; none for a ring.
    pub fn half_plane_deg(&self) -> Option<f64> {
        match self {
            Self::HalfPlane { c_deg, .. } => Some(*c_deg),
            Self::Ring { .. } => None,
        }
    }

    /// (C, γ) where the axis that moves is at `moving_deg`, degrees.
    pub fn at_deg(&self, moving_deg: f64) -> (f64, f64) {
        match self {
            Self::HalfPlane { c_deg, .. } => (*c_deg, moving_deg),
            Self::Ring { gamma_deg, .. } => (moving_deg, *gamma_deg),
        }
    }
}

/// One sweep, at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// What it goes along.
    pub way: Way,
    /// Cruising speed, °/s.
    pub speed_deg_s: f64,
    /// Range of the meter, where it is a more sensitive one than the largest light of the lamp needs.
    pub range: Option<u8>,
}

impl Pass {
    /// Where the axis that moves starts from and is sent to: so far outside that it cruises within, with a quarter of a
    /// second for its swing, at the acceleration `accel_deg_s2`. Degrees.
    pub fn ends_deg(&self, accel_deg_s2: f64) -> [f64; 2] {
        let ramp = 0.5 * self.speed_deg_s * self.speed_deg_s / accel_deg_s2 + 0.25 * self.speed_deg_s;
        let [from, to] = self.way.moving_deg();
        [from - self.way.sign() * ramp, to + self.way.sign() * ramp]
    }

    /// (C, γ) where it begins to be read, degrees.
    pub fn from_deg(&self) -> (f64, f64) {
        self.way.at_deg(self.way.moving_deg()[0])
    }

    /// (C, γ) where it was read last, degrees.
    pub fn to_deg(&self) -> (f64, f64) {
        self.way.at_deg(self.way.moving_deg()[1])
    }
}

/// Half-planes from which some are chosen are no farther apart, degrees.
const MOST_STEP_DEG: f64 = 30.0;

/// What the half-planes of a block of sweeps are chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum PlaneTarget {
    /// Standard uncertainty (k = 1) of the interpolation over C anywhere, in shares of the largest light.
    UMapRel(f64),
    /// The same of the flux, relative.
    UFluxRel(f64),
}

/// Rings that are swept before the half-planes are chosen.
pub const RINGS: usize = 4;
/// A ring goes all round, in this direction first, degrees.
const ROUND_DEG: [f64; 2] = [0.0, 360.0];

/// A ring at γ, forward or back.
pub fn ring(gamma_deg: f64, forward: bool, speed_deg_s: f64) -> Pass {
    let [from, to] = ROUND_DEG;
    Pass {
        way: Way::Ring {
            gamma_deg,
            c_deg: if forward { [from, to] } else { [to, from] },
        },
        speed_deg_s,
        range: None,
    }
}

/// The speed of a block of sweeps; none for one that is read at rest.
///
/// # Errors
/// [`Fault`] for a key that does not go with sweeps.
pub(super) fn speed(path: &str, block: &BlockDocument, gamma_deg: &[f64]) -> Result<Option<f64>, Fault> {
    let fault = |key: &str, message: &str| Err(Fault::new(format!("{path}.{key}"), message));
    if block.mode == Mode::Step {
        let given = [
            ("speed_deg_s", block.speed_deg_s.is_some()),
            ("target", block.target.is_some()),
            ("symmetry_max_rel", block.symmetry_max_rel.is_some()),
            ("beam_speed_deg_s", block.beam_speed_deg_s.is_some()),
            ("dim_digits", block.dim_digits.is_some()),
        ];
        return match given.iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) => fault(key, "belongs to blocks with mode = \"sweep\""),
            None => Ok(None),
        };
    }
    if block.kind != ReadingKind::Lit || block.instrument != Instrument::Luxmeter {
        return fault(
            "mode",
            "sweeps are lit readings of the lux meter; leave `mode` out of this block",
        );
    }
    if block.repeats.is_some() || block.u_rel.is_some() {
        let key = if block.repeats.is_some() { "repeats" } else { "u_rel" };
        return fault(
            key,
            "does not go with mode = \"sweep\": a slower `speed_deg_s` reads more often",
        );
    }
    if block.order != Order::Forward {
        return fault("order", "does not go with mode = \"sweep\": directions alternate");
    }
    if gamma_deg.len() < 4 || gamma_deg.windows(2).any(|pair| pair[0] >= pair[1]) {
        let key = if block.gamma_deg.is_some() {
            "gamma_deg"
        } else {
            "gamma_range"
        };
        return fault(
            key,
            "a sweep needs at least four γ, rising; −180 to 180 gives two half-planes a sweep",
        );
    }
    match block.speed_deg_s {
        Some(speed) if !(speed.is_finite() && speed > 0.0 && speed <= 360.0) => {
            fault("speed_deg_s", "is above 0 and at most 360 °/s")
        }
        speed => Ok(Some(speed.unwrap_or(SPEED_DEG_S))),
    }
}

/// What the half-planes of a block of sweeps are chosen for; none where all of them are swept.
///
/// # Errors
/// [`Fault`] for a value out of range, and for half-planes that are not all of the circle: what is left out could not
/// be seen.
pub(super) fn target(
    path: &str,
    block: &BlockDocument,
    c_deg: &[f64],
    gamma_deg: &[f64],
) -> Result<Option<PlaneTarget>, Fault> {
    let Some(target) = block.target else { return Ok(None) };
    let fault = |key: &str, message: String| Err(Fault::new(format!("{path}.{key}"), message));
    let (PlaneTarget::UMapRel(wanted) | PlaneTarget::UFluxRel(wanted)) = target;
    if !(wanted.is_finite() && (1e-4..=0.5).contains(&wanted)) {
        return fault("target", format!("is {wanted}, expected 0.0001 to 0.5"));
    }
    let (low, high) = (
        gamma_deg.first().copied().unwrap_or(0.0),
        gamma_deg.last().copied().unwrap_or(0.0),
    );
    let both = low < 0.0;
    if both
        && gamma_deg
            .iter()
            .zip(gamma_deg.iter().rev())
            .any(|(a, b)| (a + b).abs() > 1e-6)
    {
        return fault(
            "gamma_deg|gamma_range",
            format!(
                "goes from {low}° to {high}°: where half-planes are chosen both sides have the same γ, as −180 \
                 to 180"
            ),
        );
    }
    let circle = if both { 180.0 } else { 360.0 };
    let round = c_deg.first().copied().zip(c_deg.last().copied());
    let widest = c_deg.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let closes = round.is_some_and(|(first, last)| {
        let gap = first + circle - last;
        first >= 0.0 && gap > 0.0 && gap <= widest.max(1e-9) * (1.0 + 1e-6)
    });
    if c_deg.windows(2).any(|pair| pair[0] >= pair[1]) || widest > MOST_STEP_DEG || !closes {
        return fault(
            "c_deg|c_range",
            format!(
                "where half-planes are chosen, it lists those that may be: all round, rising, at most \
                 {MOST_STEP_DEG}° apart, as [0, {}, 5] with this γ",
                circle - 5.0
            ),
        );
    }
    Ok(Some(target))
}

/// How far rings may show the light to differ from the symmetry that the half-planes assume.
///
/// # Errors
/// [`Fault`] for a value out of range, and for half-planes that are chosen all round: those assume nothing.
pub(super) fn symmetry_max_rel(path: &str, block: &BlockDocument) -> Result<Option<f64>, Fault> {
    let fault = |message: String| Err(Fault::new(format!("{path}.symmetry_max_rel"), message));
    match block.symmetry_max_rel {
        Some(most) if !(0.001..=0.2).contains(&most) => fault(format!("is {most}, expected 0.001 to 0.2")),
        Some(_) if block.target.is_some() => fault(
            "does not go with `target`: half-planes that are chosen lie all round and assume no symmetry".to_owned(),
        ),
        most => Ok(most),
    }
}

/// The speed within the beam is no more than this share of that everywhere else: two speeds tell delay and play apart.
const MOST_SHARE_OF_BEAM: f64 = 0.7;

/// The speed of the second sweeps within the beam; none where there are none.
///
/// # Errors
/// [`Fault`] for a value out of range.
pub(super) fn beam_speed(path: &str, block: &BlockDocument, speed_deg_s: Option<f64>) -> Result<Option<f64>, Fault> {
    let (Some(beam), Some(speed)) = (block.beam_speed_deg_s, speed_deg_s) else {
        return Ok(None);
    };
    let most = MOST_SHARE_OF_BEAM * speed;
    if beam.is_finite() && beam > 0.0 && beam <= most {
        return Ok(Some(beam));
    }
    Err(Fault::new(
        format!("{path}.beam_speed_deg_s"),
        format!("is {beam}, expected above 0 and at most {most:.2} °/s, {MOST_SHARE_OF_BEAM} of `speed_deg_s`"),
    ))
}

/// Digits below which dim light is swept again; none where it is not.
///
/// # Errors
/// [`Fault`] for a value out of range.
pub(super) fn dim_digits(path: &str, block: &BlockDocument) -> Result<Option<f64>, Fault> {
    match block.dim_digits {
        Some(digits) if !(1.0..=100.0).contains(&digits) => Err(Fault::new(
            format!("{path}.dim_digits"),
            format!("is {digits}, expected 1 to 100"),
        )),
        digits => Ok(digits),
    }
}

/// Where rings stand among the sweeps of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rings {
    /// Nowhere.
    None,
    /// As soon as a half-plane says where there is light.
    BehindTheFirst,
    /// Behind all sweeps of the first half-plane.
    BehindThePair,
}

/// The sweeps of half-planes `c_deg` over rising `gamma_deg`: the first forward, backward, and `with_slow_pair` both
/// again slowly near γ = 0°; then directions alternate. The γ of `rings` is decided by the light of the half-planes
/// before them.
pub(super) fn passes(
    c_deg: &[f64],
    gamma_deg: &[f64],
    speed_deg_s: f64,
    with_slow_pair: bool,
    rings: Rings,
) -> Vec<Pass> {
    let (Some(&low), Some(&high), Some(&first)) = (gamma_deg.first(), gamma_deg.last(), c_deg.first()) else {
        return Vec::new();
    };
    let pass = |c_deg: f64, gamma_deg: [f64; 2], speed_deg_s: f64| Pass {
        way: Way::HalfPlane { c_deg, gamma_deg },
        speed_deg_s,
        range: None,
    };
    let inner = [low.max(-SLOW_REACH_DEG), high.min(SLOW_REACH_DEG)];
    let inner = if inner[1] - inner[0] < SLOW_REACH_DEG {
        [low, high]
    } else {
        inner
    };
    let slow = SLOW_SHARE * speed_deg_s;
    let mut passes = vec![
        pass(first, [low, high], speed_deg_s),
        pass(first, [high, low], speed_deg_s),
    ];
    if with_slow_pair {
        passes.extend([pass(first, inner, slow), pass(first, [inner[1], inner[0]], slow)]);
    }
    let around = (0..RINGS).map(|place| ring(high * (place + 1) as f64 / 5.0, place % 2 == 0, speed_deg_s));
    match rings {
        Rings::None => {}
        Rings::BehindTheFirst => drop(passes.splice(1..1, around)),
        Rings::BehindThePair => passes.extend(around),
    }
    for (place, &c) in c_deg[1..].iter().enumerate() {
        let way = if place % 2 == 0 { [low, high] } else { [high, low] };
        passes.push(pass(c, way, speed_deg_s));
    }
    passes
}
