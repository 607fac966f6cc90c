//! Every reader of a file that a person or another program may have written.

use std::path::PathBuf;

use camino::Utf8Path;
use glam::DVec3;
use isolux_darkroom::Darkroom;
use isolux_formats::tm25::{Ray, RaySet, Reader};
use isolux_formats::{Content, ReadOptions, WriteOptions, formats, read_any_with, write_distribution, write_spectrum};
use isolux_model::{Model, Scene};
use isolux_modulation::{Camera, Source, Waveform};
use isolux_record::responsivity::WavelengthCurve;
use isolux_record::spectra::{Pixel, SpectralCalibration, SpectralCorrections, SpectrumRecord, parse_calibration};
use isolux_record::{Plan, ReadingKind, Station, readings};

use crate::Target;

/// Every reader.
pub const TARGETS: &[Target] = &[
    Target {
        name: "photometric_file",
        run: photometric,
        seeds: photometric_files,
    },
    Target {
        name: "station",
        run: station,
        seeds: || vec![STATION.into()],
    },
    Target {
        name: "plan",
        run: plan,
        seeds: || vec![include_bytes!("../../../crates/app/src/init/plan.toml").to_vec()],
    },
    Target {
        name: "room",
        run: room,
        seeds: || vec![isolux_darkroom::BUILT_IN.into()],
    },
    Target {
        name: "scene",
        run: scene,
        seeds: || vec![include_bytes!("../../../crates/app/src/init/scene.toml").to_vec()],
    },
    Target {
        name: "model",
        run: model,
        seeds: || vec![include_bytes!("../../../examples/hidden-effect/model.toml").to_vec()],
    },
    Target {
        name: "waveform",
        run: waveform,
        seeds: waveforms,
    },
    Target {
        name: "tm25",
        run: tm25,
        seeds: || vec![ray_file()],
    },
    Target {
        name: "readings",
        run: recorded_readings,
        seeds: || {
            vec![
                [readings::HEADER, "\n0,scan,lit,12.5,0,0,10000,up,3,25.1,3.41,0.01\n"]
                    .concat()
                    .into(),
            ]
        },
    },
    Target {
        name: "recorded_spectrum",
        run: recorded_spectrum,
        seeds: || vec![spectrum()],
    },
    Target {
        name: "calibration",
        run: calibration,
        seeds: || vec![b"wavelength_nm,factor\n380,2e-6\n580,1.5e-6\n780,3e-6\n".to_vec()],
    },
];

const STATION: &str = r#"format = "isolux-station/1"
[bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 2.0
u_gamma_deg = 0.05
[axis.c]
open = "zaber:/dev/ttyUSB0?axis=1"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = 1
limit_deg = [-5.0, 365.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[axis.gamma]
open = "zaber:/dev/ttyUSB0?axis=2"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = -1
limit_deg = [-185.0, 185.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[luxmeter]
open = "t10a:/dev/ttyUSB1"
calibration_factor = 1.0
u_rel = 0.01
[lamp]
open = "zaber:/dev/ttyUSB0?do=1"
diameter_mm = 70.0
"#;

/// The first byte chooses the format whose name the file has, the others are the file.
fn photometric(data: &[u8]) {
    let Some((&first, bytes)) = data.split_first() else {
        return;
    };
    let extensions: Vec<&str> = formats().filter_map(|row| row.extensions.first().copied()).collect();
    let name = format!("a.{}", extensions[usize::from(first) % extensions.len()]);
    for parsed in read_any_with(bytes, &name, ReadOptions::default()) {
        for finding in &parsed.findings {
            assert!(!finding.message.is_empty(), "a finding without words");
        }
    }
}

/// The good files of the formats' own tests, and what each format writes.
fn photometric_files() -> Vec<Vec<u8>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/formats/tests/good");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("the formats' good files")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let extensions: Vec<&str> = formats().filter_map(|row| row.extensions.first().copied()).collect();
    let seed = |extension: &str, bytes: Vec<u8>| {
        let place = extensions.iter().position(|known| *known == extension).unwrap_or(0);
        [vec![place as u8], bytes].concat()
    };
    let mut seeds = Vec::new();
    for path in paths {
        let bytes = std::fs::read(&path).expect("a good file");
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        for parsed in read_any_with(&bytes, &name, ReadOptions::default()) {
            for row in formats().filter(|_| name == "rotational.ies" || name == "spectrum.csv") {
                let written = match &parsed.document {
                    Some(Content::Distribution(light)) => {
                        write_distribution(light, row.format, &WriteOptions::default()).and_then(Result::ok)
                    }
                    Some(Content::Spectrum(spectrum)) => write_spectrum(spectrum, row.format),
                    None => None,
                };
                seeds.extend(written.map(|written| seed(row.extensions.first().unwrap_or(&""), written.bytes)));
            }
        }
        seeds.push(seed(&extension, bytes));
    }
    seeds
}

fn tm25(data: &[u8]) {
    let Ok(mut reader) = Reader::new(data, data.len() as u64) else {
        return;
    };
    reader.header().doubts();
    while let Ok(Some(_)) = reader.next_ray() {}
}

fn with_text(data: &[u8], read: impl Fn(&str)) {
    if let Ok(text) = std::str::from_utf8(data) {
        read(text);
    }
}

fn file() -> &'static Utf8Path {
    Utf8Path::new("a file")
}

fn station(data: &[u8]) {
    with_text(data, |text| drop(Station::parse(file(), text)));
}

fn plan(data: &[u8]) {
    with_text(data, |text| drop(Plan::parse(file(), text)));
}

fn scene(data: &[u8]) {
    with_text(data, |text| drop(Scene::parse(nowhere(), text)));
}

fn model(data: &[u8]) {
    with_text(data, |text| drop(Model::parse(nowhere(), text)));
}

/// What the file names is looked for beside it, and is not there.
fn nowhere() -> &'static Utf8Path {
    Utf8Path::new("/no such folder/a file")
}

