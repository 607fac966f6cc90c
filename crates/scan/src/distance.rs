//! What a photometric distance costs: rounding and noise grow with its square, near field and the error of its length
//! fall.

use isolux_record::plan::{Block, Instrument, Plan, Repeats};
use isolux_record::station::Rail;
use isolux_record::{DistanceClass, ReadingKind, Station};
use serde::Serialize;
use std::f64::consts::{PI, TAU};

use crate::read_distance::distance_mm;

/// One range of a lux meter: its end, and the last digit of its display.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DisplayRange {
    /// Largest value.
    pub full_scale_lx: f64,
    /// Last digit.
    pub digit_lx: f64,
}

/// Share of a range that the expected illuminance may fill: an estimate is uncertain, and automatic ranges have
/// hysteresis.
const FILLED: f64 = 0.85;
/// Distances between the ends of the rail, evenly spaced in their logarithm.
const BETWEEN: usize = 7;
/// Proposals are rounded up to this.
const STEP_MM: f64 = 50.0;

/// Costs of the plan's distance and of others that the bench reaches.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distances {
    /// The block of the distribution.
    pub block: String,
    /// By distance.
    pub costs: Vec<Cost>,
    /// The distance with the least uncertainty, if the lamp's estimates allow to say so.
    pub best_mm: Option<f64>,
    /// What is not known, and which key would say it.
    pub unknown: Vec<String>,
    /// Whether a person moves the detector.
    pub by_hand: bool,
}

/// Contributions of one distance to the uncertainties of the flux and of the largest intensity (k = 1).
///
/// The calibration, stray light and drift have no part in it: no distance changes them, or no plan knows them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// The distance.
    pub distance_mm: f64,
    /// Its class.
    pub distance_class: DistanceClass,
    /// Whether it is the plan's.
    pub planned: bool,
    /// Largest illuminance expected.
    pub illuminance_lx: Option<f64>,
    /// Digit of the range that shows it.
    pub digit_lx: Option<f64>,
    /// Rounding, of the flux: what is subtracted is rounded alike for all directions, and so are readings without
    /// light.
    pub rounding_lm: f64,
    /// Rounding, of the largest intensity: of the reading itself and of what is subtracted.
    pub rounding_cd: Option<f64>,
    /// Noise of the readings and of what is subtracted, of the flux.
    pub noise_lm: Option<f64>,
    /// Noise, of the largest intensity.
    pub noise_cd: Option<f64>,
    /// Uncertainty of the distance, 2·u(d)/d: of both.
    pub distance_rel: Option<f64>,
    /// Error of the inverse square law, of the largest intensity. The flux has none: what crosses a closed surface
    /// around the lamp does not depend on its size.
    pub near_field_rel: Option<f64>,
    /// All contributions together, of the flux.
    pub flux_rel: Option<f64>,
    /// All contributions together, of the largest intensity.
    pub i_max_rel: Option<f64>,
}

/// The costs of the distances of `plan` on `station`, whose meter has the ranges `display`; none without a distribution
/// or a display that is known.
pub fn distances(station: &Station, plan: &Plan, display: &[DisplayRange]) -> Option<Distances> {
    let block = distribution_block(plan)?;
    let finest = display.first()?;
    let bench = Setup::of(station, plan, block, finest.digit_lx, display);
    let planned_mm = distance_mm(station, block);
    let [low, high] = reach(station, planned_mm);
    let mut wanted = vec![planned_mm];
    if high > low {
        // Far field of the beam, and where the largest reading nearly fills a range.
        let own = bench.least_mm().into_iter().chain(bench.filled_mm(display));
        let steps = (0..BETWEEN).map(|k| low * (high / low).powf((k as f64 + 1.0) / BETWEEN as f64));
        wanted.extend(
            own.chain(steps)
                .map(|mm| (mm / STEP_MM).ceil() * STEP_MM)
                .filter(|mm| (low..=high).contains(mm)),
        );
    }
    wanted.retain(|mm| *mm == planned_mm || bench.least_mm().is_none_or(|least| *mm >= least));
    wanted.sort_by(f64::total_cmp);
    wanted.dedup();
    let costs: Vec<Cost> = wanted.iter().map(|mm| bench.cost(*mm, planned_mm)).collect();
    let far = |cost: &&Cost| bench.least_mm().is_some_and(|least| cost.distance_mm >= least);
    let best_mm = costs
        .iter()
        .filter(far)
        .filter_map(|cost| Some((cost.distance_mm, cost.flux_rel?.hypot(cost.i_max_rel?))))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(mm, _)| mm);
    Some(Distances {
        block: block.name.clone(),
        best_mm,
        unknown: bench.unknown(),
        by_hand: station.rail().is_none_or(|rail| rail.open.is_none()),
        costs,
    })
}

