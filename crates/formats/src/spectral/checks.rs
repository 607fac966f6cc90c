//! Rows of a spectrum against each other: gaps, single values, signs, ends.

use super::point::Point;
use crate::finding::{Finding, Findings};

/// A step out of line in a grid that is smooth around it: a lost or a damaged line.
pub(super) fn gaps(points: &[Point], left_out: &[f64], findings: &mut Findings) {
    let steps: Vec<f64> = points.windows(2).map(|p| p[1].x - p[0].x).collect();
    if steps.len() < 4 {
        return;
    }
    for i in 0..steps.len() {
        // The three steps on either side, or six on one at the ends; a damaged wavelength spoils two neighbouring
        // steps.
        let neighbours: Vec<f64> = (i.saturating_sub(4)..(i + 5).min(steps.len()))
            .filter(|&k| k != i && k + 1 != i && k != i + 1)
            .map(|k| steps[k])
            .collect();
        if neighbours.len() < 3 {
            continue;
        }
        let mean = neighbours.iter().sum::<f64>() / neighbours.len() as f64;
        let smooth = neighbours.iter().all(|s| (s - mean).abs() <= 0.05 * mean);
        let (a, b) = (&points[i], &points[i + 1]);
        let known = || left_out.iter().any(|&x| a.x < x && x < b.x);
        if smooth && steps[i] > 1.4 * mean && !known() {
            findings.push(
                Finding::warning(
                    "spectrum-gap",
                    format!(
                        "{} nm lie between two lines where about {mean:.4} nm is usual",
                        short(steps[i])
                    ),
                )
                .at(b.line.max(a.line), b.column)
                .raw(&format!("{}", b.x))
                .assumed("the spectrum is linear across the step")
                .fix("check for a missing line or a damaged wavelength"),
            );
        }
    }
}

/// One value far above everything else: a lost decimal point or a stray exponent.
pub(super) fn outliers(points: &[Point], findings: &mut Findings) {
    let series = points.iter().map(|p| p.value.len()).max().unwrap_or(0);
    for k in 0..series {
        let (mut first, mut second, mut at) = (0.0f64, 0.0f64, None);
        for point in points {
            let size = point.value.get(k).copied().flatten().unwrap_or(0.0).abs();
            if size > first {
                (second, first, at) = (first, size, Some(point));
            } else {
                second = second.max(size);
            }
        }
        if let (Some(point), true) = (at, points.len() > 4 && second > 0.0 && first > 1e3 * second) {
            findings.push(
                Finding::warning(
                    "spectrum-outlier",
                    format!("the value {first:e} is more than a thousand times every other"),
                )
                .at(point.line, point.column)
                .raw(&format!("{first:e}"))
                .assumed("as written")
                .fix("check decimal point and exponent"),
            );
        }
    }
}

/// Values below zero: noise where there is little light, and worth a warning where they are large in the middle of the
/// visible.
pub(super) fn negatives(points: &[Point], findings: &mut Findings) {
    const VISIBLE: std::ops::RangeInclusive<f64> = 420.0..=680.0;
    let first = |p: &Point| p.value.first().copied().flatten().unwrap_or(0.0);
    let low = points.iter().min_by(|a, b| first(a).total_cmp(&first(b)));
    let high = points.iter().map(first).fold(0.0, f64::max);
    let count = points.iter().filter(|p| first(p) < 0.0).count();
    if let (Some(low), true) = (low, count > 0) {
        let strong = points.iter().any(|p| VISIBLE.contains(&p.x) && -first(p) > 0.1 * high);
        let message = format!(
            "{count} values are negative, the lowest {} at {} nm",
            short(first(low)),
            low.x
        );
        let finding = if strong {
            Finding::warning("spectrum-negative", message).fix("check the sign, or the dark measurement")
        } else {
            Finding::note("spectrum-negative", message)
        };
        findings.push(finding.at(low.line, low.column).assumed("kept as they are"));
    }
}

/// Data that end inside the visible where there is still light: a cut file, or colour that cannot be right.
pub(super) fn range(points: &[Point], findings: &mut Findings) {
    const VISIBLE: (f64, f64) = (400.0, 700.0);
    let value = |p: &Point| p.value.first().copied().flatten().unwrap_or(0.0);
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return;
    };
    if points.len() < 8 || first.x > 780.0 || last.x < 380.0 {
        return;
    }
    let largest = points.iter().map(value).fold(0.0, f64::max);
    let ends = [
        (first, "begin", first.x > VISIBLE.0 + 5.0),
        (last, "end", last.x < VISIBLE.1 - 5.0),
    ];
    for (end, word, inside) in ends {
        if inside && value(end) > 0.02 * largest {
            findings.push(
                Finding::warning(
                    "spectrum-range",
                    format!(
                        "the data {word} at {} nm with {:.0} % of their highest value",
                        short(end.x),
                        100.0 * value(end) / largest
                    ),
                )
                .at(end.line, end.column)
                .raw(&format!("{}", end.x))
                .assumed("no light beyond: colour and luminous integral count what stands there")
                .fix("check that the file is not cut"),
            );
        }
    }
}

fn short(value: f64) -> String {
    format!("{value:.6}")
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}
