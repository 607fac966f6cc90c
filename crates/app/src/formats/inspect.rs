//! `inspect`: facts, quantities and findings of photometric and spectral files.

mod action;
mod colour;
mod coloured;
mod inspection;
mod mismatch;
mod ray_quantities;
pub(crate) mod rays;
mod read;
mod source;
mod stated;

use camino::Utf8Path;
use isolux_formats::{Content, Kind, Parsed, ReadOptions};

use self::read::parsed;
use self::source::OpenFile;

pub use action::{Action, is_rated_cct_k};
pub use coloured::{AngularColour, ColourOfDirection, ColouredQuantities};
pub use inspection::{Inspection, Quantities, SpectrumQuantities};
pub use mismatch::Meter;
pub use ray_quantities::RayQuantities;
pub use read::read;

/// Looks at one file; a file that cannot be read gives its reason as a finding.
pub fn file(path: &Utf8Path, options: ReadOptions) -> Vec<Inspection> {
    if colour::is_model(path) {
        return colour::of_model(path, options);
    }
    let parsed = match OpenFile::open(path) {
        Ok(source) if rays::are_in(path, &source) => return vec![rays::inspection(path, source)],
        Ok(source) => parsed(path, source, options),
        Err(finding) => Err(finding),
    };
    match parsed {
        Ok(parsed) => parsed.into_iter().map(|parsed| inspection(path, parsed)).collect(),
        Err(finding) => vec![Inspection::unreadable(path, finding)],
    }
}

/// What is said of `content` that is in no file yet; `name` stands for one.
pub fn content(name: &str, content: Content) -> Inspection {
    let kind = match content {
        Content::Distribution(_) => Kind::Distribution,
        Content::Spectrum(_) => Kind::Spectrum,
    };
    let parsed = Parsed {
        inner: None,
        format: None,
        kind: Some(kind),
        document: Some(content),
        findings: Vec::new(),
    };
    inspection(Utf8Path::new(name), parsed)
}

fn inspection(path: &Utf8Path, parsed: Parsed<Content>) -> Inspection {
    let file = parsed
        .inner
        .as_ref()
        .map_or_else(|| path.to_string(), |inner| format!("{path}!{inner}"));
    let quantities = match &parsed.document {
        Some(Content::Distribution(distribution)) => Quantities::Distribution(Box::new(distribution.quantities())),
        Some(Content::Spectrum(spectrum)) => spectrum.quantities().map_or(Quantities::None {}, |of| {
            Quantities::Spectrum(Box::new(SpectrumQuantities {
                of,
                spectral_mismatch: None,
                rated_colour: None,
                daylight_efficacy_ratio: None,
            }))
        }),
        None => Quantities::None {},
    };
    let mut inspection = Inspection {
        file,
        format: parsed.format,
        kind: parsed.kind,
        readable: parsed.document.is_some(),
        findings: parsed.findings,
        quantities,
        content: parsed.document,
    };
    colour::of_tm33(path, &mut inspection);
    inspection
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
        #[cfg(unix)]
        std::os::unix::fs::symlink(outer.join("outside.tlt"), folder.join("link.tlt")).unwrap();

        let found = inspected(&folder, "lamp.tlt");
        assert_eq!(tilt(&found).unwrap().factor, [1.0, 0.95, 0.9]);
        let stated = found.findings.iter().find(|f| f.code == "ies-tilt-factors").unwrap();
        assert!(stated.message.contains("Lamp.TLT"), "{}", stated.message);
        assert_eq!(stated.line, Some(6));

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
