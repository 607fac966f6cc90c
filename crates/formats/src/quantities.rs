//! The quantities that a photometrist reads off a distribution.

mod glare;
mod luminous_body;
pub(crate) mod utilisation;

use isolux_photometry::IntensityDistribution;
use serde_json::{Map, Value, json};

use crate::distribution::Distribution;
use crate::distribution::Native;
use crate::ies::OwnLight;

impl Distribution {
    /// Keys and units as `inspect --json` prints them; what the file does not allow is null.
    pub fn quantities(&self) -> Map<String, Value> {
        let grid = &self.intensity;
        // A table of type A or B has its own flux and peak; the rest is of the light over C-γ.
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
        let (down, up) = (grid.flux_between_lm(0.0, 90.0), grid.flux_between_lm(90.0, 180.0));
        let angles = |of: fn(&IntensityDistribution, usize) -> Option<f64>| -> Vec<Option<f64>> {
            (0..grid.c_deg().len()).map(|plane| of(grid, plane)).collect()
        };
        let quantities = json!({
            "flux_lm": flux,
            "flux_stated_lm": self.lamp_flux_lm,
            "flux_up_lm": up,
            "flux_down_lm": down,
            "zonal_flux_lm": grid.zonal_flux_lm(10.0),
            "lorl_percent": self.lamp_flux_lm.filter(|&lamp| lamp > 0.0).map(|lamp| 100.0 * flux / lamp),
            "dff_percent": (over_grid > 0.0).then(|| 100.0 * down / over_grid),
            "i_max_cd": own.peak_cd,
            "i_max_c_deg": own.peak_c_deg,
            "i_max_gamma_deg": own.peak_gamma_deg,
            "beam_angle_deg": angles(|grid, plane| grid.beam_angle(plane).map(|beam| beam.full_angle_deg())),
            "field_angle_deg": angles(|grid, plane| grid.field_angle(plane).map(|field| field.full_angle_deg())),
            "luminous_area_mm2": self.luminaire.luminous_area_mm2(),
            "ugr": glare::table(self),
            "direct_ratios": utilisation::direct_ratios(grid),
            "cie_flux_code": utilisation::cie_flux_code(grid, self.lamp_flux_lm),
        });
        match quantities {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }
}
