//! What is left in the readings because it was not measured: offset, ambient light, stray light.
//!
//! A part that was not subtracted lies between zero and the bound that the station states; without a bound nothing is
//! known of it. The value is not moved by half the bound: the square root of the mean square of a rectangular
//! distribution on [0, b] about zero is b/√3, and so much it contributes, to all directions alike.

use isolux_photometry::IntensityDistribution;
use isolux_record::Station;

use crate::background::{Background, Subtract};

/// Fewer baffled γ do not show how the stray light varies over γ.
const LEAST_BAFFLED: usize = 3;

/// Standard uncertainties, common to all directions, of what is still in the readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unmeasured {
    /// Of the meter's offset.
    pub offset_lx: f64,
    /// Of the ambient light.
    pub ambient_lx: f64,
    /// Of the stray light made by the lamp.
    pub stray_lx: f64,
    /// What is neither measured nor bounded, one phrase each.
    pub missing: Vec<String>,
}

/// What was done about offset, ambient and stray light.
#[derive(Debug, Clone, Copy)]
pub struct Done<'a> {
    /// What the run measured of them.
    pub background: &'a Background,
    /// The corrections that are on.
    pub corrected: Subtract,
    /// Those that were subtracted as they were read; the others were taken out by a model.
    pub subtract: Subtract,
    /// The result.
    pub distribution: &'a IntensityDistribution,
    /// Distance of its readings.
    pub distance_mm: f64,
}

impl Unmeasured {
    /// What is left in the readings, by the bounds that the station states.
    pub fn of(station: &Station, done: &Done<'_>) -> Self {
        let bench = station.bench();
        let peak_lx = done.distribution.peak().intensity_cd / (done.distance_mm * 1e-3).powi(2);
        let [offset, ambient, stray] = done.background.left(done.corrected);
        let mut unmeasured = Self::default();
        let mut bounded = |left: f64, bound_lx: Option<f64>, by_model: bool, what: &str| -> f64 {
            if left == 0.0 {
                return 0.0;
            }
            if bound_lx.is_none() {
                unmeasured.missing.push(if by_model {
                    format!("no uncertainty is known of the {what} that the model takes out")
                } else {
                    format!("not corrected for {what}")
                });
            }
            left.abs() * bound_lx.unwrap_or(0.0) / 3.0_f64.sqrt()
        };
        let taken = |corrected: bool, subtract: bool| corrected && !subtract;
        let (on, raw) = (done.corrected, done.subtract);
        let offset_lx = bounded(
            offset,
            bench.dark_max_lx,
            taken(on.dark, raw.dark),
            "the meter's offset",
        );
        let ambient_lx = bounded(
            ambient,
            bench.ambient_max_lx,
            taken(on.ambient, raw.ambient),
            "ambient light",
        );
        let stray_max_lx = bench.stray_max_rel.map(|share| share * peak_lx);
        let stray_lx = if stray == 0.0 {
            match over_gamma(done) {
                Ok(u_lx) => u_lx,
                Err(count) => {
                    if stray_max_lx.is_none() {
                        unmeasured
                            .missing
                            .push(format!("the stray light was measured at {count} γ alone"));
                    }
                    stray_max_lx.unwrap_or(0.0) / 3.0_f64.sqrt()
                }
            }
        } else {
            bounded(stray, stray_max_lx, taken(on.stray, raw.stray), "stray light")
        };
        Self {
            offset_lx,
            ambient_lx,
            stray_lx,
            ..unmeasured
        }
    }
}

/// Standard uncertainty of baffled readings that are interpolated over γ and taken for all half-planes; how many γ
/// there are where they are too few for that or do not reach as far as the distribution.
fn over_gamma(done: &Done<'_>) -> Result<f64, usize> {
    let baffled = &done.background.baffled;
    let gammas = done.distribution.gamma_deg();
    let widest = baffled.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
    let reach = match (baffled.first(), baffled.last(), gammas.last()) {
        (Some((from, _)), Some((to, _)), Some(last)) => *from <= gammas[0] + widest && to + widest >= *last,
        _ => false,
    };
    if baffled.len() < LEAST_BAFFLED || !reach {
        return Err(baffled.len());
    }
    if !done.subtract.stray {
        // A model holds it at every direction, and explains every baffled reading.
        return Ok(0.0);
    }
    // A parabola through three readings is at most δ/8 away from the line between two of them.
    let bend_lx = baffled
        .windows(3)
        .map(|three| {
            let share = (three[1].0 - three[0].0) / (three[2].0 - three[0].0);
            let line = three[0].1.mean_lx + share * (three[2].1.mean_lx - three[0].1.mean_lx);
            2.0 * (three[1].1.mean_lx - line).abs() / 8.0
        })
        .fold(0.0, f64::max);
    // They were read in one half-plane; the light of the others differs as their own light does.
    let level_lx = baffled
        .iter()
        .map(|(gamma, _)| done.background.parts_lx(*gamma)[2].unwrap_or(0.0).abs())
        .fold(0.0, f64::max);
    Ok(bend_lx.hypot(level_lx * spread_of_planes(done.distribution)) / 3.0_f64.sqrt())
}

/// (Largest − smallest)/2 of the light of the half-planes, relative to their mean.
fn spread_of_planes(distribution: &IntensityDistribution) -> f64 {
    let weights = distribution.flux_weights_sr();
    let widths = distribution.plane_widths_deg();
    let count = distribution.gamma_deg().len();
    let light: Vec<f64> = (0..widths.len())
        .map(|plane| {
            let weights = &weights[plane * count..(plane + 1) * count];
            let sum: f64 = weights
                .iter()
                .zip(distribution.row(plane))
                .map(|(weight, cd)| weight * cd)
                .sum();
            sum / widths[plane]
        })
        .collect();
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let high = light.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = light.iter().copied().fold(f64::INFINITY, f64::min);
    if mean > 0.0 { 0.5 * (high - low) / mean } else { 0.0 }
}
