//! The quantities that a photometrist reads off a distribution.

mod glare;
mod luminance;
mod luminous_body;
mod outdoor;
pub(crate) mod utilisation;

use isolux_photometry::IntensityDistribution;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distribution::Distribution;
use crate::distribution::Native;
use crate::ies::OwnLight;
pub use glare::GlareTable;
pub use luminance::{LuminanceTable, SCREEN_LIMITS_CD_M2, SCREEN_LUMINANCE_CD_M2};
pub use outdoor::Outdoor;

/// The quantities of one distribution, with the keys that `inspect --json` prints; what the file does not allow is null.
/// A table of type A or B has its own flux and peak; the rest is of the light over C-γ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantities {
    /// Luminous flux of the table.
    pub flux_lm: f64,
    /// Luminous flux of the lamps as the file states it.
    pub flux_stated_lm: Option<f64>,
    /// Into the upper half-space, γ above 90°.
    pub flux_up_lm: f64,
    /// Into the lower one.
    pub flux_down_lm: f64,
    /// In zones of 10° of γ.
    pub zonal_flux_lm: Vec<f64>,
    /// Light output ratio luminaire: flux over that of the lamps.
    pub lorl_percent: Option<f64>,
    /// Downward flux fraction.
    pub dff_percent: Option<f64>,
    /// Largest intensity.
    pub i_max_cd: f64,
    /// Its C.
    pub i_max_c_deg: f64,
    /// Its γ.
    pub i_max_gamma_deg: f64,
    /// Full angle between the edges at 50 % of the largest intensity, by half-plane.
    pub beam_angle_deg: Vec<Option<f64>>,
    /// At 10 %.
    pub field_angle_deg: Vec<Option<f64>>,
    /// Luminous area seen along γ 0°.
    pub luminous_area_mm2: Option<f64>,
    /// Mean luminance of the luminous area in the directions in which luminaires are seen; absent without an area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub luminance: Option<LuminanceTable>,
    /// Zones of the classification of outdoor luminaires; absent where it does not apply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outdoor: Option<Outdoor>,
    /// UGR of standard rooms; null without a luminous area or without downward light.
    pub ugr: Option<GlareTable>,
    /// Direct ratios of the room indices 0.6 to 5.
    pub direct_ratios: Option<[f64; 10]>,
    /// CIE flux code N1 to N5 in %.
    pub cie_flux_code: Option<[f64; 5]>,
}

impl Distribution {
    /// Its quantities.
    pub fn quantities(&self) -> Quantities {
        let grid = &self.intensity;
        let (over_grid, peak) = (grid.flux_lm(), grid.peak());
        let own = self.native.as_ref().map_or(
            OwnLight {
                flux_lm: over_grid,
                peak_cd: peak.intensity_cd,
                peak_c_deg: peak.c_deg,
                peak_gamma_deg: peak.gamma_deg,
            },
            Native::own_light,
        );
        let flux = own.flux_lm;
        let down = grid.flux_between_lm(0.0, 90.0);
        let angles = |of: fn(&IntensityDistribution, usize) -> Option<f64>| -> Vec<Option<f64>> {
            (0..grid.c_deg().len()).map(|plane| of(grid, plane)).collect()
        };
        Quantities {
            flux_lm: flux,
            flux_stated_lm: self.lamp_flux_lm,
            flux_up_lm: grid.flux_between_lm(90.0, 180.0),
            flux_down_lm: down,
            zonal_flux_lm: grid.zonal_flux_lm(10.0),
            lorl_percent: self
                .lamp_flux_lm
                .filter(|&lamp| lamp > 0.0)
                .map(|lamp| 100.0 * flux / lamp),
            dff_percent: (over_grid > 0.0).then(|| 100.0 * down / over_grid),
            i_max_cd: own.peak_cd,
            i_max_c_deg: own.peak_c_deg,
            i_max_gamma_deg: own.peak_gamma_deg,
            beam_angle_deg: angles(|grid, plane| grid.beam_angle(plane).map(|beam| beam.full_angle_deg())),
            field_angle_deg: angles(|grid, plane| grid.field_angle(plane).map(|field| field.full_angle_deg())),
            luminous_area_mm2: self.luminaire.luminous_area_mm2(),
            luminance: luminance::table(self),
            outdoor: outdoor::by_convention(self),
            ugr: glare::table(self),
            direct_ratios: utilisation::direct_ratios(grid),
            cie_flux_code: utilisation::cie_flux_code(grid, self.lamp_flux_lm),
        }
    }
}
