//! Second sweeps of half-planes, over a part of γ: slowly within the beam, and in a more sensitive range of the meter
//! where the light is dim against the range that was held. Which ones follow from the sweeps of the plan alone, so that a
//! resumed scan makes the same.

use isolux_record::Station;
use isolux_record::plan::{Block, Pass, Way};

use crate::chosen::{Chosen, PlaneLight};
use crate::sweeps::{self, FILLED};

/// Share of the largest light of the block from which on it is the beam.
const BEAM: f64 = 0.1;
/// Steps of γ that a sweep of the beam reaches beyond it: curves are held from one side at their ends.
const MARGIN: usize = 1;
/// γ of a sweep of the beam, at least: a pair shows its displacement by those inside.
const LEAST_IN_BEAM: usize = 14;
/// Two beams of a half-plane are swept in one where it takes no longer: a sweep costs so much beside its way, s.
const BETWEEN_S: f64 = 3.0;
/// What a drive makes of a speed differs by less, relative.
const SAME_SPEED: f64 = 0.1;
/// γ of a sweep of dim light, at least.
const LEAST_IN_DIM: usize = 8;

/// A second sweep that follows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Second {
    /// It.
    pub pass: Pass,
    /// Why.
    pub reason: String,
}

/// What second sweeps need to know of the bench.
#[derive(Debug, Clone)]
pub(crate) struct Bench {
    /// Of γ.
    pub accel_deg_s2: f64,
    /// Ends of the meter's ranges, calibrated, rising, lx.
    pub tops_lx: Vec<f64>,
}

/// A part of a half-plane that is swept a second time.
struct Part {
    c_deg: f64,
    /// Its ends, rising, degrees.
    ends_deg: [f64; 2],
    speed_deg_s: f64,
    range: Option<u8>,
    /// Both directions of it, in place of one.
    pair: bool,
    reason: String,
}

