//! Directional response (ISO/CIE 19476, f2) to the light of a lamp of some size: its edge does not come along the
//! meter's normal. How bright which part is, is not known; a disc that is even shares the light of `lamp.diameter_mm`.

use isolux_record::station::{Cosine, Lamp};

use crate::samples::unsigned;

/// Rings of equal area, and points on each.
const RINGS: u32 = 12;
const AROUND: u32 = 16;

/// The response of a meter to the light of a lamp.
#[derive(Debug, Clone, PartialEq)]
pub struct Directional {
    table: Cosine,
    radius_mm: f64,
}

impl Directional {
    /// None for a lamp of unknown size.
    pub fn new(stated: &Cosine, lamp: Option<&Lamp>) -> Option<Self> {
        Some(Self {
            table: stated.clone(),
            radius_mm: 0.5 * lamp?.diameter_mm?,
        })
    }

    /// By what a reading towards γ from this distance is multiplied, and the relative standard uncertainty of the table
    /// there. Seen from γ the disc is an ellipse.
    pub fn factor(&self, gamma_deg: f64, distance_mm: f64) -> (f64, f64) {
        let (_, gamma_deg) = unsigned(0.0, gamma_deg);
        let narrow = gamma_deg.to_radians().cos().abs();
        let (mut response, mut u) = (0.0, 0.0);
        for ring in 0..RINGS {
            let radius_mm = self.radius_mm * ((f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
            for place in 0..AROUND {
                let turn = std::f64::consts::TAU * (f64::from(place) + 0.5) / f64::from(AROUND);
                let off_mm = radius_mm * turn.cos().hypot(turn.sin() * narrow);
                let incidence_deg = (off_mm / distance_mm).atan().to_degrees();
                response += at(&self.table.angle_deg, &self.table.response_rel, incidence_deg);
                u += at(&self.table.angle_deg, &self.table.u_rel, incidence_deg);
            }
        }
        let count = f64::from(RINGS * AROUND);
        (count / response, u / count)
    }

    /// The table of the effect of a model with `name`, 1 + k·(1 − cos ε)/(1 − cos 60°), as near to this as it comes.
    pub fn effect(&self, name: &str) -> Option<String> {
        let (mut above, mut below) = (0.0, 0.0);
        for (angle, response) in self.table.angle_deg.iter().zip(&self.table.response_rel) {
            let lost = 2.0 * (1.0 - angle.to_radians().cos());
            above += lost * (response - 1.0);
            below += lost * lost;
        }
        let k = above / below;
        (k.is_finite() && k != 0.0).then(|| format!("name = \"{name}\"\ncoefficient_rel = {k:.8}\n"))
    }
}

/// Linear between two angles, held beyond the last.
fn at(angle_deg: &[f64], value: &[f64], incidence_deg: f64) -> f64 {
    let above = angle_deg.partition_point(|angle| *angle < incidence_deg);
    match (above.checked_sub(1), angle_deg.get(above)) {
        (Some(below), Some(to)) => {
            let share = (incidence_deg - angle_deg[below]) / (to - angle_deg[below]);
            value[below] + share * (value[above] - value[below])
        }
        (Some(below), None) => value[below],
        (None, _) => value.first().copied().unwrap_or(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_as_wide_as_it_is_far_is_seen_at_a_slant() {
        // Response 1 − q·tan² ε up to 30°: its mean over an even disc seen under tan ε = R/d is 1 − q·(R/d)²/2.
        let q = 0.1;
        let angle_deg: Vec<f64> = (0..=300).map(|step| 0.1 * f64::from(step)).collect();
        let response_rel = angle_deg
            .iter()
            .map(|deg| 1.0 - q * deg.to_radians().tan().powi(2))
            .collect();
        let directional = Directional {
            table: Cosine {
                u_rel: vec![0.001; angle_deg.len()],
                angle_deg,
                response_rel,
            },
            radius_mm: 500.0,
        };
        let (factor, u) = directional.factor(0.0, 1000.0);
        assert!((1.0 / factor - (1.0 - q * 0.25 / 2.0)).abs() < 2e-5, "{factor}");
        assert!((u - 0.001).abs() < 1e-12);
        // From the side the disc is a line: half of it.
        let (side, _) = directional.factor(-90.0, 1000.0);
        assert!((1.0 / side - (1.0 - q * 0.25 / 4.0)).abs() < 2e-5, "{side}");
    }
}
