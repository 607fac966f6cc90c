//! One exposure of a scene's camera.

use isolux_model::optics::CameraSheet;

use super::facts::CameraFacts;
use crate::camera::Camera;
use crate::noise;

/// One exposure of the scene's camera.
pub(super) struct Exposure {
    pub signal_dn: Vec<u16>,
    pub facts: CameraFacts,
}

impl Exposure {
    /// `photons` per (m²·s) and unit of the map, weighted by the quantum efficiency, by the number of the pixel.
    pub fn of(sheet: &CameraSheet, map: &[f64], photons: &dyn Fn(usize) -> f64, pixel_m2: f64) -> Self {
        let camera = Camera {
            exposure_s: sheet.exposure_s,
            dark_electrons_per_s: sheet.dark_electrons_per_s,
            read_noise_electrons: sheet.read_noise_electrons,
            dsnu_electrons: sheet.dsnu_electrons,
            prnu_rel: sheet.prnu_rel,
            full_well_electrons: sheet.full_well_electrons,
            gain_dn_per_electron: sheet.gain_dn_per_electron,
            offset_dn: sheet.offset_dn,
            bits: sheet.bits,
        };
        let light: Vec<f64> = map
            .iter()
            .enumerate()
            .map(|(pixel, value)| value.max(0.0) * photons(pixel))
            .collect();
        let top = (1_u32 << sheet.bits.min(16)) - 1;
        // Pixels differ from camera to camera, not from exposure to exposure: one camera, seed 1.
        let signal_dn: Vec<u16> = camera
            .expose(&light, pixel_m2, 1, sheet.seed)
            .into_iter()
            .map(|dn| dn as u16)
            .collect();
        let n = map.len() as f64;
        let mean_electrons = noise::sum(light.iter().map(|photons| camera.electrons(*photons, pixel_m2))) / n;
        let caught = noise::sum(
            light
                .iter()
                .map(|photons| (photons * pixel_m2 * sheet.exposure_s).min(sheet.full_well_electrons)),
        ) / n;
        let full = light
            .iter()
            .filter(|photons| camera.electrons(**photons, pixel_m2) >= sheet.full_well_electrons)
            .count();
        let variance = sheet.read_noise_electrons.powi(2)
            + mean_electrons
            + (sheet.prnu_rel * caught).powi(2)
            + sheet.dsnu_electrons.powi(2)
            + (12.0 * sheet.gain_dn_per_electron.powi(2)).recip();
        Self {
            facts: CameraFacts {
                mean_electrons,
                mean_dn: noise::sum(signal_dn.iter().map(|dn| f64::from(*dn))) / n,
                full_well_pixels: full,
                clipped_pixels: signal_dn.iter().filter(|dn| u32::from(**dn) == top).count(),
                signal_to_noise: (variance > 0.0).then(|| caught / variance.sqrt()),
                seed: sheet.seed,
            },
            signal_dn,
        }
    }
}
