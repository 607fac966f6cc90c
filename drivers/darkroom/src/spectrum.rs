//! The lamp's spectrum: a blue chip under a yellow and a red phosphor, cool white.

/// V(λ) at 1 nm from 360 nm to 830 nm (CIE 018:2019; the same numbers as ISO/CIE 23539).
const V_LAMBDA: &str = include_str!("v_lambda.csv");

/// First wavelength of the tables, nm.
pub const FIRST_NM: usize = 360;
/// Last wavelength of the tables, nm.
pub const LAST_NM: usize = 830;

/// Relative spectral power at `wavelength_nm`: CCT 5896 K, Ra 85.1, 311.4 lm/W, peak at 457 nm.
///
/// The blue peak is skewed to the red as a chip's is; the phosphors are broad and skewed likewise. Colour figures from
/// colour-science 0.4 on 360–830 nm.
pub fn relative_power(wavelength_nm: f64) -> f64 {
    let chip = skewed(wavelength_nm, 457.0, 9.5, 12.0);
    let yellow = skewed(wavelength_nm, 533.0, 31.0, 46.0);
    let red = skewed(wavelength_nm, 612.0, 38.0, 46.0);
    chip + 0.74 * (0.58 * yellow + 0.42 * red)
}

fn skewed(wavelength_nm: f64, peak_nm: f64, below_nm: f64, above_nm: f64) -> f64 {
    let width = if wavelength_nm < peak_nm { below_nm } else { above_nm };
    (-0.5 * ((wavelength_nm - peak_nm) / width).powi(2)).exp()
}

/// The lamp's spectrum, scaled to one lux.
#[derive(Debug, Clone, PartialEq)]
pub struct LampSpectrum {
    watt_per_lux: f64,
    scale: f64,
}

impl Default for LampSpectrum {
    fn default() -> Self {
        let mut power = 0.0;
        let mut light = 0.0;
        for (row, wavelength_nm) in V_LAMBDA.lines().zip(FIRST_NM..=LAST_NM) {
            let v: f64 = row
                .split_once(',')
                .and_then(|(_, v)| v.trim().parse().ok())
                .unwrap_or(f64::NAN);
            let s = relative_power(wavelength_nm as f64);
            power += s;
            light += 683.0 * s * v;
        }
        Self {
            watt_per_lux: power / light,
            scale: 1.0 / light,
        }
    }
}

impl LampSpectrum {
    /// Spectral irradiance at one lux, W/(m² nm).
    pub fn per_lux(&self, wavelength_nm: f64) -> f64 {
        self.scale * relative_power(wavelength_nm)
    }

    /// Irradiance (360–830 nm) at one lux, W/m².
    pub fn watt_per_lux(&self) -> f64 {
        self.watt_per_lux
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_v_is_whole() {
        let rows: Vec<(usize, f64)> = V_LAMBDA
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
            (1.0 / spectrum.watt_per_lux() - 311.358).abs() < 0.01,
            "{}",
            1.0 / spectrum.watt_per_lux()
        );
    }
}
