//! The project's own corpus, hostile bytes, and every pair of formats there and back.
//!
//! `tests/golden` holds one small file a deviation; `tests/golden/expected.txt` what each must give. `ISOLUX_BLESS=1`
//! writes that list anew, for a person to read before it is committed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use isolux_formats::{Content, Distribution, Parsed, eulumdat, ies, read_any, tm33};
use isolux_spectrum::Spectrum;
use proptest::prelude::*;

fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn files(folder: &str) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<PathBuf> = std::fs::read_dir(tests().join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    all.sort();
    let read = |path: &PathBuf| {
        (
            path.file_name().unwrap().to_string_lossy().into_owned(),
            std::fs::read(path).unwrap(),
        )
    };
    all.iter()
        .filter(|path| !path.ends_with("expected.txt"))
        .map(read)
        .collect()
}

fn distribution(parsed: Vec<Parsed<Content>>) -> Option<Distribution> {
    match parsed.into_iter().next()?.document? {
        Content::Distribution(distribution) => Some(*distribution),
        Content::Spectrum(_) => None,
    }
}

#[test]
fn golden_files_give_their_findings() {
    let mut found = String::new();
    for (name, bytes) in files("golden") {
        for parsed in read_any(&bytes, &name) {
            let readable = if parsed.document.is_some() {
                "readable"
            } else {
                "unreadable"
            };
            writeln!(found, "{name} {readable}").unwrap();
            for finding in &parsed.findings {
                let line = finding.line.map_or("-".to_owned(), |line| line.to_string());
                writeln!(found, "    {} {} line {line}", finding.severity.word(), finding.code).unwrap();
            }
            if let Some(Content::Distribution(d)) = &parsed.document {
                let peak = d.intensity.peak().intensity_cd;
                let flux = d.intensity.flux_lm();
                writeln!(
                    found,
                    "    {} planes, {} γ, peak {peak:.3} cd, {flux:.2} lm",
                    d.intensity.c_deg().len(),
                    d.intensity.gamma_deg().len()
                )
                .unwrap();
            }
        }
    }
    let path = tests().join("golden/expected.txt");
    if std::env::var("ISOLUX_BLESS").is_ok() {
        std::fs::write(&path, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    for (found, expected) in found.lines().zip(expected.lines()) {
        assert_eq!(found, expected);
    }
    assert_eq!(found.lines().count(), expected.lines().count());
}

/// Absolute candela in the directions of `a`, within 1e-6 of each value or of a billionth of the peak.
fn same_light(a: &Distribution, b: &Distribution, what: &str) {
    let peak = a.intensity.peak().intensity_cd.abs();
    for (plane, &c) in a.intensity.c_deg().iter().enumerate() {
        for (&gamma, &candela) in a.intensity.gamma_deg().iter().zip(a.intensity.row(plane)) {
            let other = b.intensity.intensity_cd_at(c, gamma);
            assert!(
                (candela - other).abs() <= 1e-6 * candela.abs().max(1e-3 * peak),
                "{what}: C{c} γ{gamma}: {candela} became {other}"
            );
        }
    }
}

#[test]
fn every_pair_of_formats_keeps_the_light() {
    let mut shared: Vec<(String, Vec<u8>)> = files("good");
    shared.extend(files("golden"));
    for (name, bytes) in shared {
        let Some(original) = distribution(read_any(&bytes, &name)) else {
            continue;
        };
        let written = |target: &str, d: &Distribution| match target {
            "ldt" => eulumdat::write(&d.intensity, &d.eulumdat_header()).unwrap().bytes,
            "ies" => ies::write(&d.intensity, &d.ies_facts(), ies::Edition::E2002).bytes,
            "2019.ies" => ies::write(&d.intensity, &d.ies_facts(), ies::Edition::E2019).bytes,
            "23.xml" => tm33::write(d, tm33::Edition::E2023).bytes,
            _ => tm33::write(d, tm33::Edition::E2018).bytes,
        };
        for first in ["ldt", "ies", "2019.ies", "xml", "23.xml"] {
            let there = distribution(read_any(&written(first, &original), &format!("x.{first}")))
                .unwrap_or_else(|| panic!("{name} as {first} cannot be read back"));
            same_light(&original, &there, &format!("{name} → {first}"));
            for second in ["ldt", "ies", "xml"] {
                let back = distribution(read_any(&written(second, &there), &format!("x.{second}"))).unwrap();
                same_light(&original, &back, &format!("{name} → {first} → {second}"));
            }
        }
    }
}

#[test]
fn a_rewritten_file_keeps_its_header_and_its_symmetry() {
    for class in 0..5 {
        let bytes = std::fs::read(tests().join(format!("good/isym{class}.ldt"))).unwrap();
        let original = distribution(read_any(&bytes, "a.ldt")).unwrap();
        let document = original.eulumdat.as_ref().unwrap();
        assert_eq!(document.isym, class);
        let written = eulumdat::rewrite(document, &original.intensity);
        assert_eq!(
            String::from_utf8(written.bytes).unwrap().lines().count(),
            bytes.split(|&b| b == b'\n').count() - 1
        );
        let again = eulumdat::write(&original.intensity, &original.eulumdat_header()).unwrap();
        let back = eulumdat::read_document(&again.bytes).document.unwrap();
        assert_eq!(back.isym, class, "symmetry is kept where it is real");
        assert!(
            again
                .bytes
                .split(|&b| b == b'\n')
                .all(|line| line.is_empty() || line.ends_with(b"\r"))
        );
    }
}

#[test]
fn what_was_not_stated_is_computed_and_what_was_is_kept() {
    let rewritten = |name: &str| {
        let bytes = std::fs::read(tests().join("golden").join(name)).unwrap();
        let read = distribution(read_any(&bytes, name)).unwrap();
        let written = eulumdat::rewrite(read.eulumdat.as_ref().unwrap(), &read.intensity);
        eulumdat::read_document(&written.bytes).document.unwrap().header
    };
    let computed = rewritten("fractions-zero.ldt");
    assert_eq!(computed.lorl_percent, Some(84.8));
    assert_eq!(computed.dff_percent, Some(100.0));
    assert_eq!(rewritten("lorl-2-percent-off.ldt").lorl_percent, Some(86.3));
    let ratios = rewritten("ratios-of-another.ldt").direct_ratios;
    assert_eq!(ratios[0], Some(0.69), "stated, though of another light");
}

#[test]
fn a_luminaire_may_be_called_as_a_line_of_another_format() {
    let bytes = std::fs::read(tests().join("good/isym4.ldt")).unwrap();
    let mut lines: Vec<String> = String::from_utf8(bytes).unwrap().lines().map(str::to_owned).collect();
    lines[8] = "TILT=INCLUDE, the lamp".to_owned();
    let parsed = read_any(lines.join("\r\n").as_bytes(), "x.ldt").remove(0);
    assert_eq!(parsed.format, Some(isolux_formats::Format::EULUMDAT));
    assert!(parsed.document.is_some());
}

#[test]
fn what_is_too_large_is_refused() {
    let zeros = vec![b'1'; isolux_formats::LARGEST_FILE + 1];
    let parsed = read_any(&zeros, "x.ldt");
    assert_eq!(parsed[0].findings[0].code, "file-too-large");
    // Three short lines that claim a grid of ten thousand million directions.
    let mut lines = vec![""; 42];
    lines[2] = "1";
    let c: Vec<String> = (0..99_000).map(|i| format!("{}", f64::from(i) * 0.0036)).collect();
    let mut text = String::from(
        "a\n1\n1\n99000\n0.0036\n3\n90\n\n\n\n\n\n1\n1\n1\n1\n1\n0\n0\n0\n0\n100\n100\n1\n0\n1\n1\nLED\n1000\n\n\n1\n",
    );
    text.push_str(&"0\n".repeat(10));
    text.push_str(&c.join("\n"));
    text.push_str("\n0\n90\n180\n1\n1\n1\n");
    let parsed = read_any(text.as_bytes(), "x.ldt");
    assert!(parsed[0].document.is_none() || c.len() * 3 < 4_000_000);
}

/// A tilt table is the one block whose end nothing else announces.
#[test]
fn a_file_cut_off_anywhere_says_so() {
    for name in ["tilt-include.ies", "2019.ies", "isym4.ldt", "atla.xml"] {
        let folder = if name.starts_with("isym") { "good" } else { "golden" };
        let whole = std::fs::read(tests().join(folder).join(name)).unwrap();
        for end in 0..whole.len() {
            let parsed = read_any(&whole[..end], name).remove(0);
            let error = |finding: &isolux_formats::Finding| finding.severity == isolux_formats::Severity::Error;
            assert!(
                parsed.document.is_some() || parsed.findings.iter().any(error),
                "{name} cut after {end} bytes"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn any_bytes_end_in_an_answer(bytes in proptest::collection::vec(any::<u8>(), 0..600), name in 0usize..6) {
        let name = ["x.ldt", "x.ies", "x.xml", "x.gldf", "x.csv", "x"][name];
        let heads: [&[u8]; 5] = [b"", b"IESNA:LM-63-2002\nTILT=NONE\n", b"<IESTM33-22><Emitter>", b"PK\x03\x04", b"gamma_deg,intensity_cd\n"];
        for head in heads {
            for parsed in read_any(&[head, &bytes].concat(), name) {
                prop_assert!(parsed.document.is_some() || parsed.findings.iter().any(|f| f.severity == isolux_formats::Severity::Error));
            }
        }
    }

    #[test]
    fn any_damage_of_a_good_file_ends_in_an_answer(file in 0usize..200, cuts in proptest::collection::vec((any::<u32>(), any::<u8>(), 0u8..4), 1..8)) {
        let mut all = files("good");
        all.extend(files("golden"));
        let (name, mut bytes) = all.swap_remove(file % all.len());
        for (at, byte, what) in cuts {
            if bytes.is_empty() { break }
            let at = at as usize % bytes.len();
            match what {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 => { bytes.remove(at); }
                _ => bytes.truncate(at),
            }
        }
        for parsed in read_any(&bytes, &name) {
            prop_assert!(parsed.document.is_some() || parsed.findings.iter().any(|f| f.severity == isolux_formats::Severity::Error));
        }
    }
}

/// Keywords that name a radiometric unit are reported, and no document calls such numbers luminous in silence; words
/// that merely look like it are not.
#[test]
fn radiant_intensity_is_not_taken_for_light_in_silence() {
    let plain = std::fs::read_to_string(tests().join("golden/2002.ies")).unwrap();
    let with = |keyword: &str| {
        let text = plain.replacen("TILT=NONE", &format!("{keyword}\nTILT=NONE"), 1);
        read_any(text.as_bytes(), "x.ies").remove(0)
    };
    for keyword in [
        "[OTHER] candela-> mW/sr",
        "[OTHER] intensity in W / sr",
        "[_RADIATIONTYPE] UVC 222",
    ] {
        let parsed = with(keyword);
        let finding = parsed
            .findings
            .iter()
            .find(|finding| finding.code == "ies-unit")
            .expect(keyword);
        let at = plain.lines().position(|line| line.starts_with("TILT")).unwrap() + 1;
        assert_eq!(
            (finding.line, finding.severity),
            (Some(at), isolux_formats::Severity::Warning)
        );
        let read = distribution(vec![parsed]).unwrap();
        let written = tm33::write(&read, tm33::Edition::E2018);
        assert!(
            written.findings.iter().any(|finding| finding.code == "tm33-metric"),
            "{keyword}"
        );
    }
    for keyword in [
        "[LUMINAIRE] UV-stable lens, IR remote, 12 W/srf",
        "[OTHER] 90 lm/W/sr",
        "[_RADIATIONTYPE] Visible",
        "[LAMP] IRIS 200W",
    ] {
        let parsed = with(keyword);
        assert!(
            parsed.findings.iter().all(|finding| finding.code != "ies-unit"),
            "{keyword}"
        );
        let written = tm33::write(&distribution(vec![parsed]).unwrap(), tm33::Edition::E2018);
        assert!(
            written.findings.iter().all(|finding| finding.code != "tm33-metric"),
            "{keyword}"
        );
    }
}

/// A lamp with spectra in two directions, as TM-33-23.
fn with_spectra() -> Vec<u8> {
    let bytes = std::fs::read(tests().join("good/isym1.ldt")).unwrap();
    let read = distribution(read_any(&bytes, "a.ldt")).unwrap();
    let spectrum = |nm: f64| Spectrum::new(vec![nm, nm + 1.0], vec![1e-3, 2e-3]).unwrap();
    let (total, axis, aside) = (spectrum(500.0), spectrum(550.0), spectrum(600.0));
    let spectra = tm33::Spectra {
        total: &total,
        directions: &[((0.0, 0.0), &axis), ((90.0, 40.0), &aside)],
    };
    tm33::write_2023(&read, Some(&spectra)).bytes
}

#[test]
fn spectra_over_angle_stand_beside_the_light_and_do_not_become_candela() {
    let text = String::from_utf8(with_spectra()).unwrap();
    let directions = text.split_once("<AngularSpectral>").unwrap().1;
    assert!(directions.contains("<NumberMeasured>2</NumberMeasured>"));
    assert!(
        directions.contains("<IntData h=\"90\" v=\"40\" w=\"601\">2.000000e-3</IntData>"),
        "{directions}"
    );
    assert!(text.contains("<PwrData w=\"500\">1.000000e-3</PwrData>"));
    let bytes = std::fs::read(tests().join("good/isym1.ldt")).unwrap();
    let original = distribution(read_any(&bytes, "a.ldt")).unwrap();
    let back = distribution(read_any(text.as_bytes(), "a.xml")).unwrap();
    same_light(&original, &back, "with spectra");
    // Without luminous data there is no light to read: watts are no candela.
    let (before, rest) = text.split_once("    <LuminousData>").unwrap();
    let (_, after) = rest.split_once("</LuminousData>\n").unwrap();
    for part in ["AngularSpectral", "RadiantIntensity"] {
        let holder = if part == "RadiantIntensity" {
            "RadiantData"
        } else {
            "SpectralData"
        };
        let other = format!("{before}{after}")
            .replace("AngularSpectral", part)
            .replace("SpectralData", holder);
        let parsed = read_any(other.as_bytes(), "a.xml");
        let refused = parsed[0]
            .findings
            .iter()
            .any(|finding| finding.code == "tm33-no-intensity");
        assert!(refused && parsed[0].document.is_none(), "{part}");
    }
}
