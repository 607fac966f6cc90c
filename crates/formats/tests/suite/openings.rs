//! Luminous openings: which way they lie in each format, what glare makes of them, what a conversion keeps.
//!
//! One lamp is written as EULUMDAT has it (length along C90–C270) and as LM-63 has it (length along C0–C180); nothing
//! of what is asserted was computed by the code that reads it.

use isolux_formats::{Content, Distribution, Format, eulumdat, ies, read_any, tm33};
use serde_json::Value;

fn read(bytes: &[u8], name: &str) -> Distribution {
    match read_any(bytes, name).remove(0).document {
        Some(Content::Distribution(distribution)) => *distribution,
        _ => panic!("{name} holds no distribution"),
    }
}

fn gamma_deg() -> impl Iterator<Item = u8> {
    (0..=90).step_by(5)
}

/// A tube lamp that lies along C = `axis_deg`: 1000·cos γ·(1 − 0.6·sin²γ·cos²(C − axis)) cd.
fn tube_cd(axis_deg: f64, c_deg: f64, gamma_deg: f64) -> f64 {
    let (sin, cos) = gamma_deg.to_radians().sin_cos();
    let along = sin * (c_deg - axis_deg).to_radians().cos();
    1000.0 * cos * (1.0 - 0.6 * along * along)
}

/// An LM-63 file of a tube lamp along C0 with this opening.
fn ies_file(version: &str, units: u8, opening: &str) -> Vec<u8> {
    let mut lines = vec![
        version.to_owned(),
        "[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] today\n[MANUFAC] b\nTILT=NONE".to_owned(),
        format!("1 -1 1 19 5 1 {units} {opening}\n1 1 40"),
        gamma_deg().map(|gamma| gamma.to_string()).collect::<Vec<_>>().join(" "),
        "0 22.5 45 67.5 90".to_owned(),
    ];
    for c in [0.0, 22.5, 45.0, 67.5, 90.0] {
        let row: Vec<String> = gamma_deg()
            .map(|gamma| format!("{:.6}", tube_cd(0.0, c, f64::from(gamma))))
            .collect();
        lines.push(row.join(" "));
    }
    lines.join("\n").into_bytes()
}

fn ies_lamp(opening: &str) -> Distribution {
    read(&ies_file("IESNA:LM-63-2002", 2, opening), "lamp.ies")
}

/// The EULUMDAT file of the same lamp, which lies along C90 there. `sizes`: luminous length, width and four heights.
fn ldt_lamp(sizes: [f64; 6]) -> Distribution {
    let mut lines: Vec<String> = "co 3 4 16 22.5 19 5 rep x num f d 1200 1200 60"
        .split(' ')
        .map(str::to_owned)
        .collect();
    lines.extend(sizes.map(|size| size.to_string()));
    lines.extend(
        "0 0 1 0 1 -1 l 1000 4000 80 40 0 0 0 0 0 0 0 0 0 0"
            .split(' ')
            .map(str::to_owned),
    );
    lines.extend((0..16).map(|plane| (f64::from(plane) * 22.5).to_string()));
    lines.extend(gamma_deg().map(|gamma| gamma.to_string()));
    for c in [0.0, 22.5, 45.0, 67.5, 90.0] {
        lines.extend(gamma_deg().map(|gamma| format!("{:.6}", tube_cd(90.0, c, f64::from(gamma)))));
    }
    read((lines.join("\r\n") + "\r\n").as_bytes(), "lamp.ldt")
}

fn ugr(lamp: &Distribution) -> Value {
    serde_json::to_value(lamp.quantities().ugr).unwrap()
}

fn area_mm2(lamp: &Distribution) -> Option<f64> {
    lamp.quantities().luminous_area_mm2
}

/// Largest distance of two tables.
fn apart(a: &Value, b: &Value) -> f64 {
    let mut most = 0.0_f64;
    for view in ["crosswise", "endwise"] {
        for room in 0..19 {
            for column in 0..5 {
                let of = |table: &Value| table[view][room][column].as_f64().unwrap();
                most = most.max((of(a) - of(b)).abs());
            }
        }
    }
    most
}

