//! Correlated colour temperature and distance from the Planckian locus.

use crate::illuminant::planckian_chromaticity;
use crate::locus::{OnLocus, locus};
use crate::{Chromaticity, Spectrum};

/// Correlated colour temperature and Duv.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cct {
    /// Temperature of the nearest Planckian radiator in the CIE 1960 (u, v) diagram, K.
    pub cct_k: f64,
    /// Signed distance to it: positive above the locus (greenish), negative below (Ohno 2014, ANSI C78.377).
    pub duv: f64,
}

impl Cct {
    /// The same; none where it is farther from the locus than CIE 15 allows.
    pub fn meaningful(self) -> Option<Self> {
        (self.duv.abs() <= FARTHEST_MEANINGFUL_DUV).then_some(self)
    }
}

/// Beyond this distance CIE 15 (9.5) holds a correlated colour temperature to be without meaning.
pub const FARTHEST_MEANINGFUL_DUV: f64 = 0.05;

/// Steps of the search at most; nearly always it needs six.
const MOST_STEPS: usize = 60;
/// It ends with a step that is smaller than this share of the reciprocal temperature.
const PRECISION_REL: f64 = 1e-12;

/// The point of the Planckian locus that is nearest in (u, v) 1960: its temperature and the signed distance.
///
/// Ohno's definition, solved by minimising the distance itself instead of by his table and parabola, so without their
/// error of up to 1 K. None where the nearest point is an end of 1000–100 000 K.
pub fn nearest_planckian(colour: Chromaticity) -> Option<Cct> {
    let (u, v) = colour.uv_1960();
    let locus = locus();
    // In reciprocal temperature the locus is nearly even. Where it is nearest, the way there stands upright on it: the
    // root of the slope, by false position (Illinois).
    let slope = |at: &OnLocus| (at.u - u) * at.du + (at.v - v) * at.dv;
    let (mut a, mut b) = locus.around_nearest(u, v)?;
    let (from, to) = (a.mired, b.mired);
    let (mut fa, mut fb) = (slope(&a), slope(&b));
    for _ in 0..MOST_STEPS {
        let next = (b.mired - fb * (b.mired - a.mired) / (fb - fa)).clamp(from, to);
        if next.is_nan() {
            break;
        }
        let next = locus.at(next);
        let f = slope(&next);
        if (f > 0.0) == (fb > 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        let moved = (next.mired - b.mired).abs();
        (b, fb) = (next, f);
        if f == 0.0 || moved < PRECISION_REL * b.mired {
            break;
        }
    }
    Some(Cct {
        cct_k: 1e6 / b.mired,
        duv: (u - b.u).hypot(v - b.v).copysign(v - b.v),
    })
}

/// A point `duv` from the Planckian locus, along the normal at `temperature_k`: for iso-temperature lines.
pub fn beside_locus(temperature_k: f64, duv: f64) -> Option<Chromaticity> {
    let (u, v) = planckian_chromaticity(temperature_k)?.uv_1960();
    let (nu, nv) = planckian_chromaticity(temperature_k * 1.001)?.uv_1960();
    // The locus runs to the left (falling u) as the temperature rises; its upper normal is (−dv, du) turned to point
    // up.
    let (du, dv) = (nu - u, nv - v);
    let length = du.hypot(dv).copysign(-du);
    Some(Chromaticity::from_uv_1960(u + duv * dv / length, v - duv * du / length))
}

impl Spectrum {
    /// The nearest Planckian radiator; none without light or outside 1000–100 000 K. See [`FARTHEST_MEANINGFUL_DUV`].
    pub fn nearest_planckian(&self) -> Option<Cct> {
        nearest_planckian(self.chromaticity()?)
    }

    /// Correlated colour temperature and Duv; none where [`Spectrum::nearest_planckian`] is farther than CIE 15 allows.
    pub fn cct(&self) -> Option<Cct> {
        self.nearest_planckian().and_then(Cct::meaningful)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::illuminant;

    #[test]
    fn a_planckian_has_its_own_temperature() {
        for t in [1500.0, 2856.0, 4000.0, 6500.0, 20_000.0] {
            let c = nearest_planckian(planckian_chromaticity(t).unwrap()).unwrap();
            assert!((c.cct_k / t - 1.0).abs() < 1e-6 && c.duv.abs() < 1e-9, "{t}: {c:?}");
        }
    }

    #[test]
    fn duv_is_positive_above_the_locus() {
        for duv in [0.01, -0.01] {
            let c = nearest_planckian(beside_locus(3000.0, duv).unwrap()).unwrap();
            assert!((c.duv - duv).abs() < 1e-5 && (c.cct_k - 3000.0).abs() < 2.0, "{c:?}");
        }
    }

    #[test]
    fn a_green_line_has_no_colour_temperature() {
        let s = Spectrum::new(vec![519.0, 520.0, 521.0], vec![0.0, 1.0, 0.0]).unwrap();
        assert!(s.nearest_planckian().unwrap().duv > 0.05);
        assert_eq!(s.cct(), None);
        let d = Spectrum::from_1_nm(&illuminant::daylight(6504.0).unwrap()).unwrap();
        assert!((d.cct().unwrap().cct_k - 6504.0).abs() < 2.0);
    }
}
