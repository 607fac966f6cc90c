//! Flux and peak of a table of type A or B, from its own angles: straight lines between the values that the file
//! states.

use isolux_photometry::{angles_deg, linear_times_sine};

use super::native::{Native, folds};
use super::photometry::Photometry;
use crate::distribution;

/// What a table says in its own coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnLight {
    /// The exact integral of the bilinear interpolant over the file's angles, in lm.
    pub flux_lm: f64,
    /// The largest value of the file, in cd.
    pub peak_cd: f64,
    /// Where that is: the first half-plane, where several are equal, in degrees.
    pub peak_c_deg: f64,
    /// And the smallest γ, in degrees.
    pub peak_gamma_deg: f64,
}

impl distribution::Native {
    /// Flux and peak in the file's own coordinates.
    pub fn own_light(&self) -> OwnLight {
        Native {
            type_a: self.photometry_type == "A",
            vertical_deg: &self.vertical_deg,
            horizontal_deg: &self.horizontal_deg,
            candela: &self.intensity_cd.concat(),
        }
        .own_light()
    }
}

impl Native<'_> {
    /// Flux and peak over the directions that the angles reach.
    pub(super) fn own_light(&self) -> OwnLight {
        let round = if self.reach_deg() > 90.0 { 180.0 } else { 90.0 };
        // The angle about the axis of the turn counts as it is, the elevation above that axis' equator with its cosine.
        let (v, h) = if self.type_a {
            (elevation(self.vertical_deg), azimuth(self.horizontal_deg, round))
        } else {
            (azimuth(self.vertical_deg, round), elevation(self.horizontal_deg))
        };
        let mut light = OwnLight {
            flux_lm: 0.0,
            peak_cd: f64::NEG_INFINITY,
            peak_c_deg: 0.0,
            peak_gamma_deg: 0.0,
        };
        for (row, (&horizontal, weight)) in self.candela.chunks(v.len()).zip(self.horizontal_deg.iter().zip(&h)) {
            light.flux_lm += weight
                * row
                    .iter()
                    .zip(&v)
                    .map(|(candela, weight)| candela * weight)
                    .sum::<f64>();
            for (&candela, &vertical) in row.iter().zip(self.vertical_deg) {
                if candela < light.peak_cd {
                    continue;
                }
                if let Some((c, gamma)) = self.c_gamma(horizontal, vertical)
                    && (candela > light.peak_cd || (c, gamma) < (light.peak_c_deg, light.peak_gamma_deg))
                {
                    (light.peak_cd, light.peak_c_deg, light.peak_gamma_deg) = (candela, c, gamma);
                }
            }
        }
        light
    }

    /// C and γ of a pair of the file's angles, to a millionth of a degree; none where these angles name no direction
    /// that others do not name as well.
    pub(super) fn c_gamma(&self, horizontal_deg: f64, vertical_deg: f64) -> Option<(f64, f64)> {
        let (photometry, elevation, azimuth) = if self.type_a {
            (Photometry::A, vertical_deg, horizontal_deg)
        } else {
            (Photometry::B, horizontal_deg, vertical_deg)
        };
        if elevation.abs() > 90.0 || azimuth.abs() > 180.0 {
            return None;
        }
        let (c, gamma) = angles_deg(photometry.direction(vertical_deg, horizontal_deg));
        let round = |degrees: f64| (degrees * 1e6).round() / 1e6;
        if round(gamma) == 0.0 {
            return Some((0.0, 0.0));
        }
        let c = round(c).rem_euclid(360.0);
        Some((c, round(gamma)))
    }
}

/// What one candela at each angle of a row adds to the integral over the row, where the angle is counted as it is.
fn azimuth(row: &[f64], last: f64) -> Vec<f64> {
    weights(row, last, &|a, b, fa, fb| (b - a).to_radians() * 0.5 * (fa + fb))
}

/// The same where it is counted with its cosine.
fn elevation(row: &[f64]) -> Vec<f64> {
    weights(row, 90.0, &|a, b, fa, fb| linear_times_sine(a + 90.0, b + 90.0, fa, fb))
}

/// The integral of each angle's straight rise and fall, within ±`last`; `of` integrates a straight line between two
/// angles.
fn weights(row: &[f64], last: f64, of: &dyn Fn(f64, f64, f64, f64) -> f64) -> Vec<f64> {
    let &[first, _, ..] = row else {
        return vec![of(-last, last, 1.0, 1.0)];
    };
    let sides = if folds(row) { 2.0 } else { 1.0 };
    let from = if folds(row) { first } else { -last };
    let mut all = vec![0.0; row.len()];
    for (index, edge) in row.windows(2).enumerate() {
        let (a, b) = (edge[0].max(from), edge[1].min(last));
        if b > a {
            let falling = |x: f64| (edge[1] - x) / (edge[1] - edge[0]);
            all[index] += sides * of(a, b, falling(a), falling(b));
            all[index + 1] += sides * of(a, b, 1.0 - falling(a), 1.0 - falling(b));
        }
    }
    all
}
