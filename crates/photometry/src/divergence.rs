//! Beam and field angle, half-peak divergence.

use crate::IntensityDistribution;

/// The two edges of a beam in the plane that a half-plane and its opposite form, as signed γ (negative: the opposite
/// side; a beam about γ = 180° goes on beyond it).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Divergence {
    /// Edge on the side of C + 180°, signed γ in degrees.
    pub from_deg: f64,
    /// Edge on the side of C, signed γ in degrees.
    pub to_deg: f64,
    /// The largest intensity between them, signed γ in degrees.
    pub top_deg: f64,
}

impl Divergence {
    /// Full angle between the edges, in degrees.
    pub fn full_angle_deg(&self) -> f64 {
        self.to_deg - self.from_deg
    }
}

impl IntensityDistribution {
    /// Beam angle of the plane through C half-plane `plane`: the full angle between the directions where the intensity
    /// falls to 50 % of that plane's maximum (CIE S 017 17-27-097, half-peak divergence). None where it does not fall
    /// that far.
    pub fn beam_angle(&self, plane: usize) -> Option<Divergence> {
        self.divergence(plane, 0.5)
    }

    /// Field angle: as [`beam_angle`](Self::beam_angle), at 10 % of the plane's maximum.
    pub fn field_angle(&self, plane: usize) -> Option<Divergence> {
        self.divergence(plane, 0.1)
    }

    /// The exponent n of the lobe cosⁿ that has the beam angle of the narrowest plane, or where no plane falls so far in a
    /// grid that ends below 90°, its fall from the axis to there; at least 1, that of a diffuse area.
    pub fn lobe_exponent(&self) -> f64 {
        let last_deg = self.gamma_deg().last().copied().unwrap_or(180.0);
        let of_zone = |plane: usize| {
            let row = self.row(plane);
            let fall = row.last()? / row.first()?;
            (last_deg < 90.0).then(|| fall.ln() / last_deg.to_radians().cos().ln())
        };
        let of_beam = |beam: Divergence| 0.5_f64.ln() / (0.5 * beam.full_angle_deg()).to_radians().cos().ln();
        (0..self.c_deg().len())
            .filter_map(|plane| self.beam_angle(plane).map(of_beam).or_else(|| of_zone(plane)))
            .filter(|exponent| exponent.is_finite())
            .fold(1.0, f64::max)
    }

    /// The edges around the plane's maximum where the interpolant first falls below `fraction` of it, going outwards.
    /// None where the plane is dark or an edge lies beyond the γ range of the grid. The two half-planes meet at γ = 0,
    /// and at γ = 180° where the grid reaches it.
    pub fn divergence(&self, plane: usize, fraction: f64) -> Option<Divergence> {
        let profile = self.profile(plane);
        let points = &profile.points;
        let top = (0..points.len()).reduce(|best, i| if points[i].1 > points[best].1 { i } else { best })?;
        let level = fraction * points[top].1;
        if level <= 0.0 {
            return None;
        }
        let to = crossing(profile.outwards(top, true), level)?;
        let from = crossing(profile.outwards(top, false), level)?;
        let turn = if from < -180.0 { 360.0 } else { 0.0 };
        Some(Divergence {
            from_deg: from + turn,
            to_deg: to + turn,
            top_deg: points[top].0,
        })
    }

    /// The opposite half-plane from its last γ down to 0, then this one up.
    fn profile(&self, plane: usize) -> Profile {
        let opposite_cd = self.half_plane_cd(self.c_deg()[plane] + 180.0);
        let gamma_deg = self.gamma_deg();
        let mut points: Vec<(f64, f64)> = gamma_deg
            .iter()
            .zip(opposite_cd)
            .rev()
            .filter(|(gamma, _)| **gamma > 0.0)
            .map(|(gamma, intensity_cd)| (-gamma, intensity_cd))
            .collect();
        let own = points.len();
        points.extend(gamma_deg.iter().copied().zip(self.row(plane).iter().copied()));
        let first = gamma_deg.first().copied().unwrap_or(0.0);
        let step = gamma_deg.get(1).map_or(0.0, |second| second - first);
        Profile {
            points,
            own,
            // A grid may leave the pole itself out; it does not leave out a half-space.
            over_nadir: first == 0.0 || (first <= step && first < 90.0),
            over_zenith: gamma_deg.last().is_some_and(|&last| last >= 180.0),
        }
    }
}

/// Signed γ and intensity around a plane, and whether its two half-planes meet below and above.
struct Profile {
    points: Vec<(f64, f64)>,
    /// Where the plane's own half begins.
    own: usize,
    over_nadir: bool,
    over_zenith: bool,
}

