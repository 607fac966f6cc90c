//! What gives no factor: each kind with its own evidence.

use isolux_app::FailureKind;
use isolux_app::calibration::Instrument;
use isolux_record::station::StationDocument;
use isolux_record::{Quality, ReadingKind, Run, Standard, Station};
use isolux_reduce::standard::{luxmeter, spectroradiometer};

use crate::calibration::lab::Lab;

struct Recorded {
    lab: Lab,
    run: Run,
    text: String,
    table: String,
}

impl Recorded {
    fn of(instrument: Instrument) -> Self {
        let lab = Lab::new(11, |_| {});
        lab.calibrate(instrument).unwrap();
        Self {
            run: Run::read(&lab.run(instrument)).unwrap(),
            text: std::fs::read_to_string(lab.standard()).unwrap(),
            table: std::fs::read_to_string(lab.standard().with_file_name("standard.csv")).unwrap(),
            lab,
        }
    }

    fn standard(&self, edit: impl Fn(&str) -> String) -> Standard {
        let text = edit(&self.text);
        assert_ne!(text, self.text);
        Standard::parse("standard.toml".into(), &text, &|_| Ok(self.table.clone())).unwrap()
    }

    fn refuses(&self, instrument: Instrument, standard: &Standard, edit: impl Fn(&mut Run), expected: &str) {
        let mut run = self.run.clone();
        edit(&mut run);
        let refused = match instrument {
            Instrument::Spectroradiometer => spectroradiometer(&run, standard).map(drop),
            Instrument::Luxmeter => luxmeter(&run, standard).map(drop),
        };
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// The text with another value of a key.
fn with(text: &str, key: &str, value: &str) -> String {
    let set = |line: &str| {
        if line.starts_with(&format!("{key} = ")) {
            format!("{key} = {value}")
        } else {
            line.to_owned()
        }
    };
    text.lines().map(|line| set(line) + "\n").collect()
}

fn without(text: &str, table: &str) -> String {
    let (before, rest) = text.split_once(&format!("[{table}]")).unwrap();
    let after = rest.find("\n[").map_or("", |at| &rest[at..]);
    format!("{before}{after}")
}

fn station(run: &mut Run, edit: impl Fn(&mut StationDocument)) {
    let mut document = run.header.station.document().clone();
    edit(&mut document);
    run.header.station = Station::try_from(document).unwrap();
}

/// The spectra of a block of the procedure, by its number.
fn spectrum(run: &mut Run, number: usize) -> &mut isolux_record::spectra::SpectrumRecord {
    &mut run.spectra[number]
}

#[test]
fn no_factors_of_a_spectroradiometer_without_what_they_need() {
    let recorded = Recorded::of(Instrument::Spectroradiometer);
    let whole = Standard::load(&recorded.lab.standard()).unwrap();
    let of = |standard: &Standard, edit: &dyn Fn(&mut Run), expected: &str| {
        recorded.refuses(Instrument::Spectroradiometer, standard, edit, expected);
    };
    let same = |_: &mut Run| {};
    let expired = |text: &str| with(&with(text, "issued", "\"2020-01-01\""), "expires", "\"2021-01-01\"");
    of(&recorded.standard(expired), &same, "expired on 2021-01-01");
    let later = |text: &str| with(&with(text, "issued", "\"2090-01-01\""), "expires", "\"2091-01-01\"");
    of(&recorded.standard(later), &same, "issued on 2090-01-01");
    of(
        &recorded.standard(|text| without(text, "spectral_irradiance")),
        &same,
        "states no spectral irradiance",
    );
    let far = |text: &str| text.replacen("distance_mm = 500.0", "distance_mm = 300.0", 1);
    of(&recorded.standard(far), &same, "read at 500 mm, certified at 300 mm");
    let other = |text: &str| with(text, "current_a", "2.0100");
    of(&recorded.standard(other), &same, "the certificate is of 2.0100 A");
    let mistyped = recorded.table.replacen("600,", "600,1", 1);
    let mistyped = Standard::parse("standard.toml".into(), &recorded.text, &|_| Ok(mistyped.clone())).unwrap();
    of(&mistyped, &same, "off a filament's curve");

    of(&whole, &|run| run.header.stopped = None, "not finished");
    of(
        &whole,
        &|run| {
            for row in &mut run.readings.rows {
                row.electrical.current_a = None;
            }
        },
        "no reading",
    );
    of(
        &whole,
        &|run| run.readings.rows[1].electrical.current_a = Some(1.99),
        "reading 1: the lamp had 1.9900 A",
    );
    of(
        &whole,
        &|run| spectrum(run, 2).pixels[900].saturated = true,
        "spectra/002.csv: saturated at",
    );
    of(
        &whole,
        &|run| run.spectra.retain(|record| record.kind != ReadingKind::Baffled),
        "behind the baffle",
    );
    of(
        &whole,
        &|run| drop(run.spectra.remove(5)),
        "second spectrum at the longest",
    );
    of(
        &whole,
        &|run| drop(run.spectra.drain(1..5)),
        "at a shorter integration time",
    );
    // The light of one spectrum, which its dark is under.
    let brighter = |number: usize, by: f64| {
        move |run: &mut Run| {
            for pixel in &mut spectrum(run, number).pixels {
                pixel.counts += (by - 1.0) * (pixel.counts - pixel.dark_counts);
            }
        }
    };
    of(&whole, &brighter(4, 1.012), "not linear: pixels at");
    of(&whole, &brighter(4, 0.988), "not linear: pixels at");
    of(&whole, &brighter(5, 1.03), "the light changed by +3.0");
    for (edit, key) in [
        (
            (|of: &mut StationDocument| of.spectroradiometer.as_mut().unwrap().u_wavelength_nm = None)
                as fn(&mut StationDocument),
            "spectroradiometer.u_wavelength_nm",
        ),
        (
            |of| of.spectroradiometer.as_mut().unwrap().u_distance_mm = None,
            "spectroradiometer.u_distance_mm",
        ),
        (|of| of.bench.u_gamma_deg = None, "bench.u_gamma_deg"),
        (|of| of.powermeter = None, "powermeter.u_current_rel"),
    ] {
        of(&whole, &|run| station(run, edit), key);
    }
}

#[test]
fn no_factor_of_a_lux_meter_without_what_it_needs() {
    let recorded = Recorded::of(Instrument::Luxmeter);
    let whole = Standard::load(&recorded.lab.standard()).unwrap();
    let of = |standard: &Standard, edit: &dyn Fn(&mut Run), expected: &str| {
        recorded.refuses(Instrument::Luxmeter, standard, edit, expected);
    };
    let same = |_: &mut Run| {};
    of(
        &recorded.standard(|text| without(text, "illuminance")),
        &same,
        "states no illuminance",
    );
    let hotter = |text: &str| with(text, "colour_temperature_k", "3000");
    of(&recorded.standard(hotter), &same, "the standard has 3000 K");
    let far = |text: &str| text.replacen("distance_mm = 2000.0", "distance_mm = 1000.0", 1);
    of(&recorded.standard(far), &same, "read at 2000 mm, certified at 1000 mm");
    let full = |run: &mut Run| {
        run.readings.rows[2].quality = Quality::OverRange;
        run.readings.rows[2].illuminance_lx = None;
    };
    of(&whole, &full, "reading 2: over_range");
    of(
        &whole,
        &|run| run.readings.rows.retain(|row| row.kind != ReadingKind::Baffled),
        "behind the baffle",
    );
    of(
        &whole,
        &|run| run.readings.rows.truncate(20),
        "before and after the baffle",
    );
    let brighter = |run: &mut Run| {
        for row in run.readings.rows.iter_mut().skip(40) {
            row.illuminance_lx = row.illuminance_lx.map(|lx| 1.02 * lx);
        }
    };
    of(&whole, &brighter, "the light changed by +1.9");
}

#[test]
fn a_bench_that_cannot_calibrate_is_refused_before_anything_is_opened() {
    for (name, from, to, expected) in [
        (
            "station.toml",
            "u_wavelength_nm = 0.1\n",
            "",
            "spectroradiometer.u_wavelength_nm",
        ),
        (
            "station.toml",
            "u_current_rel = 0.0005\n",
            "",
            "powermeter.u_current_rel",
        ),
        (
            "standard.toml",
            "distance_mm = 500.0",
            "distance_mm = 900.0",
            "certified at 900 mm",
        ),
    ] {
        let lab = Lab::new(1, |_| {});
        lab.edit(name, from, to);
        let failure = lab.calibrate(Instrument::Spectroradiometer).unwrap_err();
        assert!(failure.message.contains(expected), "{failure}");
        assert!(!lab.run(Instrument::Spectroradiometer).exists());
    }
    let lab = Lab::new(1, |_| {});
    let text = std::fs::read_to_string(lab.standard()).unwrap();
    let text = with(&with(&text, "issued", "\"2020-01-01\""), "expires", "\"2021-01-01\"");
    std::fs::write(lab.standard(), text).unwrap();
    let failure = lab.calibrate(Instrument::Luxmeter).unwrap_err();
    assert_eq!(failure.kind, FailureKind::BadInput);
    assert!(
        failure.message.contains("expired") && !lab.run(Instrument::Luxmeter).exists(),
        "{failure}"
    );
}

#[test]
fn a_room_with_another_current_or_a_bent_instrument_gives_no_factor() {
    let lab = Lab::new(12, |room| room.lamp.current_error_rel = 0.005);
    let failure = lab.calibrate(Instrument::Luxmeter).unwrap_err();
    assert_eq!(failure.kind, FailureKind::No);
    assert!(failure.message.contains("the certificate is of 2.0000 A"), "{failure}");
    let lab = Lab::new(13, |room| room.spectroradiometer.nonlinearity_error = 0.03);
    let failure = lab.calibrate(Instrument::Spectroradiometer).unwrap_err();
    assert_eq!(failure.kind, FailureKind::No);
    assert!(failure.message.contains("not linear"), "{failure}");
    assert!(!lab.run(Instrument::Spectroradiometer).join("calibration").exists());
}
