//! The head of the lux meter: what it makes of one lux of the lamp's light, calibrated with illuminant A.

use crate::parts::LuxMeter;
use crate::spectrum::{FIRST_NM, LAST_NM, LampSpectrum, v_lambda};

/// Middle and width of a leak of its filter in the blue, nm.
const LEAK_NM: (f64, f64) = (440.0, 25.0);

/// Relative spectral responsivity of the head: V(λ) displaced, and a leak in the blue.
pub fn responsivity(meter: &LuxMeter, wavelength_nm: f64) -> f64 {
    let at = wavelength_nm - meter.head_shift_nm;
    let (below, share) = (at.floor(), at - at.floor());
    let v = (1.0 - share) * v_lambda(below) + share * v_lambda(below + 1.0);
    v + meter.head_blue_rel * (-0.5 * ((wavelength_nm - LEAK_NM.0) / LEAK_NM.1).powi(2)).exp()
}

/// Whether the head is V(λ) itself.
pub fn is_perfect(meter: &LuxMeter) -> bool {
    meter.head_shift_nm == 0.0 && meter.head_blue_rel == 0.0
}

/// CIE standard illuminant A by the formula of its definition, 1 at 560 nm.
fn illuminant_a(wavelength_nm: f64) -> f64 {
    let planck = |nm: f64| (560.0 / nm).powi(5) / (1.435e7 / (2848.0 * nm)).exp_m1();
    planck(wavelength_nm) / planck(560.0)
}

/// What a head shows of one lux of the lamp's light, by how much of the phosphor's is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Head {
    /// Shown of one lux with 1 of it, and what each more of it adds to that in the unit of its light.
    along_axis: f64,
    more: f64,
    /// Luminous share of the phosphor in light with 1 of it.
    phosphor_light: f64,
}

impl Head {
    /// None for a head that is V(λ).
    pub fn new(meter: &LuxMeter, lamp: &LampSpectrum) -> Option<Self> {
        if is_perfect(meter) {
            return None;
        }
        let all_nm = || (FIRST_NM..=LAST_NM).map(|nm| nm as f64);
        let [mut of_a, mut light_of_a, mut one, mut two] = [0.0; 4];
        for nm in all_nm() {
            let s = responsivity(meter, nm);
            of_a += s * illuminant_a(nm);
            light_of_a += 683.0 * v_lambda(nm) * illuminant_a(nm);
            one += s * lamp.per_lux(nm, 1.0);
            two += s * lamp.per_lux(nm, 2.0);
        }
        let of_one_lux = of_a / light_of_a;
        let phosphor_light = lamp.phosphor_light_share();
        let along_axis = one / of_one_lux;
        Some(Self {
            along_axis,
            more: two / of_one_lux * (1.0 + phosphor_light) - along_axis,
            phosphor_light,
        })
    }

    /// What it shows of one lux of light with `phosphor` times the phosphor's part, lx.
    pub fn shown_of_one_lux(&self, phosphor: f64) -> f64 {
        (self.along_axis + (phosphor - 1.0) * self.more) / (1.0 + (phosphor - 1.0) * self.phosphor_light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values by numpy and the tables of colour-science 0.4.7: 1/F* of the same head and lights.
    #[test]
    fn a_displaced_head_shows_too_little_of_a_cool_white() {
        let meter = LuxMeter {
            head_shift_nm: 4.0,
            head_blue_rel: 0.02,
            ..LuxMeter::default()
        };
        let head = Head::new(&meter, &LampSpectrum::default()).unwrap();
        for (phosphor, f_star) in [(1.0, 1.022_128_2), (1.25, 1.022_568_2), (0.8, 1.021_587_8)] {
            let shown = head.shown_of_one_lux(phosphor);
            assert!((shown * f_star - 1.0).abs() < 2e-6, "{phosphor}: {shown}");
        }
        assert_eq!(Head::new(&LuxMeter::default(), &LampSpectrum::default()), None);
    }
}
