//! Record → distribution and spectrum, with uncertainty.
//!
//! Reduction is a pure function of a run: the same run gives the same numbers and the same bytes. Every correction is a
//! switch ([`Correction`]), and every headline number is a [`Quantity`] whose parts say where its uncertainty comes
//! from.

mod acceptance;
mod angles;
mod apparent;
mod background;
mod bandpass;
mod bench;
mod between;
mod blocks;
mod budget;
mod circle;
mod closing;
mod colour;
mod correction;
mod direction;
mod drift;
mod electrical;
mod error;
pub mod eu_label;
mod feasibility;
mod finding;
mod floor;
mod grid;
mod headline;
mod instrument;
mod intensity;
mod interpolation;
mod known;
mod meter;
mod monte_carlo;
mod near_field;
mod normal;
mod notes;
mod one_nm;
mod order;
mod over_angle;
mod partial;
mod pipeline;
mod quantity;
pub mod ratings;
mod reference;
mod results;
mod samples;
mod smooth;
mod so_far;
mod spectral;
mod spectral_noise;
pub mod spectrometer;
pub mod standard;
mod straight;
mod sweeps;
mod unmeasured;

#[cfg(test)]
mod testing;

use std::collections::BTreeSet;

use isolux_model::Model;
use isolux_record::Run;

pub use angles::BeamAngles;
pub use apparent::Apparent;
pub use background::{Background, Level, Subtract};
pub use between::Between;
pub use budget::{Common, noise_of_directions, of_directions_cd, weighted_sum};
pub use closing::Closing;
pub use colour::Colour;
pub use correction::{Correction, UnknownCorrection};
pub use drift::{Burning, Drift};
pub use electrical::{Electrical, Over};
pub use error::ReduceError;
pub use feasibility::check_feasibility;
pub use finding::{Accepted, Evidence, Finding, note};
pub use grid::{Grid, Smoothing};
pub use headline::NEAR_FIELD_AT_SENSOR;
pub use meter::{MeterFactors, MeterFacts, SpectralMismatch};
pub use monte_carlo::{MonteCarlo, Propagated};
pub use over_angle::{
    AverageColour, ColourOverAngle, DirectionColour, LargestDifference, LeftOut, OverAngle, TotalColour,
};
pub use partial::Partial;
pub use quantity::{Quantity, no_uncertainty};
pub use results::{Budget, COLOUR_FOLDER, ResultFile, Subtracted, budget_of, file_name, files, photometric};
pub use samples::Sample;
pub use smooth::SmoothError;
pub use so_far::in_motion_so_far;
pub use spectral::{SpectralResult, on_axis};
pub use straight::straight_lines_miss_cd;

use bench::Bench;
use floor::Floor;
use meter::Response;
use sweeps::InMotion;

/// Side of the square sensor and its distance, for which the budget gives the mean irradiance: a full-frame-class
/// sensor at half a metre.
pub const SENSOR_MM: (f64, f64) = (24.576, 500.0);

/// How a run is reduced.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Corrections that are switched off.
    pub without: BTreeSet<Correction>,
    /// Why a drift, an unstable reference or a closing half-plane beyond the limits of the plan is accepted, in a
    /// person's words; none: it is refused.
    pub accept_drift: Option<String>,
}

/// What a run says.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// The distribution and the samples at its nodes.
    pub grid: Grid,
    /// The spectrum on the axis, if one was taken.
    pub spectral: Option<SpectralResult>,
    /// Colour over angle, if spectra were taken off the axis.
    pub over_angle: Option<OverAngle>,
    /// Offset, ambient and stray light.
    pub background: Background,
    /// Which of them were subtracted.
    pub subtract: Subtract,
    /// Drift of the reference.
    pub drift: Drift,
    /// What is known of the lux meter's own response.
    pub luxmeter: MeterFacts,
    /// Uncertainties that all readings share.
    pub common: Common,
    /// Distance of the readings of the distribution.
    pub distance_mm: f64,
    /// Luminous flux.
    pub flux: Quantity,
    /// The supply line and lm/W, where there was a power meter.
    pub electrical: Option<Electrical>,
    /// Largest intensity.
    pub i_max: Quantity,
    /// Its direction (C, γ) in degrees.
    pub i_max_deg: (f64, f64),
    /// Beam and field angle of the planes through C0 and C90 that were read.
    pub angles: Vec<BeamAngles>,
    /// Mean illuminance of a sensor of [`SENSOR_MM`] by the inverse square law, normal to the axis.
    pub sensor_illuminance: Quantity,
    /// Its mean irradiance, where there is a spectrum.
    pub sensor_irradiance: Option<Quantity>,
    /// Closing half-plane C 360° against C 0°, if the plan has one.
    pub closing: Option<Closing>,
    /// Apparent intensity on the axis at other distances.
    pub other_distances: Vec<Apparent>,
    /// Numbers of the readings that the distribution was made of.
    pub made_of: Vec<u64>,
    /// Readings that were used, and all of them.
    pub readings: (usize, usize),
    /// What a person should know.
    pub notes: Vec<String>,
    /// What was read, where the scan is not finished.
    pub partial: Option<Partial>,
    /// What was interpolated, where the scan chose its half-planes.
    pub between: Option<Between>,
    /// What did not agree and was accepted.
    pub accepted: Option<Accepted>,
    /// Corrections that were switched off.
    pub without: BTreeSet<Correction>,
    /// Effects that a model took out.
    pub removed_effects: Vec<String>,
    /// Further `[[effect]]` tables of the bench for the model file, without their heading: what a model took out,
    /// what was fitted to the stray light, what was corrected of the lux meter's response.
    pub bench_effects: Vec<String>,
}

