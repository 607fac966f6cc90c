//! `inspect`: facts, quantities and findings of photometric and spectral files.

mod dropped;
mod mismatch;
pub(crate) mod rays;
mod source;

use camino::{Utf8Component, Utf8Path, Utf8PathBuf};
use isolux_formats::{Content, Finding, Format, Kind, Opened, Parsed, ReadOptions, Severity, read_any_beside};
use serde::Serialize;
use serde_json::{Map, Value};

use self::source::Source;
use crate::files;

pub use dropped::{Dropped, dropped};
pub use mismatch::Meter;

/// What is said of one photometry or spectrum; serialises to the object of `inspect --json`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// The file, `outer!inner` inside a container.
    pub file: String,
    /// The format that was recognised.
    pub format: Option<Format>,
    /// What it describes.
    pub kind: Option<Kind>,
    /// Whether its content can be used: `convert` writes it, or all its rays are there.
    pub readable: bool,
    /// What the reader found.
    pub findings: Vec<Finding>,
    /// What follows from the content.
    pub quantities: Map<String, Value>,
    /// The content itself, for pictures.
    #[serde(skip)]
    pub content: Option<Content>,
}

impl Inspection {
    /// Whether any finding is an error.
    pub fn has_error(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Error)
    }
}

/// Looks at one file; a file that cannot be read gives its reason as a finding.
pub fn file(path: &Utf8Path, options: ReadOptions) -> Vec<Inspection> {
    let parsed = match Source::open(path) {
        Ok(source) if rays::are_in(path, &source) => return vec![rays::inspection(path, source)],
        Ok(source) => parsed(path, source, options),
        Err(finding) => Err(finding),
    };
    match parsed {
        Ok(parsed) => parsed.into_iter().map(|parsed| inspection(path, parsed)).collect(),
        Err(finding) => vec![Inspection {
            file: path.to_string(),
            format: None,
            kind: None,
            readable: false,
            findings: vec![finding],
            quantities: Map::new(),
            content: None,
        }],
    }
}

impl Inspection {
    /// Adds to a spectrum's quantities what `meter` makes of it: `spectral_mismatch`, null where it cannot be had, and
    /// why; and what was found in the meter's own files.
    pub fn seen_by(&mut self, meter: &Meter) {
        let Some(Content::Spectrum(file)) = &self.content else {
            return;
        };
        let Ok(source) = file.spectrum() else {
            return;
        };
        self.findings.extend_from_slice(meter.findings());
        let factor = match meter.mismatch(&source) {
            Ok(factor) => Value::from(factor),
            Err(why) => {
                self.findings.push(
                    Finding::warning(
                        "meter-no-factor",
                        format!("there is no spectral mismatch correction factor: {why}"),
                    )
                    .fix("check that the responsivity is this meter's, over the wavelengths of this light"),
                );
                Value::Null
            }
        };
        self.quantities.insert("spectral_mismatch".to_owned(), factor);
    }
}

/// The content of one file or pipe, refused before it is read when it is too large.
///
/// # Errors
/// A finding that says why there is nothing to parse.
pub fn read(path: &Utf8Path, options: ReadOptions) -> Result<Vec<Parsed<Content>>, Finding> {
    parsed(path, Source::open(path)?, options)
}

fn parsed(path: &Utf8Path, source: Source, options: ReadOptions) -> Result<Vec<Parsed<Content>>, Finding> {
    Ok(read_any_beside(
        &source.into_bytes(path)?,
        path.file_name().unwrap_or(path.as_str()),
        options,
        &|name| beside(path, name),
    ))
}

/// Largest file that another one may name: a tilt table has a few hundred numbers.
const LARGEST_BESIDE: u64 = 1024 * 1024;

