//! The numbers with one thing after the other moved by its standard uncertainty.

use isolux_photometry::{HalfPlanes, IntensityDistribution};
use isolux_spectrum::Spectrum;

use super::blur::blurred;
use super::chromaticity::{self, Numbers, Point, changes};
use super::facts::{AverageColour, DirectionColour, LargestDifference};
use super::largest::Largest;
use super::outcome::Outcome;
use super::weights::{Lumens, lm79};
use super::{Found, LEAST_SHARE, Set, mix, of_one_lumen, sum};
use crate::colour::{bow_changed, shape_changed, wavelengths_changed};
use crate::quantity::Quantity;

/// Most of its own colour that stray light may take from a direction: where more comes astray there is none.
const MOST_STRAY: f64 = 0.5;

/// Between the directions that were read.
const INTERPOLATION: &str = "interpolation";
/// Of the lamp's size.
const LAMP_SIZE: &str = "lamp_size";

/// The numbers as they are, and with one thing moved.
pub struct Moved {
    /// As they are.
    pub centre: Outcome,
    /// For the whole light and the average.
    pub of_whole: Vec<(&'static str, Outcome)>,
    /// For single directions.
    pub of_directions: Vec<(&'static str, Outcome)>,
    /// Chromaticities with their noise.
    points: Vec<Point>,
    /// Weights of the average.
    lm79: Vec<f64>,
    /// Share of the flux beyond the last spectra.
    pub beyond: f64,
}

/// The part of a change that is its standard uncertainty. Steps that are doubled quadruple the error of interpolation
/// (Richardson, as for the flux). The mixture of a lamp of some size lies anywhere from none to what its disc would do.
pub fn share(part: &str) -> f64 {
    match part {
        INTERPOLATION => 1.0 / 3.0,
        LAMP_SIZE => 1.0 / 3.0_f64.sqrt(),
        _ => 1.0,
    }
}

/// The largest change of each number by each part: interpolation is tried in several ways.
pub fn largest_of_each<const N: usize>(
    parts: impl Iterator<Item = (&'static str, [f64; N])>,
) -> Vec<(&'static str, [f64; N])> {
    let mut largest: Vec<(&'static str, [f64; N])> = Vec::new();
    for (name, change) in parts {
        match largest.iter_mut().find(|(known, _)| *known == name) {
            Some((_, most)) => *most = std::array::from_fn(|number| most[number].max(change[number].abs())),
            None => largest.push((name, change.map(f64::abs))),
        }
    }
    largest
}

impl Moved {
    /// None where a spectrum has no chromaticity.
    pub fn of(found: &Found<'_>) -> Option<Self> {
        let (set, lamp, known) = (&found.set, found.lamp, &found.known);
        let (distribution, common) = (lamp.distribution, lamp.common);
        let count = set.directions.len();
        let weighed = |half_planes: &HalfPlanes, count: usize, shift_deg: f64, added_cd: f64| {
            let lumens = Lumens::of(distribution, half_planes, count, shift_deg, added_cd);
            // What smoothing and its own rule make of the flux is the flux's.
            let scale = lamp.flux.value / lumens.of.iter().sum::<f64>();
            let scaled = |of: Vec<f64>| -> Vec<f64> { of.into_iter().map(|lm| scale * lm).collect() };
            (scaled(lumens.of), scaled(lumens.held))
        };
        let averaged = |shift_deg: f64, added_cd: f64| -> Vec<f64> {
            let read = set.directions_deg.iter();
            let read = read.map(|(c, gamma)| Some(distribution.intensity_cd_at(*c, *gamma) + added_cd));
            let planned = read.chain(found.left_out.iter().map(|_| None)).collect::<Vec<_>>();
            let mut weights = lm79(&found.planned, &planned, shift_deg);
            weights.truncate(count);
            weights
        };
        let (lumens, held) = weighed(&set.half_planes, count, 0.0, 0.0);
        let weights = averaged(0.0, 0.0);
        let centre = Outcome::of(&set.per_lumen, &lumens, &weights)?;
        let again = |per_lumen: &[Spectrum]| Outcome::of(per_lumen, &lumens, &weights);

        let mut of_both = Vec::new();
        let reshaped = |change: &dyn Fn(&Spectrum) -> Option<Spectrum>| -> Vec<Spectrum> {
            let changed = |spectrum: &Spectrum| change(spectrum).map(|changed| of_one_lumen(&changed));
            let spectra = set.per_lumen.iter();
            spectra
                .map(|spectrum| changed(spectrum).unwrap_or_else(|| spectrum.clone()))
                .collect()
        };
        of_both.push((
            "calibration_shape",
            again(&reshaped(&|s| shape_changed(s, known.shape_rel)))?,
        ));
        for (part, per_lumen) in &found.moved {
            of_both.push((*part, again(per_lumen)?));
        }
        of_both.push((
            "calibration_bow",
            again(&reshaped(&|s| bow_changed(s, known.shape_rel)))?,
        ));
        of_both.push((
            "wavelength",
            again(&reshaped(&|s| wavelengths_changed(s, known.wavelength_nm)))?,
        ));
        of_both.push(("stray", again(&astray(set, &centre.total, known.stray_rel))?));
        if let Some(blur_deg) = found.blur_deg() {
            let at = &set.directions_deg;
            let (planes, step_deg) = (&set.half_planes, found.step_deg());
            let once_more = blurred(planes, at, &set.per_lumen, distribution, blur_deg, step_deg);
            let pairs = set.per_lumen.iter().zip(&once_more);
            let without =
                pairs.map(|(read, more)| sum([(read, 2.0), (more, -1.0)]).map(|without| of_one_lumen(&without)));
            let without: Vec<Spectrum> = without.collect::<Option<_>>()?;
            of_both.push((LAMP_SIZE, again(&without)?));
        }

        let (mut of_whole, mut of_directions) = (of_both.clone(), of_both);
        // A zero that is wrong moves every direction and every ring.
        let shift_deg = common.gamma_deg;
        let (moved, _) = weighed(&set.half_planes, count, shift_deg, 0.0);
        of_whole.push(("angle", Outcome::of(&set.per_lumen, &moved, &averaged(shift_deg, 0.0))?));
        let elsewhere = set.directions_deg.iter();
        let elsewhere =
            elsewhere.map(|(c, gamma)| mix(&set.half_planes, &set.per_lumen, *c, (gamma + shift_deg).min(180.0)));
        of_directions.push(("angle", again(&elsewhere.collect::<Option<Vec<_>>>()?)?));
        let added_cd = common.added_cd();
        let (brighter, _) = weighed(&set.half_planes, count, 0.0, added_cd);
        let brighter = Outcome::of(&set.per_lumen, &brighter, &averaged(0.0, added_cd))?;
        of_whole.push(("intensity", brighter));
        for kept in thinned(set) {
            let directions: Vec<(f64, f64)> = kept.iter().map(|&index| set.directions_deg[index]).collect();
            let Ok(planes) = HalfPlanes::new(&directions) else {
                continue;
            };
            let (of_kept, _) = weighed(&planes, kept.len(), 0.0, 0.0);
            let mut fewer = vec![0.0; count];
            kept.iter()
                .zip(of_kept)
                .for_each(|(&index, lumens)| fewer[index] = lumens);
            of_whole.push((INTERPOLATION, Outcome::of(&set.per_lumen, &fewer, &weights)?));
        }
        // What is held beyond the last spectra may be as far from it as that is from the mean of all.
        let beyond = held.iter().sum::<f64>() / lamp.flux.value;
        let mean = 1.0 - beyond;
        let farther: Vec<f64> = lumens
            .iter()
            .zip(&held)
            .map(|(lumens, held)| lumens * mean + held)
            .collect();
        of_whole.push(("beyond", Outcome::of(&set.per_lumen, &farther, &weights)?));

        let points = set.directions.iter().zip(&set.per_lumen);
        let points = points.map(|(direction, _)| Point::of(&direction.spectrum, &direction.variance));
        Some(Self {
            points: points.collect::<Option<_>>()?,
            centre,
            of_whole,
            of_directions,
            lm79: weights,
            beyond,
        })
    }

    /// Standard uncertainty of each value of the total: noise `u_w_nm`, the flux's own, and every part.
    pub fn u_of_total(&self, u_w_nm: &[f64], flux_rel: f64) -> Vec<f64> {
        let total = self.centre.total.value();
        let of = |place: usize| {
            let parts = self.of_whole.iter().map(|(name, other)| {
                let change = share(name) * (other.total.value()[place] - total[place]);
                (*name, [change])
            });
            let parts = largest_of_each(parts)
                .into_iter()
                .map(|(_, [part])| part * part)
                .sum::<f64>();
            (parts + u_w_nm[place].powi(2) + (flux_rel * total[place]).powi(2)).sqrt()
        };
        (0..total.len()).map(of).collect()
    }

    /// The average of LM-79, as the standard defines it on these directions.
    pub fn average(&self, missing: &[String]) -> AverageColour {
        let mean = Point::mean(self.points.iter().zip(self.lm79.iter().copied()));
        let parts: Vec<(&'static str, [f64; chromaticity::COUNT])> = std::iter::once(("noise", mean.noise()))
            .chain(
                (self.of_whole.iter())
                    .filter(|(name, _)| ![INTERPOLATION, "beyond"].contains(name))
                    .map(|(name, other)| {
                        let change = changes(&self.centre.average, &other.average);
                        (*name, change.map(|change| share(name) * change))
                    }),
            )
            .collect();
        let quantity = |number: usize, unit: &'static str| {
            let parts = parts.iter().map(|(name, part)| (*name, part[number]));
            Some(Quantity::new(self.centre.average[number]?, unit, parts).lacking(missing.iter().cloned()))
        };
        AverageColour {
            x: quantity(0, ""),
            y: quantity(1, ""),
            u_prime: quantity(2, ""),
            v_prime: quantity(3, ""),
            cct: quantity(4, "K"),
            duv: quantity(5, ""),
        }
    }

    /// Δu′v′ over the directions that have light enough; none without one.
    pub fn largest(&self, found: &Found<'_>, missing: &[String]) -> Option<LargestDifference> {
        let distribution = found.lamp.distribution;
        let least_cd = LEAST_SHARE * distribution.peak().intensity_cd;
        let bright = |c_deg: f64, gamma_deg: f64| distribution.intensity_cd_at(c_deg, gamma_deg) >= least_cd;
        let at = &found.set.directions_deg;
        let counted: Vec<usize> = (0..at.len())
            .filter(|&index| bright(at[index].0, at[index].1))
            .collect();
        let differences = self.centre.differences();
        let read: Vec<[f64; 2]> = counted.iter().map(|&index| differences[index]).collect();
        let covariance: Vec<[f64; 3]> = counted
            .iter()
            .map(|&index| self.points[index].covariance_uv())
            .collect();
        let counted_at: Vec<(f64, f64)> = counted.iter().map(|&index| at[index]).collect();
        let largest = Largest::of(&counted_at, &read, &covariance)?;
        let farthest = |outcome: &Outcome| {
            let differences = outcome.differences();
            let lengths = counted
                .iter()
                .map(|&index| differences[index][0].hypot(differences[index][1]));
            lengths.fold(0.0, f64::max)
        };
        // Spectra without what a second mixing takes are those before the first one, to first order (van Cittert 1931).
        let unmixed = self.of_directions.iter().find(|(name, _)| *name == LAMP_SIZE);
        let lamp_size_bias = unmixed.map_or(0.0, |(_, unmixed)| largest.read - farthest(unmixed));
        let parts = self.of_directions.iter();
        let parts = parts.map(|(name, other)| (*name, share(name) * (farthest(other) - largest.read)));
        let dark = found.left_out.iter().find(|left| bright(left.c_deg, left.gamma_deg));
        let dark = dark.map(|left| {
            format!(
                "no spectrum at C {}° γ {}°, which is bright",
                left.c_deg, left.gamma_deg
            )
        });
        let (c_deg, gamma_deg) = at[counted[largest.place]];
        Some(LargestDifference {
            value: Quantity::new(
                (largest.value - lamp_size_bias).max(0.0),
                "",
                std::iter::once(("noise", largest.u_noise)).chain(parts),
            )
            .lacking(missing.iter().cloned().chain(dark)),
            read: largest.read,
            noise_bias: largest.read - largest.value,
            lamp_size_bias,
            c_deg,
            gamma_deg,
            directions: counted.len(),
            least_share: LEAST_SHARE,
        })
    }

    /// Every direction.
    pub fn directions(&self, set: &Set, distribution: &IntensityDistribution, complete: bool) -> Vec<DirectionColour> {
        let differences = self.centre.differences();
        let of = |index: usize| {
            let own: &Numbers = &self.centre.directions[index];
            let noise = self.points[index].noise();
            let mut squares = noise.map(|noise| noise * noise);
            for (name, other) in &self.of_directions {
                let change = changes(own, &other.directions[index]);
                for (sum, change) in squares.iter_mut().zip(change) {
                    *sum += (share(name) * change).powi(2);
                }
            }
            let u = |number: usize| (complete && own[number].is_some()).then(|| squares[number].sqrt());
            let value = |number: usize| own[number].unwrap_or(f64::NAN);
            let (c_deg, gamma_deg) = set.directions_deg[index];
            let [du, dv] = differences[index];
            DirectionColour {
                c_deg,
                gamma_deg,
                intensity_cd: distribution.intensity_cd_at(c_deg, gamma_deg),
                illuminance_lx: set.directions[index].illuminance_lx,
                x: value(0),
                u_x: u(0),
                y: value(1),
                u_y: u(1),
                u_prime: value(2),
                u_u_prime: u(2),
                v_prime: value(3),
                u_v_prime: u(3),
                cct_k: own[4],
                u_cct_k: u(4),
                duv: own[5],
                u_duv: u(5),
                delta_u_prime_v_prime: du.hypot(dv),
                noise_u_prime_v_prime: (0.5 * (noise[2] * noise[2] + noise[3] * noise[3])).sqrt(),
            }
        };
        (0..set.directions.len()).map(of).collect()
    }
}

/// Spectra without the light that reached them another way, which has the colour of the whole: a share of the strongest
/// illuminance, so more of a dim direction's.
fn astray(set: &Set, total: &Spectrum, stray_rel: f64) -> Vec<Spectrum> {
    let whole = of_one_lumen(total);
    let illuminance = set.directions.iter().map(|direction| direction.illuminance_lx);
    let strongest = illuminance.fold(0.0, f64::max);
    let of = |(direction, per_lumen): (&super::Direction, &Spectrum)| {
        let share = (stray_rel * strongest / direction.illuminance_lx).min(MOST_STRAY);
        sum([(per_lumen, 1.0 + share), (&whole, -share)]).unwrap_or_else(|| per_lumen.clone())
    };
    set.directions.iter().zip(&set.per_lumen).map(of).collect()
}

/// The directions that are left when every second γ, or half-plane, is left out, in both ways; the ends stay.
fn thinned(set: &Set) -> Vec<Vec<usize>> {
    let planes: Vec<(f64, Vec<usize>)> = {
        let mut by_c: Vec<(f64, Vec<usize>)> = Vec::new();
        let mut order: Vec<usize> = (0..set.directions_deg.len()).collect();
        order.sort_by(|&a, &b| {
            let (a, b) = (set.directions_deg[a], set.directions_deg[b]);
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        for index in order {
            let (c_deg, gamma_deg) = set.directions_deg[index];
            if crate::grid::is_pole(gamma_deg) {
                continue;
            }
            match by_c.last_mut() {
                Some((last, nodes)) if *last == c_deg => nodes.push(index),
                _ => by_c.push((c_deg, vec![index])),
            }
        }
        by_c
    };
    let poles: Vec<usize> = (0..set.directions_deg.len())
        .filter(|&index| crate::grid::is_pole(set.directions_deg[index].1))
        .collect();
    let mut ways = Vec::new();
    for parity in [0, 1] {
        let along = planes.iter().flat_map(|(_, nodes)| {
            let last = nodes.len() - 1;
            let kept = move |(place, index): (usize, &usize)| (place == last || place % 2 == parity).then_some(*index);
            nodes.iter().enumerate().filter_map(kept)
        });
        ways.push(poles.iter().copied().chain(along).collect());
        if planes.len() >= 4 {
            let around = planes.iter().enumerate().filter(|(plane, _)| plane % 2 == parity);
            let around = around.flat_map(|(_, (_, nodes))| nodes.iter().copied());
            ways.push(poles.iter().copied().chain(around).collect());
        }
    }
    ways.retain(|kept: &Vec<usize>| kept.len() < set.directions_deg.len());
    ways
}