/// What of a reduction is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    /// All of it.
    Everything,
    /// Values: no colour over angle, and of the spectrum on the axis no budget.
    Values,
}

/// What a run says, whatever order its rows are in: by `model`, whose bench effects are taken out, or else by the
/// run's own dark, ambient and baffled readings. Where a floor explains the baffled readings, it is the floor that is
/// taken out: then the model file, which carries it, predicts the readings as they were read, and no digit of the
/// baffled readings is cut into the distribution.
///
/// # Errors
/// [`ReduceError`]; nothing half-made is returned. The effect of `model` without inverse comes back as text in
/// [`ReduceError::Format`].
pub fn reduce(run: &Run, options: &Options, model: Option<Model>) -> Result<Reduction, ReduceError> {
    reduce_to(Wanted::Everything, run, options, model)
}

fn reduce_to(wanted: Wanted, run: &Run, options: &Options, model: Option<Model>) -> Result<Reduction, ReduceError> {
    let at_rest = sweeps::as_readings(run)?;
    let mut reduction = reduced(
        wanted,
        &order::in_order(&at_rest.run),
        &at_rest.in_motion,
        options,
        model,
    )?;
    reduction.made_of = at_rest.in_record(reduction.made_of);
    reduction.notes.splice(0..0, at_rest.notes);
    Ok(reduction)
}

/// The same, of a run in order whose sweeps are readings.
fn reduced(
    wanted: Wanted,
    run: &Run,
    in_motion: &InMotion,
    options: &Options,
    model: Option<Model>,
) -> Result<Reduction, ReduceError> {
    let by_model = model.map(|model| Bench {
        model,
        measured_by_the_run: false,
    });
    let response = Response::of(run, options, by_model.as_ref());
    let run = &*response.applied(run);
    let spectral = || spectral::on_axis_to(wanted, run, options);
    let mut reduction = if let Some(bench) = by_model {
        let mut reduction = pipeline::reduce(run, in_motion, options, Some(&bench), &response, spectral)?;
        reduction.bench_effects.extend(bench.tables());
        reduction
    } else {
        let plain = pipeline::reduce(run, in_motion, options, None, &response, spectral)?;
        without_floor(run, in_motion, options, &response, plain)?
    };
    if wanted == Wanted::Everything {
        reduction.add_colour_over_angle(run, options)?;
    }
    Ok(reduction)
}

/// Where a floor explains the baffled readings, the run reduced again with that floor taken out.
fn without_floor(
    run: &Run,
    in_motion: &InMotion,
    options: &Options,
    response: &Response,
    plain: Reduction,
) -> Result<Reduction, ReduceError> {
    let Some(floor) = Floor::of(run, &plain) else {
        return Ok(plain);
    };
    let table = floor.table();
    let bench = Bench {
        model: floor::far_field(&plain).with_effects(vec![floor.effect]),
        measured_by_the_run: true,
    };
    // No effect of the bench is in the spectrum.
    let again = || Ok(plain.spectral.clone());
    let mut reduction = pipeline::reduce(run, in_motion, options, Some(&bench), response, again)?;
    reduction.bench_effects.push(table);
    Ok(reduction)
}

impl Reduction {
    fn add_colour_over_angle(&mut self, run: &Run, options: &Options) -> Result<(), ReduceError> {
        let lamp = over_angle::Lamp {
            distribution: &self.grid.distribution,
            common: &self.common,
            flux: &self.flux,
            partial: self.partial.as_ref(),
        };
        match over_angle::of(run, options, &lamp)? {
            Some(Ok(found)) => {
                self.notes.extend(found.notes.iter().cloned());
                self.over_angle = Some(found);
            }
            Some(Err(why)) => self.notes.push(why),
            None => {}
        }
        Ok(())
    }
}
