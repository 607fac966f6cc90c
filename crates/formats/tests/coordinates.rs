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
fn lit(of: impl Fn(f64, f64) -> f64, gamma_end: usize) -> Distribution {
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
    let source = lit(
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
                // Two turns: A first by V about the horizontal axis and then by H about the vertical one, B in the other order.
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
    let even = lit(|_, gamma| 50.0 * (1.0 + gamma.to_radians().cos()), 180);
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
