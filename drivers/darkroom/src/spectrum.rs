//! The lamp's spectrum: a blue chip under a yellow and a red phosphor, cool white; or a filament.
//!
//! What an LED sends aside went a longer way through the phosphor. So light is a mixture of two spectra, and its colour
//! one number: how much phosphor light there is to the chip's, in units of that along an LED's axis.

use std::sync::LazyLock;

use crate::filament;
use crate::parts::Lamp;

/// V(λ) at 1 nm from 360 nm to 830 nm (CIE 018:2019; the same numbers as ISO/CIE 23539).
const ROWS: &str = include_str!("v_lambda.csv");

static V_LAMBDA: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let value = |row: &str| row.split_once(',').and_then(|(_, value)| value.trim().parse().ok());
    ROWS.lines().map(|row| value(row).unwrap_or(f64::NAN)).collect()
});

/// First wavelength of the tables, nm.
pub const FIRST_NM: usize = 360;
/// Last wavelength of the tables, nm.
pub const LAST_NM: usize = 830;

/// V(λ) at the nearest whole nanometre; zero outside the table.
pub fn v_lambda(wavelength_nm: f64) -> f64 {
    let place = wavelength_nm.round() - FIRST_NM as f64;
    let value = (place >= 0.0).then(|| V_LAMBDA.get(place as usize)).flatten();
    value.copied().unwrap_or(0.0)
}

/// Relative spectral power at `wavelength_nm` of light with `phosphor` times the phosphor's part; with 1 CCT 5896 K, Ra
/// 85.1, 311.4 lm/W, peak at 457 nm.
///
/// The blue peak is skewed to the red as a chip's is; the phosphors are broad and skewed likewise. Colour figures from
/// colour-science 0.4 on 360–830 nm.
pub fn relative_power(wavelength_nm: f64, phosphor: f64) -> f64 {
    let chip = skewed(wavelength_nm, 457.0, 9.5, 12.0);
    chip + phosphor * phosphor_power(wavelength_nm)
}

fn phosphor_power(wavelength_nm: f64) -> f64 {
    let yellow = skewed(wavelength_nm, 533.0, 31.0, 46.0);
    let red = skewed(wavelength_nm, 612.0, 38.0, 46.0);
    0.74 * (0.58 * yellow + 0.42 * red)
}

fn skewed(wavelength_nm: f64, peak_nm: f64, below_nm: f64, above_nm: f64) -> f64 {
    let width = if wavelength_nm < peak_nm { below_nm } else { above_nm };
    (-0.5 * ((wavelength_nm - peak_nm) / width).powi(2)).exp()
}

/// What gives the light.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// Chips under phosphor.
    Leds,
    /// A filament at this temperature, K.
    Filament(f64),
}

impl Source {
    /// Relative power of what is not the phosphor's, and of the phosphor with 1 of it.
    fn power(self, wavelength_nm: f64) -> [f64; 2] {
        match self {
            Self::Leds => [relative_power(wavelength_nm, 0.0), phosphor_power(wavelength_nm)],
            Self::Filament(temperature_k) => [filament::radiance(wavelength_nm, temperature_k), 0.0],
        }
    }
}

/// The lamp's spectrum, scaled to one lux.
#[derive(Debug, Clone, PartialEq)]
pub struct LampSpectrum {
    source: Source,
    /// ∫S dλ and 683·∫SV dλ along an LED's axis, and of its phosphor alone.
    power: f64,
    light: f64,
    phosphor_power: f64,
    phosphor_light: f64,
    /// Light at the lamp's current over that at the rated one.
    level: f64,
}

impl Default for LampSpectrum {
    fn default() -> Self {
        Self::from_source(Source::Leds)
    }
}

impl LampSpectrum {
    /// The spectrum of the lamp at its current.
    pub fn new(lamp: &Lamp) -> Self {
        if lamp.temperature_k == 0.0 {
            return Self::default();
        }
        let temperature_k = filament::temperature_at(lamp.temperature_k, lamp.current_error_rel);
        let [now, rated] =
            [temperature_k, lamp.temperature_k].map(|kelvin| Self::from_source(Source::Filament(kelvin)));
        Self {
            level: now.light / rated.light,
            ..now
        }
    }

    fn from_source(source: Source) -> Self {
        let mut spectrum = Self {
            source,
            power: 0.0,
            light: 0.0,
            phosphor_power: 0.0,
            phosphor_light: 0.0,
            level: 1.0,
        };
        for (v, wavelength_nm) in V_LAMBDA.iter().zip(FIRST_NM..=LAST_NM) {
            let [other, phosphor] = source.power(wavelength_nm as f64);
            spectrum.power += other + phosphor;
            spectrum.light += 683.0 * (other + phosphor) * v;
            spectrum.phosphor_power += phosphor;
            spectrum.phosphor_light += 683.0 * phosphor * v;
        }
        spectrum
    }

    /// Light at the lamp's current over that at the rated one.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// Relative power of what is not the phosphor's, and of the phosphor with 1 of it.
    pub(crate) fn parts(&self, wavelength_nm: f64) -> [f64; 2] {
        self.source.power(wavelength_nm)
    }

