//! What line 2 claims of the light, against the light.

use super::document::Document;
use crate::finding::{Finding, Findings};

/// Planes of a rotationally symmetric luminaire scatter. Of 30 files by many hands that claim one 23 store one plane;
/// in seven, made from templates of other luminaires, planes are 0.10 of the peak apart or more.
const SAME: f64 = 0.05;

/// Line 2: 1 means that the light is the same in all planes. `line` is one-based.
pub(super) fn type_indicator(document: &Document, line: usize, findings: &mut Findings) {
    let Some(stated) = document.header.type_indicator else {
        return;
    };
    let say = |message: String| {
        Finding::warning("ldt-type-indicator", message)
            .at(line, 1)
            .raw(&stated.to_string())
    };
    if ![0.0, 1.0, 2.0, 3.0].contains(&stated) {
        let finding =
            say(format!("{stated} is no type of light source")).assumed("nothing: only symmetry (line 3) counts");
        findings.push(finding.fix("write 1 (rotationally symmetric), 2 (linear) or 3 (any other)"));
        return;
    }
    let ng = document.gamma_deg.len();
    let values = &document.intensity_cd_klm;
    let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let spread = (0..ng)
        .map(|angle| {
            let plane = values.iter().skip(angle).step_by(ng);
            let (low, high) = plane.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
                (low.min(value), high.max(value))
            });
            high - low
        })
        .fold(0.0, f64::max);
    if stated == 1.0 && spread > SAME * peak {
        let message = format!(
            "type 1 claims the same light in all planes; they differ by {:.0} % of the peak",
            100.0 * spread / peak
        );
        let finding = say(message).assumed("the planes as they stand");
        findings.push(finding.fix("write 2 (linear) or 3 (any other symmetry), or look for damage in the intensities"));
    }
}