impl Profile {
    /// The points from `top` on towards rising or falling signed γ, at most once around, to where the grid ends.
    fn outwards(&self, top: usize, rising: bool) -> impl Iterator<Item = (f64, f64)> {
        let count = self.points.len();
        let steps = (0..count).map(move |step| {
            if rising {
                (top + step, step)
            } else {
                (top + count - step, step)
            }
        });
        let inside = steps.take_while(move |&(at, step)| {
            // The joint that is passed on the way to this point.
            let after = if rising { at % count } else { (at + 1) % count };
            step == 0
                || match after {
                    0 => self.over_zenith,
                    after if after == self.own => self.over_nadir,
                    _ => true,
                }
        });
        inside.map(move |(at, _)| {
            let (gamma, candela) = self.points[at % count];
            let turn = match (rising, at < count) {
                (true, false) => 360.0,
                (false, true) => -360.0,
                _ => 0.0,
            };
            (gamma + turn, candela)
        })
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
    fn a_zone_around_the_axis_has_the_exponent_of_its_lobe() {
        for last_deg in [6, 40, 180] {
            let n = cosine_power(5.3, last_deg).lobe_exponent();
            assert!((n - 5.3).abs() < 1e-3, "to {last_deg}°: {n}");
        }
        // A diffuse area where the zone says nothing: as bright at its edge as on the axis, or without the axis.
        let even = IntensityDistribution::new(vec![0.0], vec![0.0, 10.0], vec![1.0, 1.0]).unwrap();
        let away = IntensityDistribution::new(vec![0.0], vec![5.0, 10.0], vec![1.0, 2.0]).unwrap();
        assert_eq!([even.lobe_exponent(), away.lobe_exponent()], [1.0, 1.0]);
    }

    #[test]
    fn a_beam_that_is_cut_off_has_no_angle() {
        assert_eq!(cosine_power(1.0, 50).beam_angle(0), None);
    }

    /// I ∝ −cos γ above the horizontal, on γ from `first_deg` to 180° every 5°.
    fn uplight(first_deg: u8, below: f64) -> IntensityDistribution {
        let gamma: Vec<f64> = (first_deg..=180).step_by(5).map(f64::from).collect();
        let row = gamma.iter().map(|g| {
            let up = -g.to_radians().cos();
            if up < 0.0 { -below * up } else { up }
        });
        IntensityDistribution::new(vec![0.0], gamma.clone(), row.collect()).unwrap()
    }

    #[test]
    fn a_beam_upwards_closes_over_the_zenith() {
        // Lambertian about γ = 180°: 120° between the edges, as about γ = 0; also where the grid has the upper half
        // alone, and where a third of the light goes down (the beam is that of the plane's maximum).
        for (first, below) in [(0, 0.0), (90, 0.0), (0, 0.3)] {
            let beam = uplight(first, below).beam_angle(0).unwrap();
            assert!(
                (beam.full_angle_deg() - 120.0).abs() < 1e-9,
                "{first} {below}: {beam:?}"
            );
            assert!((beam.from_deg - 120.0).abs() < 1e-9 && (beam.to_deg - 240.0).abs() < 1e-9);
        }
        // cos 84.26° = 0.1, linear between 80° (0.17365) and 85° (0.08716).
        let edge = 80.0 + 5.0 * (0.173_648_178 - 0.1) / (0.173_648_178 - 0.087_155_743);
        let field = uplight(90, 0.0).field_angle(0).unwrap().full_angle_deg();
        assert!((field - 2.0 * edge).abs() < 1e-6, "{field}");
    }

    #[test]
    fn light_all_around_has_no_beam() {
        let gamma: Vec<f64> = (0..=180).step_by(10).map(f64::from).collect();
        let round = IntensityDistribution::new(vec![0.0], gamma.clone(), vec![1.0; gamma.len()]).unwrap();
        assert_eq!(round.beam_angle(0), None);
        // Strongest at the horizontal where the grid begins: what lies below is not known, and is not the other side.
        let upper: Vec<f64> = (90..=180).step_by(10).map(f64::from).collect();
        let row = upper.iter().map(|g| g.to_radians().sin().max(0.0)).collect();
        let edge = IntensityDistribution::new(vec![0.0], upper, row).unwrap();
        assert_eq!(edge.beam_angle(0), None);
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
        assert!((beam.from_deg - 20.0).abs() < 1e-9 && (beam.to_deg - 40.0).abs() < 1e-9);
        let opposite = IntensityDistribution::new(vec![0.0, 180.0], vec![0.0, 90.0], vec![0.0; 4]).unwrap();
        assert_eq!(opposite.beam_angle(0), None, "a dark plane has no beam");
    }
}
