//! The largest of many distances, of which each has noise: what noise adds to a maximum, and how well it is known.
//!
//! Of N directions of one colour the largest distance read is not 0 but about σ·√(2 ln N): 37 directions read to
//! 3·10⁻⁴ differ by 8·10⁻⁴ at most. Where one direction stands out, noise adds next to nothing. How the
//! directions lie without noise is estimated first: smoothly over the sphere, and of what each differs from that as
//! much as is more than noise. All are then scaled by a common factor t, noise is drawn on top, and t is the factor for
//! which the largest of them is, in the mean, the one that was read. The factors for which the one that was read is
//! still within the central 95 % are the interval (Neyman's construction).

use nalgebra::{DMatrix, DVector};

use crate::normal::Normal;

/// A maximum of distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Largest {
    /// Its place.
    pub place: usize,
    /// As it was read.
    pub read: f64,
    /// Without what noise adds.
    pub value: f64,
    /// Standard uncertainty from noise.
    pub u_noise: f64,
}

/// Draws of noise for each factor; fewer where there are many directions.
const DRAWS: usize = 2000;
const MOST: usize = 2_000_000;
const LEAST_DRAWS: usize = 200;
/// Halvings of the interval of t.
const HALVINGS: usize = 18;
/// Singular values below this share of the largest: functions that the directions cannot tell apart.
const RANK_REL: f64 = 1e-9;
/// Share of the draws outside the interval, at each end.
const TAIL: f64 = 0.025;

