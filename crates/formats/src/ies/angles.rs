//! Types A and B to C-γ.
//!
//! The photometric axis (V = 0, H = 0) becomes γ = 0, positive H becomes C0 and positive V becomes C90: seen from
//! behind the luminaire, C0 is to the right and C90 up. Type A turns about the vertical axis (H is the azimuth, V the
//! elevation), type B about the horizontal one (V is the azimuth, H the elevation).

use isolux_photometry::{DistributionError, IntensityDistribution, direction};

use super::native::{Native, folds};
use super::own::OwnLight;

/// Directions that a conversion makes at most, and how many for each one of the file where that is more: a short file
/// may name any step.
const LARGEST_GRID: (usize, usize) = (1_000_000, 8);
/// The same for steps finer than the file's own.
const LARGEST_REFINED: (usize, usize) = (24_576, 8);
/// The same for the file's own step with the directions of its maxima.
const LARGEST_CRESTED: (usize, usize) = (400_000, 8);
/// Flux and peak nearer than this to the file's own need no finer step.
const NEAR_ENOUGH: f64 = 1e-3;
/// Steps of the resampled grid that one of the file is parted into at most.
const FINEST_PART: usize = 8;
/// Directions of local maxima that get half-planes and γ of their own at most.
const MOST_CRESTS: usize = 16;
/// A maximum below this part of the peak is none.
const LOWEST_CREST: f64 = 0.1;

/// The light of a table over C-γ, and what that cost: parts of the file's own flux and peak.
#[derive(Debug)]
pub(super) struct Resampled {
    pub intensity: IntensityDistribution,
    /// The even step of C and γ.
    pub step_deg: f64,
    /// Flux over that of the file's own table, less one; none where that is not above zero.
    pub flux_off: Option<f64>,
    /// Peak over that of the file's own table, less one; none where that is not above zero.
    pub peak_off: Option<f64>,
}

impl Resampled {
    /// The larger of the two differences.
    pub(super) fn off(&self) -> f64 {
        let part = |off: Option<f64>| off.map_or(0.0, f64::abs);
        part(self.flux_off).max(part(self.peak_off))
    }
}

