//! Photometry of types A and B, written: as it was read, and turned from C–γ.

use std::path::Path;

use isolux_formats::ies::{self, Edition, Photometry};
use isolux_formats::{Content, Distribution, Finding, read_any};
use isolux_photometry::IntensityDistribution;

fn read(bytes: &[u8], name: &str) -> Distribution {
    match read_any(bytes, name).remove(0).document {
        Some(Content::Distribution(distribution)) => *distribution,
        _ => panic!("{name} holds no distribution"),
    }
}

fn golden(name: &str) -> Distribution {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    read(&std::fs::read(path).unwrap(), name)
}

fn written(distribution: &Distribution, photometry: Option<Photometry>) -> (Distribution, Vec<Finding>) {
    let written = ies::write_as(distribution, &distribution.ies_facts(), Edition::E2002, photometry);
    (read(&written.bytes, "x.ies"), written.findings)
}

/// The same description with another light.
fn illuminated(of: impl Fn(f64, f64) -> f64, gamma_end: usize) -> Distribution {
    let c_deg: Vec<f64> = (0..72).map(|plane| f64::from(plane) * 5.0).collect();
    let gamma_deg: Vec<f64> = (0..=gamma_end).map(|gamma| gamma as f64).collect();
    let candela = c_deg
        .iter()
        .flat_map(|&c| gamma_deg.iter().map(move |&gamma| (c, gamma)));
    let candela = candela.map(|(c, gamma)| of(c, gamma)).collect();
    Distribution {
        intensity: IntensityDistribution::new(c_deg, gamma_deg, candela).unwrap(),
        native: None,
        absolute: true,
        ..golden("type-b.ies")
    }
}

#[test]
fn a_table_of_type_a_or_b_is_written_as_it_was_read() {
    for name in ["type-a.ies", "type-b.ies"] {
        let original = golden(name);
        let (back, findings) = written(&original, None);
        assert_eq!(back.native, original.native, "{name}");
        assert!(
            !findings.iter().any(|finding| finding.code == "ies-resampled"),
            "{name}"
        );
        // Asked for, it becomes C–γ.
        let (turned, _) = written(&original, Some(Photometry::C));
        assert!(turned.native.is_none(), "{name}");
    }
}

#[test]
fn a_turned_table_says_the_light_of_each_direction() {
    // Up and to the right there is more light: nothing is symmetric.
    let light = |right: f64, up: f64, axis: f64| 100.0 * axis.max(0.0).powi(2) * (1.0 + 0.4 * right + 0.2 * up);
    let source = illuminated(
        |c, gamma| {
            let ((sin_c, cos_c), (sin_g, cos_g)) = (c.to_radians().sin_cos(), gamma.to_radians().sin_cos());
            light(sin_g * cos_c, sin_g * sin_c, cos_g)
        },
        90,
    );
    for photometry in [Photometry::A, Photometry::B] {
        let (back, findings) = written(&source, Some(photometry));
        assert!(findings.iter().any(|finding| finding.code == "ies-resampled"));
        assert!(!findings.iter().any(|finding| finding.code == "ies-behind"));
        let native = back.native.unwrap();
        assert_eq!(native.photometry_type, photometry.letter());
        assert_eq!((native.vertical_deg.len(), native.horizontal_deg.len()), (181, 181));
        let mut worst = 0.0_f64;
        for (row, h) in native.intensity_cd.iter().zip(&native.horizontal_deg) {
            for (candela, v) in row.iter().zip(&native.vertical_deg) {
                // Two turns: A first by V about the horizontal axis and then by H about the vertical one, B in the
                // other order.
                let ((sin_v, cos_v), (sin_h, cos_h)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
                let expected = match photometry {
                    Photometry::A => light(cos_v * sin_h, sin_v, cos_v * cos_h),
                    _ => light(sin_h, cos_h * sin_v, cos_h * cos_v),
                };
                worst = worst.max((candela - expected).abs());
            }
        }
        // What straight lines between half-planes 5° apart leave.
        assert!(worst < 0.05, "type {}: {worst}", photometry.letter());
    }
}

#[test]
fn left_like_right_is_kept_as_lateral_symmetry_and_light_behind_is_said() {
    let even = illuminated(|_, gamma| 50.0 * (1.0 + gamma.to_radians().cos()), 180);
    let (back, findings) = written(&even, Some(Photometry::B));
    let native = back.native.unwrap();
    assert_eq!(native.horizontal_deg[0], 0.0);
    assert_eq!(native.vertical_deg[0], -90.0);
    let behind = findings.iter().find(|finding| finding.code == "ies-behind").unwrap();
    // ∫ 50 (1 + cos γ) dω is 200 π, of which π·50 lie behind.
    assert!(
        behind.message.starts_with("157.0") && behind.message.contains("628.3"),
        "{}",
        behind.message
    );
}

/// A table of type A or B as a file, every `step`° over the half-space in front.
fn table(photometry: Photometry, step: f64, candela: impl Fn(f64, f64) -> f64) -> (Vec<f64>, String) {
    let count = (180.0 / step).round() as usize + 1;
    let angles: Vec<f64> = (0..count).map(|at| at as f64 * step - 90.0).collect();
    let line = |row: Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let rows = angles
        .iter()
        .map(|&h| line(angles.iter().map(|&v| candela(h, v)).collect()));
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST]\n[TESTLAB]\n[ISSUEDATE]\n[MANUFAC]\nTILT=NONE\n1 -1 1 {count} {count} {} 2 0 0 0\n1 1 1000\n",
        photometry.code()
    );
    for part in [line(angles.clone()), line(angles.clone())].into_iter().chain(rows) {
        text += &part;
        text.push('\n');
    }
    (angles, text)
}

