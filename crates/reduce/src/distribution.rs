//! Lit readings → luminous intensity distribution with its uncertainty.

use isolux_photometry::IntensityDistribution;
use isolux_record::run::RunHeader;
use isolux_record::{Reading, ReadingKind, Role};
use serde::Serialize;

use crate::correction::{Correction, Switches};
use crate::drift::Drift;
use crate::error::ReduceError;
use crate::level::Levels;
use crate::point::{PointGrid, grid, mean};
use crate::uncertainty::{Combined, CommonPart, weighted_sum};

/// A distribution as it was reduced from a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Absolute intensity in candela; negative values are noise about zero.
    pub distribution: IntensityDistribution,
    /// Independent standard uncertainty of each point in cd, in the order of the distribution's intensities.
    pub u_independent_cd: Vec<f64>,
    /// What moves many points together.
    pub common: Vec<CommonPart>,
    /// Distance of the readings.
    pub distance_mm: f64,
    /// What the meter showed without direct light.
    pub levels: Levels,
    /// The lamp's drift, where reference visits show it.
    pub drift: Option<Drift>,
    /// The plane at C = 360° against the one at C = 0.
    pub closing: Option<Closing>,
    /// Corrections that were made.
    pub applied: Vec<Correction>,
    /// Corrections that are switched on but could not be made, and why.
    pub not_possible: Vec<(Correction, &'static str)>,
    /// Uncertainties that the station does not state, and that are therefore missing from every result.
    pub not_stated: Vec<&'static str>,
    /// Usable lit readings that went in.
    pub readings: usize,
}

/// The closing check: the last half-plane is the first one again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Closing {
    /// Root mean square over γ of the difference in units of its standard uncertainty.
    pub rms_sigma: f64,
    /// Largest difference, relative to the peak.
    pub largest_rel_of_peak: f64,
    /// γ of the largest difference.
    pub largest_at_gamma_deg: f64,
}

impl Reduction {
    /// Luminous flux in lm.
    pub fn flux_lm(&self) -> Combined {
        self.weighted(&self.distribution.flux_weights_sr())
    }

    /// The largest intensity in cd.
    pub fn i_max_cd(&self) -> Combined {
        let values = self.distribution.intensity_cd();
        let peak = self.distribution.peak().intensity.value();
        let at = values.iter().position(|&value| value == peak).unwrap_or(0);
        let mut weights = vec![0.0; values.len()];
        weights[at] = 1.0;
        self.weighted(&weights)
    }

    /// Mean intensity in cd over the cone γ ≤ `half_angle_deg` about the axis: what lights a sensor there.
    pub fn axial_intensity_cd(&self, half_angle_deg: f64) -> Combined {
        let d = &self.distribution;
        // Weights of the cone: the full weights of a distribution whose row is 1 at one γ and 0 at all others.
        let gammas = d.gamma_deg();
        let unit = |index: usize| {
            let row: Vec<f64> = (0..gammas.len()).map(|i| f64::from(u8::from(i == index))).collect();
            let ring = IntensityDistribution::new(vec![0.0], gammas.to_vec(), row);
            ring.map_or(0.0, |ring| ring.flux_between(0.0, half_angle_deg).value())
        };
        let along: Vec<f64> = (0..gammas.len()).map(unit).collect();
        let whole: f64 = along.iter().sum();
        let weights: Vec<f64> = d
            .plane_widths_deg()
            .iter()
            .flat_map(|width| {
                along
                    .iter()
                    .map(move |w| if whole > 0.0 { w * width / 360.0 / whole } else { 0.0 })
            })
            .collect();
        self.weighted(&weights)
    }

    /// Σ wᵢ·Iᵢ with its uncertainty.
    pub fn weighted(&self, weights: &[f64]) -> Combined {
        weighted_sum(
            weights,
            self.distribution.intensity_cd(),
            &self.u_independent_cd,
            &self.common,
        )
    }
}

