//! What light does beside being seen: blue-light hazard, photons for plants, melanopic efficacy. Each is a ratio to the
//! light that is seen, so that it needs a relative spectrum alone.

use crate::per_nm::per_nm;
use crate::{Spectrum, cie, illuminant};

/// Blue-light hazard weighting function B(λ) by 5 nm from 380 nm to 500 nm: IEC 62471:2006, Table 4.2 (ICNIRP 2013,
/// Table 2, has 0.0125 at 385 nm). Below, from 300 nm on, it is 0.01; to 600 nm 10^((450 − λ)/50); to 700 nm 0.001.
const B_BY_5_NM: [f64; 25] = [
    0.01, 0.013, 0.025, 0.05, 0.1, 0.2, 0.4, 0.8, 0.9, 0.95, 0.98, 1.0, 1.0, 0.97, 0.94, 0.9, 0.8, 0.7, 0.62, 0.55,
    0.45, 0.4, 0.22, 0.16, 0.1,
];

/// Irradiance weighted with B(λ) in W/m² up to which a small source is of no higher risk group than 1, at an exposure
/// of 100 s and more (IEC 62471:2006, Table 6.1).
pub const E_B_LIMIT_W_M2: f64 = 1.0;

/// Planck constant × speed of light × Avogadro constant in J·m/mol, of their values in the SI.
const HC_NA_J_M_PER_MOL: f64 = 6.626_070_15e-34 * 299_792_458.0 * 6.022_140_76e23;

/// Photons that plants use are counted between these wavelengths in nm.
const PHOTONS_NM: [usize; 2] = [400, 700];

/// CIE standard illuminant D65: a daylight of this temperature in K (CIE 15, 4.1.2).
const D65_K: f64 = 6500.0 * 1.4388 / 1.4380;

/// B(λ) at 360, 361, … 830 nm, linear between the points of its table.
pub fn blue_light_hazard() -> [f64; 471] {
    std::array::from_fn(|place| {
        let nm = cie::FIRST_NM + place;
        match nm {
            ..380 => B_BY_5_NM[0],
            380..500 => {
                let (point, part) = ((nm - 380) / 5, ((nm - 380) % 5) as f64 / 5.0);
                B_BY_5_NM[point] + part * (B_BY_5_NM[point + 1] - B_BY_5_NM[point])
            }
            500..=600 => 10.0_f64.powf((450.0 - nm as f64) / 50.0),
            601..=700 => 0.001,
            _ => 0.0,
        }
    })
}

impl Spectrum {
    /// Blue-light hazard efficacy of luminous radiation K_B,v = ∫S·B dλ / (K_m ∫S·V dλ) in W/lm, over 360–830 nm (IEC
    /// TR 62778, 5.1); none without light.
    pub fn k_bv_w_per_lm(&self) -> Option<f64> {
        self.per_lumen(&blue_light_hazard())
    }

    /// Photons of 400–700 nm in µmol/s for one lumen; none without light.
    pub fn photons_umol_per_s_lm(&self) -> Option<f64> {
        let per_joule = |nm: f64| 1e6 * nm * 1e-9 / HC_NA_J_M_PER_MOL;
        let [first, last] = PHOTONS_NM;
        let weights: [f64; 471] = std::array::from_fn(|place| {
            let nm = cie::FIRST_NM + place;
            // The range is cut at whole nanometres: half of what stands there lies outside.
            let inside = match nm {
                nm if nm == first || nm == last => 0.5,
                nm if (first..last).contains(&nm) => 1.0,
                _ => 0.0,
            };
            inside * per_joule(nm as f64)
        });
        self.per_lumen(&weights)
    }

    /// Daylight efficacy ratio for the action spectrum `action`: its efficacy of luminous radiation over that of
    /// illuminant D65 (CIE S 026). The melanopic DER with the melanopic action spectrum; none without light or
    /// where D65 has none of it.
    pub fn daylight_efficacy_ratio(&self, action: &Self) -> Option<f64> {
        let d65 = Self::from_1_nm(&illuminant::daylight(D65_K)?)?;
        // Both may be finer than 1 nm: their product is integrated.
        let efficacy = |light: &Self| {
            let luminous = light.luminous_integral();
            let acting: f64 = per_nm(&[light, action]).iter().sum();
            (luminous > 0.0).then(|| acting / luminous)
        };
        let (of, of_d65) = (efficacy(self)?, efficacy(&d65)?);
        (of_d65 > 0.0).then(|| of / of_d65)
    }

    fn per_lumen(&self, weights: &[f64; 471]) -> Option<f64> {
        let luminous = self.luminous_integral();
        let sum: f64 = self.per_nm().iter().zip(weights).map(|(s, weight)| s * weight).sum();
        let ratio = sum / luminous;
        (luminous > 0.0 && ratio.is_finite()).then_some(ratio)
    }
}

