//! The array spectroradiometer: what each of its pixels counts.

use crate::lines;
use crate::noise::{Noise, Stream};
use crate::parts::Spectroradiometer;
use crate::pixel::Pixel;
use crate::room::Room;
use crate::spectrum::v_lambda;

/// Pixels of the detector.
pub const PIXELS: usize = 2048;
/// First and last of the optically black pixels.
pub const BLACK_PIXELS: (usize, usize) = (6, 20);

/// Responsivity of grating and detector, relative to its maximum.
pub fn responsivity(wavelength_nm: f64) -> f64 {
    let blaze = (-0.5 * ((wavelength_nm - 560.0) / 190.0).powi(2)).exp();
    let silicon_edge = 1.0 / (1.0 + ((wavelength_nm - 1010.0) / 25.0).exp());
    let glass_edge = 1.0 / (1.0 + ((345.0 - wavelength_nm) / 6.0).exp());
    blaze * silicon_edge * glass_edge
}

/// What is known of one exposure before it is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Illuminance on the entrance, lx, zero behind a shutter.
    pub illuminance_lx: f64,
    /// Phosphor light in it against the chip's, 1 along an LED's axis.
    pub phosphor: f64,
    /// Illuminance of a line lamp on the entrance besides, lx.
    pub lines_lx: f64,
    /// Integration time, s.
    pub integration_s: f64,
    /// Temperature of the detector, °C.
    pub detector_c: f64,
    /// Number of the exposure since the instrument was switched on.
    pub index: u64,
}

impl Room {
    /// Spectral irradiance as the spectrometer's optics spread it, at the stated wavelength, W/(m² nm), for
    /// `illuminance_lx` with so much `phosphor` light on its entrance: shift, bandpass, stray light and second order
    /// are in it, its dark is not.
    pub fn spread_irradiance(&self, stated_nm: f64, illuminance_lx: f64, phosphor: f64) -> f64 {
        self.spread_light(self.spread_parts(stated_nm), illuminance_lx, phosphor)
    }

    fn spread_light(&self, [other, part]: [f64; 2], illuminance_lx: f64, phosphor: f64) -> f64 {
        illuminance_lx * ((other + phosphor * part) / self.spectrum().light(phosphor))
    }

    /// The spread light of what is not the phosphor's, and of the phosphor with 1 of it, in the unit of their relative
    /// power.
    fn spread_parts(&self, stated_nm: f64) -> [f64; 2] {
        let injected_effects = &self.document().injected_effects;
        let instrument = &self.document().spectroradiometer;
        let filtered = |nm: f64| self.spectrum().parts(nm).map(|power| instrument.filter(nm) * power);
        let true_nm = instrument.true_nm(stated_nm) - injected_effects.spectro_shift.shift_nm;
        // A triangle of the given full width at half maximum is the running mean of a running mean.
        let fwhm = injected_effects.spectro_bandpass.fwhm_nm;
        let first_order = if fwhm > 0.0 {
            const CELLS: usize = 24;
            let (mut sums, mut weight) = ([0.0; 2], 0.0);
            for k in 0..CELLS {
                let t = 2.0 * (k as f64 + 0.5) / CELLS as f64 - 1.0;
                let w = 1.0 - t.abs();
                for (sum, power) in sums.iter_mut().zip(filtered(true_nm + fwhm * t)) {
                    *sum += w * power;
                }
                weight += w;
            }
            sums.map(|sum| sum / weight)
        } else {
            filtered(true_nm)
        };
        let (whole, second_order) = (self.spectrum().integrated_parts(), filtered(0.5 * true_nm));
        std::array::from_fn(|part| {
            first_order[part]
                + injected_effects.spectro_stray.fraction * whole[part]
                + injected_effects.spectro_2nd.fraction * second_order[part]
        })
    }

    /// Spectral irradiance of `lines_lx` of a mercury-argon lamp as a pixel of `pixel_nm` sees it, W/(m² nm).
    fn spread_lines(&self, stated_nm: f64, pixel_nm: f64, lines_lx: f64) -> f64 {
        if lines_lx == 0.0 {
            return 0.0;
        }
        let injected_effects = &self.document().injected_effects;
        let instrument = &self.document().spectroradiometer;
        let true_nm = instrument.true_nm(stated_nm) - injected_effects.spectro_shift.shift_nm;
        let fwhm_nm = injected_effects.spectro_bandpass.fwhm_nm;
        let filtered = |nm: f64| instrument.filter(nm);
        lines_lx * lines::per_lux(true_nm, pixel_nm, fwhm_nm, filtered)
    }

