//! What every effect of the catalogue must keep: its keys, its null, its stages, its inverse.

use camino::Utf8PathBuf;
use isolux_model::{Effect, EffectSpec, Emitter, Luminaire, Model, Role, Spectral, Stage, catalogue, effects::by_name};
use isolux_photometry::IntensityDistribution;
use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, Need, Observations, ReadingCoordinates, SpectraSet, open};
use isolux_spectrum::Spectrum;
use proptest::prelude::*;

/// The names, owners and keys that model files rely on.
const KEYS: &str = "\
ambient_stray | bench | illuminance_lx
ambient_light | sensor | illuminance_lx, irradiance_w_m2
dark_offset | bench, sensor | offset_lx, offset_rel
floor_reflection | bench | albedo, height_mm
distance_offset | bench | offset_mm
axial_centre | bench | offset_mm
lateral_centre | bench | offset_mm, azimuth_deg
near_field | luminaire | radius_mm, aim_deg, inner_share, inner_radius_rel
gamma_zero | bench | offset_deg
gamma_sag | bench | amplitude_deg
c_zero | bench | offset_deg
luminaire_tilt | bench | angle_deg, azimuth_deg
axis_nonperp | bench | angle_deg
backlash | bench | width_deg
nonlinearity | bench, sensor | inverse_scale_per_lx, inverse_scale
range_step | bench | factor_rel, range
temp_coefficient | bench | coefficient_per_k, reference_c
lamp_warmup | luminaire | amplitude_rel, time_constant_s
lamp_drift | luminaire | rate_per_h, reference_s
light_level | luminaire | factor_rel
beam_width | luminaire | exponent
flicker_alias | luminaire | amplitude_rel, period_s, phase_rad
dead_sector | luminaire | depth_rel, azimuth_deg, width_deg, aim_deg
self_absorption | luminaire | depth_rel, azimuth_deg, gamma_deg, width_deg
polarization | bench | amplitude_rel, azimuth_deg
detector_aperture | bench | diameter_mm
cosine_f2 | bench | coefficient_rel
spectral_mismatch | bench | factor, slope_per_deg
colour_over_angle | luminaire | sensor_rel, head_rel
ler_scale | luminaire | factor
air_absorption | path | coefficient_per_m
spectro_shift | bench | shift_nm
spectro_bandpass | bench | fwhm_nm
spectro_stray | bench | fraction
spectro_2nd | bench | fraction
spectro_dark | bench | offset
stage_lateral | sensor | offset_mm, azimuth_deg
sensor_axial | sensor | offset_mm
sensor_tilt | sensor | angle_deg, azimuth_deg
source_tilt | sensor | angle_deg, azimuth_deg
cover_glass | sensor | plates, index
pixel_angular | sensor | coefficient
vignetting | sensor | coefficient_rel
prnu_gradient | sensor | gradient_rel, azimuth_deg
flicker_banding | sensor | amplitude_rel, period_mm, phase_rad
ghost | sensor | amplitude_rel, x_mm, y_mm, width_mm
exposure_offset | sensor | offset
saturation | sensor | level_rel
quantization | sensor | step_rel
crosstalk | sensor | width_px";

const COORDINATES: &str = "time_s gamma_deg c_deg distance_mm travel range ambient_c level x_mm y_mm radius_mm incidence_deg \
exposure wavelength_nm";

#[test]
fn names_owners_and_keys_are_the_promised_ones() {
    let found: Vec<String> = catalogue()
        .iter()
        .map(|spec| {
            let owners: Vec<_> = spec.belongs_to.iter().map(|owner| owner.as_str()).collect();
            let keys: Vec<_> = spec.parameters.iter().map(|parameter| parameter.key).collect();
            format!("{} | {} | {}", spec.name, owners.join(", "), keys.join(", "))
        })
        .collect();
    assert_eq!(found, KEYS.lines().collect::<Vec<_>>());
}

#[test]
fn what_is_said_of_an_effect_can_be_used() {
    for spec in catalogue() {
        assert!(
            COORDINATES.split(' ').any(|word| word == spec.shows_in),
            "{}: shows in {}",
            spec.name,
            spec.shows_in
        );
        assert!(
            !spec.acts.is_empty() && !spec.formula.is_empty() && !spec.source.is_empty(),
            "{}",
            spec.name
        );
        for (name, _) in spec.look_alikes {
            let other = by_name(name).unwrap_or_else(|| panic!("{}: {name} is unknown", spec.name));
            assert!(
                other.stages.iter().any(|stage| spec.stages.contains(stage)),
                "{} and {}",
                spec.name,
                other.name
            );
        }
        assert!(
            spec.parameters.len() <= isolux_model::effects::MOST_KEYS,
            "{}",
            spec.name
        );
        assert_eq!(spec.parameters[0].role, Role::Amplitude, "{}", spec.name);
        for parameter in spec.parameters {
            let (low, high) = parameter.plausible;
            assert!(low < high && parameter.step > 0.0, "{} {}", spec.name, parameter.key);
            if let Role::Shape { grid } | Role::Azimuth { grid } = parameter.role {
                assert!(
                    grid.iter().all(|value| (low..=high).contains(value)),
                    "{} {}",
                    spec.name,
                    parameter.key
                );
            }
            assert!(
                parameter.only_on.is_none_or(|stage| spec.stages.contains(&stage)),
                "{} {}",
                spec.name,
                parameter.key
            );
        }
    }
}