/// Illuminance in lx below which light of this K_B,v in W/lm is of no higher risk group than 1, whatever the size of
/// its source: E_thr of IEC TR 62778, [`E_B_LIMIT_W_M2`] ÷ K_B,v.
pub fn threshold_illuminance_lx(k_bv_w_per_lm: f64) -> f64 {
    E_B_LIMIT_W_M2 / k_bv_w_per_lm
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: &[f64; 471]) -> Spectrum {
        Spectrum::from_1_nm(value).unwrap()
    }

    fn line(nm: f64) -> Spectrum {
        Spectrum::new(vec![nm - 1.0, nm, nm + 1.0], vec![0.0, 1.0, 0.0]).unwrap()
    }

    #[test]
    fn the_weighting_of_a_line_is_the_printed_value() {
        let b = blue_light_hazard();
        for (nm, printed) in [
            (360, 0.01),
            (400, 0.1),
            (440, 1.0),
            (450, 0.94),
            (485, 0.4),
            (500, 0.1),
            (550, 0.01),
            (600, 0.001),
            (650, 0.001),
            (700, 0.001),
            (701, 0.0),
        ] {
            assert!((b[nm - 360] - printed).abs() < 1e-12, "{nm} nm: {}", b[nm - 360]);
        }
        assert!((b[387 - 360] - (0.013 + 0.4 * 0.012)).abs() < 1e-12);
        // 1 W/m² at 440 nm weighs 1 W/m²; its illuminance is 683·V(440 nm).
        let lx = 683.0 * cie::V_LAMBDA[440 - 360];
        let threshold = threshold_illuminance_lx(line(440.0).k_bv_w_per_lm().unwrap());
        assert!((threshold / lx - 1.0).abs() < 1e-12, "{threshold}");
    }

    #[test]
    fn efficacies_are_those_of_another_program() {
        // luxpy 1.12.5: Σ S·_BLH ÷ (683·Σ S·V) at 1 nm over 360–830 nm with its tables of B (but 0.01 below 380 nm,
        // where it extrapolates), V, D65 and A.
        let d65 = of(&illuminant::daylight(D65_K).unwrap()).k_bv_w_per_lm().unwrap();
        let a = of(&illuminant::illuminant_a()).k_bv_w_per_lm().unwrap();
        assert!((d65 / 9.863_092e-4 - 1.0).abs() < 2e-4, "{d65:e}");
        assert!((a / 3.071_266e-4 - 1.0).abs() < 1e-4, "{a:e}");
        assert_eq!(of(&[0.0; 471]).k_bv_w_per_lm(), None);
    }

    #[test]
    fn photons_are_counted_from_400_to_700_nm() {
        // A line at 555 nm: 683 lm/W, and λ/(h·c·N_A) = 4.6394 µmol/J.
        let green = line(555.0).photons_umol_per_s_lm().unwrap();
        assert!((green * 683.0 - 4.639_44).abs() < 1e-4, "{}", green * 683.0);
        assert_eq!(line(720.0).photons_umol_per_s_lm(), Some(0.0));
        // Equal energy: ∫λ dλ from 400 to 700 nm is 165 000 nm².
        let equal = Spectrum::new(vec![360.0, 830.0], vec![1.0, 1.0]).unwrap();
        let exact = 165_000.0 * 1e-3 / HC_NA_J_M_PER_MOL / equal.luminous_integral();
        assert!((equal.photons_umol_per_s_lm().unwrap() / exact - 1.0).abs() < 1e-9);
        assert!((HC_NA_J_M_PER_MOL - 0.119_626_566).abs() < 1e-9);
    }

    #[test]
    fn daylight_has_the_efficacy_of_daylight() {
        let action = Spectrum::new(vec![380.0, 490.0, 600.0], vec![0.0, 1.0, 0.0]).unwrap();
        let d65 = of(&illuminant::daylight(D65_K).unwrap());
        assert!((d65.daylight_efficacy_ratio(&action).unwrap() - 1.0).abs() < 1e-12);
        // With V(λ) as the action every light has it.
        let v = of(&cie::V_LAMBDA);
        let a = of(&illuminant::illuminant_a());
        assert!((a.daylight_efficacy_ratio(&v).unwrap() - 1.0).abs() < 1e-12);
        assert!(a.daylight_efficacy_ratio(&action).unwrap() < 0.6);
        let infrared = Spectrum::new(vec![900.0, 901.0], vec![1.0, 1.0]).unwrap();
        assert_eq!(a.daylight_efficacy_ratio(&infrared), None);
    }
}