    /// The same, integrated over 360–830 nm.
    pub(crate) fn integrated_parts(&self) -> [f64; 2] {
        [self.power - self.phosphor_power, self.phosphor_power]
    }

    /// Relative power of light with `phosphor` times the phosphor's part.
    fn relative(&self, wavelength_nm: f64, phosphor: f64) -> f64 {
        let [other, part] = self.parts(wavelength_nm);
        other + phosphor * part
    }

    /// Spectral irradiance at one lux of light with `phosphor` times the phosphor's part, W/(m² nm).
    pub fn per_lux(&self, wavelength_nm: f64, phosphor: f64) -> f64 {
        (1.0 / self.light(phosphor)) * self.relative(wavelength_nm, phosphor)
    }

    /// Irradiance (360–830 nm) at one lux of such light, W/m².
    pub fn watt_per_lux(&self, phosphor: f64) -> f64 {
        (self.power + (phosphor - 1.0) * self.phosphor_power) / self.light(phosphor)
    }

    /// What a detector of the responsivity `weight` (per watt, over the wavelength in nm) makes of one lux of light
    /// with `phosphor` times the phosphor's part, relative to light along an LED's axis.
    pub fn response(&self, weight: &dyn Fn(f64) -> f64) -> impl Fn(f64) -> f64 + use<> {
        let (mut axial, mut of_phosphor) = (0.0, 0.0);
        for nm in (FIRST_NM..=LAST_NM).map(|nm| nm as f64) {
            let [other, phosphor] = self.source.power(nm);
            axial += weight(nm) * (other + phosphor);
            of_phosphor += weight(nm) * phosphor;
        }
        let (share, light) = (of_phosphor / axial, self.phosphor_light / self.light);
        move |phosphor| (1.0 + (phosphor - 1.0) * share) / (1.0 + (phosphor - 1.0) * light)
    }

    /// Luminous share of the phosphor in light with 1 of it.
    pub(crate) fn phosphor_light_share(&self) -> f64 {
        self.phosphor_light / self.light
    }

    /// 683·∫SV dλ of such light, in the unit of its relative power.
    pub(crate) fn light(&self, phosphor: f64) -> f64 {
        self.light + (phosphor - 1.0) * self.phosphor_light
    }

    /// The phosphor's part in light of several `(illuminance_lx, phosphor)` together; 1 without light.
    pub fn mixed(&self, parts: impl IntoIterator<Item = (f64, f64)>) -> f64 {
        let (mut chip, mut phosphor) = (0.0, 0.0);
        for (illuminance_lx, part) in parts {
            let amount = illuminance_lx / self.light(part);
            chip += amount;
            phosphor += amount * part;
        }
        if chip > 0.0 { phosphor / chip } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_v_is_whole() {
        let rows: Vec<(usize, f64)> = ROWS
            .lines()
            .map(|row| {
                row.split_once(',')
                    .map(|(l, v)| (l.parse().unwrap(), v.parse().unwrap()))
                    .unwrap()
            })
            .collect();
        assert_eq!(rows.len(), LAST_NM - FIRST_NM + 1);
        assert!(rows.iter().enumerate().all(|(k, row)| row.0 == FIRST_NM + k));
        assert_eq!(rows[555 - FIRST_NM].1, 1.0);
        // ∫V dλ = 106.857 nm (CIE 018:2019).
        assert!((rows.iter().map(|row| row.1).sum::<f64>() - 106.857).abs() < 0.001);
    }

    #[test]
    fn the_spectrum_is_an_honest_cool_white() {
        let spectrum = LampSpectrum::default();
        // 311.358 lm/W by colour-science 0.4 on the same formula.
        assert!(
            (1.0 / spectrum.watt_per_lux(1.0) - 311.358).abs() < 0.01,
            "{}",
            1.0 / spectrum.watt_per_lux(1.0)
        );
    }

    #[test]
    fn mixed_light_is_the_sum_of_its_parts() {
        let spectrum = LampSpectrum::default();
        let parts = [(300.0, 1.0), (50.0, 1.6), (20.0, 0.4)];
        let mixed = spectrum.mixed(parts);
        for nm in [430.0, 457.0, 520.0, 600.0, 700.0] {
            let sum: f64 = parts.iter().map(|(lx, part)| lx * spectrum.per_lux(nm, *part)).sum();
            assert!((370.0 * spectrum.per_lux(nm, mixed) / sum - 1.0).abs() < 1e-12, "{nm}");
        }
        let watts: f64 = parts.iter().map(|(lx, part)| lx * spectrum.watt_per_lux(*part)).sum();
        assert!((370.0 * spectrum.watt_per_lux(mixed) / watts - 1.0).abs() < 1e-12);
        assert_eq!(spectrum.mixed([(3.0, 1.0), (0.1, 1.0)]), 1.0);
        assert_eq!(spectrum.mixed([]), 1.0);
    }
}
