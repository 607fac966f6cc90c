//! Physical plausibility of what was read: damage that is still a number shows here.

mod outliers;

use isolux_photometry::IntensityDistribution;

use crate::finding::{Finding, Findings, Severity};

/// Intensities as they stand in a file.
#[derive(Clone, Copy)]
pub(crate) struct Stored<'s> {
    /// C or horizontal angles of the planes, one a plane.
    pub planes_deg: &'s [f64],
    /// γ or vertical angles.
    pub angles_deg: &'s [f64],
    /// Plane after plane, one value an angle, as written.
    pub values: &'s [f64],
    /// One-based line and column of each value.
    pub places: &'s [(usize, usize)],
    /// The text of each value.
    pub raw: &'s dyn Fn(usize) -> &'s str,
    /// Angles 0° and 180° are one direction for all planes.
    pub poles: bool,
}

/// Checks the numbers against each other.
pub(crate) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    negative(stored, findings);
    poles(stored, findings);
    outliers::check(stored, findings);
}

fn at(stored: &Stored<'_>, index: usize, finding: Finding) -> Finding {
    let (line, column) = stored.places.get(index).copied().unwrap_or((1, 1));
    finding.at(line, column).raw((stored.raw)(index))
}

/// Light below zero, as one finding: how many values there are and the lowest of them.
fn negative(stored: &Stored<'_>, findings: &mut Findings) {
    let below: Vec<usize> = (0..stored.values.len())
        .filter(|&index| stored.values[index] < 0.0)
        .collect();
    let lowest = below
        .iter()
        .copied()
        .min_by(|&a, &b| stored.values[a].total_cmp(&stored.values[b]));
    let Some(lowest) = lowest else { return };
    let message = match below.len() {
        1 => "the intensity is below zero".to_owned(),
        count => format!("{count} intensities are below zero; this is the lowest"),
    };
    let finding = Finding::warning("intensity-negative", message).assumed("as they stand");
    findings.push(at(stored, lowest, finding).fix("light cannot be negative; check the dark correction"));
}

/// At γ = 0 and 180 all planes meet in one direction.
fn poles(stored: &Stored<'_>, findings: &mut Findings) {
    let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
    let peak = stored.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    for (column, angle) in [(0, 0.0), (ng.saturating_sub(1), 180.0)] {
        if !stored.poles || planes < 2 || stored.angles_deg.get(column) != Some(&angle) {
            continue;
        }
        let value = |plane: usize| stored.values[plane * ng + column];
        let mut sorted: Vec<f64> = (0..planes).map(value).collect();
        sorted.sort_by(f64::total_cmp);
        let (least, median, most) = (sorted[0], sorted[planes / 2], sorted[planes - 1]);
        // Planes measured one after the other scatter by a few per cent.
        if most - least <= 0.05 * median.abs().max(0.01 * peak) {
            continue;
        }
        let away = |plane: usize| (value(plane) - median).abs();
        let worst = (0..planes).max_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap_or(0);
        let message = format!(
            "at γ = {angle}° all planes meet in one direction, yet their intensities go from {least} to {most}"
        );
        let finding = Finding::warning("intensity-pole", message).assumed("each plane as it stands");
        findings
            .push(at(stored, worst * ng + column, finding).fix("compare this value with those of the other planes"));
    }
}

/// The planes at 0° and 360° are one: the first value of the last plane that differs. The readers say it, each in its
/// way.
pub(crate) fn closing(stored: &Stored<'_>, values: &[f64]) -> Option<usize> {
    let (planes, ng) = (stored.planes_deg, stored.angles_deg.len());
    let closes = stored.poles && planes.len() > 1 && (planes[planes.len() - 1] - planes[0] - 360.0).abs() < 1e-6;
    let last = (planes.len() * ng).checked_sub(ng).filter(|_| closes)?;
    (0..ng).find(|&at| values[last + at] != values[at]).map(|at| last + at)
}

/// Two measurements of the plane at 0° and 360° scatter: so far, as a part of the peak, that is a note where most
/// values of the two differ. One value that alone differs is no scatter.
const SCATTER: f64 = 0.01;

/// How much it weighs that the plane at 360° is not the one at 0°.
pub(crate) fn closing_severity(opening: &[f64], closing: &[f64], peak: f64) -> Severity {
    let apart = || opening.iter().zip(closing).map(|(a, b)| (a - b).abs());
    let different = apart().filter(|&apart| apart > 0.0).count();
    if 3 * different > opening.len() && apart().fold(0.0, f64::max) <= SCATTER * peak {
        Severity::Note
    } else {
        Severity::Warning
    }
}

/// Programs integrate by different rules; of 76 files by many hands whose ratio means their light, 73 are within 1 %
/// and none is between 1 % and 2 %.
const FLUX_APART: f64 = 0.015;

/// No luminaire loses more than all but this part of its lamps' light; a factor of ten or more is one that was misread
/// or left out.
const DIMMEST: f64 = 0.1;

/// The integral over the sphere against the flux that the file states. `lamp_at`: one-based line and column where that
/// stands; `lorl_percent`: light output ratio as stated, and its line.
pub(crate) fn flux(
    grid: &IntensityDistribution,
    lamp_flux_lm: Option<f64>,
    lamp_at: Option<(usize, usize)>,
    lorl_percent: Option<(f64, usize)>,
    findings: &mut Findings,
) {
    let Some(lamp) = lamp_flux_lm else { return };
    let integral = grid.flux_lm();
    if let Some((lorl, line)) = lorl_percent {
        let stated = lamp * lorl / 100.0;
        if lorl > 0.0 && (integral - stated).abs() > FLUX_APART * stated {
            let message = format!(
                "the intensities integrate to {integral:.1} lm, which is {:.1} % of the lamps' flux; stated is {lorl} %",
                100.0 * integral / lamp
            );
            let finding = Finding::warning("flux-lorl", message)
                .at(line, 1)
                .assumed("the intensities");
            findings.push(finding.fix("correct the light output ratio, or look for damage in the intensities"));
            return;
        }
    }
    let (code, what) = if integral > 1.1 * lamp {
        ("flux-above-lamp", "more than")
    } else if integral < DIMMEST * lamp {
        ("flux-below-lamp", "hardly any of")
    } else {
        return;
    };
    let message = format!("the intensities integrate to {integral:.4} lm, {what} the lamps' {lamp:.1} lm");
    let finding = Finding::warning(code, message)
        .assumed("the intensities")
        .fix("check lamp flux, number of lamps and multiplier");
    findings.push(match lamp_at {
        Some((line, column)) => finding.at(line, column),
        None => finding,
    });
}