fn room(data: &[u8]) {
    with_text(data, |text| drop(Darkroom::parse(text)));
}

fn recorded_readings(data: &[u8]) {
    drop(readings::parse(file(), data));
}

fn recorded_spectrum(data: &[u8]) {
    with_text(data, |text| drop(SpectrumRecord::parse(file(), text)));
}

fn calibration(data: &[u8]) {
    with_text(data, |text| {
        drop(parse_calibration(file(), text));
        drop(WavelengthCurve::responsivity(file(), text));
    });
}

fn spectrum() -> Vec<u8> {
    let calibration = SpectralCalibration {
        file: "calibration.csv".to_owned(),
        sha256: "00".to_owned(),
        saturation_counts: 65_535.0,
        full_scale_counts: 65_535.0,
        nonlinearity: vec![1.0, -1e-6],
        dark_pixels: [0, 1],
        corrections: SpectralCorrections::default(),
        factors_corrected_by: None,
    };
    let pixel = |wavelength_nm| Pixel {
        wavelength_nm,
        counts: 10_000.0,
        u_counts: 3.0,
        dark_counts: 1000.0,
        u_dark_counts: 4.0,
        saturated: false,
        factor_w_m2_nm: 2e-6,
    };
    let record = SpectrumRecord {
        index: 0,
        block: "spectrum".to_owned(),
        point: 12,
        kind: ReadingKind::Lit,
        time_s: Some(2012.5),
        lamp_s: Some(2000.5),
        c_deg: 0.0,
        gamma_deg: 0.0,
        distance_mm: 500.0,
        integration_s: 0.1,
        averages: 5,
        detector_c: None,
        ambient_c: Some(25.0),
        pixels: vec![pixel(450.0), pixel(550.0), pixel(650.0)],
    };
    record
        .to_csv(&calibration)
        .expect("a spectrum of three pixels")
        .into_bytes()
}

fn ray_file() -> Vec<u8> {
    let ray = Ray {
        origin_mm: DVec3::new(1.0, 0.5, 0.0),
        direction: DVec3::new(0.6, 0.0, 0.8),
        radiant_w: None,
        luminous_lm: Some(0.25),
        wavelength_nm: None,
    };
    let set = RaySet {
        rays: vec![ray; 3],
        luminous_flux_lm: Some(0.75),
        radiant_flux_w: None,
    };
    isolux_formats::tm25::write(&set, "2013-09-04T08:30:29+01:00", "ring")
}

fn waveform(bytes: &[u8]) {
    let source = Source {
        rate_hz: None,
        dark: Some(0.0),
    };
    if let Ok(waveform) = Waveform::parse(bytes, source) {
        let camera = Camera {
            exposures_s: vec![2e-3],
            line_time_s: Some(2e-5),
        };
        let _ = isolux_modulation::evaluate(&waveform, &camera);
    }
}

/// 100 values as text, and as 16-bit WAVE.
fn waveforms() -> Vec<Vec<u8>> {
    let value = |k: i32| 1000 + 37 * (k % 10);
    let lines: Vec<String> = (0..100).map(|k| format!("{},{}", 5 * k, value(k))).collect();
    let text = format!("# range = -1 2000\ntime_ms,value_mV\n{}\n", lines.join("\n"));
    let mut wave = b"RIFF\xec\x00\x00\x00WAVEfmt \x10\x00\x00\x00\x01\x00\x01\x00".to_vec();
    wave.extend(2000_u32.to_le_bytes());
    wave.extend(4000_u32.to_le_bytes());
    wave.extend(b"\x02\x00\x10\x00data\xc8\x00\x00\x00");
    wave.extend((0..100).flat_map(|k| (value(k) as i16).to_le_bytes()));
    vec![text.into_bytes(), wave]
}