/// The second sweep that follows the sweeps of the plan; none where all are made. The beam comes first, then dim light;
/// of several the one that begins nearest to where the axes stand.
pub(crate) fn next(block: &Block, chosen: &Chosen, bench: &Bench) -> Option<Second> {
    if block.beam_speed_deg_s.is_none() && block.dim_digits.is_none() {
        return None;
    }
    let (at_c_deg, at_gamma_deg) = chosen.made.last()?.to_deg();
    let light = chosen.light(block);
    let largest_lx = light.iter().flat_map(|plane| &plane.lux).copied().fold(0.0, f64::max);
    let beams = light.iter().flat_map(|plane| beams(block, plane, largest_lx));
    let mut parts: Vec<Part> = beams.collect();
    // The displacement at their speed, at which no pair of the plan is.
    let first = parts.first().map(|part| part.c_deg);
    for part in &mut parts {
        part.pair = Some(part.c_deg) == first;
    }
    let dim = light.iter().flat_map(|plane| dim(block, plane, bench));
    let stages = [parts, dim.collect()];
    let passes = stages.into_iter().map(|parts| {
        let left = parts.iter().flat_map(|part| part.left(chosen));
        let way = |second: &Second| {
            let (c_deg, gamma_deg) = second.pass.from_deg();
            ((c_deg - at_c_deg).abs(), (gamma_deg - at_gamma_deg).abs())
        };
        left.min_by(|a, b| {
            let (a, b) = (way(a), way(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    });
    passes.flatten().next()
}

impl Part {
    /// The sweeps of it that are not made.
    fn left(&self, chosen: &Chosen) -> Vec<Second> {
        let [low, high] = self.ends_deg;
        let made: Vec<f64> = chosen
            .made
            .iter()
            .filter(|pass| self.is(pass))
            .map(|pass| pass.way.sign())
            .collect();
        if !made.is_empty() && !self.pair {
            return Vec::new();
        }
        let ways = [[low, high], [high, low]].map(|gamma_deg| Way::HalfPlane {
            c_deg: self.c_deg,
            gamma_deg,
        });
        let left = ways.into_iter().filter(|way| !made.contains(&way.sign()));
        let second = |way| Second {
            pass: Pass {
                way,
                speed_deg_s: self.speed_deg_s,
                range: self.range,
            },
            reason: self.reason.clone(),
        };
        left.map(second).collect()
    }

    /// Whether a sweep is one of it, in a range that its light was not over.
    fn is(&self, pass: &Pass) -> bool {
        let [from, to] = pass.way.moving_deg();
        let is_there = pass.way.half_plane_deg() == Some(self.c_deg) && [from.min(to), from.max(to)] == self.ends_deg;
        let is_as_fast = (pass.speed_deg_s / self.speed_deg_s - 1.0).abs() < SAME_SPEED;
        is_there && is_as_fast && (self.range.is_none() || pass.range.is_some())
    }
}

/// The beams of a half-plane.
fn beams(block: &Block, plane: &PlaneLight, largest_lx: f64) -> Vec<Part> {
    let Some(speed_deg_s) = block.beam_speed_deg_s else {
        return Vec::new();
    };
    let gamma_deg = &block.gamma_deg;
    let last = gamma_deg.len() - 1;
    let least_lx = BEAM * largest_lx;
    let mut joined: Vec<[usize; 2]> = Vec::new();
    for [first, end] in runs(&plane.lux, |lux| lux > 0.0 && lux >= least_lx) {
        let (mut first, mut end) = (first.saturating_sub(MARGIN), (end + MARGIN).min(last));
        while end - first + 1 < LEAST_IN_BEAM.min(last + 1) {
            (first, end) = (first.saturating_sub(1), (end + 1).min(last));
        }
        match joined.last_mut() {
            Some(before) if gamma_deg[first] - gamma_deg[before[1]] < BETWEEN_S * speed_deg_s => before[1] = end,
            _ => joined.push([first, end]),
        }
    }
    let part = |[first, end]: [usize; 2]| Part {
        c_deg: plane.c_deg,
        ends_deg: [gamma_deg[first], gamma_deg[end]],
        speed_deg_s,
        range: None,
        pair: false,
        reason: format!(
            "the beam, with {:.0} % of the largest light or more, is swept again at {speed_deg_s} °/s",
            100.0 * BEAM
        ),
    };
    joined.into_iter().map(part).collect()
}

/// The parts of a half-plane whose light, that of run-up and run-out too, is below so many digits.
fn dim(block: &Block, plane: &PlaneLight, bench: &Bench) -> Vec<Part> {
    let (Some(digits), Some(speed_deg_s)) = (block.dim_digits, block.sweep_deg_s) else {
        return Vec::new();
    };
    let most_lx = digits * plane.digit_lx;
    let more_sensitive = bench.tops_lx.iter().take(usize::from(plane.range.saturating_sub(1)));
    let fits = more_sensitive
        .zip(1_u8..)
        .find(|(top_lx, _)| most_lx <= FILLED * *top_lx);
    let Some((top_lx, range)) = fits.filter(|_| plane.digit_lx > 0.0) else {
        return Vec::new();
    };
    let gamma_deg = &block.gamma_deg;
    let pass = |gamma_deg: [f64; 2]| Pass {
        way: Way::HalfPlane {
            c_deg: plane.c_deg,
            gamma_deg,
        },
        speed_deg_s,
        range: Some(range),
    };
    let [start, end] = pass([0.0, 0.0]).ends_deg(bench.accel_deg_s2);
    let ramp_deg = 0.5 * (end - start).abs();
    let within: Vec<f64> = gamma_deg
        .iter()
        .map(|at| {
            let near = gamma_deg
                .iter()
                .zip(&plane.lux)
                .filter(|(gamma, _)| (*gamma - at).abs() <= ramp_deg);
            near.map(|(_, lux)| *lux).fold(0.0, f64::max)
        })
        .collect();
    let runs = runs(&within, |lux| lux < most_lx);
    let long = runs.into_iter().filter(|[first, end]| end - first + 1 >= LEAST_IN_DIM);
    let part = |[first, end]: [usize; 2]| Part {
        c_deg: plane.c_deg,
        ends_deg: [gamma_deg[first], gamma_deg[end]],
        speed_deg_s,
        range: Some(range),
        pair: false,
        reason: format!(
            "light below {most_lx:.3} lx, {digits} digits of range {}, is swept again in range {range}, up to {top_lx:.3} lx",
            plane.range
        ),
    };
    long.map(part).collect()
}

/// First and last place of every run of values that `is`.
fn runs(values: &[f64], is: impl Fn(f64) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (place, _) in values.iter().enumerate().filter(|(_, value)| is(**value)) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == place => run[1] = place,
            _ => runs.push([place, place]),
        }
    }
    runs
}

/// How long the sweeps within the beam take at least, where it is narrow, s; that of dim light is not known before.
pub(crate) fn least_s(station: &Station, block: &Block) -> f64 {
    let planes = if block.target.is_some() { 2 } else { block.c_deg.len() };
    let narrow = LEAST_IN_BEAM.min(block.gamma_deg.len()) - 1;
    let one_s = block
        .beam_speed_deg_s
        .map(|speed| along_s(station, block.gamma_deg[narrow] - block.gamma_deg[0], speed));
    // Both ways in one half-plane.
    (planes + 1) as f64 * one_s.unwrap_or(0.0)
}

/// What a person should know of them before the scan; empty where there are none.
pub(crate) fn words(station: &Station, block: &Block) -> String {
    let (Some(low), Some(high), Some(speed)) = (block.gamma_deg.first(), block.gamma_deg.last(), block.sweep_deg_s)
    else {
        return String::new();
    };
    let planes = block.c_deg.len();
    let beam = block.beam_speed_deg_s.map(|beam| {
        format!(
            "up to {} sweeps within the beam at {beam} °/s, {:.0} s where it is narrow and {:.0} s where all is beam, ",
            planes + 1,
            least_s(station, block),
            (planes + 1) as f64 * along_s(station, high - low, beam)
        )
    });
    let dim = block.dim_digits.map(|digits| {
        format!(
            "up to {:.0} s of sweeps where the light is below {digits} digits, ",
            planes as f64 * (along_s(station, high - low, speed) + BETWEEN_S)
        )
    });
    beam.into_iter().chain(dim).collect()
}

/// How long a second sweep over so many degrees takes with the way to it, s.
fn along_s(station: &Station, way_deg: f64, speed_deg_s: f64) -> f64 {
    let pass = Pass {
        way: Way::HalfPlane {
            c_deg: 0.0,
            gamma_deg: [0.0, way_deg],
        },
        speed_deg_s,
        range: None,
    };
    sweeps::pass_s(station, &pass) + BETWEEN_S
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use isolux_record::plan::Plan;
    use isolux_record::sweeps::SweepRecord;

    use super::*;
    use crate::chosen::tests::swept;

    const BENCH: Bench = Bench {
        accel_deg_s2: 40.0,
        tops_lx: Vec::new(),
    };

    fn block(keys: &str) -> Block {
        let text = format!(
            "format = \"isolux-plan/1\"\n[[block]]\nname = \"a\"\nkind = \"lit\"\nmode = \"sweep\"\n\
             c_range = [0, 120, 60]\ngamma_range = [-180, 180, 2]\n{keys}\n"
        );
        Plan::parse(Utf8Path::new("p.toml"), &text).unwrap().blocks()[0].clone()
    }

    /// The digit of range 3 in all sweeps of the plan, of range 1 in those that are more sensitive.
    fn read(index: usize, pass: &Pass, light: &dyn Fn(f64, f64) -> f64) -> SweepRecord {
        let mut record = swept(index as u64, pass, light);
        record.of.range = i32::from(pass.range.unwrap_or(3));
        for sample in &mut record.light {
            sample.digit_lx = if pass.range.is_some() { 0.01 } else { 1.0 };
        }
        record
    }

    /// All sweeps of a scan, in their order, and how many of them are those of the plan.
    fn scan(block: &Block, bench: &Bench, light: &dyn Fn(f64, f64) -> f64) -> (Vec<SweepRecord>, usize) {
        let (mut chosen, mut records) = (Chosen::default(), Vec::new());
        let planned = block.passes();
        for pass in &planned {
            records.push(read(records.len(), pass, light));
            chosen.add(block, &records[records.len() - 1]);
        }
        while let Some(second) = next(block, &chosen, bench) {
            records.push(read(records.len(), &second.pass, light));
            chosen.add(block, &records[records.len() - 1]);
            assert!(records.len() < 60, "it comes to an end");
        }
        (records, planned.len())
    }

    fn spot(gamma: f64) -> f64 {
        600.0 * 0.5f64.powf((gamma / 7.5).powi(2)) + 1.5 * gamma.to_radians().cos().max(0.0)
    }

    #[test]
    fn the_beam_is_swept_once_in_every_half_plane_and_both_ways_in_the_first() {
        let block = block("beam_speed_deg_s = 6.0");
        let (records, planned) = scan(&block, &BENCH, &|_, gamma| spot(gamma));
        let second: Vec<(f64, [f64; 2])> = records[planned..]
            .iter()
            .map(|sweep| (sweep.of.c_target_deg, sweep.of.gamma_deg))
            .collect();
        // A tenth of the largest light is at 13.7°. Each begins where the one before has ended.
        let [forth, back] = [[-14.0, 14.0], [14.0, -14.0]];
        assert_eq!(second, [(120.0, forth), (60.0, back), (0.0, forth), (0.0, back)]);
        assert!(records[planned..].iter().all(|sweep| sweep.of.speed_deg_s == 6.0));
    }

    #[test]
    fn a_narrow_beam_of_one_side_has_enough_directions_for_a_pair() {
        let text = "beam_speed_deg_s = 6.0";
        let mut block = block(text);
        block.gamma_deg.retain(|gamma| *gamma >= 0.0);
        let (records, planned) = scan(&block, &BENCH, &|_, gamma| spot(4.0 * gamma));
        assert_eq!(records.len() - planned, 4);
        let [low, high] = records[planned + 3].of.gamma_deg.map(f64::abs);
        assert_eq!((low - high).abs() / 2.0 + 1.0, LEAST_IN_BEAM as f64);
        assert_eq!(
            scan(&block, &BENCH, &|_, _| 0.0).0.len(),
            planned,
            "the dark has no beam"
        );
    }

    #[test]
    fn dim_light_is_swept_in_the_most_sensitive_range_that_holds_it_and_no_beam_is_with_it() {
        let block = block("dim_digits = 20.0");
        let bench = Bench {
            tops_lx: vec![30.0, 300.0, 3000.0],
            ..BENCH
        };
        let (records, planned) = scan(&block, &bench, &|_, gamma| spot(gamma));
        assert_eq!(records.len() - planned, 2 * 3);
        for sweep in &records[planned..] {
            assert_eq!(sweep.of.range, 1);
            let [a, b] = sweep.of.gamma_deg;
            let (near, far) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
            // 20 lx are at 16.6°, and run-up and run-out take 4.8° at 12 °/s.
            assert!((22.0..=24.0).contains(&near) && far == 180.0, "{a}° to {b}°");
        }
        let none = Bench {
            tops_lx: vec![3.0, 20.0, 3000.0],
            ..BENCH
        };
        assert_eq!(scan(&block, &none, &|_, gamma| spot(gamma)).0.len(), planned);
    }

    #[test]
    fn a_scan_that_is_taken_up_again_makes_the_same_second_sweeps() {
        let block = block("beam_speed_deg_s = 6.0\ndim_digits = 20.0");
        let bench = Bench {
            tops_lx: vec![30.0, 300.0, 3000.0],
            ..BENCH
        };
        let (records, planned) = scan(&block, &bench, &|_, gamma| spot(gamma));
        assert_eq!(records.len() - planned, 4 + 6);
        for made in planned..records.len() {
            let again = Chosen::of(&block, records[..made].iter());
            let second = next(&block, &again, &bench).unwrap();
            assert_eq!(second.pass.way, records[made].of.way(), "after {made}");
        }
    }
}
