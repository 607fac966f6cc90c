//! Each edit on an asymmetric lamp, written and read again.

use isolux_formats::{Content, Distribution, Edit, Symmetry, eulumdat, read_any};
use isolux_photometry::IntensityDistribution;

/// An asymmetric lamp: 24 half-planes, brighter towards C 30°.
fn lamp() -> Distribution {
    let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let gamma_deg: Vec<f64> = (0..37).map(|k| 5.0 * f64::from(k)).collect();
    let value = |c: f64, gamma: f64| {
        let along = (1.0 + 0.3 * (c - 30.0).to_radians().cos() * gamma.to_radians().sin()).max(0.0);
        200.0 * along * gamma.to_radians().cos().max(0.0)
    };
    let rows = c_deg
        .iter()
        .flat_map(|&c| gamma_deg.iter().map(move |&gamma| value(c, gamma)))
        .collect();
    let header = eulumdat::Header {
        name: "Ring".to_owned(),
        date_user: "2026-11-22".to_owned(),
        length_mm: Some(300.0),
        width_mm: Some(100.0),
        luminous_height_mm: [Some(1.0), Some(2.0), Some(3.0), Some(4.0)],
        lamp_sets: vec![eulumdat::LampSet {
            count: Some(1.0),
            flux_lm: Some(1000.0),
            ..eulumdat::LampSet::default()
        }],
        ..eulumdat::Header::default()
    };
    let grid = IntensityDistribution::new(c_deg, gamma_deg, rows).unwrap();
    read(&eulumdat::write(&grid, &header).unwrap().bytes)
}

fn read(bytes: &[u8]) -> Distribution {
    match read_any(bytes, "lamp.ldt").remove(0).document {
        Some(Content::Distribution(distribution)) => *distribution,
        _ => panic!("no distribution"),
    }
}

/// What a file of the edited distribution says, read again.
fn written(edited: &Distribution) -> Distribution {
    let header = &edited.eulumdat.as_ref().unwrap().header;
    read(&eulumdat::write(&edited.intensity, header).unwrap().bytes)
}

#[test]
fn a_turn_moves_the_light_and_the_sizes_and_back_again() {
    let lamp = lamp();
    let (turned, notes) = lamp.edited(&[Edit::RotateC(90.0)]).unwrap();
    assert_eq!(notes.len(), 1);
    let file = written(&turned);
    for (c, gamma) in [(0.0, 40.0), (120.0, 25.0), (345.0, 70.0)] {
        let (there, here) = (
            file.intensity.intensity_cd_at(c, gamma),
            lamp.intensity.intensity_cd_at(c - 90.0, gamma),
        );
        assert!((there - here).abs() < 1e-3, "{c} {gamma}: {there} {here}");
    }
    assert_eq!(
        (file.luminaire.length_mm, file.luminaire.width_mm),
        (Some(100.0), Some(300.0))
    );
    assert_eq!(
        file.luminaire.luminous_height_mm,
        [Some(4.0), Some(1.0), Some(2.0), Some(3.0)]
    );
    assert!(
        file.luminaire.date.contains("isolux: turned 90 deg"),
        "{}",
        file.luminaire.date
    );
    let (back, _) = turned.edited(&[Edit::RotateC(-90.0)]).unwrap();
    assert_eq!(back.intensity, lamp.intensity);
    // Between the half-planes: the old ones are kept.
    let (between, _) = lamp.edited(&[Edit::RotateC(7.0)]).unwrap();
    assert_eq!(between.intensity.c_deg(), lamp.intensity.c_deg());
    let flux = |of: &Distribution| of.intensity.flux_lm();
    assert!((flux(&between) / flux(&lamp) - 1.0).abs() < 1e-9);
}

#[test]
fn the_record_of_the_changes_has_room_in_a_full_line() {
    let mut lamp = lamp();
    let full = "Converted by an editor of another maker, version 1.3.3.0, on 07-02-2022 by him";
    lamp.eulumdat.as_mut().unwrap().header.date_user = full.to_owned();
    let (edited, notes) = lamp.edited(&[Edit::RotateC(90.0), Edit::ScaleFlux(1234.0)]).unwrap();
    let date = written(&edited).luminaire.date;
    assert!(date.starts_with("Converted by an editor"), "{date}");
    assert!(date.ends_with("; isolux: turned 90 deg, flux 1234 lm"), "{date}");
    assert!(notes.iter().any(|note| note.code == "convert-date-cut"));
}

#[test]
fn symmetry_is_a_mean_and_keeps_the_flux() {
    let lamp = lamp();
    for symmetry in [
        Symmetry::Rotational,
        Symmetry::C0C180,
        Symmetry::C90C270,
        Symmetry::Quadrant,
    ] {
        let (even, _) = lamp.edited(&[Edit::Symmetrize(symmetry)]).unwrap();
        assert_eq!(even.symmetry, symmetry);
        let ratio = even.intensity.flux_lm() / lamp.intensity.flux_lm();
        assert!((ratio - 1.0).abs() < 1e-9, "{symmetry:?}: {ratio}");
    }
}

#[test]
fn flux_grid_and_description() {
    let lamp = lamp();
    let edits = [
        Edit::Resample(30.0, 2.5),
        Edit::ScaleFlux(800.0),
        Edit::Set("luminaire.name".to_owned(), "Ring 2".to_owned()),
        Edit::Set("luminaire.watts".to_owned(), "9.5".to_owned()),
    ];
    let (edited, notes) = lamp.edited(&edits).unwrap();
    assert_eq!(notes.len(), 4);
    let file = written(&edited);
    assert!((file.intensity.flux_lm() - 800.0).abs() < 0.01);
    assert_eq!(
        (file.intensity.c_deg().len(), file.intensity.gamma_deg().len()),
        (12, 73)
    );
    assert_eq!(
        (file.luminaire.name.as_str(), file.luminaire.watts),
        ("Ring 2", Some(9.5))
    );
    for wrong in [
        Edit::Resample(7.0, 5.0),
        Edit::Resample(15.0, 0.001),
        Edit::ScaleFlux(0.0),
        Edit::ScaleFlux(f64::INFINITY),
        Edit::RotateC(f64::NAN),
        Edit::Set("luminaire.nmae".to_owned(), "x".to_owned()),
        Edit::Set("luminaire.watts".to_owned(), "many".to_owned()),
        Edit::Set("luminaire.name".to_owned(), "two\nlines".to_owned()),
    ] {
        assert!(lamp.edited(std::slice::from_ref(&wrong)).is_err(), "{wrong:?}");
    }
}