impl Largest {
    /// Of differences in (u′, v′) of directions (C, γ), each with the variance of u′, the covariance and the
    /// variance of v′ of its noise; none without differences.
    pub fn of(directions_deg: &[(f64, f64)], read_at: &[[f64; 2]], covariance: &[[f64; 3]]) -> Option<Self> {
        let length = |[u, v]: &[f64; 2]| u.hypot(*v);
        let lengths = read_at.iter().map(length).enumerate();
        let (place, read) = lengths.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let differences = without_noise(directions_deg, read_at, covariance);
        let reach = differences.iter().map(length).fold(0.0, f64::max);
        if reach == 0.0 || read == 0.0 {
            let (value, u_noise) = (0.0, 0.5 * read);
            return Some(Self {
                place,
                read,
                value,
                u_noise,
            });
        }
        // Noise may hide a little of a difference, and not a multiple of what was read.
        let farthest = 2.0 * read / reach;
        let draws = (MOST / read_at.len()).clamp(LEAST_DRAWS, DRAWS);
        let mut normal = Normal::new(read_at.len() as u64);
        // The same noise for every factor, so that the maxima rise with it.
        let noise: Vec<[f64; 2]> = (0..draws)
            .flat_map(|_| covariance.iter())
            .map(|[uu, uv, vv]| {
                let (a, b) = (normal.next(), normal.next());
                let u = uu.max(0.0).sqrt();
                let along = if u > 0.0 { uv / u } else { 0.0 };
                [u * a, along * a + (vv - along * along).max(0.0).sqrt() * b]
            })
            .collect();
        let maxima = |t: f64| {
            let differences = &differences;
            noise.chunks(differences.len()).map(move |noise| {
                let squares = differences.iter().zip(noise);
                let squares = squares.map(|([u, v], [nu, nv])| (t * u + nu).powi(2) + (t * v + nv).powi(2));
                squares.fold(0.0, f64::max).sqrt()
            })
        };
        // The factor up to which something of the maxima is below what was read; 0 where it is above from the first.
        let factor = |is_below: &dyn Fn(f64) -> bool| {
            let (mut low, mut high) = (0.0, farthest);
            if !is_below(low) {
                return low;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if is_below(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        };
        let place_of = |share: f64| ((draws - 1) as f64 * share).round() as usize;
        // A quantile is below what was read where more maxima are below that than stand before the quantile.
        let quantile_below = |share: f64| {
            let before = place_of(share);
            move |t: f64| maxima(t).filter(|maximum| *maximum < read).count() > before
        };
        let t = factor(&|t| maxima(t).sum::<f64>() / (draws as f64) < read);
        let (least, most) = (factor(&quantile_below(1.0 - TAIL)), factor(&quantile_below(TAIL)));
        let u_of_noise_alone = || {
            let mut alone: Vec<f64> = maxima(0.0).collect();
            alone.sort_by(f64::total_cmp);
            0.5 * (alone[place_of(0.84)] - alone[place_of(0.16)])
        };
        Some(Self {
            place,
            read,
            value: t * reach,
            // Where there was even less than noise alone gives, what that scatters by.
            u_noise: (0.5 * reach * (t - least).max(most - t)).max(if t == 0.0 { u_of_noise_alone() } else { 0.0 }),
        })
    }
}

/// Where the directions lie without noise: what goes with γ alone (to the third order of cos γ, by least squares),
/// and of what goes around C (harmonics of the sphere to the second order), and of the rest, the share that is more
/// than noise.
fn without_noise(directions_deg: &[(f64, f64)], read_at: &[[f64; 2]], covariance: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let variance = |of: &[f64; 3]| of[0] + of[2];
    let largest = covariance.iter().map(variance).fold(0.0, f64::max);
    let functions = functions(0.0, 0.0).len();
    if largest <= 0.0 || read_at.len() < 2 * functions {
        return read_at.to_vec();
    }
    // A direction without noise does not count for all of them.
    let weights: Vec<f64> = covariance
        .iter()
        .map(|of| (variance(of).max(1e-4 * largest)).sqrt().recip())
        .collect();
    // In units of the noise, and the freedom that a fit leaves it.
    let weighted: Vec<[f64; 2]> = (read_at.iter().zip(&weights))
        .map(|([u, v], weight)| [weight * u, weight * v])
        .collect();
    let (Some((zonal, of_zonal)), Some((smooth, of_smooth))) = (
        fitted(directions_deg, &weighted, &weights, ZONAL),
        fitted(directions_deg, &weighted, &weights, functions),
    ) else {
        return read_at.to_vec();
    };
    let around = share(&zonal, &smooth, of_smooth - of_zonal);
    let rest = share(&smooth, &weighted, read_at.len() - of_smooth);
    let of = |row: usize| {
        let axis = |axis: usize| {
            let (zonal, smooth, read) = (zonal[row][axis], smooth[row][axis], weighted[row][axis]);
            (zonal + around * (smooth - zonal) + rest * (read - smooth)) / weights[row]
        };
        [axis(0), axis(1)]
    };
    (0..read_at.len()).map(of).collect()
}

/// Values in units of their noise by the first `count` functions, and how many of these they can tell apart.
fn fitted(
    directions_deg: &[(f64, f64)],
    weighted: &[[f64; 2]],
    weights: &[f64],
    count: usize,
) -> Option<(Vec<[f64; 2]>, usize)> {
    let design = DMatrix::from_fn(weighted.len(), count, |row, column| {
        let (c_deg, gamma_deg) = directions_deg[row];
        weights[row] * functions(c_deg, gamma_deg)[column]
    });
    let svd = design.clone().svd(true, true);
    let least = RANK_REL * svd.singular_values.max();
    let along = |axis: usize| {
        let values = DVector::from_fn(weighted.len(), |row, _| weighted[row][axis]);
        svd.solve(&values, least).ok().map(|found| &design * found)
    };
    let (u, v) = (along(0)?, along(1)?);
    let fitted = (0..weighted.len()).map(|row| [u[row], v[row]]).collect();
    Some((fitted, svd.rank(least)))
}

/// The share of what `to` differs from `from` that is more than noise, which would make `freedom` of it (James and
/// Stein).
fn share(from: &[[f64; 2]], to: &[[f64; 2]], freedom: usize) -> f64 {
    let squares = from.iter().zip(to);
    let squares: f64 = squares
        .map(|(from, to)| (to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2))
        .sum();
    if squares > 0.0 {
        (1.0 - freedom as f64 / squares).max(0.0)
    } else {
        0.0
    }
}

/// How many of the functions go with γ alone.
const ZONAL: usize = 4;

/// Functions on the sphere that a smooth colour is made of.
fn functions(c_deg: f64, gamma_deg: f64) -> [f64; 10] {
    let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
    let (sin, cos) = gamma_deg.to_radians().sin_cos();
    [
        1.0,
        cos,
        cos * cos,
        cos * cos * cos,
        sin * cos_c,
        sin * sin_c,
        sin * cos * cos_c,
        sin * cos * sin_c,
        sin * sin * (cos_c * cos_c - sin_c * sin_c),
        sin * sin * sin_c * cos_c,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four half-planes every 10°.
    fn directions() -> Vec<(f64, f64)> {
        let rings = (1..=9).flat_map(|k| [0.0, 90.0, 180.0, 270.0].map(|c| (c, 10.0 * f64::from(k))));
        std::iter::once((0.0, 0.0)).chain(rings).collect()
    }

    /// Truths read many times with noise: bias in σ of what is read and of what is made of it, and how often the truth
    /// is within ± 2 u.
    fn read(truth: &dyn Fn(f64, f64) -> [f64; 2], sigma: f64, times: u32) -> (f64, f64, f64) {
        let at = directions();
        let truth: Vec<[f64; 2]> = at.iter().map(|&(c, gamma)| truth(c, gamma)).collect();
        let exact = truth.iter().map(|[u, v]| u.hypot(*v)).fold(0.0, f64::max);
        let covariance = vec![[sigma * sigma, 0.3 * sigma * sigma, 0.5 * sigma * sigma]; truth.len()];
        let (mut raw, mut corrected, mut inside) = (0.0, 0.0, 0.0);
        let share = f64::from(times).recip();
        for seed in 0..times {
            let mut normal = Normal::new(5000 + u64::from(seed));
            let noisy: Vec<[f64; 2]> = truth
                .iter()
                .map(|[u, v]| {
                    let (a, b) = (normal.next(), normal.next());
                    [u + sigma * a, v + sigma * (0.3 * a + (0.5f64 - 0.09).sqrt() * b)]
                })
                .collect();
            let found = Largest::of(&at, &noisy, &covariance).unwrap();
            raw += share * (found.read - exact);
            corrected += share * (found.value - exact);
            inside += if (found.value - exact).abs() <= 2.0 * found.u_noise {
                share
            } else {
                0.0
            };
        }
        (raw / sigma, corrected / sigma, inside)
    }

    #[test]
    fn the_largest_of_noise_alone_is_no_colour() {
        // 37 directions of one colour at 3·10⁻⁴: about σ·√(2 ln N) = 8·10⁻⁴ is read.
        let (raw, corrected, inside) = read(&|_, _| [0.0; 2], 3e-4, 60);
        assert!((2.3..3.0).contains(&raw), "{raw}");
        assert!(corrected < 0.35 * raw, "{corrected} of {raw}");
        assert!(inside >= 0.93, "{inside}");
    }

    #[test]
    fn what_stands_out_stays_and_what_is_level_loses_what_noise_adds() {
        // A lamp that turns yellow with γ: four directions stand out alike, by sixteen times the noise.
        let yellow = |_: f64, gamma: f64| [4e-3 * (gamma / 90.0).powi(2), 3e-3 * (gamma / 90.0).powi(2)];
        let (raw, corrected, inside) = read(&yellow, 3e-4, 60);
        assert!(
            raw > 0.8 && corrected.abs() < 0.35 && inside >= 0.91,
            "{raw} {corrected} {inside}"
        );
        let single = |c: f64, gamma: f64| {
            if (c, gamma) == (90.0, 20.0) {
                [6e-3, 0.0]
            } else {
                [0.0; 2]
            }
        };
        let (raw, corrected, inside) = read(&single, 3e-4, 100);
        assert!(
            raw.abs() < 0.4 && corrected.abs() < 0.4 && inside >= 0.88,
            "{raw} {corrected} {inside}"
        );
        let leaning = |c: f64, gamma: f64| [1e-3 * gamma.to_radians().sin() * c.to_radians().cos(), 0.0];
        let (raw, corrected, inside) = read(&leaning, 3e-4, 60);
        assert!(
            raw > 1.0 && corrected.abs() < 0.6 && inside >= 0.91,
            "{raw} {corrected} {inside}"
        );
        assert_eq!(Largest::of(&[], &[], &[]), None);
        let still = Largest::of(&[(0.0, 0.0), (0.0, 9.0)], &[[1e-3, 0.0], [0.0, 2e-3]], &[[0.0; 3]; 2]).unwrap();
        assert!(
            (still.value - 2e-3).abs() < 1e-7 && still.u_noise < 1e-7 && still.place == 1,
            "{still:?}"
        );
    }
}