/// Reduces the lux readings of a run.
///
/// # Errors
/// [`ReduceError`] names the point that has no usable reading, or what else keeps the record from being a distribution.
pub fn reduce(header: &RunHeader, readings: &[Reading], switches: &Switches) -> Result<Reduction, ReduceError> {
    let distance_mm = scan_distance(header, readings).ok_or(ReduceError::NothingLit)?;
    let here: Vec<&Reading> = readings
        .iter()
        .filter(|r| r.kind == ReadingKind::Lit && (r.distance_mm - distance_mm).abs() < 0.5)
        .collect();
    let on_the_plan: Vec<&Reading> = here.iter().copied().filter(|r| r.role == Role::Point).collect();
    if on_the_plan.is_empty() {
        return Err(ReduceError::NothingLit);
    }
    let points = grid(&on_the_plan)?;
    let levels = Levels::among(readings, distance_mm);
    let drift = if switches.on(Correction::Drift) {
        reference_drift(&here, &levels, switches)
    } else {
        None
    };

    let (applied, not_possible) = account(switches, &levels, drift.as_ref());
    let corrected = Corrected::new(&points, &levels, drift.as_ref(), switches, distance_mm);
    let distribution = IntensityDistribution::new(
        points.c_deg.clone(),
        points.gamma_deg.clone(),
        corrected.intensity_cd.clone(),
    )?;
    let flux_lm = distribution.flux().value();
    if flux_lm <= 0.0 {
        return Err(ReduceError::NoFlux { flux_lm });
    }

    let mut common = corrected.common;
    let mut not_stated = Vec::new();
    let scaled = |rel: f64| corrected.intensity_cd.iter().map(|i| i * rel).collect::<Vec<f64>>();
    common.push(CommonPart {
        name: "calibration",
        effect_cd: scaled(header.station.luxmeter().u_rel),
    });
    match header.station.bench().u_distance_mm {
        Some(u) => common.push(CommonPart {
            name: "distance",
            effect_cd: scaled(2.0 * u / distance_mm),
        }),
        None => not_stated.push("distance (bench.u_distance_mm)"),
    }
    Ok(Reduction {
        distribution,
        u_independent_cd: corrected.independent_cd,
        common,
        distance_mm,
        closing: closing(&points),
        levels,
        drift,
        applied,
        not_possible,
        not_stated,
        readings: on_the_plan
            .iter()
            .filter(|reading| reading.illuminance_lx.is_some())
            .count(),
    })
}

/// The bench's own distance, or, where nothing was read there, the largest one.
fn scan_distance(header: &RunHeader, readings: &[Reading]) -> Option<f64> {
    let own = header.station.bench().distance_mm;
    let lit = || {
        readings
            .iter()
            .filter(|r| r.kind == ReadingKind::Lit && r.role == Role::Point)
            .map(|r| r.distance_mm)
    };
    if lit().any(|distance| (distance - own).abs() < 0.5) {
        Some(own)
    } else {
        lit().reduce(f64::max)
    }
}

fn reference_drift(here: &[&Reading], levels: &Levels, switches: &Switches) -> Option<Drift> {
    let background = levels.subtrahend(switches, 0.0).illuminance_lx;
    let visits: Vec<(f64, f64, f64)> = here
        .iter()
        .filter(|reading| reading.role == Role::Reference)
        .filter_map(|&reading| {
            let point = mean([reading])?;
            Some((
                point.time_s?,
                point.illuminance_lx - background,
                point.u.noise.hypot(point.u.rounding),
            ))
        })
        .collect();
    Drift::fit(&visits)
}

