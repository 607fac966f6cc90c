//! The near field of two circles is that of any radial profile: of a disc and of three rings.

use isolux_model::{Effect, Emitter, Luminaire, Model, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

const N: i32 = 8;

fn model(emitter: Emitter) -> Model {
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let intensity_cd = gamma_deg
        .iter()
        .map(|gamma| 300.0 * gamma.to_radians().cos().powi(N))
        .collect();
    let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap();
    Model::of(Luminaire::new(distribution, emitter, Spectral::None))
}

/// Readings of γ from 0 to 40° at 150 to 600 mm.
fn readings(model: &Model) -> Vec<f64> {
    let at = |distance_mm: f64, gamma_deg: f64| ReadingCoordinates {
        kind: ReadingKind::Lit,
        time_s: Some(0.0),
        lamp_s: None,
        c_deg: 0.0,
        gamma_deg,
        distance_mm,
        travel: 0,
        range: None,
        ambient_c: None,
        head: 0,
    };
    let places = [150.0, 300.0, 600.0]
        .into_iter()
        .flat_map(|mm| (0..=8).map(move |k| at(mm, 5.0 * f64::from(k))));
    places.map(|place| model.predict_reading(&place)).collect()
}

fn circles(keys: &[(&str, f64)]) -> Vec<f64> {
    let effect = Effect::from_keys("near_field", keys.iter().copied()).unwrap();
    readings(&model(Emitter::Point {}).with_effects(vec![effect]))
}

fn apart(found: &[f64], truth: &[f64]) -> f64 {
    let ratio = found
        .iter()
        .zip(truth)
        .map(|(found, truth)| (found / truth - 1.0).abs());
    ratio.fold(0.0, f64::max)
}

/// Two radii and the share of the inner one whose moments of r², up to the third, are those of a profile
/// (radius, share): the roots of its orthogonal polynomial of degree 2.
fn two_circles(profile: &[(f64, f64)]) -> [f64; 3] {
    let moment = |power: i32| -> f64 { profile.iter().map(|(r, share)| share * (r * r).powi(power)).sum() };
    let (m1, m2, m3) = (moment(1), moment(2), moment(3));
    let determinant = m2 - m1 * m1;
    let (b, c) = ((m1 * m2 - m3) / determinant, (m1 * m3 - m2 * m2) / determinant);
    let root = (b * b / 4.0 - c).sqrt();
    let (inner, outer) = (-b / 2.0 - root, -b / 2.0 + root);
    [outer.sqrt(), (outer - m1) / (outer - inner), (inner / outer).sqrt()]
}

fn of(profile: &[(f64, f64)]) -> Vec<f64> {
    let [radius_mm, share, inner] = two_circles(profile);
    let keys = [
        ("radius_mm", radius_mm),
        ("inner_share", share),
        ("inner_radius_rel", inner),
    ];
    circles(&keys)
}

/// Circles of LEDs that stand for their own light.
fn rings(profile: &[(f64, f64)]) -> Vec<f64> {
    readings(&model(Emitter::Leds {
        position_mm: Vec::new(),
        weight: profile.iter().map(|(_, share)| *share).collect(),
        radius_mm: profile.iter().map(|(radius, _)| *radius).collect(),
        count: vec![36; profile.len()],
        aim_deg: 0.0,
    }))
}

#[test]
fn two_circles_are_a_disc_or_rings_and_one_is_neither() {
    let disc = (0..30).map(|k| (30.0 * ((f64::from(k) + 0.5) / 30.0).sqrt(), 1.0));
    let profiles = [disc.collect::<Vec<_>>(), vec![(10.0, 1.0), (22.0, 1.0), (34.0, 1.0)]];
    for profile in profiles {
        let total = profile.len() as f64;
        let profile: Vec<(f64, f64)> = profile.iter().map(|(r, share)| (*r, share / total)).collect();
        let mean_square: f64 = profile.iter().map(|(r, share)| r * r * share).sum();
        let truth = rings(&profile);
        let two = apart(&of(&profile), &truth);
        let one = apart(&circles(&[("radius_mm", mean_square.sqrt())]), &truth);
        assert!(two < 4e-4 && one > 8.0 * two, "{} circles: {two} {one}", profile.len());
    }
}

#[test]
fn a_share_above_one_is_refused() {
    let keys = [("radius_mm", 30.0), ("inner_share", 1.2)];
    let refused = Effect::from_keys("near_field", keys).unwrap_err().to_string();
    assert!(
        refused.contains("inner_share = 1.2") && refused.contains("from 0 to 1"),
        "{refused}"
    );
}
