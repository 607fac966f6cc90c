//! A distribution as a file of each format that holds one: what a person may decide, and what is lost.

use crate::distribution::Distribution;
use crate::finding::Finding;
use crate::parsed::{Format, Written};
use crate::{eulumdat as ldt, ies, tm33 as atla};

/// What a person may decide of a file that is written.
#[derive(Debug, Clone, Default)]
pub struct WriteOptions {
    /// Edition: `2002`, `2019` for IES; `2018`, `2023` for TM-33.
    pub edition: Option<String>,
    /// File generation type of LM-63-2019; without it the source's own, or undefined.
    pub generation: Option<String>,
    /// Coordinates of an IES file; without it those of the source.
    pub photometry: Option<ies::Photometry>,
    /// The light is no longer that of the file which was read.
    pub edited: bool,
}

impl WriteOptions {
    /// Decisions that the format does not know are no mistake to be passed over.
    fn only_for(&self, format: Format) -> Result<(), Finding> {
        let (lm63, editions) = (format == Format::Ies, matches!(format, Format::Ies | Format::Tm33));
        let asked = [
            (
                self.photometry.is_some() && !lm63,
                "only IES files have photometry of types A and B",
                "write an .ies, or leave --photometry out",
            ),
            (
                self.generation.is_some() && !lm63,
                "--generation: only IES files have a file generation type",
                "write an .ies, or leave --generation out",
            ),
            (
                self.edition.is_some() && !editions,
                "--edition: only IES and TM-33 files have editions",
                "write an .ies or .xml, or leave --edition out",
            ),
        ];
        match asked.into_iter().find(|(wrong, ..)| *wrong) {
            Some((_, message, fix)) => Err(Finding::error("convert-option", message).fix(fix)),
            None => Ok(()),
        }
    }
}

/// The document `isolux-distribution/1`.
pub(crate) fn json(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::Json)?;
    let mut bytes = serde_json::to_vec(&distribution.to_json())
        .map_err(|error| Finding::error("convert-json", error.to_string()))?;
    bytes.push(b'\n');
    Ok(Written {
        bytes,
        findings: Vec::new(),
    })
}

pub(crate) fn eulumdat(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::Eulumdat)?;
    let written = match &distribution.eulumdat {
        Some(document) if !options.edited => ldt::rewrite(document, &distribution.intensity),
        Some(document) => ldt::write(&distribution.intensity, &document.header)?,
        None => ldt::write(&distribution.intensity, &distribution.eulumdat_header())?,
    };
    Ok(with_losses(
        written,
        distribution,
        Format::Eulumdat,
        ies::Edition::E2002,
    ))
}

pub(crate) fn lm63(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    let edition = match options.edition.as_deref() {
        None | Some("2002") => ies::Edition::E2002,
        Some("2019") => ies::Edition::E2019,
        Some(other) => {
            let message = format!("LM-63 is written in editions 2002 and 2019, not {other}");
            return Err(Finding::error("convert-edition", message));
        }
    };
    let mut facts = distribution.ies_facts();
    if let Some(asked) = &options.generation {
        facts.generation = Some(generation(asked, edition)?);
    }
    let written = ies::write_as(distribution, &facts, edition, options.photometry);
    Ok(with_losses(written, distribution, Format::Ies, edition))
}

pub(crate) fn tm33(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::Tm33)?;
    let edition = match options.edition.as_deref() {
        None | Some("2018") => atla::Edition::E2018,
        Some("2023") => atla::Edition::E2023,
        Some(other) => {
            let message = format!("TM-33 is written in editions 2018 and 2023, not {other}");
            return Err(Finding::error("convert-edition", message));
        }
    };
    let written = atla::write(distribution, edition);
    Ok(with_losses(written, distribution, Format::Tm33, ies::Edition::E2002))
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

/// What was written, and what of the source's header its format (LM-63: of that edition) has no field for.
fn with_losses(mut written: Written, distribution: &Distribution, target: Format, edition: ies::Edition) -> Written {
    let lost = distribution.without_field(target, edition);
    if !lost.is_empty() {
        let message = format!("this format has no field for: {}", lost.join(", "));
        written.findings.push(Finding::note("convert-header", message));
    }
    written
}