fn account(
    switches: &Switches,
    levels: &Levels,
    drift: Option<&Drift>,
) -> (Vec<Correction>, Vec<(Correction, &'static str)>) {
    let (mut applied, mut not_possible) = (Vec::new(), Vec::new());
    for correction in [
        Correction::Dark,
        Correction::Ambient,
        Correction::Stray,
        Correction::Drift,
    ] {
        if !switches.on(correction) {
            continue;
        }
        let possible = match correction {
            Correction::Drift => drift.is_some(),
            other => levels.possible(switches, other),
        };
        if possible {
            applied.push(correction);
        } else {
            not_possible.push((
                correction,
                match correction {
                    Correction::Dark => "the run has neither capped nor lamp-off readings",
                    Correction::Ambient => "the run has no lamp-off readings that tell room light from offset",
                    Correction::Stray => "the run has no baffled readings",
                    _ => "the run has fewer than two visits to the reference point",
                },
            ));
        }
    }
    (applied, not_possible)
}

/// Points in candela, with what is independent and what is common in their uncertainty.
struct Corrected {
    intensity_cd: Vec<f64>,
    independent_cd: Vec<f64>,
    common: Vec<CommonPart>,
}

impl Corrected {
    fn new(grid: &PointGrid, levels: &Levels, drift: Option<&Drift>, switches: &Switches, distance_mm: f64) -> Self {
        let n = grid.points.len();
        let m = grid.gamma_deg.len();
        // Inverse square law: cd = lx·m².
        let square_m2 = (distance_mm * 1e-3).powi(2);
        let parameters = drift.map_or(0, |drift| drift.effects(drift.span_s.0).len());
        let mut result = Self {
            intensity_cd: vec![0.0; n],
            independent_cd: vec![0.0; n],
            common: Vec::new(),
        };
        let mut dark = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let mut digit = vec![0.0; n];
        let mut drifts = vec![vec![0.0; n]; parameters];
        // Rounding of a point that its neighbours do not share, in cd.
        let mut rounding_cd = vec![0.0; n];
        for (index, point) in grid.points.iter().enumerate() {
            let subtrahend = levels.subtrahend(switches, grid.gamma_deg[index % m]);
            let net_lx = point.illuminance_lx - subtrahend.illuminance_lx;
            let time_s = drift.zip(point.time_s);
            let lamp = time_s.map_or(1.0, |(drift, time)| drift.level(time));
            let to_cd = square_m2 / lamp;
            result.intensity_cd[index] = net_lx * to_cd;
            for (level, effect) in dark.iter_mut().zip(subtrahend.effect_lx) {
                level[index] = -effect * to_cd;
            }
            if let Some((drift, time)) = time_s {
                for (part, effect) in drifts.iter_mut().zip(drift.effects(time)) {
                    part[index] = -net_lx * to_cd * effect / lamp;
                }
            }
            // Light below one digit shows the same number everywhere, and is rounded alike everywhere: where noise does
            // not dither it, that rounding is one error common to all such points. Above, levels differ from point to
            // point by more than a digit, and their rounding is independent.
            if point.u.stuck && net_lx.abs() <= point.digit_lx {
                digit[index] = point.u.rounding * to_cd;
            } else {
                rounding_cd[index] = point.u.rounding * to_cd;
            }
            result.independent_cd[index] = (point.u.noise * to_cd).hypot(rounding_cd[index]);
        }
        let named = |name: &'static str| move |effect_cd: Vec<f64>| CommonPart { name, effect_cd };
        result.common.extend(dark.into_iter().map(named("dark")));
        result.common.push(named("digit")(digit));
        result.common.extend(drifts.into_iter().map(named("drift")));
        result.one_value_at_poles(grid, &rounding_cd);
        result
    }

    /// All half-planes show one direction at a pole: they get its mean. Their noise averages out, the rounding of equal
    /// levels does not unless noise dithers it; what is left is one error for all of them.
    fn one_value_at_poles(&mut self, grid: &PointGrid, rounding_cd: &[f64]) {
        let (n, m) = (grid.c_deg.len(), grid.gamma_deg.len());
        for (column, gamma) in grid.gamma_deg.iter().enumerate() {
            if *gamma != 0.0 && *gamma != 180.0 {
                continue;
            }
            let at = |plane: usize| plane * m + column;
            let average = |values: &[f64]| (0..n).map(|plane| values[at(plane)]).sum::<f64>() / n as f64;
            let mean_cd = average(&self.intensity_cd);
            let scatter_cd = average(&self.independent_cd) / (n as f64).sqrt();
            let alike_cd = (0..n)
                .filter(|&plane| grid.points[at(plane)].u.stuck)
                .map(|plane| rounding_cd[at(plane)]);
            let u_cd = scatter_cd.hypot(alike_cd.fold(0.0, f64::max));
            for part in &mut self.common {
                let mean_effect = average(&part.effect_cd);
                (0..n).for_each(|plane| part.effect_cd[at(plane)] = mean_effect);
            }
            let mut pole = vec![0.0; grid.points.len()];
            for plane in 0..n {
                self.intensity_cd[at(plane)] = mean_cd;
                self.independent_cd[at(plane)] = 0.0;
                pole[at(plane)] = u_cd;
            }
            self.common.push(CommonPart {
                name: "independent",
                effect_cd: pole,
            });
        }
    }
}

fn closing(grid: &PointGrid) -> Option<Closing> {
    if grid.closing.is_empty() || grid.c_deg.first() != Some(&0.0) {
        return None;
    }
    let peak = grid
        .points
        .iter()
        .map(|point| point.illuminance_lx)
        .fold(f64::MIN, f64::max);
    let mut sum = 0.0;
    let mut largest = (0.0f64, 0.0);
    for (index, (first, last)) in grid.points.iter().zip(&grid.closing).enumerate() {
        let difference = last.illuminance_lx - first.illuminance_lx;
        let u = |p: &crate::point::Point| p.u.noise.hypot(p.u.rounding);
        let u2 = u(first).powi(2) + u(last).powi(2);
        sum += if u2 > 0.0 { difference * difference / u2 } else { 0.0 };
        if difference.abs() > largest.0.abs() {
            largest = (difference, grid.gamma_deg[index]);
        }
    }
    Some(Closing {
        rms_sigma: (sum / grid.closing.len() as f64).sqrt(),
        largest_rel_of_peak: largest.0 / peak,
        largest_at_gamma_deg: largest.1,
    })
}
