//! How far a colour is from the one that it should be, in steps: circles of the diagram (u′, v′).

use crate::illuminant::{daylight, planckian_chromaticity};
use crate::{Chromaticity, Tristimulus};

/// Radius of the circle of one step in (u′, v′), about that of a one-step ellipse of MacAdam near the Planckian locus
/// (CIE TN 001:2014, 3.2).
pub const STEP_UV: f64 = 0.0011;

/// From this temperature in K on a white light is compared with daylight (CIE 13.3).
const DAYLIGHT_FROM_K: f64 = 5000.0;

/// The colour that a white light of a rated temperature should have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Its chromaticity.
    pub chromaticity: Chromaticity,
    /// What it is the colour of.
    pub name: &'static str,
}

/// The Planckian radiator of a correlated colour temperature in K, from 5000 K on the CIE daylight; none outside
/// 1000–25 000 K.
pub fn target(cct_k: f64) -> Option<Target> {
    if !(1000.0..=25_000.0).contains(&cct_k) {
        return None;
    }
    let (chromaticity, name) = if cct_k < DAYLIGHT_FROM_K {
        (planckian_chromaticity(cct_k), "Planckian radiator")
    } else {
        let daylight = daylight(cct_k)?;
        (Tristimulus::of_1_nm(&daylight).chromaticity(), "CIE daylight")
    };
    let chromaticity = chromaticity?;
    Some(Target { chromaticity, name })
}

impl Chromaticity {
    /// Distance from another colour in steps of [`STEP_UV`].
    pub fn steps_from(self, other: Self) -> f64 {
        let ((u, v), (other_u, other_v)) = (self.uv_1976(), other.uv_1976());
        (u - other_u).hypot(v - other_v) / STEP_UV
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cct::{beside_locus, nearest_planckian};

    #[test]
    fn the_target_is_planckian_below_5000_k_and_daylight_from_there_on() {
        let duv = |cct_k: f64| nearest_planckian(target(cct_k).unwrap().chromaticity).unwrap();
        for cct_k in [2700.0, 4999.0] {
            let of = duv(cct_k);
            assert!((of.cct_k - cct_k).abs() < 1e-2 && of.duv.abs() < 1e-9, "{of:?}");
        }
        // CIE 15, table T.3: D65 is at x = 0.31272, y = 0.32903, 0.0032 above the Planckian locus.
        let d65 = target(6504.0).unwrap();
        let at = d65.chromaticity;
        assert!((at.x - 0.31272).abs() < 5e-5 && (at.y - 0.32903).abs() < 5e-5, "{at:?}");
        assert!((duv(6504.0).duv - 0.0032).abs() < 1e-4);
        assert_eq!((target(900.0), target(30_000.0)), (None, None));
    }

    #[test]
    fn steps_are_distances_in_the_diagram_of_1976() {
        let target = target(3000.0).unwrap().chromaticity;
        // Duv is a distance in (u, v) of 1960, whose v is two thirds of v′.
        let beside = beside_locus(3000.0, 0.001).unwrap();
        let ((u, v), (tu, tv)) = (beside.uv_1960(), target.uv_1960());
        let exact = (u - tu).hypot(1.5 * (v - tv)) / 0.0011;
        assert!(
            (beside.steps_from(target) - exact).abs() < 1e-9 && exact > 1.0,
            "{exact}"
        );
    }

    /// Ellipses of one step of MacAdam by luxpy 1.12.5 (`get_macadam_ellipse`), in (u′, v′): the radius of the circle
    /// of the same area.
    #[test]
    fn a_step_is_about_that_of_macadam() {
        for (cct_k, radius_uv) in [
            (2700.0, 1.232e-3),
            (3000.0, 1.286e-3),
            (4000.0, 1.374e-3),
            (5000.0, 1.333e-3),
            (6500.0, 1.059e-3),
        ] {
            assert!((STEP_UV / radius_uv - 1.0).abs() < 0.25, "{cct_k} K: {radius_uv}");
        }
    }
}