/// A luminaire that is neither rotational nor a point, with light at every angle.
fn model() -> Model {
    let c_deg: Vec<f64> = (0..24).map(|i| 15.0 * f64::from(i)).collect();
    let gamma_deg: Vec<f64> = (0..=90).map(|i| 2.0 * f64::from(i)).collect();
    let mut intensity_cd = Vec::new();
    for c in &c_deg {
        for gamma in &gamma_deg {
            let lobe = 300.0 * gamma.to_radians().cos().max(0.0).powi(3) + 5.0;
            let sin = gamma.to_radians().sin();
            let turn =
                1.0 + 0.1 * (2.0 * c).to_radians().cos() * sin * sin + 0.04 * (c - 40.0).to_radians().sin() * sin;
            intensity_cd.push(lobe * turn);
        }
    }
    let distribution = IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap();
    let wavelength_nm: Vec<f64> = (380..=780).step_by(5).map(f64::from).collect();
    let value = wavelength_nm
        .iter()
        .map(|nm| (-((nm - 560.0) / 60.0f64).powi(2)).exp() + 0.1)
        .collect();
    let spectrum = Spectrum::new(wavelength_nm, value).unwrap();
    Model::of(Luminaire::new(
        distribution,
        Emitter::Disc { diameter_mm: 1.0 },
        Spectral::Spectrum(spectrum),
    ))
}

fn maps() -> MapSet {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("maps.toml")).unwrap();
    let pose =
        |name: &str, rest: &str| format!("[[map]]\nname = \"{name}\"\ndistance_mm = 300.0\ntime_s = 400.0\n{rest}\n");
    let text = [
        "sensor_mm = [24.0, 16.0]\nbins = [6, 4]\nunit = \"W/m2\"\nfull_scale = 8.0\n".to_owned(),
        pose("square", ""),
        pose(
            "tilted",
            "tilt_x_deg = 30.0\ntilt_y_deg = -20.0\nrot_z_deg = 40.0\noffset_mm = [5.0, -3.0]\nexposure = 0.7",
        ),
        pose("off", "lamp = false"),
        pose("capped", "capped = true"),
    ]
    .concat();
    std::fs::write(&path, text).unwrap();
    match open(&path, Need::Coordinates).unwrap() {
        Observations::Maps(maps) => maps,
        other => panic!("{other:?}"),
    }
}

fn spectra() -> SpectraSet {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("spectra.toml")).unwrap();
    std::fs::write(
        &path,
        "quantity = \"irradiance\"\nunit = \"W/m2/nm\"\ndistance_mm = 500.0\nc_deg = 10.0\ngamma_deg = 5.0\n",
    )
    .unwrap();
    let rows: Vec<String> = (0..68)
        .map(|i| {
            format!(
                "{i},{},{}\n",
                if i % 7 == 3 { "capped" } else { "lit" },
                385.5 + 6.3 * f64::from(i)
            )
        })
        .collect();
    std::fs::write(
        path.with_extension("csv"),
        format!("index,kind,wavelength_nm\n{}", rows.concat()),
    )
    .unwrap();
    match open(&path, Need::Coordinates).unwrap() {
        Observations::Spectra(spectra) => spectra,
        other => panic!("{other:?}"),
    }
}

fn readings() -> Vec<ReadingCoordinates> {
    let mut readings = Vec::new();
    for (i, kind) in [
        ReadingKind::Lit,
        ReadingKind::Baffled,
        ReadingKind::LampOff,
        ReadingKind::Capped,
    ]
    .into_iter()
    .enumerate()
    {
        for (j, gamma_deg) in [-61.0, -30.5, 0.0, 7.3, 44.0, 70.0].into_iter().enumerate() {
            readings.push(ReadingCoordinates {
                kind,
                time_s: Some(11.0 + 97.0 * (i + 3 * j) as f64),
                lamp_s: None,
                c_deg: 37.0 * j as f64,
                gamma_deg,
                distance_mm: 1000.0 + 500.0 * (j % 3) as f64,
                travel: [1, -1, 0][j % 3],
                range: Some((j % 3) as i32),
                ambient_c: Some(22.0 + j as f64),
                head: (j % 2) as u32,
            });
        }
    }
    readings
}

/// Everything that the model predicts, stage by stage.
fn everything(model: &Model) -> [Vec<f64>; 3] {
    [
        model.predict_readings(&readings()),
        model.predict_maps(&maps()),
        model.predict_spectra(&spectra()).unwrap(),
    ]
}

const STAGES: [Stage; 3] = [Stage::Readings, Stage::Maps, Stage::Spectra];

