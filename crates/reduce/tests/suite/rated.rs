//! Ratings and the EU label of runs made from closed forms; what is not stated or not measured is not known.

use isolux_photometry::Sector;
use isolux_photometry::ratings::LcsZone;
use isolux_record::Electrical;

use super::*;
use isolux_reduce::eu_label::{Class, Cone, Known, label};
use isolux_reduce::ratings::{flux_share, hazard_distance, outdoor, photon_flux, rated_colour, sector_flux};

const PI: f64 = std::f64::consts::PI;
/// A power meter of 0.2 %.
const POWERMETER: &str = "[powermeter]\nopen = \"scpi-meter:/dev/x?profile=gpm-8213\"\nu_power_rel = 0.002\n";

/// A day of a lamp of 337·cosⁿγ cd at a supply of so many watts.
fn lit(n: i32, watts: Option<f64>) -> Run {
    let mut rows = day(|lux| lux, 0.0);
    for row in &mut rows {
        row.electrical = Electrical {
            power_w: watts,
            power_factor: watts.map(|_| 0.9),
            ..Electrical::default()
        };
        if row.kind == ReadingKind::Lit {
            let (c, gamma) = (row.c_target_deg, row.gamma_deg);
            let narrower = 337.0 * gamma.to_radians().cos().max(0.0).powi(n) - lamp(c, gamma);
            row.illuminance_lx = row.illuminance_lx.map(|lux| lux + narrower / 100.0);
        }
    }
    let mut run = run(rows);
    let text = format!("{STATION}{POWERMETER}");
    run.header.station = Station::parse(Utf8Path::new("s.toml"), &text).unwrap();
    run
}

fn of(run: &Run) -> Reduction {
    let options = Options {
        without: [Correction::Smoothing].into_iter().collect(),
        accept_drift: Some("a test".to_owned()),
    };
    reduce(run, &options, None).unwrap()
}

fn with_label(mut run: Run, mains: Option<bool>) -> Run {
    run.header.eu_label.mains = mains;
    run.header
        .eu_label
        .stated
        .insert("cap_type".to_owned(), "E27".to_owned());
    run
}

fn known<'a>(label: &'a isolux_reduce::eu_label::Label, name: &str) -> &'a Known {
    &label.rows.iter().find(|row| row.name == name).unwrap().known
}

#[test]
fn a_cone_has_its_part_of_the_flux_and_of_its_uncertainty() {
    let reduction = of(&lit(1, None));
    // I = I₀·cos γ: Φ(γ) = π·I₀·sin²γ.
    let wide = sector_flux(&reduction, &Sector::zone(0.0, 60.0)).unwrap();
    assert!((wide.value / (0.75 * PI * 337.0) - 1.0).abs() < 1e-3, "{wide:?}");
    let calibration = |quantity: &isolux_reduce::Quantity| quantity.parts["calibration"] / quantity.value;
    assert!((calibration(&wide) - calibration(&reduction.flux)).abs() < 1e-12);
    let share = flux_share(&reduction, &Sector::zone(0.0, 60.0)).unwrap();
    assert!((share.value - 75.0).abs() < 0.1, "{share:?}");
    assert!(
        share.parts["calibration"].abs() < 1e-9 && share.parts["distance"].abs() < 1e-9,
        "{share:?}"
    );
    assert!(share.parts["angle"] > 0.0 && share.u_of_parts < 1.0, "{share:?}");
    let whole = sector_flux(&reduction, &Sector::zone(0.0, 180.0)).unwrap();
    for (name, part) in &reduction.flux.parts {
        assert!((whole.parts[name] - part).abs() < 1e-9 * reduction.flux.value, "{name}");
    }
}

#[test]
fn the_class_is_that_of_the_useful_flux_over_the_power() {
    // cos γ: 75 % within 120°, not directional, all of the flux counts: 1058.7 lm.
    let flux_lm = PI * 337.0;
    for (mains, factor) in [(true, 1.0), (false, 0.926)] {
        let run = with_label(lit(1, Some(flux_lm / 137.0)), Some(mains));
        let label = label(&of(&run), &run).unwrap().unwrap();
        assert!(
            !label.directional.is_directional && label.cone == Cone::Sphere,
            "{label:?}"
        );
        let efficacy = label.efficacy.clone().unwrap();
        assert!((efficacy.value / (factor * 137.0) - 1.0).abs() < 2e-3, "{efficacy:?}");
        assert_eq!(label.class, Some(if mains { Class::D } else { Class::E }));
        let sum: f64 = label.probabilities.iter().map(|(_, share)| share).sum();
        assert!((sum - 1.0).abs() < 3e-3, "{:?}", label.probabilities);
        // 137 lm/W with 0.8 % of the lux meter: E is not out of reach.
        let other = label.probabilities.iter().find(|(class, _)| *class == Class::E);
        assert!(other.is_some(), "{:?}", label.probabilities);
    }
    // cos³: beam 75°, 93.75 % within 120°, so the flux of the cone of 90° counts: 1 − cos⁴45° = 75 %.
    let flux_lm = 2.0 * PI * 337.0 / 4.0;
    let run = with_label(lit(3, Some(flux_lm / 100.0)), Some(true));
    let narrow = label(&of(&run), &run).unwrap().unwrap();
    assert!(
        narrow.directional.is_directional && narrow.cone == Cone::Narrow,
        "{narrow:?}"
    );
    assert!((narrow.directional.share.value - 93.75).abs() < 0.1, "{narrow:?}");
    assert!(
        (narrow.useful_flux.value / (0.75 * flux_lm) - 1.0).abs() < 3e-3,
        "{narrow:?}"
    );
    let efficacy = narrow.efficacy.clone().unwrap().value;
    assert!((efficacy / (1.176 * 75.0) - 1.0).abs() < 4e-3, "{efficacy}");
    assert_eq!(narrow.class, Some(Class::F));
    let Known::Measured { value, .. } = known(&narrow, "beam_angle") else {
        panic!("{narrow:?}")
    };
    assert_eq!(value, "75");
}

