//! Planes that repeat each other to the digit, except in one or two places.
//!
//! Symmetric light that is written on the full circle says everything twice: a value that differs from its mirror image
//! where all others are equal is no light.

use super::{Stored, at};
use crate::finding::{Finding, Findings};

/// Fewest equal values, zeros not counted, that make a symmetry.
const EQUAL: usize = 40;
/// Most places that may differ, and the equal ones that each of them needs.
const DIFFER: (usize, usize) = (3, 40);

/// Where C has its image.
type Image = fn(f64) -> f64;

/// Looks for the mirror at C0–C180, the one at C90–C270, half a turn, and planes that are all one.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    for image in images(stored) {
        if let Some(odd) = odd(stored, &image.pairs) {
            for (one, other) in odd {
                findings.push(finding(stored, one, other, image.name));
            }
            return;
        }
    }
}

/// Planes with their images.
struct Images {
    name: &'static str,
    pairs: Vec<(usize, usize)>,
}

/// The first of them that almost holds decides.
fn images(stored: &Stored<'_>) -> impl Iterator<Item = Images> {
    let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
    let usable = stored.poles && planes >= 2 && stored.values.len() == planes * ng;
    let images: [(&str, Image); 3] = [
        ("mirrored at C0–C180", |c| -c),
        ("mirrored at C90–C270", |c| 180.0 - c),
        ("half a turn away", |c| c + 180.0),
    ];
    let turned = images.into_iter().filter_map(|(name, image)| {
        let pairs = pairs(stored.planes_deg, image)?;
        Some(Images { name, pairs })
    });
    let all_one = Images {
        name: "of the first plane",
        pairs: (1..planes).map(|plane| (0, plane)).collect(),
    };
    turned.chain(std::iter::once(all_one)).filter(move |_| usable)
}

/// Planes and their images, each pair once; none where a plane has no image or all are their own.
fn pairs(planes_deg: &[f64], image: Image) -> Option<Vec<(usize, usize)>> {
    let mut pairs = Vec::new();
    for (plane, &c) in planes_deg.iter().enumerate() {
        let wanted = image(c).rem_euclid(360.0);
        let apart = |other: f64| {
            let apart = (other.rem_euclid(360.0) - wanted).abs();
            apart.min(360.0 - apart)
        };
        let twin = planes_deg.iter().position(|&other| apart(other) < 1e-6)?;
        if plane < twin {
            pairs.push((plane, twin));
        }
    }
    (!pairs.is_empty()).then_some(pairs)
}

/// Indices of values that differ from their image, where almost all others are equal.
fn odd(stored: &Stored<'_>, pairs: &[(usize, usize)]) -> Option<Vec<(usize, usize)>> {
    let tally = Tally::of(stored, pairs, DIFFER.0);
    tally.almost().then_some(tally.odd)
}

/// How far planes equal their images.
#[derive(Clone)]
struct Tally {
    equal: usize,
    odd: Vec<(usize, usize)>,
    /// So many are odd that the count was given up.
    too_many: bool,
}

impl Tally {
    fn of(stored: &Stored<'_>, pairs: &[(usize, usize)], most: usize) -> Self {
        let ng = stored.angles_deg.len();
        let mut tally = Self {
            equal: 0,
            odd: Vec::new(),
            too_many: false,
        };
        for &(one, other) in pairs {
            let rows = [one, other].map(|plane| &stored.values[plane * ng..(plane + 1) * ng]);
            for angle in 0..ng {
                let [a, b] = rows.map(|row| row[angle]);
                if a == b {
                    tally.equal += usize::from(a != 0.0);
                } else if !matches!(stored.angles_deg[angle], 0.0 | 180.0) {
                    tally.odd.push((one * ng + angle, other * ng + angle));
                    if tally.odd.len() > most {
                        tally.too_many = true;
                        return tally;
                    }
                }
            }
        }
        tally
    }

    fn almost(&self) -> bool {
        let odd = self.odd.len();
        !self.too_many && (1..=DIFFER.0).contains(&odd) && self.equal >= EQUAL.max(DIFFER.1 * odd)
    }
}

/// The one of the two that fits its neighbours along γ less well, and the other.
fn suspect(values: &[f64], ng: usize, one: usize, other: usize) -> (usize, usize) {
    let bend = |index: usize| {
        let inside = (1..ng - 1).contains(&(index % ng));
        if inside {
            (values[index - 1] - 2.0 * values[index] + values[index + 1]).abs()
        } else {
            0.0
        }
    };
    if bend(one) > bend(other) {
        (one, other)
    } else {
        (other, one)
    }
}

fn finding(stored: &Stored<'_>, one: usize, other: usize, how: &str) -> Finding {
    let ng = stored.angles_deg.len();
    let (suspect, twin) = suspect(stored.values, ng, one, other);
    let line = stored.places.get(twin).map_or(1, |place| place.0);
    let message = format!(
        "all other intensities equal their image {how}; this one (γ = {}°) differs from {} in line {line}",
        stored.angles_deg[suspect % ng],
        (stored.raw)(twin)
    );
    at(
        stored,
        suspect,
        Finding::warning("intensity-twin", message).assumed("the value as it stands"),
    )
    .fix("compare both values with the source")
}