    /// Spectral irradiance that a calibrated reading on the axis gives at the stated wavelength, noise-free, W/(m²
    /// nm).
    pub fn indicated_spectral_irradiance(&self, stated_nm: f64, illuminance_lx: f64) -> f64 {
        let gain = 1.0 + self.document().spectroradiometer.gain_error_rel;
        gain * self.spread_irradiance(stated_nm, illuminance_lx, 1.0)
            + self.document().injected_effects.spectro_dark.offset
    }

    /// Irradiance calibration of the instrument as its certificate states it: W/(m² nm) for one count per second at
    /// pixel `pixel`, after offset, dark and non-linearity. Zero where the responsivity is below a thousandth of its
    /// maximum.
    pub fn calibration(&self, pixel: usize) -> f64 {
        let instrument = &self.document().spectroradiometer;
        let response = responsivity(instrument.nm_at(pixel as f64));
        if response < 1e-3 {
            0.0
        } else {
            (1.0 + instrument.gain_error_rel) / (response * instrument.counts_per_s)
        }
    }

    /// Counts of all pixels in one exposure: light, dark, read and shot noise, non-linearity, the converter's end.
    pub fn exposure_counts(&self, exposure: &Exposure) -> Vec<u16> {
        let instrument = &self.document().spectroradiometer;
        let noise = Noise::new(self.document().seed, Stream::Spectrometer);
        let pixels = self.pixels.get_or_init(|| self.described_pixels());
        // Dark current of silicon doubles every 7 K.
        let dark_rate = instrument.dark_counts_per_s * ((exposure.detector_c - 25.0) / 7.0).exp2();
        let light: Vec<f64> = pixels
            .iter()
            .map(|pixel| {
                if pixel.is_black {
                    return 0.0;
                }
                let lamp = self.spread_light(pixel.spread_parts, exposure.illuminance_lx, exposure.phosphor);
                let lines = self.spread_lines(pixel.stated_nm, pixel.width_nm, exposure.lines_lx);
                (lamp + lines) * pixel.responsivity
            })
            .collect();
        let scattered = instrument.scatter_rel * light.iter().sum::<f64>() / PIXELS as f64;
        let counts = |(at, (pixel, light)): (usize, (&Pixel, &f64))| {
            // An error of the dark is not seen by the black pixels: it is what makes it an error.
            let (pedestal, scattered) = if pixel.is_black {
                (0.0, 0.0)
            } else {
                (self.document().injected_effects.spectro_dark.offset, scattered)
            };
            let rate = (light + scattered + pedestal * pixel.responsivity) * instrument.counts_per_s;
            let dark = dark_rate * pixel.dark_rel;
            let collected = (rate + dark) * exposure.integration_s;
            let [shot, read] = noise.normal_pair(exposure.index, at as u32);
            let electrons = collected.max(0.0) * instrument.electrons_per_count;
            let linear = collected + shot * electrons.sqrt() / instrument.electrons_per_count;
            let counts = bend(instrument, linear) + instrument.offset_counts + read * instrument.read_noise_counts;
            counts.round().clamp(0.0, f64::from(instrument.saturation_counts)) as u16
        };
        pixels.iter().zip(&light).enumerate().map(counts).collect()
    }

    /// All pixels, as they are in every exposure.
    fn described_pixels(&self) -> Vec<Pixel> {
        let instrument = &self.document().spectroradiometer;
        let pattern = Noise::new(self.document().seed, Stream::DarkPattern);
        let described = |pixel: usize| {
            let [stated_nm, next_nm] = [pixel, pixel + 1].map(|pixel| instrument.nm_at(pixel as f64));
            Pixel {
                is_black: (BLACK_PIXELS.0..=BLACK_PIXELS.1).contains(&pixel),
                stated_nm,
                width_nm: next_nm - stated_nm,
                responsivity: responsivity(stated_nm),
                spread_parts: self.spread_parts(stated_nm),
                dark_rel: (1.0 + 0.05 * pattern.normal(pixel as u64, 0)).max(0.0),
            }
        };
        (0..PIXELS).map(described).collect()
    }
}

/// Noise of the illuminance that exposures of `integration_s` give without light, weighted by V(λ), lx: read noise and
/// that of the dark current at 25 °C, as independent in each pixel.
pub fn dark_noise_lx(instrument: &Spectroradiometer, integration_s: f64) -> f64 {
    let dark = instrument.dark_counts_per_s * integration_s / instrument.electrons_per_count;
    let counts = (instrument.read_noise_counts.powi(2) + dark).sqrt();
    let squares = (1..PIXELS).map(|pixel| {
        let [before_nm, nm] = [pixel - 1, pixel].map(|pixel| instrument.nm_at(pixel as f64));
        let per_count = (nm - before_nm) / (responsivity(nm) * instrument.counts_per_s * integration_s);
        (683.0 * v_lambda(nm) * per_count * counts).powi(2)
    });
    squares.sum::<f64>().sqrt()
}