/// An effect with its amplitudes null and other parameters anywhere in their plausible range.
fn null_with_any_shape(spec: &'static EffectSpec, places: &[f64]) -> Effect {
    let values: Vec<f64> = spec
        .parameters
        .iter()
        .zip(places)
        .map(|(parameter, place)| match parameter.role {
            Role::Amplitude | Role::Alternative => parameter.null,
            Role::RangeId => (place * 3.0).floor(),
            _ => parameter.plausible.0 + place * (parameter.plausible.1 - parameter.plausible.0) * 0.999 + 1e-3,
        })
        .collect();
    Effect::new(spec, &values).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn null_reproduces_the_baseline(places in prop::collection::vec(0.0..1.0f64, 4)) {
        let model = model();
        let baseline = everything(&model);
        for spec in catalogue() {
            let found = everything(&model.with_effects(vec![null_with_any_shape(spec, &places)]));
            for (stage, (found, baseline)) in found.iter().zip(&baseline).enumerate() {
                for (found, baseline) in found.iter().zip(baseline) {
                    let apart = (found - baseline).abs();
                    prop_assert!(apart <= 1e-12 * baseline.abs().max(1.0), "{} on {:?}: {found} for {baseline}", spec.name, STAGES[stage]);
                }
            }
        }
    }
}

#[test]
fn an_effect_changes_its_own_stages_and_no_other() {
    // A light centre beside the axis: otherwise all light meets the detector at right angles, and f2 has nothing to do.
    let beside = Effect::from_keys("lateral_centre", [("offset_mm", 15.0)]).unwrap();
    let model = model().with_effects(vec![beside.clone()]);
    let baseline = everything(&model);
    for spec in catalogue() {
        let values: Vec<f64> = spec
            .parameters
            .iter()
            .map(|parameter| match parameter.role {
                Role::Amplitude => parameter.null + parameter.step,
                Role::RangeId => 1.0,
                _ => parameter.null,
            })
            .collect();
        let found = everything(&model.with_effects(vec![beside.clone(), Effect::new(spec, &values).unwrap()]));
        for (index, stage) in STAGES.into_iter().enumerate() {
            let largest = found[index]
                .iter()
                .zip(&baseline[index])
                .map(|(f, b)| (f - b).abs())
                .fold(0.0, f64::max);
            // The light of the luminaire's own effects also makes the spectrum's level; that is no stage of theirs.
            let level = stage == Stage::Spectra && !spec.belongs_to(isolux_model::BelongsTo::Bench);
            if spec.stages.contains(&stage) {
                assert!(largest > 1e-9, "{} does nothing on {stage:?}", spec.name);
            } else if !level {
                assert!(largest == 0.0, "{} changes {stage:?} by {largest}", spec.name);
            }
        }
    }
}

#[test]
fn what_the_bench_adds_to_a_reading_can_be_taken_out() {
    let base = model();
    let illuminated: Vec<ReadingCoordinates> = readings()
        .into_iter()
        .filter(|at| at.kind == ReadingKind::Lit)
        .collect();
    for spec in catalogue()
        .iter()
        .filter(|spec| spec.belongs_to(isolux_model::BelongsTo::Bench))
    {
        if !spec.stages.contains(&Stage::Readings) || spec.name == "detector_aperture" {
            continue;
        }
        let values: Vec<f64> = spec
            .parameters
            .iter()
            .map(|parameter| match parameter.role {
                Role::Amplitude => parameter.null + 2.0 * parameter.step,
                Role::RangeId => 1.0,
                _ => parameter.null + 0.3 * parameter.step,
            })
            .collect();
        let model = base.with_effects(vec![Effect::new(spec, &values).unwrap()]);
        let corrected = model
            .correct_readings(&illuminated, &model.predict_readings(&illuminated))
            .unwrap();
        for (at, corrected) in illuminated.iter().zip(corrected) {
            let truth = base
                .luminaire()
                .distribution()
                .intensity_cd_at(corrected.c_deg, corrected.gamma_deg);
            let found = corrected.intensity_cd;
            assert!(
                (found / truth - 1.0).abs() < 3e-5,
                "{} at {at:?}: {found} for {truth}",
                spec.name
            );
        }
    }
    let aperture = base.with_effects(vec![
        Effect::from_keys("detector_aperture", [("diameter_mm", 30.0)]).unwrap(),
    ]);
    assert_eq!(
        aperture
            .correct_readings(&illuminated, &vec![1.0; illuminated.len()])
            .unwrap_err()
            .effect,
        "detector_aperture"
    );
}

#[test]
fn several_effects_act_in_the_order_of_the_physics_not_of_the_file() {
    let base = model();
    let one = Effect::from_keys("dark_offset", [("offset_lx", 0.3)]).unwrap();
    let two = Effect::from_keys("nonlinearity", [("inverse_scale_per_lx", 1e-3)]).unwrap();
    let forward = base
        .with_effects(vec![one.clone(), two.clone()])
        .predict_readings(&readings());
    let backward = base.with_effects(vec![two, one]).predict_readings(&readings());
    assert_eq!(forward, backward);
    // The zero is added to what the meter answers, and not itself bent.
    let capped = readings().iter().position(|at| at.kind == ReadingKind::Capped).unwrap();
    assert_eq!(forward[capped], 0.3);
}