/// The lit block of the lux meter with the most directions.
pub fn distribution_block(plan: &Plan) -> Option<&Block> {
    let directions = |block: &Block| block.c_deg.len() * block.gamma_deg.len();
    plan.blocks()
        .iter()
        .filter(|block| block.kind == ReadingKind::Lit && block.instrument == Instrument::Luxmeter)
        .max_by_key(|block| directions(block))
        .filter(|block| directions(block) > 1)
}

/// Exponent n of the lobe cosⁿ with this flux and peak: Φ = 2π·I/(n + 1); at least 0.
pub fn lobe_exponent(flux_lm: f64, peak_cd: f64) -> f64 {
    (TAU * peak_cd / flux_lm - 1.0).max(0.0)
}

/// The distances that the bench reaches: the rail's limits; without a driven rail, up to the station's own or the
/// plan's.
fn reach(station: &Station, planned_mm: f64) -> [f64; 2] {
    if let Some(rail) = station.rail().and_then(Rail::driven) {
        return rail.limit_mm;
    }
    let farthest = station.bench().distance_mm.max(planned_mm);
    let diameter = station.lamp().and_then(|lamp| lamp.diameter_mm);
    [
        diameter.map_or(farthest, |diameter| (5.0 * diameter).min(farthest)),
        farthest,
    ]
}

/// What the costs rest on.
struct Setup<'a> {
    finest_lx: f64,
    display: &'a [DisplayRange],
    flux_lm: Option<f64>,
    peak_cd: Option<f64>,
    diameter_mm: Option<f64>,
    u_distance_mm: Option<f64>,
    noise: Option<(f64, f64)>,
    directions: f64,
    repeats: f64,
    /// Readings of the level that is subtracted.
    dark_repeats: f64,
}

impl<'a> Setup<'a> {
    fn of(station: &Station, plan: &Plan, block: &Block, finest_lx: f64, display: &'a [DisplayRange]) -> Self {
        let count = |block: &Block| match block.repeats {
            Repeats::Exactly(count) => f64::from(count),
            Repeats::Until(_) => 1.0,
        };
        let of_kind = |kind| plan.blocks().iter().find(|block| block.kind == kind);
        // With all corrections on, only the uncertainty of the last level remains.
        let dark = [ReadingKind::Baffled, ReadingKind::LampOff, ReadingKind::Capped]
            .into_iter()
            .find_map(of_kind);
        let (lamp, meter) = (station.lamp(), station.luxmeter());
        Self {
            finest_lx,
            display,
            flux_lm: lamp.and_then(|lamp| lamp.flux_lm),
            peak_cd: lamp.and_then(|lamp| lamp.peak_cd),
            diameter_mm: lamp.and_then(|lamp| lamp.diameter_mm),
            u_distance_mm: station.bench().u_distance_mm,
            noise: meter.noise_rel.zip(meter.noise_lx),
            directions: (block.c_deg.len() * block.gamma_deg.len()) as f64,
            repeats: count(block),
            dark_repeats: dark.map_or(1.0, count),
        }
    }

    /// Exponent of the lobe of the lamp's estimates.
    fn lobe_exponent(&self) -> Option<f64> {
        Some(lobe_exponent(self.flux_lm?, self.peak_cd?))
    }

    /// The least distance of far-field photometry, EN 13032-4, by the beam angle of that lobe: 5 D from 90°, 10 D from
    /// 60°, 15 D below, and where it is not known.
    fn least_mm(&self) -> Option<f64> {
        let full_angle_deg = self
            .lobe_exponent()
            .map(|n| 2.0 * 0.5_f64.powf(1.0 / n.max(1e-9)).acos().to_degrees());
        let times = match full_angle_deg {
            Some(angle) if angle >= 90.0 => 5.0,
            Some(angle) if angle >= 60.0 => 10.0,
            _ => 15.0,
        };
        Some(times * self.diameter_mm?)
    }

