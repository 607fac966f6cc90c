//! From the document to absolute candela over the full circle.

use serde_json::Value;

use super::document::{Document, Header, LampSet, symmetry};
use super::fields::{self, share};
use super::layout::HEADER;
use super::{expand, header};
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::luminaire::Luminaire;
use crate::number;
use crate::options::ReadOptions;
use crate::plausible::{self, Stored};
use crate::text::Text;

/// More points than this on the full circle, and than this many for each one that is stored, are refused: a rotational
/// file of a few kilobytes may claim any number.
const LARGEST_GRID: (usize, usize) = (1_000_000, 8);

/// Index of the line of the first set's flux (26c) and of the conversion factor (24).
const FLUX_LINE: usize = HEADER + 2;
/// See [`FLUX_LINE`].
const FACTOR_LINE: usize = 23;

/// One-based line and column of every intensity.
pub(super) type Places = Vec<(usize, usize)>;

pub(super) fn distribution(
    document: Document,
    places: &Places,
    text: &Text<'_>,
    options: ReadOptions,
    findings: &mut Findings,
) -> Option<Distribution> {
    let header = &document.header;
    let set = header.lamp_sets.first()?;
    let flux_lm = lamp_flux_lm(set, text, findings)?;
    let conversion = conversion_factor(header, text, findings)?;
    if let Some(finding) = too_many_directions(&document) {
        findings.push(finding);
        return None;
    }
    sets(header, findings);
    if document.isym == 3 {
        order_of_class_three(&document, options, findings);
    }
    let factor = conversion * flux_lm / 1000.0;
    let intensity = match expand::expand(&document, factor, options.isym3_c90_first) {
        Ok(intensity) => intensity,
        Err(error) => {
            findings.push(Finding::error("ldt-angles", error.to_string()).fix("correct the angles of C or γ"));
            return None;
        }
    };
    check_as_written(&document, places, text, options, findings);
    plausible::flux(
        &intensity,
        Some(flux_lm),
        Some((FLUX_LINE + 1, 1)),
        header.lorl_percent.map(|lorl| (lorl, 23)),
        findings,
    );
    header::check(&document, &intensity, text, findings);
    let mut json = document.header_json();
    json.insert("encoding".into(), Value::from(text.encoding));
    json.insert("line_ending".into(), Value::from(text.line_ending));
    Some(Distribution {
        intensity,
        symmetry: symmetry(document.isym),
        lamp_flux_lm: Some(flux_lm),
        absolute: set.count.is_some_and(|count| count < 0.0),
        native: None,
        luminaire: luminaire(header),
        header: json,
        eulumdat: (!options.isym3_c90_first).then(|| Box::new(document)),
    })
}

/// What cd/klm is relative to.
fn lamp_flux_lm(set: &LampSet, text: &Text<'_>, findings: &mut Findings) -> Option<f64> {
    let message = match set.flux_lm {
        Some(flux) if flux > 0.0 => return Some(flux),
        Some(_) => "the lamp flux is not above zero",
        None => "no lamp flux is stated",
    };
    findings.push(
        Finding::error("ldt-lamp-flux", format!("{message}; cd/klm cannot become candela"))
            .at(FLUX_LINE + 1, 1)
            .raw(text.line(FLUX_LINE))
            .fix("write the flux of the lamps in lm into line 26c"),
    );
    None
}

/// What every intensity is multiplied by.
fn conversion_factor(header: &Header, text: &Text<'_>, findings: &mut Findings) -> Option<f64> {
    let raw = text.line(FACTOR_LINE);
    let (factor, finding) = match header.conversion_factor {
        Some(1.0) => return Some(1.0),
        Some(factor) if factor > 0.0 => {
            let message = format!("the intensities are multiplied by the conversion factor {factor}");
            let finding = Finding::warning("ldt-conversion-factor", message);
            (Some(factor), finding.raw(raw).assumed("a factor on every intensity"))
        }
        Some(_) => {
            let finding = Finding::error("ldt-conversion-factor", "the conversion factor is not above zero");
            let fix = "write 1 unless every intensity is to be multiplied";
            (None, finding.raw(raw).fix(fix))
        }
        None if number::is_blank(raw) => {
            let finding = Finding::warning("ldt-conversion-factor", "the conversion factor is blank");
            (Some(1.0), finding.assumed("1").fix("write 1"))
        }
        None => return None,
    };
    findings.push(finding.at(FACTOR_LINE + 1, 1));
    factor
}