/// The detector's loss towards full scale.
fn bend(instrument: &Spectroradiometer, linear: f64) -> f64 {
    let loss = instrument.nonlinearity + instrument.nonlinearity_error;
    linear * (1.0 - loss * linear / 65_535.0)
}

/// Coefficients of the polynomial P(counts) that undoes the non-linearity as linear = counts / P(counts), as the
/// maker's calibration stores them (order 7).
///
/// With counts = x (1 − a x), x = counts · C(a · counts) where C is the generating function of Catalan's numbers,
/// and 1/C(t) = 1 − t C(t).
pub fn linearity_coefficients(instrument: &Spectroradiometer) -> [f64; 8] {
    const CATALAN: [f64; 7] = [1.0, 1.0, 2.0, 5.0, 14.0, 42.0, 132.0];
    let a = instrument.nonlinearity / 65_535.0;
    std::array::from_fn(|k| {
        if k == 0 {
            1.0
        } else {
            -CATALAN[k - 1] * a.powi(k as i32)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;

    fn quiet() -> Darkroom {
        let mut document = Darkroom::default();
        document.spectroradiometer.read_noise_counts = 0.0;
        document.spectroradiometer.electrons_per_count = 1e12;
        document
    }

    /// The whole chain backwards with what the instrument tells of itself gives the light that went in.
    #[test]
    fn counts_lead_back_to_the_irradiance() {
        let mut document = quiet();
        document.spectroradiometer.gain_error_rel = 0.0;
        let room = Room::new(document);
        let instrument = &room.document().spectroradiometer;
        let exposure = Exposure {
            illuminance_lx: 1330.0,
            phosphor: 1.0,
            lines_lx: 0.0,
            integration_s: 0.2,
            detector_c: 25.0,
            index: 3,
        };
        let illuminated = room.exposure_counts(&exposure);
        let dark = room.exposure_counts(&Exposure {
            illuminance_lx: 0.0,
            ..exposure
        });
        let linearity = linearity_coefficients(instrument);
        let linear = |counts: u16| {
            let c = f64::from(counts) - instrument.offset_counts;
            c / linearity.iter().rev().fold(0.0, |sum, k| sum * c + k)
        };
        let mut worst: f64 = 0.0;
        for pixel in 100..1500 {
            let nm = instrument.nm_at(pixel as f64);
            let expected = room.spread_irradiance(nm, 1330.0, 1.0);
            let got = (linear(illuminated[pixel]) - linear(dark[pixel])) / 0.2 * room.calibration(pixel);
            worst = worst.max((got - expected).abs());
        }
        let peak = room.spread_irradiance(457.0, 1330.0, 1.0);
        assert!(worst < 2e-4 * peak, "{worst} of {peak}");
        assert!(
            *illuminated.iter().max().unwrap() > 10_000,
            "{:?}",
            illuminated.iter().max()
        );
    }

    #[test]
    fn the_converter_ends_and_black_pixels_stay_black() {
        let room = Room::new(quiet());
        let exposure = Exposure {
            illuminance_lx: 1330.0,
            phosphor: 1.0,
            lines_lx: 0.0,
            integration_s: 30.0,
            detector_c: 25.0,
            index: 0,
        };
        let counts = room.exposure_counts(&exposure);
        assert_eq!(*counts.iter().max().unwrap(), 65_535);
        assert!(counts[BLACK_PIXELS.0] < 10_000);
    }

    #[test]
    fn the_injected_effects_of_the_spectrometer_do_what_they_say() {
        let clean = Room::new(quiet());
        let disturbed = |name: &str, key: &str, value: f64| {
            let mut document = quiet();
            assert!(document.injected_effects.set(name, key, value));
            Room::new(document)
        };
        let shifted = disturbed("spectro_shift", "shift_nm", 0.4);
        assert_eq!(
            shifted.spread_irradiance(500.4, 1.0, 1.0),
            clean.spread_irradiance(500.0, 1.0, 1.0)
        );
        let second = disturbed("spectro_2nd", "fraction", 0.01);
        let extra = second.spread_irradiance(914.0, 1.0, 1.0) - clean.spread_irradiance(914.0, 1.0, 1.0);
        assert!((extra / (0.01 * clean.spread_irradiance(457.0, 1.0, 1.0)) - 1.0).abs() < 1e-9);
        // A triangle of FWHM b widens the curve by variance b²/6: second derivative times b²/12.
        let wide = disturbed("spectro_bandpass", "fwhm_nm", 4.0);
        let s = |nm: f64| clean.spread_irradiance(nm, 1.0, 1.0);
        let curvature = s(561.0) - 2.0 * s(560.0) + s(559.0);
        let got = wide.spread_irradiance(560.0, 1.0, 1.0) - s(560.0);
        assert!(
            (got / (curvature * 16.0 / 12.0) - 1.0).abs() < 0.02,
            "{got} {curvature}"
        );
    }
}
