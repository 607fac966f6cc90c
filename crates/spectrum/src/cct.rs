//! Correlated colour temperature and distance from the Planckian locus.

use std::sync::OnceLock;

use crate::illuminant::planckian_chromaticity;
use crate::{Chromaticity, Spectrum};

/// Correlated colour temperature and Duv.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cct {
    /// Temperature of the nearest Planckian radiator in the CIE 1960 (u, v) diagram, K.
    pub cct_k: f64,
    /// Signed distance to it: positive above the locus (greenish), negative below (Ohno 2014, ANSI C78.377).
    pub duv: f64,
}

/// Beyond this distance CIE 15 (9.5) holds a correlated colour temperature to be without meaning.
pub const FARTHEST_MEANINGFUL_DUV: f64 = 0.05;

const LOWEST_K: f64 = 1000.0;
const HIGHEST_K: f64 = 100_000.0;

/// The point of the Planckian locus that is nearest in (u, v) 1960: its temperature and the signed distance.
///
/// Ohno's definition, solved by minimising the distance itself instead of by his table and parabola, so without their
/// error of up to 1 K. None where the nearest point is an end of 1000–100 000 K.
pub fn nearest_planckian(colour: Chromaticity) -> Option<Cct> {
    let (u, v) = colour.uv_1960();
    let distance = |mired: f64| -> f64 {
        planckian_chromaticity(1e6 / mired).map_or(f64::INFINITY, |p| {
            let (pu, pv) = p.uv_1960();
            (u - pu).hypot(v - pv)
        })
    };
    let table = locus();
    let (best, _) = table
        .iter()
        .map(|&(_, (pu, pv))| (u - pu).hypot(v - pv))
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    if best == 0 || best + 1 == table.len() {
        return None;
    }
    // Golden section in reciprocal temperature, where the locus is nearly even.
    let (mut a, mut b) = (table[best - 1].0, table[best + 1].0);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fc, mut fd) = (distance(c), distance(d));
    for _ in 0..36 {
        if fc < fd {
            (b, d, fd) = (d, c, fc);
            c = b - golden * (b - a);
            fc = distance(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + golden * (b - a);
            fd = distance(d);
        }
    }
    let cct_k = 2e6 / (a + b);
    let (_, pv) = planckian_chromaticity(cct_k)?.uv_1960();
    Some(Cct {
        cct_k,
        duv: distance(1e6 / cct_k).copysign(v - pv),
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
        self.nearest_planckian()
            .filter(|c| c.duv.abs() <= FARTHEST_MEANINGFUL_DUV)
    }
}

/// (mired, (u, v)) of the locus, every 5 mired.
fn locus() -> &'static [(f64, (f64, f64))] {
    static LOCUS: OnceLock<Vec<(f64, (f64, f64))>> = OnceLock::new();
    LOCUS.get_or_init(|| {
        let (from, to) = (1e6 / HIGHEST_K, 1e6 / LOWEST_K);
        let n = ((to - from) / 5.0).round() as usize;
        (0..=n)
            .filter_map(|i| {
                let mired = from + (to - from) * i as f64 / n as f64;
                Some((mired, planckian_chromaticity(1e6 / mired)?.uv_1960()))
            })
            .collect()
    })
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