impl Native<'_> {
    /// The distribution over C-γ. γ ends where the file's angles end, at 90° for the front half-space that types A and
    /// B describe.
    ///
    /// The step is the file's smallest (a multiple of it where that would be too many directions). Straight lines
    /// between points of one grid cut the corners of straight lines between points of another; where flux or peak show
    /// it, the directions of the table's maxima get half-planes and γ of their own and the step is halved until they
    /// show it no more, or the grid is as large as [`LARGEST_REFINED`] lets it be.
    pub(super) fn resampled(&self) -> Result<Resampled, DistributionError> {
        let quarters = if self.reach_deg() > 90.0 { 2 } else { 1 };
        let step = self.smallest_step().map_or(5.0, |step| step.min(30.0));
        let mut steps = (90.0 / step - 1e-9).ceil().max(1.0) as usize;
        let most = |(least, each): (usize, usize)| least.max(each * self.candela.len());
        while 4 * steps * (steps * quarters + 1) > most(LARGEST_GRID) {
            steps /= 2;
        }
        let own = self.own_light();
        let made = |part: usize, crests: &[(f64, f64)]| {
            let step = 90.0 / (steps * part) as f64;
            let even = |count: usize| -> Vec<f64> { (0..count).map(|i| i as f64 * step).collect() };
            let c_deg = with(even(4 * steps * part), crests.iter().map(|crest| crest.0));
            let gamma_deg = with(even(steps * part * quarters + 1), crests.iter().map(|crest| crest.1));
            (step, c_deg, gamma_deg)
        };
        let mut best = self.sampled(made(1, &[]), own)?;
        if best.off() <= NEAR_ENOUGH {
            return Ok(best);
        }
        let crests = self.crests((quarters * 90) as f64);
        let mut part = 1;
        while part <= FINEST_PART && best.off() > NEAR_ENOUGH {
            let grid = made(part, &crests);
            let limit = if part == 1 { LARGEST_CRESTED } else { LARGEST_REFINED };
            if grid.1.len() * grid.2.len() > most(limit) {
                break;
            }
            let finer = self.sampled(grid, own)?;
            if finer.off() <= best.off() {
                best = finer;
            }
            part *= 2;
        }
        Ok(best)
    }

    fn sampled(
        &self,
        (step_deg, c_deg, gamma_deg): (f64, Vec<f64>, Vec<f64>),
        own: OwnLight,
    ) -> Result<Resampled, DistributionError> {
        let mut candela = Vec::with_capacity(c_deg.len() * gamma_deg.len());
        for &c in &c_deg {
            for &gamma in &gamma_deg {
                candela.push(self.toward(c, gamma));
            }
        }
        let intensity = IntensityDistribution::new(c_deg, gamma_deg, candela)?;
        let off = |value: f64, own: f64| (own > 0.0).then(|| value / own - 1.0);
        Ok(Resampled {
            flux_off: off(intensity.flux_lm(), own.flux_lm),
            peak_off: off(intensity.peak().intensity_cd, own.peak_cd),
            intensity,
            step_deg,
        })
    }

    /// C and γ of the table's local maxima, the largest first.
    fn crests(&self, last_gamma_deg: f64) -> Vec<(f64, f64)> {
        let (nv, nh) = (self.vertical_deg.len(), self.horizontal_deg.len());
        let at = |h: usize, v: usize| self.candela[h * nv + v];
        let least = LOWEST_CREST * self.own_light().peak_cd;
        let mut found: Vec<(f64, usize, usize)> = Vec::new();
        for (h, v) in (0..nh).flat_map(|h| (0..nv).map(move |v| (h, v))) {
            let here = at(h, v);
            // A plateau counts once: at its last angles.
            let lower = (h == 0 || at(h - 1, v) <= here)
                && (v == 0 || at(h, v - 1) <= here)
                && (h + 1 == nh || at(h + 1, v) < here)
                && (v + 1 == nv || at(h, v + 1) < here);
            if here > least && lower {
                found.push((here, h, v));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(MOST_CRESTS);
        let mut all = Vec::new();
        for (_, h, v) in found {
            let (horizontal, vertical) = (self.horizontal_deg[h], self.vertical_deg[v]);
            for (h, v) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let mirrored = (h > 0.0 || folds(self.horizontal_deg)) && (v > 0.0 || folds(self.vertical_deg));
                if let Some(direction) = mirrored.then(|| self.c_gamma(h * horizontal, v * vertical)).flatten()
                    && direction.1 <= last_gamma_deg
                {
                    all.push(direction);
                }
            }
        }
        all
    }

    /// Candela in a direction of C-γ; 0 outside the file's angles.
    fn toward(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let [right, up, axis] = direction(c_deg, gamma_deg).to_array();
        let (horizontal, vertical) = if self.type_a {
            (right.atan2(axis), up.clamp(-1.0, 1.0).asin())
        } else {
            (right.clamp(-1.0, 1.0).asin(), up.atan2(axis))
        };
        let folded = |angle: f64, angles: &[f64]| {
            let angle = angle.to_degrees();
            if folds(angles) { angle.abs() } else { angle }
        };
        let h = bracket(self.horizontal_deg, folded(horizontal, self.horizontal_deg));
        let v = bracket(self.vertical_deg, folded(vertical, self.vertical_deg));
        let (Some((h, s)), Some((v, t))) = (h, v) else {
            return 0.0;
        };
        let nv = self.vertical_deg.len();
        let at = |h: usize, v: usize| self.candela[h.min(self.horizontal_deg.len() - 1) * nv + v.min(nv - 1)];
        let along = |h: usize| at(h, v) * (1.0 - t) + if t > 0.0 { at(h, v + 1) * t } else { 0.0 };
        along(h) * (1.0 - s) + if s > 0.0 { along(h + 1) * s } else { 0.0 }
    }
}

/// An even row with more angles, each of them once.
fn with(mut row: Vec<f64>, more: impl Iterator<Item = f64>) -> Vec<f64> {
    row.extend(more);
    row.sort_by(f64::total_cmp);
    row.dedup_by(|a, b| (*a - *b).abs() < 1e-5);
    row
}

