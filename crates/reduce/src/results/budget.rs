//! budget.json: every number of a reduction with its uncertainty and the parts of it.

use std::borrow::Cow;
use std::collections::BTreeSet;

use isolux_photometry::IntensityDistribution;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    Accepted, Apparent, Background, BeamAngles, Closing, Colour, ColourOverAngle, Common, Correction, Drift,
    Electrical, MeterFacts, Partial, Quantity, Reduction, SENSOR_MM, Smoothing,
};

/// `budget.json`. Standard uncertainties, k = 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Budget {
    /// What the uncertainties are, in words.
    pub coverage: Cow<'static, str>,
    /// Luminous flux.
    pub flux: Quantity,
    /// Largest intensity.
    pub i_max: Quantity,
    /// Its C.
    pub i_max_c_deg: f64,
    /// Its γ.
    pub i_max_gamma_deg: f64,
    /// Beam and field angle of the planes through C0 and C90 that were read.
    pub angles: Vec<BeamAngles>,
    /// Side of the square sensor on the axis.
    pub sensor_mm: f64,
    /// Its distance.
    pub sensor_distance_mm: f64,
    /// Its mean illuminance; null where it is outside of the measured zone.
    pub sensor_mean_illuminance: Option<Quantity>,
    /// Its mean irradiance; null without a spectrum too.
    pub sensor_mean_irradiance: Option<Quantity>,
    /// Luminous efficacy of radiation; null without a spectrum, as what follows.
    pub efficacy: Option<Quantity>,
    /// Correlated colour temperature.
    pub cct: Option<Quantity>,
    /// Colour.
    pub colour: Option<Colour>,
    /// Irradiance where the spectrum was taken.
    pub on_axis_irradiance: Option<Quantity>,
    /// Illuminance there.
    pub on_axis_illuminance: Option<Quantity>,
    /// Distance of the spectroradiometer.
    pub on_axis_distance_mm: Option<f64>,
    /// Uncertainties that all readings share.
    pub common: Common,
    /// What was subtracted from the readings.
    pub subtracted: Subtracted,
    /// Directions whose noise came out negative: files have zero there.
    pub negative_points_written_as_zero: usize,
    /// Flux of those files above that of the readings.
    pub flux_added_by_them_lm: f64,
    /// What smoothing did; null without.
    pub smoothing: Option<Smoothing>,
    /// Drift of the reference.
    pub drift: Drift,
    /// What is known of the lux meter's own response.
    #[serde(default, skip_serializing_if = "MeterFacts::is_empty")]
    pub luxmeter: MeterFacts,
    /// Closing half-plane against the first; null where the plan has none.
    pub closing_plane: Option<Closing>,
    /// How far the half-planes are apart at γ 0° and 180°, their common poles.
    pub pole_spread_cd: [f64; 2],
    /// Distance of the readings of the distribution.
    pub distance_mm: f64,
    /// Apparent intensity on the axis at other distances.
    pub other_distances: Vec<Apparent>,
    /// Readings that make the distribution.
    pub readings_used: usize,
    /// All readings.
    pub readings: usize,
    /// Corrections that were switched off.
    pub without: BTreeSet<Correction>,
    /// A disagreement that a person has accepted.
    pub accepted_drift: Option<Accepted>,
    /// Effects that a model took out.
    pub removed_effects: Vec<String>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// What was read of a scan that is not finished.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial: Option<Partial>,
    /// The supply line, where there was a power meter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub electrical: Option<Electrical>,
    /// Colour of the whole light and of every direction, where spectra were taken off the axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colour_over_angle: Option<ColourOverAngle>,
}

/// What was subtracted from the readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Subtracted {
    /// Whether the offset was.
    pub dark: bool,
    /// Whether ambient light was.
    pub ambient: bool,
    /// Whether stray light was.
    pub stray: bool,
    /// The offset; null where it was not read, as the next two.
    pub offset_lx: Option<f64>,
    /// Ambient light.
    pub ambient_lx: Option<f64>,
    /// Stray light on the axis.
    pub stray_on_axis_lx: Option<f64>,
    /// The readings that these come from.
    #[serde(rename = "levels")]
    pub background: Background,
}

impl Budget {
    /// Of a reduction; `shown` is the distribution as files hold it.
    pub(super) fn of(reduction: &Reduction, shown: &IntensityDistribution) -> Self {
        let [offset_lx, ambient_lx, stray_on_axis_lx] = reduction.background.parts_lx(0.0);
        let spectral = reduction.spectral.as_ref();
        let measured = &reduction.grid.distribution;
        // A sensor outside the measured zone has no number, not one of 0 ± 0.
        let seen = reduction.sensor_illuminance.u_of_parts_rel().is_finite();
        Self {
            coverage: "standard uncertainties, k = 1; u is null where something is missing that was neither measured nor stated"
                .into(),
            flux: reduction.flux.clone(),
            i_max: reduction.i_max.clone(),
            i_max_c_deg: reduction.i_max_deg.0,
            i_max_gamma_deg: reduction.i_max_deg.1,
            angles: reduction.angles.clone(),
            sensor_mm: SENSOR_MM.0,
            sensor_distance_mm: SENSOR_MM.1,
            sensor_mean_illuminance: seen.then(|| reduction.sensor_illuminance.clone()),
            sensor_mean_irradiance: reduction.sensor_irradiance.clone().filter(|_| seen),
            efficacy: spectral.map(|spectral| spectral.ler.clone()),
            cct: spectral.and_then(|spectral| spectral.colour.cct.clone()),
            colour: spectral.map(|spectral| spectral.colour.clone()),
            on_axis_irradiance: spectral.map(|spectral| spectral.irradiance.clone()),
            on_axis_illuminance: spectral.map(|spectral| spectral.illuminance.clone()),
            on_axis_distance_mm: spectral.map(|spectral| spectral.distance_mm),
            common: reduction.common,
            subtracted: Subtracted {
                dark: reduction.subtract.dark,
                ambient: reduction.subtract.ambient,
                stray: reduction.subtract.stray,
                offset_lx,
                ambient_lx,
                stray_on_axis_lx,
                background: reduction.background.clone(),
            },
            negative_points_written_as_zero: measured.intensity_cd().iter().filter(|cd| **cd < 0.0).count(),
            flux_added_by_them_lm: shown.flux_lm() - measured.flux_lm(),
            smoothing: reduction.grid.smoothed.as_ref().map(|(_, facts)| *facts),
            drift: reduction.drift.clone(),
            luxmeter: reduction.luxmeter.clone(),
            closing_plane: reduction.closing,
            pole_spread_cd: reduction.grid.pole_spread_cd,
            distance_mm: reduction.distance_mm,
            other_distances: reduction.other_distances.clone(),
            readings_used: reduction.readings.0,
            readings: reduction.readings.1,
            without: reduction.without.clone(),
            accepted_drift: reduction.accepted.clone(),
            removed_effects: reduction.removed_effects.clone(),
            notes: reduction.notes.clone(),
            partial: reduction.partial.clone(),
            electrical: reduction.electrical.clone(),
            colour_over_angle: reduction.over_angle.as_ref().map(|found| found.facts.clone()),
        }
    }
}
