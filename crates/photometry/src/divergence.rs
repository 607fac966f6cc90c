//! Beam and field angle, half-peak divergence.

use isolux_units::Degrees;

use crate::IntensityDistribution;

/// The two edges of a beam in the plane that a half-plane and its opposite form, as signed γ (negative: the opposite side).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Divergence {
    /// Edge on the side of C + 180°, signed γ in degrees.
    pub from: Degrees,
    /// Edge on the side of C, signed γ in degrees.
    pub to: Degrees,
}

impl Divergence {
    /// Full angle between the edges, in degrees.
    pub fn full_angle_deg(&self) -> f64 {
        self.to.value() - self.from.value()
    }
}

impl IntensityDistribution {
    /// Beam angle of the plane through C half-plane `plane`: the full angle between the directions where the intensity falls to
    /// 50 % of that plane's maximum (CIE S 017 17-27-097, half-peak divergence). None where it does not fall that far.
    pub fn beam_angle(&self, plane: usize) -> Option<Divergence> {
        self.divergence(plane, 0.5)
    }

    /// Field angle: as [`beam_angle`](Self::beam_angle), at 10 % of the plane's maximum.
    pub fn field_angle(&self, plane: usize) -> Option<Divergence> {
        self.divergence(plane, 0.1)
    }

    /// The edges around the plane's maximum where the interpolant first falls below `fraction` of it, going outwards.
    /// None where the plane is dark or an edge lies beyond the γ range of the grid.
    pub fn divergence(&self, plane: usize, fraction: f64) -> Option<Divergence> {
        let profile = self.profile(plane);
        let top = (0..profile.len()).reduce(|best, i| if profile[i].1 > profile[best].1 { i } else { best })?;
        let level = fraction * profile[top].1;
        if level <= 0.0 {
            return None;
        }
        let to = crossing(profile[top..].iter().copied(), level)?;
        let from = crossing(profile[..=top].iter().rev().copied(), level)?;
        Some(Divergence {
            from: Degrees::new(from).ok()?,
            to: Degrees::new(to).ok()?,
        })
    }

    /// Signed γ and intensity along the plane: the opposite half-plane from its last γ down to 0, then this one up.
    fn profile(&self, plane: usize) -> Vec<(f64, f64)> {
        let opposite = self.c_deg()[plane] + 180.0;
        let mut profile: Vec<(f64, f64)> = self
            .gamma_deg()
            .iter()
            .rev()
            .filter(|&&gamma| gamma > 0.0)
            .map(|&gamma| (-gamma, self.intensity_cd_at(opposite, gamma)))
            .collect();
        profile.extend(self.gamma_deg().iter().copied().zip(self.row(plane).iter().copied()));
        profile
    }
}

/// Where a polyline first falls to `level`, linear between its points.
fn crossing(mut points: impl Iterator<Item = (f64, f64)>, level: f64) -> Option<f64> {
    let mut before = points.next()?;
    for point in points {
        if point.1 <= level {
            let t = (before.1 - level) / (before.1 - point.1);
            return Some(before.0 + t * (point.0 - before.0));
        }
        before = point;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cosine_power(n: f64, last_deg: usize) -> IntensityDistribution {
        let gamma: Vec<f64> = (0..=last_deg * 10).map(|i| i as f64 * 0.1).collect();
        let row: Vec<f64> = gamma.iter().map(|g| g.to_radians().cos().max(0.0).powf(n)).collect();
        IntensityDistribution::new(vec![0.0], gamma, row).unwrap()
    }

    #[test]
    fn lambertian_beam_is_120_degrees() {
        let d = cosine_power(1.0, 180);
        assert!((d.beam_angle(0).unwrap().full_angle_deg() - 120.0).abs() < 1e-3);
        let field = 2.0 * 0.1f64.acos().to_degrees();
        assert!((d.field_angle(0).unwrap().full_angle_deg() - field).abs() < 1e-3);
    }

    #[test]
    fn cosine_power_has_its_closed_form() {
        let exact = 2.0 * 0.5f64.powf(1.0 / 5.3).acos().to_degrees();
        assert!((cosine_power(5.3, 90).beam_angle(0).unwrap().full_angle_deg() - exact).abs() < 1e-3);
    }

    #[test]
    fn a_beam_that_is_cut_off_has_no_angle() {
        assert_eq!(cosine_power(1.0, 50).beam_angle(0), None);
    }

    #[test]
    fn a_beam_off_the_axis_keeps_its_edges() {
        // maximum at γ = 30° in C0, triangular, 20° half base; the opposite side is dark
        let triangle = |c: f64, g: f64| {
            if c == 0.0 {
                (1.0 - (g - 30.0).abs() / 20.0).max(0.0)
            } else {
                0.0
            }
        };
        let (c, g): (Vec<f64>, Vec<f64>) = (vec![0.0, 180.0], (0..=90).map(f64::from).collect());
        let values = c.iter().flat_map(|&c| g.iter().map(move |&g| triangle(c, g))).collect();
        let beam = IntensityDistribution::new(c, g, values).unwrap().beam_angle(0).unwrap();
        assert!((beam.from.value() - 20.0).abs() < 1e-9 && (beam.to.value() - 40.0).abs() < 1e-9);
        let opposite = IntensityDistribution::new(vec![0.0, 180.0], vec![0.0, 90.0], vec![0.0; 4]).unwrap();
        assert_eq!(opposite.beam_angle(0), None, "a dark plane has no beam");
    }
}