#[test]
fn one_lamp_in_two_conventions_has_one_glare() {
    let ldt = ugr(&ldt_lamp([1200.0, 100.0, 50.0, 50.0, 50.0, 50.0]));
    // eulumdat-ugr 1.0.1 on that file: rooms 2H × 2H, 4H × 8H and 12H × 8H, crosswise 70/50/20 and 30/30/20, endwise
    // likewise. Its position indices are the table's, ours Guth's formula: up to 0.3.
    let published = [
        (0, [18.20, 20.47, 16.75, 19.01]),
        (10, [21.94, 23.72, 20.16, 21.95]),
        (18, [22.35, 23.98, 20.76, 22.39]),
    ];
    for (room, expected) in published {
        let views = [("crosswise", 0), ("crosswise", 4), ("endwise", 0), ("endwise", 4)];
        for ((view, column), expected) in views.into_iter().zip(expected) {
            let found = ldt[view][room][column].as_f64().unwrap();
            assert!(
                (found - expected).abs() < 0.4,
                "room {room}, {view}: {found} for {expected}"
            );
        }
    }
    // The lamp of the LM-63 file lies along C0, and so does its length.
    let ies = ies_lamp("0.1 1.2 0.05");
    assert_eq!(apart(&ugr(&ies), &ldt), 0.0);
    for (target, bytes) in written(&ies) {
        let back = read(&bytes, &format!("lamp.{target}"));
        assert_eq!(back.luminaire.luminous_width_mm, Some(1200.0), "{target}: along C0");
        assert_eq!(back.luminaire.luminous_length_mm, Some(100.0), "{target}: along C90");
        let light = [
            ies.intensity.intensity_cd_at(0.0, 60.0),
            back.intensity.intensity_cd_at(0.0, 60.0),
        ];
        assert!(
            (light[1] / light[0] - 1.0).abs() < 1e-6,
            "{target}: the planes stay where they are"
        );
        // TM-33 has no height.
        let beside = if target == "xml" { 8.0 } else { 0.0 };
        assert!(apart(&ugr(&back), &ldt) <= beside, "{target}");
    }
}