#[test]
fn flux_and_peak_are_those_of_the_files_own_angles() {
    // Two narrow lobes up and to the sides, and the largest values between the directions of an even grid over C-γ.
    let light = |h: f64, v: f64| 1e5 * (-((h.abs() - 15.0) / 6.0).powi(2) - ((v - 10.0) / 5.0).powi(2)).exp();
    for photometry in [Photometry::A, Photometry::B] {
        let (angles, text) = table(photometry, 5.0, light);
        let parsed = read_any(text.as_bytes(), "x.ies").remove(0);
        let finding = parsed.findings.iter().find(|finding| finding.code == "ies-resampled");
        assert_eq!(finding.unwrap().severity, isolux_formats::Severity::Note, "{finding:?}");
        let read = read(text.as_bytes(), "x.ies");
        // Midpoints of each cell's straight lines, 40 × 40 of them.
        let (cells, parts) = (angles.len() - 1, 40);
        let mut flux = 0.0;
        for (h, v) in (0..cells).flat_map(|h| (0..cells).map(move |v| (h, v))) {
            for (a, b) in (0..parts).flat_map(|a| (0..parts).map(move |b| (a, b))) {
                let at = |part: i32| (f64::from(part) + 0.5) / f64::from(parts);
                let (s, t) = (at(a), at(b));
                let corner = |i: usize, j: usize| light(angles[h + i], angles[v + j]);
                let candela = (1.0 - s) * ((1.0 - t) * corner(0, 0) + t * corner(0, 1))
                    + s * ((1.0 - t) * corner(1, 0) + t * corner(1, 1));
                let elevation = match photometry {
                    Photometry::A => angles[v] + 5.0 * t,
                    _ => angles[h] + 5.0 * s,
                };
                flux += candela * elevation.to_radians().cos();
            }
        }
        flux *= (5.0 / f64::from(parts)).to_radians().powi(2);
        let quantities = serde_json::to_value(read.quantities()).unwrap();
        let number = |key: &str| quantities[key].as_f64().unwrap();
        assert!(
            (number("flux_lm") / flux - 1.0).abs() < 1e-4,
            "{} {flux}",
            number("flux_lm")
        );
        assert_eq!(number("i_max_cd"), 1e5);
        let direction = photometry.direction(10.0, 15.0);
        assert!((number("i_max_c_deg") - direction.y.atan2(direction.x).to_degrees()).abs() < 1e-5);
        assert!((number("i_max_gamma_deg") - direction.z.acos().to_degrees()).abs() < 1e-5);
        // And the light that others take is near it, in both lobes.
        for horizontal in [15.0, -15.0] {
            let there = read.intensity.toward(photometry.direction(10.0, horizontal));
            assert!((there / 1e5 - 1.0).abs() < 1e-3, "{there} at H {horizontal}");
        }
        assert!((read.intensity.flux_lm() / flux - 1.0).abs() < 5e-3);
    }
}

#[test]
fn light_that_resampling_changes_by_more_than_a_hundredth_is_a_warning() {
    // One value alone, no wider than the step: a finer grid than the file's size allows would be needed.
    let (_, text) = table(
        Photometry::B,
        2.5,
        |h, v| {
            if h == 0.0 && v == 0.0 { 100.0 } else { 0.0 }
        },
    );
    let parsed = read_any(text.as_bytes(), "x.ies").remove(0);
    let finding = parsed
        .findings
        .iter()
        .find(|finding| finding.code == "ies-resampled")
        .unwrap();
    let Some(Content::Distribution(read)) = &parsed.document else {
        panic!("a table")
    };
    let own = read.quantities().flux_lm;
    let off = read.intensity.flux_lm() / own - 1.0;
    assert!(off.abs() >= 0.01, "{off}");
    assert_eq!(finding.severity, isolux_formats::Severity::Warning);
    assert!(
        finding.message.contains(&format!("flux {:+.2} %", 100.0 * off)),
        "{}",
        finding.message
    );
}

#[test]
fn a_half_that_is_mirrored_is_said() {
    let (_, whole) = table(Photometry::B, 5.0, |h, v| 90.0 - 0.5 * h.abs() - 0.5 * v.abs());
    let of = |text: &str| -> Vec<(String, isolux_formats::Severity, Option<usize>)> {
        let findings = read_any(text.as_bytes(), "x.ies").remove(0).findings;
        let mirrored = findings.iter().filter(|finding| finding.code == "ies-mirrored");
        mirrored
            .map(|finding| (finding.message.to_string(), finding.severity, finding.line))
            .collect()
    };
    assert_eq!(of(&whole), []);
    // The second half of the angles and of the values of each row; the rows of H from 0.
    let lines: Vec<&str> = whole.lines().collect();
    let half = |line: &str| line.split(' ').skip(18).collect::<Vec<_>>().join(" ");
    let mut up: Vec<String> = lines[..8].iter().map(|line| (*line).to_owned()).collect();
    up[6] = up[6].replace("37 37", "19 37");
    up.push(half(lines[8]));
    up.push(lines[9].to_owned());
    up.extend(lines[10..].iter().map(|line| half(line)));
    let found = of(&up.join("\n"));
    assert!(
        matches!(&found[..], [(message, isolux_formats::Severity::Warning, Some(9))] if message.starts_with("vertical")),
        "{found:?}"
    );
    let mut right: Vec<String> = lines[..9].iter().map(|line| (*line).to_owned()).collect();
    right[6] = right[6].replace("37 37", "37 19");
    right.push(half(lines[9]));
    right.extend(lines[28..].iter().map(|line| (*line).to_owned()));
    let found = of(&right.join("\n"));
    assert!(
        matches!(&found[..], [(message, isolux_formats::Severity::Note, Some(10))] if message.starts_with("horizontal")),
        "{found:?}"
    );
}