/// Index and fraction of `x` on a rising grid, with room for rounding at its ends; a grid of one angle holds
/// everywhere.
fn bracket(grid: &[f64], x: f64) -> Option<(usize, f64)> {
    let (&first, &last) = (grid.first()?, grid.last()?);
    if grid.len() == 1 {
        return Some((0, 0.0));
    }
    if x < first - 1e-9 || x > last + 1e-9 {
        return None;
    }
    let x = x.clamp(first, last);
    let index = grid
        .partition_point(|&angle| angle <= x)
        .saturating_sub(1)
        .min(grid.len() - 2);
    let fraction = (x - grid[index]) / (grid[index + 1] - grid[index]);
    // At a grid point to within rounding it is that grid point.
    if fraction < 1e-9 {
        Some((index, 0.0))
    } else if fraction > 1.0 - 1e-9 {
        Some((index + 1, 0.0))
    } else {
        Some((index, fraction))
    }
}

#[cfg(test)]
mod tests {
    use isolux_photometry::Symmetry;

    use super::*;

    fn grid() -> Vec<f64> {
        (-9..=9).map(|i| f64::from(i) * 10.0).collect()
    }

    #[test]
    fn a_lambertian_lamp_is_lambertian_in_every_system() {
        let angles = grid();
        for type_a in [true, false] {
            let mut candela = Vec::new();
            for h in &angles {
                for v in &angles {
                    // The axis component is the product of both cosines in A and in B.
                    candela.push(100.0 * h.to_radians().cos() * v.to_radians().cos());
                }
            }
            let native = Native {
                type_a,
                vertical_deg: &angles,
                horizontal_deg: &angles,
                candela: &candela,
            };
            let converted = native.resampled().unwrap().intensity;
            assert_eq!(native.symmetry(), Symmetry::None);
            for c in [0.0, 40.0, 90.0, 180.0, 300.0] {
                for gamma in [0.0, 20.0, 60.0] {
                    let expected = 100.0 * f64::to_radians(gamma).cos();
                    let found = converted.intensity_cd_at(c, gamma);
                    assert!(
                        (found - expected).abs() < 0.9,
                        "type A {type_a}, C{c} γ{gamma}: {found} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn right_is_c0_and_up_is_c90() {
        let angles = grid();
        let spot = |right: f64, up: f64| {
            let mut candela = Vec::new();
            for &h in &angles {
                for &v in &angles {
                    candela.push(if h == right && v == up { 50.0 } else { 0.0 });
                }
            }
            candela
        };
        let (right, up) = (spot(30.0, 0.0), spot(0.0, 30.0));
        for type_a in [true, false] {
            let native = |candela| {
                Native {
                    type_a,
                    vertical_deg: &angles,
                    horizontal_deg: &angles,
                    candela,
                }
                .resampled()
                .unwrap()
                .intensity
            };
            assert_eq!(native(&right).peak().c_deg, 0.0);
            assert_eq!(native(&right).peak().gamma_deg, 30.0);
            assert_eq!(native(&up).peak().c_deg, 90.0);
        }
    }

    #[test]
    fn a_spot_off_both_axes_is_where_two_turns_put_it() {
        let angles: Vec<f64> = (-45..=45).map(|i| f64::from(i) * 2.0).collect();
        let (h0, v0) = (40.0_f64, 30.0_f64);
        let mut candela = Vec::new();
        for h in &angles {
            for v in &angles {
                candela.push(100.0 * (-((h - h0).powi(2) + (v - v0).powi(2)) / 200.0).exp());
            }
        }
        // Type A turns by V about the horizontal axis first and by H about the vertical one then; type B the other way.
        let ((sin_h, cos_h), (sin_v, cos_v)) = (h0.to_radians().sin_cos(), v0.to_radians().sin_cos());
        let directions = [
            (true, [cos_v * sin_h, sin_v, cos_v * cos_h]),
            (false, [sin_h, cos_h * sin_v, cos_h * cos_v]),
        ];
        for (type_a, [right, up, axis]) in directions {
            let native = Native {
                type_a,
                vertical_deg: &angles,
                horizontal_deg: &angles,
                candela: &candela,
            };
            let converted = native.resampled().unwrap().intensity;
            let (c, gamma) = (up.atan2(right).to_degrees(), axis.acos().to_degrees());
            let (peak, at) = (converted.peak(), converted.intensity_cd_at(c, gamma));
            assert!((at - 100.0).abs() < 5.0, "type A {type_a}: {at} at C{c} γ{gamma}");
            assert!((peak.c_deg - c).abs() < 2.0 && (peak.gamma_deg - gamma).abs() < 2.0);
        }
    }
}