fn written(lamp: &Distribution) -> [(&'static str, Vec<u8>); 3] {
    [
        (
            "ldt",
            eulumdat::write(&lamp.intensity, &lamp.eulumdat_header()).unwrap().bytes,
        ),
        (
            "ies",
            ies::write(&lamp.intensity, &lamp.ies_facts(), ies::Edition::E2002).bytes,
        ),
        ("xml", tm33::write(lamp, tm33::Edition::E2018).bytes),
    ]
}

#[test]
fn a_line_has_no_area_and_becomes_no_circle() {
    for opening in ["0 1.2 0", "1.2 0 0", "0 1.2 0.1", "1.2 0 0.1"] {
        let line = ies_lamp(opening);
        assert_eq!(area_mm2(&line), None, "{opening}");
        assert_eq!(ugr(&line), Value::Null, "{opening}");
        for (target, bytes) in written(&line) {
            let back = read(&bytes, &format!("line.{target}"));
            assert_eq!(area_mm2(&back), None, "{opening} as {target}");
            if target == "ies" {
                assert_eq!(back.luminaire.luminous_body_mm, line.luminaire.luminous_body_mm);
            }
        }
    }
}

#[test]
fn codes_of_shapes_give_their_area_and_stay() {
    let round = std::f64::consts::FRAC_PI_4;
    for (opening, area) in [
        ("-0.2 -0.2 0", 4e4 * round),
        ("-0.2 0 0", 4e4 * round),
        ("-0.2 -0.4 0", 8e4 * round),
        ("-0.2 -0.4 0.1", 8e4 * round),
        ("-0.2 -0.2 -0.2", 4e4 * round),
        ("-0.2 -0.4 -0.3", 8e4 * round),
        ("-0.04 1.2 -0.04", 48e3),
        ("1.2 -0.04 -0.04", 48e3),
        ("0 1.2 -0.04", 48e3),
        ("1.2 0 -0.04", 48e3),
        ("0.2 0.4 0.1", 8e4),
    ] {
        let lamp = ies_lamp(opening);
        assert!((area_mm2(&lamp).unwrap() / area - 1.0).abs() < 1e-12, "{opening}");
        let [_, (_, bytes), _] = written(&lamp);
        let back = read(&bytes, "x.ies");
        assert_eq!(back.luminaire, lamp.luminaire, "{opening} as LM-63 again");
        assert_eq!(ugr(&back), ugr(&lamp), "{opening}");
    }
    assert_eq!(
        area_mm2(&ies_lamp("-0.3 0 -0.3")),
        None,
        "an upright circle is not seen from below"
    );
    let before = read(&ies_file("IESNA:LM-63-1995", 2, "-0.3 0 -0.3"), "x.ies");
    assert!(
        (area_mm2(&before).unwrap() / (9e4 * round) - 1.0).abs() < 1e-12,
        "a sphere until 1995"
    );
}

/// What a conversion to `target` says that it loses, beside keywords.
fn lost(lamp: &Distribution, target: Format) -> Vec<String> {
    let mut lost = lamp.without_field(target, ies::Edition::E2002);
    lost.retain(|lost| !lost.starts_with('['));
    lost
}

#[test]
fn what_a_format_cannot_say_of_an_opening_is_listed() {
    let says = |opening: &str, target: Format, text: &str| {
        let lost = lost(&ies_lamp(opening), target);
        assert!(lost.iter().any(|lost| lost.contains(text)), "{opening}: {lost:?}");
    };
    says("-0.2 -0.4 0", Format::EULUMDAT, "elliptical; written as a rectangle");
    says(
        "-0.2 -0.2 -0.2",
        Format::EULUMDAT,
        "sphere; written as an upright cylinder",
    );
    says("-0.04 1.2 -0.04", Format::EULUMDAT, "written as a box");
    says("0 1.2 0", Format::EULUMDAT, "no area");
    says("0 1.2 0", Format::TM33, "no area");
    says("0.2 0.4 0.1", Format::TM33, "height of the luminous opening, 100 mm");
    says("-0.2 -0.2 0.1", Format::TM33, "height of the luminous opening, 100 mm");
    says("-0.2 -0.2 -0.2", Format::TM33, "shape and height");
    for opening in ["0.2 0.4 0.1", "-0.2 -0.2 0.1", "-0.2 -0.2 0", "0 0 0"] {
        assert_eq!(
            lost(&ies_lamp(opening), Format::EULUMDAT),
            Vec::<String>::new(),
            "{opening}"
        );
    }
    for opening in ["0.2 0.4 0", "-0.2 -0.4 0", "-0.2 -0.2 0"] {
        assert_eq!(
            lost(&ies_lamp(opening), Format::TM33),
            Vec::<String>::new(),
            "{opening}"
        );
    }
    for opening in ["-0.2 -0.4 0", "0 1.2 0", "-0.2 -0.2 -0.2", "0.2 0.4 0.1"] {
        assert_eq!(lost(&ies_lamp(opening), Format::IES), Vec::<String>::new(), "{opening}");
    }
    let uneven = lost(&ldt_lamp([1200.0, 100.0, 50.0, 20.0, 50.0, 20.0]), Format::IES);
    assert!(
        uneven.iter().any(|lost| lost.contains("the largest, 50 mm")),
        "{uneven:?}"
    );
    let even = lost(&ldt_lamp([1200.0, 100.0, 50.0, 50.0, 50.0, 50.0]), Format::IES);
    assert!(!even.iter().any(|lost| lost.contains("heights")), "{even:?}");
}

#[test]
fn a_generation_type_is_lost_in_an_edition_without_one() {
    let of = |code: &str| {
        let text = String::from_utf8(ies_file("IES:LM-63-2019", 2, "0.1 1.2 0.05")).unwrap();
        read(text.replace("\n1 1 40", &format!("\n1 {code} 40")).as_bytes(), "x.ies")
    };
    let accredited = of("1.10000");
    assert_eq!(lost(&accredited, Format::IES), ["file_generation_type"]);
    let kept = accredited.without_field(Format::IES, ies::Edition::E2019);
    assert_eq!(kept, Vec::<String>::new());
    assert_eq!(
        lost(&of("1.00001"), Format::IES),
        Vec::<String>::new(),
        "undefined says nothing"
    );
}
