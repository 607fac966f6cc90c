//! The numbers that people read, each with the parts of its uncertainty and what is missing in it.
//!
//! | number | parts | missing where |
//! |---|---|---|
//! | flux | noise, digit, dark, offset, ambient, stray, distance, angle, calibration, drift, interpolation | no bound, no u_distance_mm, no u_gamma_deg, γ not 0° to 180°, a symmetry assumed, steps too coarse, burnings not tied, a disagreement accepted, a model without uncertainty |
//! | largest intensity | the same and near_field | the same but for γ; no lamp.diameter_mm |
//! | beam and field angle | noise, digit, dark, offset, ambient, stray, angle, interpolation, near_field | as the largest intensity |
//! | mean on the sensor | the same and near_field_at_sensor | the same but for γ; no lamp.diameter_mm |

use isolux_photometry::{IntensityDistribution, Symmetry};
use isolux_record::Station;

use crate::SENSOR_MM;
use crate::angles::{self, BeamAngles};
use crate::budget::{self, Common};
use crate::error::ReduceError;
use crate::grid::{Grid, sensor_points};
use crate::interpolation::{self, Kind};
use crate::near_field;
use crate::quantity::Quantity;

/// The part of a sensor's mean that a model of a small emitter leaves out at [`SENSOR_MM`]'s distance.
pub const NEAR_FIELD_AT_SENSOR: &str = "near_field_at_sensor";

/// The headline numbers of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Headline {
    /// Luminous flux.
    pub flux: Quantity,
    /// Largest intensity.
    pub i_max: Quantity,
    /// Its direction (C, γ) in degrees.
    pub i_max_deg: (f64, f64),
    /// Mean illuminance of the sensor of [`SENSOR_MM`].
    pub sensor_illuminance: Quantity,
    /// Beam and field angle.
    pub angles: Vec<BeamAngles>,
}

impl Headline {
    /// The numbers of `grid`, read at `distance_mm`, with the relative standard uncertainty of the flux by half-planes
    /// that the scan did not choose; `missing` is what none of them knows.
    ///
    /// # Errors
    /// [`ReduceError::NoFlux`] where there is no light.
    pub fn of(
        grid: &Grid,
        common: &Common,
        station: &Station,
        distance_mm: f64,
        u_between_rel: Option<f64>,
        missing: &[String],
    ) -> Result<Self, ReduceError> {
        let distribution = &grid.distribution;
        let missing: Vec<String> = missing
            .iter()
            .cloned()
            .chain((grid.assumed != Symmetry::None).then(|| "a symmetry is assumed, not measured".to_owned()))
            .chain(interpolation::unresolved(distribution))
            .collect();
        let flux = budget::weighted_sum(grid, &grid.flux_weights_sr(), common, "lm");
        if flux.value <= 0.0 {
            return Err(ReduceError::NoFlux { flux_lm: flux.value });
        }
        let between = interpolation::u_of(distribution, Kind::Integral, IntensityDistribution::flux_lm)?;
        let over_c = u_between_rel.map(|u_rel| ("interpolation_over_c", u_rel * flux.value));
        let flux = over_c
            .into_iter()
            .fold(flux, |flux, (name, part)| flux.with_part(name, part))
            .with_part("interpolation", between)
            .lacking(missing.iter().cloned().chain(outside(distribution)));

        let no_diameter = station.lamp().and_then(|lamp| lamp.diameter_mm).is_none();
        let near_missing = || {
            missing
                .iter()
                .cloned()
                .chain(no_diameter.then(|| near_field::NO_DIAMETER.to_owned()))
        };
        let near_rel = |at_mm: f64| near_field::largest_rel(station, distribution, at_mm).unwrap_or(0.0);
        let near = |quantity: &Quantity, at_mm: f64| quantity.value * near_field::standard(near_rel(at_mm));
        let (place_deg, weights) = largest(grid);
        let i_max = budget::weighted_sum(grid, &weights, common, "cd");
        let i_max = i_max
            .with_part("interpolation", interpolation::above_the_largest_cd(distribution))
            .with_part("near_field", near(&i_max, distance_mm))
            .lacking(near_missing());

        let between = interpolation::u_of(distribution, Kind::Local, sensor_mean_lx)?;
        let mean = budget::weighted_sum(
            grid,
            &grid.sensor_weights_per_m2(SENSOR_MM.0, SENSOR_MM.1),
            common,
            "lx",
        );
        let sensor_illuminance = mean
            .with_part("interpolation", between)
            .with_part("near_field", near(&mean, distance_mm))
            .with_part(NEAR_FIELD_AT_SENSOR, near(&mean, SENSOR_MM.1))
            .lacking(near_missing());
        let not_known: Vec<String> = near_missing().collect();
        Ok(Self {
            angles: angles::of(grid, common, near_rel(distance_mm), &not_known),
            flux,
            i_max,
            i_max_deg: place_deg,
            sensor_illuminance,
        })
    }
}

/// The direction (C, γ) of the largest intensity and the weights of the grid's nodes in it.
fn largest(grid: &Grid) -> ((f64, f64), Vec<f64>) {
    let distribution = &grid.distribution;
    let gammas = distribution.gamma_deg();
    let place = (0..grid.sample_of.len())
        .max_by(|&a, &b| distribution.intensity_cd()[a].total_cmp(&distribution.intensity_cd()[b]))
        .unwrap_or(0);
    let at = (distribution.c_deg()[place / gammas.len()], gammas[place % gammas.len()]);
    (at, grid.direction_weights(at.0, at.1))
}

/// Mean illuminance of the sensor by the inverse square law, 12 × 12 points.
fn sensor_mean_lx(distribution: &IntensityDistribution) -> f64 {
    sensor_points(SENSOR_MM.0, SENSOR_MM.1)
        .map(|(c_deg, gamma_deg, per_m2)| per_m2 * distribution.intensity_cd_at(c_deg, gamma_deg))
        .sum()
}

/// What of the sphere was not measured.
fn outside(distribution: &IntensityDistribution) -> Option<String> {
    zone_deg(distribution).map(zone_alone)
}

/// First and last γ where that is not the whole sphere, degrees.
pub fn zone_deg(distribution: &IntensityDistribution) -> Option<[f64; 2]> {
    let gammas = distribution.gamma_deg();
    let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
    (first > 0.0 || last < 180.0).then_some([first, last])
}

/// The phrase for it.
pub fn zone_alone([first, last]: [f64; 2]) -> String {
    format!("γ {first}° to {last}° alone was measured")
}