fn too_many_directions(document: &Document) -> Option<Finding> {
    let most = LARGEST_GRID.0.max(LARGEST_GRID.1 * document.intensity_cd_klm.len());
    let (planes, angles) = (document.c_deg.len(), document.gamma_deg.len());
    (planes.saturating_mul(angles) > most).then(|| {
        let message = format!("{planes} × {angles} directions are more than a file can mean");
        Finding::error("ldt-grid-too-large", message)
            .at(4, 1)
            .fix("check lines 4 and 6")
    })
}

/// The intensities as they stand in the file: what cannot be, and planes that are one and differ.
fn check_as_written(
    document: &Document,
    places: &Places,
    text: &Text<'_>,
    options: ReadOptions,
    findings: &mut Findings,
) {
    let (values, ng) = (&document.intensity_cd_klm, document.gamma_deg.len());
    let stored = expand::stored_c_deg(
        document.isym,
        &document.c_deg,
        values.len() / ng,
        options.isym3_c90_first,
    );
    let raw = |index: usize| places.get(index).map_or("", |&(line, _)| text.line(line - 1).trim());
    let written = Stored {
        planes_deg: &stored,
        angles_deg: &document.gamma_deg,
        values,
        places,
        raw: &raw,
        poles: true,
    };
    plausible::check(&written, findings);
    let closing = plausible::closing(&written, values).and_then(|index| Some((index, *places.get(index)?)));
    if let Some((index, (line, column))) = closing {
        let peak = values.iter().fold(0.0, |most: f64, &value| most.max(value));
        let severity = plausible::closing_severity(&values[..ng], &values[values.len() - ng..], peak);
        findings.push(
            Finding::new(
                severity,
                "ldt-closing-plane",
                "the planes at C0 and C360 are one plane, yet they differ",
            )
            .at(line, column)
            .raw(raw(index))
            .assumed("the plane at C0")
            .fix("compare both planes with the source"),
        );
    }
}

fn sets(header: &Header, findings: &mut Findings) {
    if header.lamp_sets.len() > 1 {
        let message = format!("{} sets of lamps are listed", header.lamp_sets.len());
        findings.push(
            Finding::note("ldt-lamp-sets", message)
                .at(26, 1)
                .assumed("candela with the flux of the first set"),
        );
    }
    if header.lamp_sets.first().is_some_and(|set| set.count == Some(0.0)) {
        findings.push(
            Finding::warning("ldt-lamp-count", "the number of lamps is 0")
                .at(HEADER + 1, 1)
                .raw("0")
                .assumed("relative photometry; line 26c is the flux of all lamps together")
                .fix("write the number of lamps, or −1 for absolute photometry"),
        );
    }
}

/// The order matters where the planes are not the same forwards and backwards.
fn order_of_class_three(document: &Document, options: ReadOptions, findings: &mut Findings) {
    let ng = document.gamma_deg.len();
    let planes: Vec<&[f64]> = document.intensity_cd_klm.chunks(ng).collect();
    if planes.iter().zip(planes.iter().rev()).all(|(a, b)| a == b) {
        return;
    }
    let (order, other) = if options.isym3_c90_first {
        (
            "C90 through C180 to C270, as asked for",
            "leave the option out to read C270 first",
        )
    } else {
        (
            "C270 through C0 to C90, as the format has it",
            "if the light falls to the wrong side, read it with --isym3 c90-first",
        )
    };
    findings.push(
        Finding::note(
            "ldt-isym3-order",
            "symmetry 3: some programs store C90 first, and the file cannot say which",
        )
        .at(3, 1)
        .raw("3")
        .assumed(order)
        .fix(other),
    );
}

fn luminaire(header: &Header) -> Luminaire {
    let (mut header, mut luminaire) = (header.clone(), Luminaire::default());
    share(fields::HEADER, &mut header, &mut luminaire, true);
    if let Some(set) = header.lamp_sets.first_mut() {
        share(fields::SET, set, &mut luminaire, true);
        luminaire.lamp_count = set.count.map(f64::abs);
    }
    luminaire
}
