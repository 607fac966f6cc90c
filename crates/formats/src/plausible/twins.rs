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
    let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
    if !stored.poles || planes < 2 || stored.values.len() != planes * ng {
        return;
    }
    let images: [(&str, Image); 3] = [
        ("mirrored at C0–C180", |c| -c),
        ("mirrored at C90–C270", |c| 180.0 - c),
        ("half a turn away", |c| c + 180.0),
    ];
    for (name, image) in images {
        let Some(pairs) = pairs(stored.planes_deg, image) else {
            continue;
        };
        if let Some(odd) = odd(stored, &pairs) {
            for (one, other) in odd {
                findings.push(finding(stored, one, other, name));
            }
            return;
        }
    }
    let with_first: Vec<(usize, usize)> = (1..planes).map(|plane| (0, plane)).collect();
    for (one, other) in odd(stored, &with_first).unwrap_or_default() {
        findings.push(finding(stored, one, other, "of the first plane"));
    }
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
    let ng = stored.angles_deg.len();
    let mut equal = 0;
    let mut odd = Vec::new();
    for &(one, other) in pairs {
        let rows = [one, other].map(|plane| &stored.values[plane * ng..(plane + 1) * ng]);
        for angle in 0..ng {
            let [a, b] = rows.map(|row| row[angle]);
            if a == b {
                equal += usize::from(a != 0.0);
            } else if !matches!(stored.angles_deg[angle], 0.0 | 180.0) {
                odd.push((one * ng + angle, other * ng + angle));
                if odd.len() > DIFFER.0 {
                    return None;
                }
            }
        }
    }
    (!odd.is_empty() && equal >= EQUAL.max(DIFFER.1 * odd.len())).then_some(odd)
}

/// The one of the two that fits its neighbours along γ less well is named.
fn finding(stored: &Stored<'_>, one: usize, other: usize, how: &str) -> Finding {
    let ng = stored.angles_deg.len();
    let bend = |index: usize| {
        let inside = (1..ng - 1).contains(&(index % ng));
        if inside {
            (stored.values[index - 1] - 2.0 * stored.values[index] + stored.values[index + 1]).abs()
        } else {
            0.0
        }
    };
    let (suspect, twin) = if bend(one) > bend(other) {
        (one, other)
    } else {
        (other, one)
    };
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
