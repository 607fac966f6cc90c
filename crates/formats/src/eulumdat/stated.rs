//! What a file states of its light beside the light output ratio, against the integral.

use isolux_photometry::IntensityDistribution;

use super::document::{Header, ROOM_INDICES};
use super::layout::HEADER;
use crate::finding::{Finding, Findings, Severity};
use crate::quantities::utilisation::rough_direct_ratios;

/// Downward flux fraction in percentage points: of 85 files by many hands whose value means their light, none is
/// farther off than 0.5.
const DFF_APART: f64 = 1.0;
/// Direct ratios, for a note and for a warning. Of 25 files by many hands 17 are within 0.045 of the integral; two of
/// narrow beams are 0.10 and 0.12 off, which another spacing of the luminaires explains; six are 0.15 to 0.7 off:
/// values of another luminaire, left over from a template.
const RATIO_APART: (f64, f64) = (0.07, 0.15);
/// Direct ratios that programs computed by coarse zones fall by so much, here and there, where they should rise.
const DIP: f64 = 0.002;

/// Downward flux fraction and direct ratios against the integral. `contradicted`: the light output ratio is that of
/// other light; what was computed from that light then says so once more, as a note.
pub(super) fn stated_ratios(
    header: &Header,
    intensity: &IntensityDistribution,
    line_of: &impl Fn(usize) -> usize,
    contradicted: bool,
    findings: &mut Findings,
) {
    let (down, all) = (intensity.flux_between(0.0, 90.0).value(), intensity.flux().value());
    if header.fractions_unstated() && all > 0.0 {
        let message = "light output ratio and downward flux fraction are zero, though there is light";
        findings.push(
            Finding::note("ldt-unstated", message)
                .at(line_of(21) + 1, 1)
                .assumed("not stated"),
        );
    } else if let Some(stated) = header.dff_percent
        && all > 0.0
        && (stated - 100.0 * down / all).abs() > DFF_APART
    {
        let message = format!(
            "{:.1} % of the integral goes down; stated is {stated} %",
            100.0 * down / all
        );
        let severity = if contradicted {
            Severity::Note
        } else {
            Severity::Warning
        };
        findings.push(
            Finding::new(severity, "flux-dff", message)
                .at(line_of(21) + 1, 1)
                .assumed("the intensities")
                .fix("correct the downward flux fraction, or look for damage in the intensities"),
        );
    }
    let stated = header.direct_ratios;
    let first = line_of(HEADER + 6 * header.lamp_sets.len() - 1) + 1;
    // Zeros stand for blanks.
    if stated.iter().flatten().all(|&ratio| ratio == 0.0) {
        return;
    }
    let say = |at: usize, message: &str| {
        Finding::warning("ldt-direct-ratios", message)
            .at(first + at + 1, 1)
            .raw(&stated[at].unwrap_or(0.0).to_string())
            .assumed("as they stand")
            .fix("compare the ratios with the source; two may be swapped")
    };
    // A share of the flux; programs round up.
    let share = |ratio: Option<f64>| ratio.is_none_or(|ratio| (0.0..=1.05).contains(&ratio));
    if let Some(at) = (0..10).find(|&at| !share(stated[at])) {
        findings.push(say(at, "a direct ratio is a share of the flux, from 0 to 1"));
        return;
    }
    let falls = |a: usize, b: usize| stated[a].zip(stated[b]).is_some_and(|(a, b)| b < a - DIP);
    if let Some(at) = (1..10).find(|&at| falls(at - 1, at)) {
        // Without the one before they go on rising: that one is too large.
        let odd = if at > 1 && !falls(at - 2, at) { at - 1 } else { at };
        findings.push(say(odd, "the direct ratios do not rise with the room index"));
        return;
    }
    let Some(computed) = rough_direct_ratios(intensity) else {
        return;
    };
    let apart = |at: usize| stated[at].map_or(0.0, |ratio| (ratio - computed[at]).abs());
    let worst = (0..10).max_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap_or(0);
    if apart(worst) > RATIO_APART.0 {
        let (far, limit) = (apart(worst) > RATIO_APART.1, RATIO_APART);
        let message = format!(
            "the direct ratio for k = {} is {}, the intensities give {:.3} (note from {} apart, warning from {})",
            ROOM_INDICES[worst],
            stated[worst].unwrap_or(0.0),
            computed[worst],
            limit.0,
            limit.1
        );
        let (severity, fix) = if far {
            (
                if contradicted {
                    Severity::Note
                } else {
                    Severity::Warning
                },
                "leave the ten ratios blank to have them computed, or look for damage in the intensities",
            )
        } else {
            (Severity::Note, "another spacing of the luminaires may explain it")
        };
        findings.push(
            Finding::new(severity, "ldt-direct-ratios", message)
                .at(first + worst + 1, 1)
                .assumed("as they stand")
                .fix(fix),
        );
    }
}
