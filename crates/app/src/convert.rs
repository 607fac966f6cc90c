//! `convert`: any photometric or spectral format to any other, by extension.

use camino::Utf8Path;
pub use isolux_formats::ies::Photometry;
pub use isolux_formats::spectral::Interpolation;
use isolux_formats::spectral::{self, SpectrumFile};
use isolux_formats::{Content, Distribution, Finding, Format, Parsed, ReadOptions, Severity, eulumdat, ies, tm33};
pub use isolux_formats::{Edit, Symmetry};

use crate::files::{self, Overwrite};
use crate::inspect::{self, Inspection};
use crate::{Failure, FailureKind};

/// What a person asks of the target.
#[derive(Debug, Clone, Default)]
pub struct Wishes {
    /// How to read the source.
    pub read: ReadOptions,
    /// Edition of the target: `2002`, `2019` for IES; `2018`, `2023` for TM-33.
    pub edition: Option<String>,
    /// File generation type of LM-63-2019; without it the source's own, or undefined.
    pub generation: Option<String>,
    /// Coordinates of an IES file; without it those of the source.
    pub photometry: Option<Photometry>,
    /// Series of a spectrum with several, by name.
    pub series: Option<String>,
    /// Changes of a distribution, in their order.
    pub edits: Vec<Edit>,
    /// Another spacing of a spectrum, nm, and how values between its points are found.
    pub resample: Option<(f64, Interpolation)>,
}

/// Reads `source`, writes `target`; the findings of reading and writing come back, also when nothing was written.
///
/// # Errors
/// Bad input (exit 2) when nothing was written; the findings then stand beside it.
pub fn run(
    source: &Utf8Path,
    target: &Utf8Path,
    wishes: &Wishes,
    overwrite: Overwrite,
) -> (Option<Inspection>, Result<(), Failure>) {
    if let Err(failure) = files::refuse_existing(target, overwrite) {
        return (None, Err(failure));
    }
    let mut all = match inspect::read(source, wishes.read) {
        Ok(parsed) => parsed,
        Err(finding) => {
            let failure = Failure::bad_input(format!("{source}: {}", finding.message));
            return (None, Err(failure));
        }
    };
    if all.len() != 1 {
        let names: Vec<String> = all.iter().filter_map(|parsed| parsed.inner.clone()).collect();
        let failure = Failure::bad_input(format!("{source} holds {} photometries or spectra", all.len()))
            .help(format!("take one of them out first: {}", names.join(", ")));
        return (None, Err(failure));
    }
    let mut only = all.remove(0);
    let written = encode(&mut only, target, wishes);
    let mut inspection = Inspection {
        file: source.to_string(),
        format: only.format,
        kind: only.kind,
        readable: only.document.is_some(),
        findings: only.findings,
        quantities: serde_json::Map::new(),
        content: only.document,
    };
    let result = written
        .map_err(|finding| {
            let failure = Failure::bad_input(format!("{source}: {}", finding.message));
            if !inspection.findings.contains(&finding) {
                inspection.findings.push(finding);
            }
            failure
        })
        .and_then(|(bytes, findings)| {
            inspection.findings.extend(findings);
            files::write(target, &bytes, overwrite)
        })
        .and_then(|()| {
            let errors = inspection
                .findings
                .iter()
                .filter(|finding| finding.severity == Severity::Error)
                .count();
            match errors {
                0 => Ok(()),
                _ => Err(Failure {
                    kind: FailureKind::No,
                    message: format!("{target} was written, but {errors} findings of {source} are errors"),
                    help: Some("mend the source before you trust the result".into()),
                }),
            }
        });
    (Some(inspection), result)
}

type Encoded = (Vec<u8>, Vec<Finding>);

fn encode(parsed: &mut Parsed<Content>, target: &Utf8Path, wishes: &Wishes) -> Result<Encoded, Finding> {
    let unreadable = || {
        let worst = parsed
            .findings
            .iter()
            .find(|finding| finding.severity == Severity::Error)
            .cloned();
        worst.unwrap_or_else(|| Finding::error("file-unreadable", "nothing could be read"))
    };
    let format = target
        .extension()
        .and_then(|extension| Format::of_extension(&extension.to_ascii_lowercase()));
    match &parsed.document {
        None => Err(unreadable()),
        Some(Content::Distribution(_)) if wishes.resample.is_some() || wishes.series.is_some() => Err(Finding::error(
            "convert-option",
            "--series and --step-nm are for spectra; this file holds a distribution",
        )),
        Some(Content::Distribution(distribution)) if wishes.edits.is_empty() => {
            encode_distribution(distribution, format, wishes)
        }
        Some(Content::Distribution(distribution)) => {
            let (edited, mut findings) = distribution.edited(&wishes.edits)?;
            let (bytes, of_writing) = encode_distribution(&edited, format, wishes)?;
            findings.extend(of_writing);
            Ok((bytes, findings))
        }
        Some(Content::Spectrum(_)) if !wishes.edits.is_empty() => Err(Finding::error(
            "convert-option",
            "--set, --scale-flux, --rotate-c, --symmetrize and --resample are for distributions; this file holds a spectrum",
        )),
        Some(Content::Spectrum(_))
            if wishes.edition.is_some() || wishes.generation.is_some() || wishes.photometry.is_some() =>
        {
            Err(Finding::error(
                "convert-option",
                "--edition, --generation and --photometry are for distributions; this file holds a spectrum",
            ))
        }
        Some(Content::Spectrum(spectrum)) => encode_spectrum(spectrum, format, wishes, target),
    }
}