#[test]
fn what_is_left_out_is_not_known_and_makes_no_class() {
    let run = lit(1, Some(8.0));
    let reduction = of(&run);
    assert_eq!(label(&reduction, &run).unwrap(), None, "no table, no label");
    let no_mains = with_label(lit(1, Some(8.0)), None);
    let found = label(&reduction, &no_mains).unwrap().unwrap();
    assert_eq!((found.class, found.f_tm), (None, None));
    assert!(found.sentence().contains("eu_label.mains"), "{}", found.sentence());
    let no_power = with_label(lit(1, None), Some(true));
    let found = label(&of(&no_power), &no_power).unwrap().unwrap();
    assert_eq!(found.class, None);
    assert!(
        found.probabilities.is_empty() && found.sentence().contains("power meter"),
        "{}",
        found.sentence()
    );
    for name in [
        "on_mode_power",
        "energy_class",
        "cct",
        "cri",
        "displacement_factor",
        "lifetime_h",
        "colour_consistency",
    ] {
        assert!(matches!(known(&found, name), Known::NotKnown(_)), "{name}");
    }
    assert_eq!(known(&found, "cap_type"), &Known::Stated("E27".to_owned()));
    // A power factor is no displacement factor.
    let with_power = label(&reduction, &no_mains).unwrap().unwrap();
    assert!(matches!(known(&with_power, "displacement_factor"), Known::NotKnown(why) if why.contains("cos φ1")));
    // A meter of unknown uncertainty: the class stands, how probable another is does not.
    let mut no_u = with_label(lit(1, Some(8.0)), Some(true));
    no_u.header.station = Station::parse(
        Utf8Path::new("s.toml"),
        &format!("{STATION}{}", POWERMETER.replace("u_power_rel = 0.002\n", "")),
    )
    .unwrap();
    let found = label(&of(&no_u), &no_u).unwrap().unwrap();
    assert!(found.class.is_some() && found.probabilities.is_empty(), "{found:?}");
    // No spectrum: no photons, no hazard distance, no rated colour; no street side: no zones.
    assert_eq!(photon_flux(&reduction), None);
    assert_eq!(hazard_distance(&reduction), None);
    let mut rated = run;
    rated.header.ratings.rated_cct_k = Some(3000.0);
    assert_eq!(rated_colour(&reduction, &rated), None);
    assert_eq!(outdoor(&reduction, &rated).unwrap(), None);
}

#[test]
fn the_file_has_a_line_for_every_row_and_its_words_stay_in_their_cells() {
    let mut run = with_label(lit(3, Some(5.3)), Some(true));
    let stated = &mut run.header.eu_label.stated;
    stated.insert("supplier_address".to_owned(), "1, Street \"North\"".to_owned());
    let reduction = of(&run);
    let files = isolux_reduce::files(&reduction, &run, &[], "isolux test").unwrap();
    let file = files.iter().find(|file| file.name == "eu_label.csv").unwrap();
    let text = std::str::from_utf8(&file.bytes).unwrap();
    let label = label(&reduction, &run).unwrap().unwrap();
    assert_eq!(text.lines().count(), 1 + label.rows.len());
    assert!(
        text.contains("\nsupplier_address,\"1, Street \"\"North\"\"\",,,,,stated\n"),
        "{text}"
    );
    assert!(text.contains("\nenergy_consumption,6,kWh/1000 h,5.3"), "{text}");
    assert!(text.contains("\nenergy_class,F,,"), "{text}");
}

#[test]
fn zones_of_a_street_side_have_uncertainty_and_so_has_no_uplight() {
    let mut run = lit(1, None);
    run.header.ratings.street_side_c_deg = Some(90.0);
    let found = outdoor(&of(&run), &run).unwrap().unwrap();
    let of_zone = |zone: LcsZone| found.zones[zone as usize].1.clone().unwrap();
    // Half of π·I₀·(sin²60° − sin²30°).
    assert!(
        (of_zone(LcsZone::Bm).value / (0.25 * PI * 337.0) - 1.0).abs() < 2e-3,
        "{found:?}"
    );
    assert!(of_zone(LcsZone::Bm).u.unwrap() > 0.0);
    // BM 265 lm and BL, BH of 132 lm and 116 lm: B1.
    assert_eq!(found.backlight, 1, "{found:?}");
    let unseen = found.uplight_unseen_lm.unwrap();
    assert!(unseen > 0.0 && unseen < 20.0, "{found:?}");
    assert!(found.uplight.unwrap() <= 1, "{found:?}");
}
