//! The Planckian locus in the CIE 1960 (u, v) diagram, over reciprocal temperature.

use std::sync::OnceLock;

use crate::cie;
use crate::illuminant::{C2_M_K, wavelengths_nm};

/// 100 000 K to 1000 K.
const FROM_MIRED: f64 = 10.0;
const TO_MIRED: f64 = 1000.0;

/// Distance of the nodes. What lies between them is then wrong by less than 1e-13 in u and v.
const STEP_MIRED: f64 = 5.0;

/// A point (u, v) of the Planckian locus, and its change for one mired.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OnLocus {
    pub mired: f64,
    pub u: f64,
    pub v: f64,
    pub du: f64,
    pub dv: f64,
}

/// u and v with their first and second derivatives over the reciprocal temperature.
#[derive(Debug, Clone, Copy)]
struct Node {
    u: [f64; 3],
    v: [f64; 3],
}

/// The locus from 100 000 K to 1000 K: nodes computed from Planck's law, quintic Hermite polynomials between them.
#[derive(Debug)]
pub(crate) struct Locus {
    nodes: Vec<Node>,
}

/// The locus; its nodes are computed when it is asked for first.
pub(crate) fn locus() -> &'static Locus {
    static LOCUS: OnceLock<Locus> = OnceLock::new();
    LOCUS.get_or_init(|| {
        let steps = ((TO_MIRED - FROM_MIRED) / STEP_MIRED) as usize;
        let nodes = (0..=steps).map(|node| Node::at(mired_of(node)));
        Locus { nodes: nodes.collect() }
    })
}

impl Locus {
    /// The nodes before and after the one that is nearest to (u, v); none where that is an end.
    pub fn around_nearest(&self, u: f64, v: f64) -> Option<(OnLocus, OnLocus)> {
        let squares = self
            .nodes
            .iter()
            .map(|node| (u - node.u[0]).powi(2) + (v - node.v[0]).powi(2));
        let (nearest, _) = squares.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let (before, after) = (nearest.checked_sub(1)?, nearest + 1);
        (after < self.nodes.len()).then(|| (self.at(mired_of(before)), self.at(mired_of(after))))
    }

    /// The point at a reciprocal temperature of 10 to 1000 mired; beyond them the polynomial of the end.
    pub fn at(&self, mired: f64) -> OnLocus {
        let place = (mired - FROM_MIRED) / STEP_MIRED;
        let below = (place.max(0.0) as usize).min(self.nodes.len() - 2);
        let share = place - below as f64;
        let (a, b) = (&self.nodes[below], &self.nodes[below + 1]);
        let ([u, du], [v, dv]) = (hermite(&a.u, &b.u, share), hermite(&a.v, &b.v, share));
        OnLocus { mired, u, v, du, dv }
    }
}

impl Node {
    /// From the sums of Planck's law at 1 nm.
    ///
    /// With a = c₂/λ and q = 1/(exp(a·m) − 1) the radiance λ⁻⁵·q changes with the reciprocal temperature m by
    /// −λ⁻⁵·a·q·(1 + q), and that by λ⁻⁵·a²·q·(1 + q)·(1 + 2q).
    fn at(mired: f64) -> Self {
        // 4X and 6Y, the numerators of u and v, and X + 15Y + 3Z, each with its derivatives.
        let (mut over_u, mut over_v, mut whole) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let bars = cie::X_BAR.iter().zip(&cie::V_LAMBDA).zip(&cie::Z_BAR);
        for (nm, ((x, y), z)) in wavelengths_nm().zip(bars) {
            let a = C2_M_K * 1e3 / nm;
            let q = 1.0 / (a * mired).exp_m1();
            let light = (560.0 / nm).powi(5) * q;
            let change = -a * light * (1.0 + q);
            let by_order = [light, change, -a * change * (1.0 + 2.0 * q)];
            for (order, light) in by_order.into_iter().enumerate() {
                over_u[order] += 4.0 * x * light;
                over_v[order] += 6.0 * y * light;
                whole[order] += (x + 15.0 * y + 3.0 * z) * light;
            }
        }
        let quotient = |over: [f64; 3]| {
            let value = over[0] / whole[0];
            let first = (over[1] - value * whole[1]) / whole[0];
            let second = (over[2] - 2.0 * first * whole[1] - value * whole[2]) / whole[0];
            [value, first, second]
        };
        Self {
            u: quotient(over_u),
            v: quotient(over_v),
        }
    }
}

/// Where a node lies.
fn mired_of(node: usize) -> f64 {
    FROM_MIRED + STEP_MIRED * node as f64
}

/// Value and derivative of the polynomial of degree five that has the values and derivatives of both nodes, at a share
/// of the way from `a` to `b`.
fn hermite(a: &[f64; 3], b: &[f64; 3], share: f64) -> [f64; 2] {
    const H: f64 = STEP_MIRED;
    let (rise, a1, b1, a2, b2) = (b[0] - a[0], H * a[1], H * b[1], H * H * a[2], H * H * b[2]);
    let by_power = [
        a[0],
        a1,
        0.5 * a2,
        10.0 * rise - 6.0 * a1 - 4.0 * b1 - 1.5 * a2 + 0.5 * b2,
        -15.0 * rise + 8.0 * a1 + 7.0 * b1 + 1.5 * a2 - b2,
        6.0 * rise - 3.0 * (a1 + b1) - 0.5 * (a2 - b2),
    ];
    let (mut value, mut slope) = (0.0, 0.0);
    for coefficient in by_power.into_iter().rev() {
        slope = slope * share + value;
        value = value * share + coefficient;
    }
    [value, slope / H]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::illuminant::planckian_chromaticity;

    /// Half way between nodes, where the polynomials are farthest from Planck's law, and by differences of it.
    #[test]
    fn between_its_nodes_it_is_planck_s_law() {
        let planck = |mired: f64| planckian_chromaticity(1e6 / mired).unwrap().uv_1960();
        let mut worst: (f64, f64) = (0.0, 0.0);
        for step in 0..198 {
            let mired = 12.5 + 5.0 * f64::from(step);
            let (at, (u, v)) = (locus().at(mired), planck(mired));
            worst.0 = worst.0.max((at.u - u).abs()).max((at.v - v).abs());
            let ((u0, v0), (u1, v1)) = (planck(mired - 0.01), planck(mired + 0.01));
            let (du, dv) = ((u1 - u0) / 0.02, (v1 - v0) / 0.02);
            worst.1 = worst.1.max((at.du - du).abs()).max((at.dv - dv).abs());
        }
        assert!(worst.0 < 1e-13 && worst.1 < 1e-11, "{worst:?}");
    }
}
