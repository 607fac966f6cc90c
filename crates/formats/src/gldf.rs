//! GLDF: a zip with a product description beside photometries and spectra in their own formats.

use std::io::{Cursor, Read};

use crate::finding::Finding;
use crate::read::{Content, Format, LARGEST_FILE, Parsed, ReadOptions, read_any_with};

/// More entries than this are no product description.
const MOST_ENTRIES: usize = 10_000;
/// All photometries and spectra together, unpacked.
const LARGEST_TOTAL: u64 = 2 * LARGEST_FILE as u64;

/// Whether these bytes are a zip.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

fn refused(finding: Finding) -> Vec<Parsed<Content>> {
    vec![Parsed {
        inner: None,
        format: Some(Format::Gldf),
        kind: None,
        document: None,
        findings: vec![finding],
    }]
}

/// One entry a photometry (`ldc/`) or spectrum (`spectrum/`) inside; their own formats and findings.
pub(crate) fn read(bytes: &[u8], options: ReadOptions) -> Vec<Parsed<Content>> {
    let mut archive = match zip::ZipArchive::new(Cursor::new(bytes)) {
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
        if entry.is_dir() || !(lower.starts_with("ldc/") || lower.starts_with("spectrum/")) {
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
        for mut parsed in read_any_with(&inner, &name, options) {
            parsed.inner = Some(name.clone());
            found.push(parsed);
        }
    }
    if found.is_empty() {
        return refused(
            Finding::error(
                "gldf-empty",
                "no photometry (ldc/) and no spectrum (spectrum/) is inside",
            )
            .fix("check that this is a GLDF container"),
        );
    }
    found
}