    /// Where the largest reading fills a range as far as it may.
    fn filled_mm(&self, display: &[DisplayRange]) -> Vec<f64> {
        let peak = self.peak_cd.into_iter();
        peak.flat_map(|peak| {
            display
                .iter()
                .map(move |range| 1e3 * (peak / (FILLED * range.full_scale_lx)).sqrt())
        })
        .collect()
    }

    fn cost(&self, distance_mm: f64, planned_mm: f64) -> Cost {
        let cd_per_lx = (distance_mm * 1e-3).powi(2);
        let illuminance_lx = self.peak_cd.map(|peak| peak / cd_per_lx);
        let range = |lux: f64| {
            let fits = self.display.iter().find(|range| lux <= FILLED * range.full_scale_lx);
            fits.or_else(|| self.display.iter().find(|range| lux <= range.full_scale_lx))
        };
        let digit_lx = illuminance_lx.and_then(range).map(|range| range.digit_lx);
        let rounding = |digit_lx: f64| digit_lx / 12.0_f64.sqrt() * cd_per_lx;
        // Behind the lamp, half of the sphere, the readings are rounded alike.
        let rounding_lm = rounding(self.finest_lx) * (4.0 * PI).hypot(TAU);
        let rounding_cd = digit_lx.map(|digit_lx| rounding(digit_lx).hypot(rounding(self.finest_lx)));
        let noise_lm = self.noise.zip(self.flux_lm).map(|((rel, lux), flux)| {
            let readings = (4.0 * PI * lux * cd_per_lx).hypot(rel * flux) / (self.directions * self.repeats).sqrt();
            readings.hypot(4.0 * PI * lux * cd_per_lx / self.dark_repeats.sqrt())
        });
        let noise_cd = self.noise.zip(self.peak_cd).map(|((rel, lux), peak)| {
            let reading = (rel * peak).hypot(lux * cd_per_lx) / self.repeats.sqrt();
            reading.hypot(lux * cd_per_lx / self.dark_repeats.sqrt())
        });
        let distance_rel = self.u_distance_mm.map(|u| 2.0 * u / distance_mm);
        // The largest error is that of a ring of the luminous diameter, (1 + R²/d²)^(−(n + 3)/2); anywhere up to it.
        let near_field_rel = self.lobe_exponent().zip(self.diameter_mm).map(|(n, diameter)| {
            let radius2 = (0.5 * diameter / distance_mm).powi(2);
            -(-0.5 * (n + 3.0) * radius2.ln_1p()).exp_m1() / 3.0_f64.sqrt()
        });
        let total = |parts: [Option<f64>; 4]| -> Option<f64> {
            let parts = parts.into_iter().collect::<Option<Vec<f64>>>()?;
            Some(parts.iter().map(|part| part * part).sum::<f64>().sqrt())
        };
        let of = |part: Option<f64>, whole: Option<f64>| part.zip(whole).map(|(part, whole)| part / whole);
        Cost {
            distance_mm,
            distance_class: DistanceClass::of(distance_mm, self.diameter_mm),
            planned: distance_mm == planned_mm,
            illuminance_lx,
            digit_lx,
            rounding_lm,
            rounding_cd,
            noise_lm,
            noise_cd,
            distance_rel,
            near_field_rel,
            flux_rel: total([
                of(Some(rounding_lm), self.flux_lm),
                of(noise_lm, self.flux_lm),
                distance_rel,
                Some(0.0),
            ]),
            i_max_rel: total([
                of(rounding_cd, self.peak_cd),
                of(noise_cd, self.peak_cd),
                distance_rel,
                near_field_rel,
            ]),
        }
    }

    fn unknown(&self) -> Vec<String> {
        let missing = [
            (self.flux_lm.is_none(), "lamp.flux_lm, an estimate of the flux"),
            (
                self.peak_cd.is_none(),
                "lamp.peak_cd, an estimate of the largest intensity",
            ),
            (
                self.diameter_mm.is_none(),
                "lamp.diameter_mm, for the near field and the distance class",
            ),
            (
                self.noise.is_none(),
                "luxmeter.noise_rel and luxmeter.noise_lx, the standard deviation of one reading",
            ),
            (
                self.u_distance_mm.is_none(),
                "bench.u_distance_mm, the uncertainty of the distance",
            ),
        ];
        missing
            .into_iter()
            .filter(|(is, _)| *is)
            .map(|(_, what)| what.to_owned())
            .collect()
    }
}

#[cfg(test)]
mod tests;