fn unwritable(what: &str, target: &Utf8Path) -> Finding {
    Finding::error("convert-target", format!("{what} cannot be written as {target}"))
        .fix("distributions go to .ldt, .ies, .xml and .json, spectra to .spdx, .spd, .sp, .spectrum, .csv and .json")
}

fn encode_spectrum(
    spectrum: &SpectrumFile,
    format: Option<Format>,
    wishes: &Wishes,
    target: &Utf8Path,
) -> Result<Encoded, Finding> {
    let chosen = match &wishes.series {
        None => None,
        Some(name) => Some(spectrum.with_series(name).ok_or_else(|| {
            let names: Vec<&str> = spectrum.series.iter().map(|series| series.name.as_str()).collect();
            Finding::error("convert-series", format!("there is no whole series “{name}”"))
                .fix(format!("the file has: {}", names.join(", ")))
        })?),
    };
    let chosen = chosen.as_ref().unwrap_or(spectrum);
    let resampled = wishes
        .resample
        .map(|(step_nm, how)| chosen.resampled(step_nm, how))
        .transpose()?;
    let (file, mut findings) = resampled.map_or((None, Vec::new()), |(file, findings)| (Some(file), findings));
    let (bytes, of_writing) = format
        .and_then(|format| spectral::write(file.as_ref().unwrap_or(chosen), format))
        .ok_or_else(|| unwritable("a spectrum", target))?;
    findings.extend(of_writing);
    Ok((bytes, findings))
}

fn encode_distribution(
    distribution: &Distribution,
    format: Option<Format>,
    wishes: &Wishes,
) -> Result<Encoded, Finding> {
    if wishes.photometry.is_some() && format != Some(Format::Ies) {
        let message = "only IES files have photometry of types A and B";
        return Err(Finding::error("convert-option", message).fix("write an .ies, or leave --photometry out"));
    }
    if wishes.generation.is_some() && format != Some(Format::Ies) {
        let message = "--generation: only IES files have a file generation type";
        return Err(Finding::error("convert-option", message).fix("write an .ies, or leave --generation out"));
    }
    if wishes.edition.is_some() && !matches!(format, Some(Format::Ies | Format::Tm33)) {
        let message = "--edition: only IES and TM-33 files have editions";
        return Err(Finding::error("convert-option", message).fix("write an .ies or .xml, or leave --edition out"));
    }
    match format {
        Some(Format::Json) => {
            let mut text = serde_json::to_vec(&distribution.to_json())
                .map_err(|error| Finding::error("convert-json", error.to_string()))?;
            text.push(b'\n');
            Ok((text, Vec::new()))
        }
        Some(Format::Eulumdat) => {
            let written = match &distribution.eulumdat {
                Some(document) if wishes.edits.is_empty() => eulumdat::rewrite(document, &distribution.intensity),
                Some(document) => eulumdat::write(&distribution.intensity, &document.header)?,
                None => eulumdat::write(&distribution.intensity, &distribution.eulumdat_header())?,
            };
            Ok((
                written.bytes,
                with_losses(written.findings, distribution, Format::Eulumdat, ies::Edition::E2002),
            ))
        }
        Some(Format::Ies) => {
            let edition = match wishes.edition.as_deref() {
                None | Some("2002") => ies::Edition::E2002,
                Some("2019") => ies::Edition::E2019,
                Some(other) => {
                    return Err(Finding::error(
                        "convert-edition",
                        format!("LM-63 is written in editions 2002 and 2019, not {other}"),
                    ));
                }
            };
            let mut facts = distribution.ies_facts();
            if let Some(asked) = &wishes.generation {
                facts.generation = Some(generation(asked, edition)?);
            }
            let written = ies::write_as(distribution, &facts, edition, wishes.photometry);
            Ok((
                written.bytes,
                with_losses(written.findings, distribution, Format::Ies, edition),
            ))
        }
        Some(Format::Tm33) => {
            let edition = match wishes.edition.as_deref() {
                None | Some("2018") => tm33::Edition::E2018,
                Some("2023") => tm33::Edition::E2023,
                Some(other) => {
                    let message = format!("TM-33 is written in editions 2018 and 2023, not {other}");
                    return Err(Finding::error("convert-edition", message));
                }
            };
            let written = tm33::write(distribution, edition);
            Ok((
                written.bytes,
                with_losses(written.findings, distribution, Format::Tm33, ies::Edition::E2002),
            ))
        }
        _ => Err(unwritable("a distribution", Utf8Path::new("this file"))),
    }
}

/// A file generation type of LM-63-2019, as a person asks for it.
fn generation(asked: &str, edition: ies::Edition) -> Result<String, Finding> {
    if edition < ies::Edition::E2019 {
        let message = "file generation types belong to LM-63-2019";
        return Err(Finding::error("convert-generation", message).fix("add --edition 2019"));
    }
    let known = ies::GENERATION_TYPES.iter().find(|(code, _)| *code == asked);
    known.map(|&(code, _)| code.to_owned()).ok_or_else(|| {
        let all: Vec<String> = ies::GENERATION_TYPES
            .iter()
            .map(|(code, meaning)| format!("{code} ({meaning})"))
            .collect();
        Finding::error("convert-generation", format!("{asked} is no file generation type"))
            .fix(format!("one of {}", all.join(", ")))
    })
}

/// The findings of a writer, and what of the source's header its format (LM-63: of that edition) has no field for.
fn with_losses(
    mut findings: Vec<Finding>,
    distribution: &Distribution,
    target: Format,
    edition: ies::Edition,
) -> Vec<Finding> {
    let lost = distribution.without_field(target, edition);
    if !lost.is_empty() {
        findings.push(Finding::note(
            "convert-header",
            format!("this format has no field for: {}", lost.join(", ")),
        ));
    }
    findings
}
