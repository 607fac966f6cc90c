//! `convert`: any photometric or spectral format to any other, by extension.

use camino::Utf8Path;
pub use isolux_formats::ies::Photometry;
pub use isolux_formats::spectral::Interpolation;
use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{
    Content, Distribution, Finding, Format, ReadOptions, Severity, WriteOptions, Written, write_distribution,
    write_spectrum,
};
pub use isolux_formats::{Edit, Symmetry};

use crate::files::{self, Overwrite};
use crate::formats::inspect::{self, Inspection, Quantities};
use crate::{Failure, FailureKind};

/// What a person asks of the target.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How to read the source.
    pub read: ReadOptions,
    /// What the target's format leaves open.
    pub write: WriteOptions,
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
    requested: &Options,
    overwrite: Overwrite,
) -> (Option<Inspection>, Result<(), Failure>) {
    if let Err(failure) = files::refuse_existing(target, overwrite) {
        return (None, Err(failure));
    }
    let mut all = match inspect::read(source, requested.read) {
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
    let only = all.remove(0);
    let written = match &only.document {
        None => Err(unreadable(&only.findings)),
        Some(content) => encode(content, target, requested),
    };
    let mut inspection = Inspection {
        file: source.to_string(),
        format: only.format,
        kind: only.kind,
        readable: only.document.is_some(),
        findings: only.findings,
        quantities: Quantities::None {},
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
        .and_then(|written| {
            inspection.findings.extend(written.findings);
            files::write(target, &written.bytes, overwrite)
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
                    help: Some("correct the source before you trust the result".into()),
                }),
            }
        });
    (Some(inspection), result)
}

/// Writes `content` to `target`, with the changes of `requested`; the findings of writing come back.
///
/// # Errors
/// Bad input (exit 2) for a target that exists or a format that cannot hold the content; nothing is written then.
pub fn write(
    content: &Content,
    target: &Utf8Path,
    requested: &Options,
    overwrite: Overwrite,
) -> Result<Vec<Finding>, Failure> {
    files::refuse_existing(target, overwrite)?;
    let written = encode(content, target, requested)
        .map_err(|finding| Failure::bad_input(format!("{target}: {}", finding.message)))?;
    files::write(target, &written.bytes, overwrite)?;
    Ok(written.findings)
}

fn unreadable(findings: &[Finding]) -> Finding {
    let worst = findings.iter().find(|finding| finding.severity == Severity::Error);
    worst.map_or_else(
        || Finding::error("file-unreadable", "nothing could be read"),
        Clone::clone,
    )
}

fn encode(content: &Content, target: &Utf8Path, requested: &Options) -> Result<Written, Finding> {
    let format = target
        .extension()
        .and_then(|extension| Format::of_extension(&extension.to_ascii_lowercase()));
    match content {
        Content::Distribution(_) if requested.resample.is_some() || requested.series.is_some() => Err(Finding::error(
            "convert-option",
            "--series and --step-nm are for spectra; this file holds a distribution",
        )),
        Content::Distribution(distribution) if requested.edits.is_empty() => {
            encode_distribution(distribution, format, requested)
        }
        Content::Distribution(distribution) => {
            let (edited, mut findings) = distribution.edited(&requested.edits)?;
            let written = encode_distribution(&edited, format, requested)?;
            findings.extend(written.findings);
            Ok(Written {
                bytes: written.bytes,
                findings,
            })
        }
        Content::Spectrum(_) if !requested.edits.is_empty() => Err(Finding::error(
            "convert-option",
            "--set, --scale-flux, --rotate-c, --symmetrize and --resample are for distributions; this file holds a spectrum",
        )),
        Content::Spectrum(_)
            if requested.write.edition.is_some()
                || requested.write.generation.is_some()
                || requested.write.photometry.is_some() =>
        {
            Err(Finding::error(
                "convert-option",
                "--edition, --generation and --photometry are for distributions; this file holds a spectrum",
            ))
        }
        Content::Spectrum(spectrum) => encode_spectrum(spectrum, format, requested, target),
    }
}

/// What files can be written, for people.
pub fn targets() -> String {
    let (distributions, spectra) = (
        isolux_formats::distribution_targets(),
        isolux_formats::spectrum_targets(),
    );
    format!("{distributions} for a distribution, {spectra} for a spectrum")
}

fn unwritable(what: &str, target: &Utf8Path) -> Finding {
    Finding::error("convert-target", format!("{what} cannot be written as {target}")).fix(targets())
}

fn encode_spectrum(
    spectrum: &SpectrumFile,
    format: Option<Format>,
    requested: &Options,
    target: &Utf8Path,
) -> Result<Written, Finding> {
    let chosen = match &requested.series {
        None => None,
        Some(name) => Some(spectrum.with_series(name).ok_or_else(|| {
            let names: Vec<&str> = spectrum.series.iter().map(|series| series.name.as_str()).collect();
            Finding::error("convert-series", format!("there is no whole series “{name}”"))
                .fix(format!("the file has: {}", names.join(", ")))
        })?),
    };
    let chosen = chosen.as_ref().unwrap_or(spectrum);
    let resampled = requested
        .resample
        .map(|(step_nm, how)| chosen.resampled(step_nm, how))
        .transpose()?;
    let (file, mut findings) = resampled.map_or((None, Vec::new()), |(file, findings)| (Some(file), findings));
    let written = format
        .and_then(|format| write_spectrum(file.as_ref().unwrap_or(chosen), format))
        .ok_or_else(|| unwritable("a spectrum", target))?;
    findings.extend(written.findings);
    Ok(Written {
        bytes: written.bytes,
        findings,
    })
}

fn encode_distribution(
    distribution: &Distribution,
    format: Option<Format>,
    requested: &Options,
) -> Result<Written, Finding> {
    let options = WriteOptions {
        edited: !requested.edits.is_empty(),
        ..requested.write.clone()
    };
    format
        .and_then(|format| write_distribution(distribution, format, &options))
        .unwrap_or_else(|| Err(unwritable("a distribution", Utf8Path::new("this file"))))
}
