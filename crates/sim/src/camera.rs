//! From irradiance to digital numbers: photons, electrons and the noise of a camera (EMVA 1288 release 4.0).

use isolux_spectrum::Spectrum;

use crate::random::{Purpose, Random};

/// h·c in J·m.
const HC_J_M: f64 = 1.986_445_857_148_928_6e-25;

/// Photon irradiance in 1/(m²·s) of light of `irradiance_w_m2` with the relative spectrum `spectrum`, each photon
/// weighted by `efficiency`, at 1 nm over 360–830 nm. `None` where the spectrum has no power there.
pub fn photon_irradiance(irradiance_w_m2: f64, spectrum: &Spectrum, efficiency: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut power, mut photons) = (0.0, 0.0);
    for (nm, value) in per_nm(spectrum) {
        power += value;
        photons += value * efficiency(nm) * nm * 1e-9 / HC_J_M;
    }
    (power > 0.0).then(|| irradiance_w_m2 * photons / power)
}

/// Photons of one joule at a wavelength: λ/(h·c).
pub fn photons_per_joule(wavelength_nm: f64) -> f64 {
    wavelength_nm * 1e-9 / HC_J_M
}

/// Irradiance in W/m² within [from, to) nm, of light of `irradiance_w_m2` in all.
pub fn band_irradiance(irradiance_w_m2: f64, spectrum: &Spectrum, from_nm: f64, to_nm: f64) -> Option<f64> {
    let (mut all, mut band) = (0.0, 0.0);
    for (nm, value) in per_nm(spectrum) {
        all += value;
        if (from_nm..to_nm).contains(&nm) {
            band += value;
        }
    }
    (all > 0.0).then(|| irradiance_w_m2 * band / all)
}

/// Whole nanometres and what of the spectrum falls to each.
fn per_nm(spectrum: &Spectrum) -> impl Iterator<Item = (f64, f64)> {
    (360..=830).map(f64::from).zip(spectrum.per_nm())
}

/// A camera's pixel, as an EMVA 1288 data sheet has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Exposure time, s.
    pub exposure_s: f64,
    /// Dark current, electrons/s.
    pub dark_electrons_per_s: f64,
    /// Temporal dark noise (read noise), electrons.
    pub read_noise_electrons: f64,
    /// Dark signal non-uniformity, electrons.
    pub dsnu_electrons: f64,
    /// Photo response non-uniformity, relative.
    pub prnu_rel: f64,
    /// Full well, electrons.
    pub full_well_electrons: f64,
    /// Overall system gain K, digital numbers per electron.
    pub gain_dn_per_electron: f64,
    /// Offset, digital numbers.
    pub offset_dn: f64,
    /// Bits of the converter.
    pub bits: u32,
}

impl Camera {
    /// Expected electrons of a pixel of `area_m2` in light of `photons_per_m2_s`, already weighted by the quantum
    /// efficiency; dark current included, full well applied.
    pub fn electrons(&self, photons_per_m2_s: f64, area_m2: f64) -> f64 {
        let light = photons_per_m2_s * area_m2 * self.exposure_s;
        (light + self.dark_electrons_per_s * self.exposure_s).min(self.full_well_electrons)
    }

    /// One exposure: shot noise, fixed patterns, read noise, full well, gain, quantisation. `fixed` seeds what stays
    /// from exposure to exposure, `seed` what does not.
    pub fn expose(&self, photons_per_m2_s: &[f64], area_m2: f64, fixed: u64, seed: u64) -> Vec<u32> {
        let (pattern, noise) = (Random::new(fixed, Purpose::Camera), Random::new(seed, Purpose::Pixel));
        let top = (1_u64 << self.bits.min(32)) - 1;
        photons_per_m2_s
            .iter()
            .enumerate()
            .map(|(index, photons)| {
                let (mut still, mut moving) = (pattern.sequence(index as u64), noise.sequence(index as u64));
                let light = photons * area_m2 * self.exposure_s * (1.0 + self.prnu_rel * still.normal());
                let dark = self.dark_electrons_per_s * self.exposure_s;
                let caught = moving.poisson((light + dark).max(0.0)) as f64 + self.dsnu_electrons * still.normal();
                let held = caught.min(self.full_well_electrons) + self.read_noise_electrons * moving.normal();
                (self.offset_dn + self.gain_dn_per_electron * held)
                    .round()
                    .clamp(0.0, top as f64) as u32
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            exposure_s: 0.01,
            dark_electrons_per_s: 20.0,
            read_noise_electrons: 3.0,
            dsnu_electrons: 0.0,
            prnu_rel: 0.0,
            full_well_electrons: 1e4,
            gain_dn_per_electron: 0.4,
            offset_dn: 64.0,
            bits: 12,
        }
    }

    #[test]
    fn photons_of_one_line_have_its_energy() {
        // 1 W/m² at 555 nm: λ/(hc) = 2.794e18 photons per joule.
        let line = Spectrum::new(vec![554.0, 555.0, 556.0], vec![0.0, 1.0, 0.0]).unwrap();
        let photons = photon_irradiance(1.0, &line, |_| 1.0).unwrap();
        assert!((photons / 2.793_935e18 - 1.0).abs() < 1e-5, "{photons}");
        assert!((photon_irradiance(1.0, &line, |_| 0.6).unwrap() / photons - 0.6).abs() < 1e-12);
    }

    #[test]
    fn bands_add_up() {
        let flat = Spectrum::new(vec![300.0, 900.0], vec![1.0, 1.0]).unwrap();
        let bands: f64 = (0..10)
            .map(|k| band_irradiance(4.0, &flat, 350.0 + 50.0 * f64::from(k), 400.0 + 50.0 * f64::from(k)).unwrap())
            .sum();
        assert!((bands - 4.0).abs() < 1e-12, "{bands}");
    }

    #[test]
    fn the_photon_transfer_curve_gives_the_gain_back() {
        let camera = camera();
        let area = 12e-6_f64 * 12e-6;
        let electrons = 4000.0;
        let photons = (electrons - 0.2) / (area * camera.exposure_s);
        assert!((camera.electrons(photons, area) - electrons).abs() < 1e-6);
        let flat = vec![photons; 40_000];
        let dn: Vec<f64> = camera.expose(&flat, area, 1, 2).into_iter().map(f64::from).collect();
        let mean = dn.iter().sum::<f64>() / dn.len() as f64;
        let variance = dn.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / dn.len() as f64;
        assert!((mean - (64.0 + 0.4 * electrons)).abs() < 1.0, "{mean}");
        // K²(σ_d² + µ_e) + 1/12 (EMVA 1288, the photon transfer).
        let k = camera.gain_dn_per_electron;
        let expected = k * k * (camera.read_noise_electrons.powi(2) + electrons) + 1.0 / 12.0;
        assert!((variance / expected - 1.0).abs() < 0.04, "{variance} {expected}");
    }

    #[test]
    fn full_well_and_converter_end_the_scale() {
        let camera = Camera {
            read_noise_electrons: 0.0,
            ..camera()
        };
        let bright = camera.expose(&[1e30], 1e-10, 1, 1);
        assert_eq!(bright, [4064]);
        assert_eq!(camera.expose(&[0.0], 1e-10, 1, 1).len(), 1);
    }
}
