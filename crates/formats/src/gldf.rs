//! GLDF: a zip with a product description beside photometries and spectra in their own formats.

use std::io::{Cursor, Read};

use crate::content::Content;
use crate::file_format::{FileFormat, Found, Source};
use crate::finding::{Finding, Findings};
use crate::parsed::{Format, LARGEST_FILE, Parsed};
use crate::spectral::embedded;
use crate::text::Text;
use crate::xml;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::GLDF,
    title: "GLDF",
    extensions: &["gldf"],
    detect: |source| looks_like(source.bytes),
    read,
    write_distribution: None,
    write_spectrum: None,
};

/// More entries than this are no product description.
const MOST_ENTRIES: usize = 10_000;
/// All photometries and spectra together, unpacked.
const LARGEST_TOTAL: u64 = 2 * LARGEST_FILE as u64;

/// Whether these bytes are a zip.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

/// Whether the zip is a workbook of Excel.
pub(crate) fn is_workbook(bytes: &[u8]) -> bool {
    looks_like(bytes)
        && zip::ZipArchive::new(Cursor::new(bytes))
            .is_ok_and(|archive| archive.index_for_name("xl/workbook.xml").is_some())
}

fn refused(finding: Finding) -> Vec<Parsed<Content>> {
    vec![Parsed::refused(Some(Format::GLDF), None, finding.into())]
}

/// One entry a photometry (`ldc/`) or spectrum (`spectrum/`, or listed in the product) inside; their own formats and
/// findings.
fn read(source: &Source<'_>) -> Found {
    let mut archive = match zip::ZipArchive::new(Cursor::new(source.bytes)) {
        Ok(archive) => archive,
        Err(error) => {
            return refused(
                Finding::error("gldf-zip", format!("the container is damaged: {error}")).fix("fetch the file again"),
            );
        }
    };
    if archive.len() > MOST_ENTRIES {
        return refused(Finding::error(
            "gldf-entries",
            format!("{} entries are too many", archive.len()),
        ));
    }
    let mut found = Vec::new();
    let mut total = 0;
    let mut addresses = 0;
    for index in 0..archive.len() {
        let mut entry = match archive.by_index(index) {
            Ok(entry) => entry,
            Err(error) => {
                found.extend(refused(Finding::error(
                    "gldf-zip",
                    format!("entry {index} is damaged: {error}"),
                )));
                continue;
            }
        };
        let name = match entry.name() {
            Ok(name) => name.into_owned(),
            Err(error) => {
                found.extend(refused(Finding::error(
                    "gldf-zip",
                    format!("entry {index} has no readable name: {error}"),
                )));
                continue;
            }
        };
        let lower = name.to_ascii_lowercase();
        let product = lower == "product.xml";
        if entry.is_dir() || !(product || lower.starts_with("ldc/") || lower.starts_with("spectrum/")) {
            continue;
        }
        let mut inner = Vec::new();
        let room = LARGEST_TOTAL.saturating_sub(total);
        let unpacked = entry
            .by_ref()
            .take(room.min(LARGEST_FILE as u64) + 1)
            .read_to_end(&mut inner);
        total += inner.len() as u64;
        if let Err(error) = unpacked {
            let mut damaged =
                refused(Finding::error("gldf-zip", format!("{name} is damaged: {error}")).fix("fetch the file again"));
            for parsed in &mut damaged {
                parsed.inner = Some(name.clone());
            }
            found.extend(damaged);
            continue;
        }
        if total > LARGEST_TOTAL {
            found.extend(refused(Finding::error(
                "gldf-too-large",
                "the container unpacks to more than is read",
            )));
            break;
        }
        // A container inside a container is not unpacked again.
        if looks_like(&inner) {
            found.extend(refused(Finding::error(
                "gldf-nested",
                format!("{name} is a container itself"),
            )));
            continue;
        }
        if product {
            let (spectra, links) = listed(&inner);
            found.extend(spectra);
            addresses += links;
            continue;
        }
        for mut parsed in (source.read_inner)(&inner, &name, source.options) {
            parsed.inner = Some(name.clone());
            found.push(parsed);
        }
    }
    if found.is_empty() {
        let message = "no photometry (ldc/) and no spectrum (spectrum/) is inside".to_owned();
        let finding = if addresses > 0 {
            let message = format!("{message}; files that are named by an address alone, and not fetched: {addresses}");
            Finding::error("gldf-empty", message).fix("fetch those files, or a container that holds them")
        } else {
            Finding::error("gldf-empty", message).fix("check that this is a GLDF container")
        };
        return refused(finding);
    }
    found
}

/// Spectra that the product description lists itself, and how many of its files are addresses.
fn listed(product: &[u8]) -> (Vec<Parsed<Content>>, usize) {
    let text = Text::decode(product, &mut Findings::new());
    let Ok(root) = xml::parse(text.content()) else {
        return (Vec::new(), 0);
    };
    let (mut spectra, mut addresses) = (Vec::new(), 0);
    let mut open = vec![&root];
    while let Some(element) = open.pop() {
        let address = element.attribute(&["type"]) == Some("url");
        addresses += usize::from(element.name == "File" && address);
        if element.name == "Spectrum"
            && let Some(parsed) = embedded::read(element)
        {
            let id = element.attribute(&["id"]).unwrap_or("");
            spectra.push(Parsed {
                inner: Some(format!("product.xml#{id}")),
                format: parsed.format,
                kind: parsed.kind,
                document: parsed.document.map(|file| Content::Spectrum(Box::new(file))),
                findings: parsed.findings,
            });
        }
        open.extend(element.children.iter().rev());
    }
    (spectra, addresses)
}
