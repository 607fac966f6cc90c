//! Every twin of the table in place of the default one: its driver, over its bytes, finds the same room in virtual
//! time.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::init;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::{Darkroom, Instrument};
use isolux_record::spectra::DarkSubtraction;
use isolux_record::{Plan, Quality, Role, Run};
use isolux_virtual::twins::{Choice, TWINS};

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 90]
gamma_deg = [-60, -30, 0, 30, 60]
distance_mm = 2000.0
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_deg = [0, 60]
distance_mm = 2000.0
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 2
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 2
"#;

/// Scans the plan with the twins of `choice`, as a station that names their drivers asks for.
fn scan_with(choice: &Choice) -> Run {
    let (station, calibration) = init::virtual_station(choice).unwrap();
    let source = StationFiles::from_text(&station, calibration.as_deref()).unwrap();
    let plan = Plan::parse(Utf8Path::new("plan.toml"), PLAN).unwrap();
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let summary = session::run(true, async {
        let session = Session::of(&source.station, Utf8Path::new("station.toml"), &Silent)?;
        for instrument in choice.instruments() {
            let (requested, played) = (choice.twin(instrument), session.room.as_ref().unwrap().twin(instrument));
            assert_eq!(
                requested.unwrap().driver,
                played.unwrap().driver,
                "{}",
                instrument.name()
            );
        }
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let job = ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(Target::New(&path), false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await
    });
    let summary = summary.unwrap();
    let run = Run::read(&path).unwrap();
    let drivers: Vec<&str> = choice
        .instruments()
        .filter_map(|instrument| Some(choice.twin(instrument)?.driver))
        .collect();
    let lost: Vec<_> = run
        .readings
        .rows
        .iter()
        .filter(|row| row.quality != Quality::Ok)
        .collect();
    assert_eq!(
        (summary.spectra, summary.without_number),
        (1, 0),
        "{drivers:?}: {lost:?}"
    );
    run
}

/// Block, C, γ, illuminance and digit of the points.
fn points(run: &Run) -> Vec<(String, f64, f64, f64, f64)> {
    let points = run.readings.rows.iter().filter(|row| row.role == Role::Point);
    let points = points.inspect(|row| assert_eq!(row.quality, Quality::Ok, "{row:?}"));
    let point = |row: &isolux_record::Reading| {
        let (lux, digit) = (row.illuminance_lx.unwrap(), row.digit_lx.unwrap());
        (row.block.clone(), row.c_target_deg, row.gamma_target_deg, lux, digit)
    };
    points.map(point).collect()
}

/// Irradiance of the spectrum from 430 nm to 670 nm, by trapezia over whatever pixels the instrument has.
fn irradiance_w_m2(run: &Run) -> f64 {
    let calibration = run.header.spectral.as_ref().unwrap();
    let spectrum = run.spectra[0]
        .irradiance(calibration, DarkSubtraction::Spectrum)
        .unwrap();
    let pixels = run.spectra[0].pixels.iter().zip(&spectrum.irradiance_w_m2_nm);
    let points: Vec<(f64, f64)> = pixels
        .filter(|(pixel, _)| (430.0..670.0).contains(&pixel.wavelength_nm))
        .map(|(pixel, value)| (pixel.wavelength_nm, value.expect("not saturated")))
        .collect();
    let trapezia = points
        .windows(2)
        .map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0));
    trapezia.sum()
}

#[test]
fn every_twin_scans_in_place_of_the_default_one() {
    let default = scan_with(&Choice::default());
    let expected = points(&default);
    assert!(expected.len() >= 14);
    let offset_lx = Darkroom::built_in().unwrap().injected_effects.dark_offset.offset_lx;
    // No station has an oscilloscope: it records the light by itself.
    for twin in TWINS.iter().filter(|twin| twin.instrument != Instrument::Oscilloscope) {
        let mut choice = Choice::default();
        choice.choose(twin.instrument, twin.driver).unwrap();
        let found = scan_with(&choice);
        let points = points(&found);
        assert_eq!(points.len(), expected.len(), "{}", twin.driver);
        for (here, there) in points.iter().zip(&expected) {
            assert_eq!(
                (&here.0, here.1, here.2),
                (&there.0, there.1, there.2),
                "{}",
                twin.driver
            );
            // Two readings of another moment: their digits, their noise, and the lamp's drift in between.
            let allowed = here.4.max(there.4) + 6.0 * 0.0012 * there.3 + 0.003 * there.3;
            // Where a spectrometer stands in the place of the lux meter, the offset of that one is not there.
            let allowed = allowed + if twin.noise_lx.is_some() { offset_lx } else { 0.0 };
            assert!(
                (here.3 - there.3).abs() <= allowed,
                "{}: {here:?} {there:?}",
                twin.driver
            );
        }
        let (found, expected) = (irradiance_w_m2(&found), irradiance_w_m2(&default));
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{}: {found} {expected} W/m²",
            twin.driver
        );
    }
}
