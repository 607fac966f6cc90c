//! Header numbers of EULUMDAT that cannot be meant: symmetry that is claimed and absent, counts of lamps, negative
//! sizes and powers, and a light output ratio that no light has.

use isolux_photometry::IntensityDistribution;

use super::document::{Document, Header};
use super::fields::{self, Value};
use super::layout::HEADER;
use crate::finding::{Finding, Findings};
use crate::text::Text;

/// More lamps than this are another number.
const MOST_LAMPS: f64 = 1000.0;
/// Planes of a rotationally symmetric luminaire scatter. Of 30 files by many hands that claim one 23 store one plane;
/// in seven, made from templates of other luminaires, planes are 0.10 of the peak apart or more.
const SAME: f64 = 0.05;

/// Says which numbers of the header cannot be meant.
pub(super) fn check(document: &Document, intensity: &IntensityDistribution, text: &Text<'_>, findings: &mut Findings) {
    let header = &document.header;
    let mut warn = |line: usize, code: &'static str, message: String, fix: &str| {
        let raw = text.line(line);
        let column = raw.chars().take_while(|c| c.is_whitespace()).count() + 1;
        let finding = Finding::warning(code, message).at(line + 1, column).raw(raw.trim());
        findings.push(finding.assumed("as it stands").fix(fix));
    };
    if let Some(stated) = header.type_indicator {
        if ![0.0, 1.0, 2.0, 3.0].contains(&stated) {
            let fix = "write 1 (rotationally symmetric), 2 (linear) or 3 (any other)";
            warn(
                1,
                "ldt-type-indicator",
                format!("{stated} is no type of light source"),
                fix,
            );
        }
        let spread = spread(document);
        if stated == 1.0 && spread > SAME {
            let percent = 100.0 * spread;
            let message =
                format!("type 1 claims the same light in all planes; they differ by {percent:.0} % of the peak");
            let fix = "write 2 (linear) or 3 (any other symmetry), or look for damage in the intensities";
            warn(1, "ldt-type-indicator", message, fix);
        }
    }
    if document.c_deg.len() == 1 && document.isym != 1 {
        let message = format!("one C plane is rotational symmetry, which is 1, not {}", document.isym);
        warn(
            2,
            "ldt-isym-one-plane",
            message,
            "write 1, or compare lines 3 to 5 with the source",
        );
    }
    for (line, size) in sizes(header).filter(|&(_, size)| size < 0.0) {
        warn(
            line,
            "ldt-size",
            format!("a size of {size} mm is below zero"),
            "correct the size",
        );
    }
    if let Some(lorl) = header.lorl_percent
        && lorl <= 0.0
        && !header.fractions_unstated()
        && intensity.flux_lm() > 0.0
    {
        let message = format!("the light output ratio is {lorl} %, though there is light");
        warn(
            22,
            "flux-lorl",
            message,
            "write the ratio in %, or leave the line blank",
        );
    }
    if let Some(tilt) = header.tilt_deg.filter(|&tilt| tilt != 0.0) {
        let message = format!("the luminaire was tilted by {tilt}° as it was measured; the light is not turned back");
        warn(
            24,
            "ldt-tilt",
            message,
            "turn the luminaire where it is used, or write 0",
        );
    }
    for (index, set) in header.lamp_sets.iter().enumerate() {
        let first = HEADER + 6 * index;
        if let Some(count) = set.count
            && (count.fract() != 0.0 || count.abs() > MOST_LAMPS)
        {
            let fix = "write a whole number, or its negative for absolute photometry";
            warn(
                first,
                "ldt-lamp-count",
                format!("{} is no number of lamps", count.abs()),
                fix,
            );
        }
        if let Some(watts) = set.watts.filter(|&watts| watts < 0.0) {
            let message = format!("a power of {watts} W is below zero");
            warn(first + 5, "ldt-power", message, "write the power with gear in W");
        }
    }
    if header.fractions_unstated() && intensity.flux_lm() > 0.0 {
        let message = "light output ratio and downward flux fraction are zero, though there is light";
        findings.push(Finding::note("ldt-unstated", message).at(22, 1).assumed("not stated"));
    }
}

/// How far planes differ in a direction at most, as a part of the peak.
fn spread(document: &Document) -> f64 {
    let ng = document.gamma_deg.len();
    let values = &document.intensity_cd_klm;
    let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let of_angle = |angle: usize| {
        let plane = || values.iter().skip(angle).step_by(ng);
        let (high, low) = (
            plane().fold(f64::NEG_INFINITY, |a, &b| a.max(b)),
            plane().fold(f64::INFINITY, |a, &b| a.min(b)),
        );
        high - low
    };
    (0..ng).map(of_angle).fold(0.0, f64::max) / peak.max(f64::MIN_POSITIVE)
}

/// Lines (zero-based) and sizes of the luminaire and its luminous area that are stated, in mm.
fn sizes(header: &Header) -> impl Iterator<Item = (usize, f64)> {
    let mut header = header.clone();
    let sizes = fields::HEADER.iter().filter(|field| field.key.ends_with("_mm"));
    sizes.filter_map(move |field| match field.value {
        Value::Number(_, _, place, _) => Some((field.line, (*place(&mut header))?)),
        Value::Text(..) => None,
    })
}
