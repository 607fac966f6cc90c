//! What a photometric file is rated by: mean luminance, and the zones of outdoor luminaires with their street side.

use isolux_formats::{Content, Distribution, read_any};
use isolux_photometry::IntensityDistribution;

fn read(text: &str, name: &str) -> Distribution {
    match read_any(text.as_bytes(), name).remove(0).document {
        Some(Content::Distribution(distribution)) => *distribution,
        _ => panic!("{name} holds no distribution"),
    }
}

const STREET: [f64; 5] = [0.0, 45.0, 90.0, 135.0, 180.0];

/// LM-63 of type C, symmetric about C0–C180, γ 0, 45 and `last`°, of an opening in m: `near` cd in C0, down to `far` cd
/// in C180; `at_last` of it at the last γ.
fn lm63(near: f64, far: f64, last: f64, at_last: f64, opening: &str) -> Distribution {
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] b\n[MANUFAC] c\nTILT=NONE\n\
         1 -1 1 3 5 1 2 {opening}\n1 1 10\n0 45 {last}\n0 45 90 135 180\n"
    );
    for c in STREET {
        let cd = near + (far - near) * c / 180.0;
        text += &format!("{0} {cd} {1}\n", 0.5 * (near + far), at_last * cd);
    }
    read(&text, "lamp.ies")
}

/// The same light as EULUMDAT of symmetry 3 has it: the street is C90.
fn eulumdat(near: f64, far: f64) -> Distribution {
    let mut lines: Vec<String> =
        "co 3 3 8 45 3 45 rep x num f d 500 500 60 500 500 0 0 0 0 100 100 1 0 1 -1 l 1000 4000 80 40"
            .split(' ')
            .map(str::to_owned)
            .collect();
    lines.extend(vec!["0".to_owned(); 10]);
    lines.extend((0..8).map(|plane| (45 * plane).to_string()));
    lines.extend([0, 45, 90].map(|gamma| gamma.to_string()));
    // C270 to C90 through C0.
    for c in STREET.into_iter().rev() {
        let cd = near + (far - near) * c / 180.0;
        lines.extend([0.5 * (near + far), cd, 0.0].map(|cd| cd.to_string()));
    }
    read(&(lines.join("\r\n") + "\r\n"), "lamp.ldt")
}

#[test]
fn the_street_side_is_that_of_the_format_or_the_one_that_is_given() {
    let ies = lm63(1000.0, 100.0, 90.0, 0.0, "0 0 0");
    let ldt = eulumdat(1000.0, 100.0);
    let (of_ies, of_ldt) = (ies.quantities().outdoor.unwrap(), ldt.quantities().outdoor.unwrap());
    assert_eq!((of_ies.street_side_c_deg, of_ldt.street_side_c_deg), (0.0, 90.0));
    let zones = |of: &isolux_formats::Outdoor| [of.fl_lm, of.fm_lm, of.fh_lm, of.bl_lm, of.bm_lm, of.bh_lm];
    for (one, other) in zones(&of_ies).into_iter().zip(zones(&of_ldt)) {
        assert!((one / other - 1.0).abs() < 1e-9, "{of_ies:?} {of_ldt:?}");
    }
    let [forward, back] = of_ies.sides_lm();
    assert!(forward > 1.5 * back, "{forward} {back}");
    // The other side: what was forward is back light.
    let turned = ies.outdoor(180.0).unwrap();
    assert!((turned.sides_lm()[1] - forward).abs() < 1e-9, "{turned:?}");
    assert!((of_ies.sides_lm().iter().sum::<f64>() - ies.intensity.flux_lm()).abs() < 1e-9);
}

#[test]
fn there_is_no_classification_where_it_does_not_apply() {
    // No street side: as much light to the one as to the other. With the street given there is one.
    let round = lm63(1000.0, 1000.0, 90.0, 0.0, "0 0 0");
    assert_eq!(round.quantities().outdoor, None);
    assert!(round.outdoor(0.0).is_some());
    // A spot that is tilted a little: more light to one side, and brightest on the axis.
    let mut spot = lm63(1000.0, 100.0, 90.0, 0.0, "0 0 0");
    let cd = vec![1000.0, 400.0, 0.0, 1000.0, 100.0, 0.0];
    spot.intensity = IntensityDistribution::new(vec![0.0, 180.0], vec![0.0, 45.0, 90.0], cd).unwrap();
    assert_eq!(spot.quantities().outdoor, None);
    // Light that goes the other way than the format's convention says.
    assert_eq!(lm63(100.0, 1000.0, 90.0, 0.0, "0 0 0").quantities().outdoor, None);
    // Below the horizontal the distribution ends: nothing is known above, and too little below.
    assert_eq!(lm63(1000.0, 100.0, 80.0, 0.1, "0 0 0").outdoor(0.0), None);
    // It ends at the horizontal in light: backlight has a rating, uplight has none.
    let cut = lm63(1000.0, 100.0, 90.0, 0.1, "0 0 0").outdoor(0.0).unwrap();
    assert_eq!((cut.ul_lm, cut.uh_lm, cut.uplight_rating), (None, None, None));
    let dark = lm63(1000.0, 100.0, 90.0, 0.0, "0 0 0").outdoor(0.0).unwrap();
    assert_eq!(
        (dark.ul_lm, dark.uh_lm, dark.uplight_rating),
        (Some(0.0), Some(0.0), Some(0))
    );
    let up = lm63(1000.0, 100.0, 180.0, 0.01, "0 0 0").outdoor(0.0).unwrap();
    assert!(up.uplight_rating.unwrap() > 1, "{up:?}");
}

#[test]
fn luminance_is_intensity_over_the_area_that_is_seen() {
    // 0.4 m along C0, 0.2 m along C90, flat: at γ 65° the intensity is a line between γ 45° and 90°.
    let lamp = lm63(1000.0, 1000.0, 90.0, 0.0, "0.2 0.4 0");
    let table = lamp.quantities().luminance.unwrap();
    assert_eq!(table.gamma_deg, [55.0, 65.0, 75.0, 85.0]);
    let exact = |gamma: f64| 1000.0 * (90.0 - gamma) / 45.0 / (0.08 * gamma.to_radians().cos());
    for (row, gamma) in table.cd_m2.iter().zip(table.gamma_deg) {
        for cell in row {
            assert!((cell.unwrap() / exact(gamma) - 1.0).abs() < 1e-9, "γ {gamma}: {row:?}");
        }
    }
    assert_eq!(table.c_deg.len(), lamp.intensity.c_deg().len());
    let largest = [65.0, 75.0, 85.0].map(exact).into_iter().fold(0.0, f64::max);
    assert!((table.largest_from_65_cd_m2 / largest - 1.0).abs() < 1e-9, "{table:?}");
    // 0.1 m high: from C0 and γ 85° its side of 0.2 m × 0.1 m is seen as well.
    let high = lm63(1000.0, 1000.0, 90.0, 0.0, "0.2 0.4 0.1")
        .quantities()
        .luminance
        .unwrap();
    let (sin, cos) = 85.0_f64.to_radians().sin_cos();
    let seen_m2 = 0.08 * cos + 0.02 * sin;
    assert!(
        (high.cd_m2[3][0].unwrap() / (1000.0 * 5.0 / 45.0 / seen_m2) - 1.0).abs() < 1e-9,
        "{high:?}"
    );
    // Without a luminous area there is no luminance.
    assert_eq!(lm63(1000.0, 100.0, 90.0, 0.0, "0 0 0").quantities().luminance, None);
}