/// The file `name` in the folder of `path` or below it; nothing outside that folder is opened, whatever a file says.
fn beside(path: &Utf8Path, name: &str) -> Result<Opened, String> {
    let relative = Utf8PathBuf::from(name.replace('\\', "/"));
    let inside = relative
        .components()
        .all(|part| matches!(part, Utf8Component::Normal(_) | Utf8Component::CurDir));
    if !inside || name.contains(':') {
        return Err(format!("{name} is not below the folder of the file itself"));
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_str().is_empty())
        .unwrap_or(Utf8Path::new("."));
    let target = in_any_case(folder, &relative);
    let real = |path: &Utf8Path| path.canonicalize_utf8().map_err(|error| format!("{path}: {error}"));
    let (root, real) = (real(folder)?, real(&target)?);
    if !real.starts_with(&root) {
        return Err(format!("{target} leads out of the folder of the file itself"));
    }
    let facts = std::fs::metadata(&real).map_err(|error| format!("{target}: {error}"))?;
    if !facts.is_file() || facts.len() > LARGEST_BESIDE {
        return Err(format!("{target} is no file of at most {LARGEST_BESIDE} bytes"));
    }
    let bytes = files::read(&real).map_err(|failure| failure.message)?;
    Ok(Opened {
        path: target.into_string(),
        bytes,
    })
}

/// `relative` in `folder`; where no such name exists, the one that differs in case alone (names come from Windows).
fn in_any_case(folder: &Utf8Path, relative: &Utf8Path) -> Utf8PathBuf {
    let exact = folder.join(relative);
    let (Some(parent), Some(name)) = (exact.parent(), exact.file_name()) else {
        return exact;
    };
    if exact.exists() {
        return exact;
    }
    let mut same: Vec<Utf8PathBuf> = parent
        .read_dir_utf8()
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().eq_ignore_ascii_case(name))
        .map(|entry| entry.path().to_owned())
        .collect();
    if same.len() == 1 { same.remove(0) } else { exact }
}

fn inspection(path: &Utf8Path, parsed: Parsed<Content>) -> Inspection {
    let file = parsed
        .inner
        .as_ref()
        .map_or_else(|| path.to_string(), |inner| format!("{path}!{inner}"));
    let quantities = match &parsed.document {
        Some(Content::Distribution(distribution)) => distribution.quantities(),
        Some(Content::Spectrum(spectrum)) => match serde_json::to_value(spectrum.quantities()) {
            Ok(Value::Object(quantities)) => quantities,
            _ => Map::new(),
        },
        None => Map::new(),
    };
    Inspection {
        file,
        format: parsed.format,
        kind: parsed.kind,
        readable: parsed.document.is_some(),
        findings: parsed.findings,
        quantities,
        content: parsed.document,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMP: &str = "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] b\n[MANUFAC] c\nTILT=NAME\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n100 70 0\n";

    fn inspected(folder: &Utf8Path, name: &str) -> Inspection {
        let path = folder.join("lamp.ies");
        std::fs::write(&path, LAMP.replace("NAME", name)).unwrap();
        file(&path, ReadOptions::default()).remove(0)
    }

    fn tilt(inspection: &Inspection) -> Option<isolux_formats::ies::TiltFactors> {
        match inspection.content.as_ref()? {
            Content::Distribution(distribution) => distribution.tilt_factors(),
            Content::Spectrum(_) => None,
        }
    }

    #[test]
    fn a_tilt_file_is_read_from_beside_and_from_nowhere_else() {
        let outer = tempfile::tempdir().unwrap();
        let outer = Utf8Path::from_path(outer.path()).unwrap().to_owned();
        let folder = outer.join("files");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("Lamp.TLT"), "1\n3\n0 45 90\n1.0 .95 .9\n").unwrap();
        std::fs::write(outer.join("outside.tlt"), "1\n3\n0 45 90\n1.0 .95 .9\n").unwrap();
        std::fs::write(folder.join("short.tlt"), "1\n3\n0 45\n1.0 .95\n").unwrap();
        std::os::unix::fs::symlink(outer.join("outside.tlt"), folder.join("link.tlt")).unwrap();

        let found = inspected(&folder, "lamp.tlt");
        assert_eq!(tilt(&found).unwrap().factor, [1.0, 0.95, 0.9]);
        let said = found.findings.iter().find(|f| f.code == "ies-tilt-factors").unwrap();
        assert!(said.message.contains("Lamp.TLT"), "{}", said.message);
        assert_eq!(said.line, Some(6));

        let absolute = outer.join("outside.tlt").into_string();
        for name in [
            "absent.tlt",
            "short.tlt",
            "../outside.tlt",
            "..\\outside.tlt",
            "link.tlt",
            &absolute,
        ] {
            let found = inspected(&folder, name);
            assert!(found.readable && !found.has_error(), "{name}");
            assert!(tilt(&found).is_none(), "{name}");
            assert!(found.findings.iter().any(|f| f.code == "ies-tilt-file"), "{name}");
        }
    }
}
