//! Days in rooms whose lamps change their colour over angle, read by a lux meter on a fine grid and by a
//! spectroradiometer on a coarse one: the truth lies within ± 2 u as often as it should, for the whole light, the
//! average of LM-79, Δu′v′ and every direction. The truth is that of the room's individual LEDs.
//!
//! A day is a pure function of its number. `ISOLUX_DAYS=400 cargo test -p isolux-app --test suite colour_over_angle --
//! --nocapture` plays a longer sample and prints its figures.

#![allow(clippy::print_stdout, reason = "the figures of a sample")]

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::spectrograph::{Exposure, PIXELS};
use isolux_darkroom::{Darkroom, Kind, Observation, Room, meter};
use isolux_record::plan::Instrument;
use isolux_record::readings::Readings;
use isolux_record::run::{Run, RunHeader};
use isolux_record::spectra::{Pixel, SpectralCalibration, SpectralCorrections, SpectrumRecord};
use isolux_record::{Plan, Quality, Reading, ReadingKind, Role, Station};
use isolux_reduce::{MonteCarlo, Options, OverAngle, Quantity, Reduction};
use isolux_spectrum::{Chromaticity, Spectrum, quantities};

use crate::draws::Draws;

/// Days that every test run plays.
const SHORT: u64 = 30;
const DISTANCE_MM: f64 = 3700.0;

/// What the certificates state, and the room keeps.
const U_SHAPE: f64 = 0.004;
const U_NM: f64 = 0.1;
const U_GAMMA_DEG: f64 = 0.1;

fn room(draws: &mut Draws, seed: u64, coloured: bool) -> Room {
    let mut document = Darkroom {
        seed,
        ..Darkroom::default()
    };
    document.lamp.exponent = draws.between(1.2, 6.0);
    document.lamp.ellipticity_rel = draws.between(0.0, 0.1);
    document.lamp.flux_lm = draws.between(300.0, 900.0);
    let (rise, lean, azimuth) = (
        draws.between(-0.15, 0.5),
        draws.between(0.0, 0.12),
        draws.between(0.0, 360.0),
    );
    if coloured {
        document.lamp.phosphor_rise_rel = rise;
        document.lamp.phosphor_lean_rel = lean;
        document.lamp.phosphor_lean_azimuth_deg = azimuth;
    }
    document.luxmeter.gain_error_rel = draws.normal(0.004);
    document.spectroradiometer.gain_error_rel = draws.normal(0.01);
    document.spectroradiometer.nonlinearity = 0.0;
    document.injected_effects.distance_offset.offset_mm = draws.normal(2.0);
    document.injected_effects.gamma_zero.offset_deg = draws.normal(U_GAMMA_DEG);
    document.injected_effects.spectro_shift.shift_nm = draws.normal(U_NM);
    document.injected_effects.ambient_stray.illuminance_lx = draws.between(0.0, 0.2);
    Room::new(document)
}

fn station() -> Station {
    let axis = |name: &str| {
        format!(
            "[axis.{name}]\nopen = \"fake:{name}\"\ncounts_per_deg = \"1000/1\"\nzero_deg = 0.0\nsense = 1\n\
             limit_deg = [-185.0, 365.0]\nspeed_deg_s = 20.0\naccel_deg_s2 = 40.0\n"
        )
    };
    let text = format!(
        "format = \"isolux-station/1\"\n[bench]\ntype = \"turning_luminaire\"\ndistance_mm = {DISTANCE_MM:.1}\n\
         u_distance_mm = 2.0\nu_gamma_deg = {U_GAMMA_DEG}\nstray_max_rel = 0.0001\ndark_max_lx = 0.001\n\
         {}{}[luxmeter]\n\
         open = \"fake:lux\"\ncalibration_factor = 1.0\nu_rel = 0.004\n\
         [lamp]\nprompt = \"switch\"\ndiameter_mm = 73.0\n\
         [spectroradiometer]\nopen = \"fake:spectro\"\ncalibration = \"s.csv\"\ndistance_mm = 500.0\n\
         u_distance_mm = 1.0\n\
         u_rel = 0.01\nu_shape_rel = {U_SHAPE}\nu_wavelength_nm = {U_NM}\nstray_max_rel = 0.0004\n",
        axis("c"),
        axis("gamma")
    );
    Station::parse(Utf8Path::new("s.toml"), &text).unwrap()
}

/// The spectroradiometer reads every `colour_deg` of γ.
fn plan(colour_deg: u32) -> Plan {
    let text = format!(
        "format = \"isolux-plan/1\"\n\
        [[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, 345, 15]\ngamma_range = [0, 180, 5]\n\
        [[block]]\nname = \"axis\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\nc_deg = 0\ngamma_deg = 0\n\
        repeats = 6\n\
        [[block]]\nname = \"colour\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\nc_deg = [0, 90]\n\
        gamma_range = [-90, 90, {colour_deg}]\nrepeats = 4\n\
        [[block]]\nname = \"off\"\nkind = \"lamp_off\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 10\n"
    );
    Plan::parse(Utf8Path::new("p.toml"), &text).unwrap()
}

/// One reading of the lux meter, long after the lamp was switched on.
fn reading(room: &Room, kind: Kind, c_deg: f64, gamma_deg: f64, index: u64) -> Reading {
    let mut at = Observation {
        kind,
        time_s: 1e6,
        c_deg,
        gamma_deg,
        distance_mm: DISTANCE_MM,
        travel: 1.0,
        range: 1,
        ambient_c: 25.0,
    };
    at.range = meter::auto_range(room.illuminance_lx(&at, 0.5), 1);
    let indicated = room.indicated_lx(&at);
    let noise = room.reading_noise_lx(indicated);
    let noisy = indicated + noise * room.meter_noise(index);
    let shown = meter::displayed_lx(noisy, at.range).unwrap_or(noisy);
    let digit = meter::digit_lx(at.range);
    Reading {
        index,
        block: if kind == Kind::Lit { "lit" } else { "off" }.to_owned(),
        kind: if kind == Kind::Lit {
            ReadingKind::Lit
        } else {
            ReadingKind::LampOff
        },
        time_s: Some(1e6),
        lamp_s: Some(1e6),
        c_deg,
        gamma_deg,
        distance_mm: DISTANCE_MM,
        travel: 1,
        range: i32::from(at.range),
        ambient_c: Some(25.0),
        illuminance_lx: Some(shown),
        u_lx: Some(noise.hypot(digit / 12.0_f64.sqrt())),
        quality: Quality::Ok,
        role: Role::Point,
        point: 0,
        repeat: 0,
        c_target_deg: c_deg,
        gamma_target_deg: gamma_deg,
        digit_lx: Some(digit),
        integration_s: Some(0.5),
        session: 0,
        burning: None,
        electrical: isolux_record::Electrical::default(),
        raw: String::new(),
    }
}

/// The spectrum of one direction, exposed as long as it may be, with `factor` on the calibration.
fn spectrum(
    room: &Room,
    block: &str,
    at: (f64, f64),
    averages: u64,
    factor: &dyn Fn(f64) -> f64,
    index: u64,
) -> SpectrumRecord {
    let (c_deg, gamma_deg) = at;
    let exposure = |illuminance_lx: f64, integration_s: f64, index: u64| Exposure {
        illuminance_lx,
        phosphor: room.spectroradiometer_phosphor(true, c_deg, gamma_deg, 1e6),
        lines_lx: 0.0,
        integration_s,
        detector_c: 25.0,
        index,
    };
    let light_lx = room.spectroradiometer_lx(true, c_deg, gamma_deg, 1e6, 0.0);
    let peak = |integration_s: f64| {
        let counts = room.exposure_counts(&exposure(light_lx, integration_s, 0));
        f64::from(counts.into_iter().max().unwrap())
    };
    let mut integration_s = 10.0;
    while integration_s > 1e-3 && peak(integration_s) > 50_000.0 {
        integration_s *= 0.5;
    }
    let mean = |illuminance_lx: f64, first: u64| -> Vec<(f64, f64)> {
        let all: Vec<Vec<u16>> = (0..averages)
            .map(|k| room.exposure_counts(&exposure(illuminance_lx, integration_s, first + k)))
            .collect();
        (0..PIXELS)
            .map(|pixel| {
                let n = averages as f64;
                let mean = all.iter().map(|counts| f64::from(counts[pixel])).sum::<f64>() / n;
                let squares: f64 = all.iter().map(|counts| (f64::from(counts[pixel]) - mean).powi(2)).sum();
                (mean, (squares / (n - 1.0) / n).sqrt())
            })
            .collect()
    };
    let (light, dark) = (mean(light_lx, 1000 * index + 1), mean(0.0, 1000 * index + 500));
    let pixels = light.into_iter().zip(dark).enumerate();
    SpectrumRecord {
        index,
        block: block.to_owned(),
        point: index,
        kind: ReadingKind::Lit,
        time_s: Some(1e6),
        lamp_s: Some(1e6),
        c_deg,
        gamma_deg,
        distance_mm: 500.0,
        integration_s,
        averages: averages as u32,
        detector_c: None,
        ambient_c: None,
        pixels: pixels
            .map(|(pixel, ((counts, u_counts), (dark_counts, u_dark_counts)))| {
                let wavelength_nm = room.document().spectroradiometer.nm_at(pixel as f64);
                Pixel {
                    wavelength_nm,
                    counts,
                    u_counts,
                    dark_counts,
                    u_dark_counts,
                    saturated: counts >= 65_535.0,
                    factor_w_m2_nm: room.calibration(pixel) * factor(wavelength_nm),
                }
            })
            .collect(),
    }
}

fn record(room: &Room, draws: &mut Draws, colour_deg: u32) -> Run {
    let plan = plan(colour_deg);
    let (tilt, bow) = (draws.normal(U_SHAPE), draws.normal(U_SHAPE));
    let factor = move |nm: f64| {
        let t = (nm - 550.0) / 300.0;
        (1.0 + tilt * t) * (1.0 + 0.5 * bow * (1.0 - 8.0 * t * t))
    };
    let (mut rows, mut spectra) = (Vec::new(), Vec::new());
    for block in plan.blocks() {
        for &c in &block.c_deg {
            for &gamma in &block.gamma_deg {
                match (block.instrument, block.kind) {
                    (Instrument::Spectroradiometer, _) => {
                        let repeats = if block.name == "axis" { 6 } else { 4 };
                        let index = spectra.len() as u64;
                        spectra.push(spectrum(room, &block.name, (c, gamma), repeats, &factor, index));
                    }
                    (_, ReadingKind::Lit) => rows.push(reading(room, Kind::Lit, c, gamma, rows.len() as u64)),
                    _ => (0..10).for_each(|_| rows.push(reading(room, Kind::LampOff, c, gamma, rows.len() as u64))),
                }
            }
        }
    }
    let mut header = RunHeader::new(
        "test".to_owned(),
        "2026-01-01T00:00:00Z".to_owned(),
        Vec::new(),
        None,
        station(),
        plan,
    );
    header.spectral = Some(SpectralCalibration {
        file: "s.csv".to_owned(),
        sha256: "00".to_owned(),
        saturation_counts: 65_535.0,
        full_scale_counts: 65_535.0,
        nonlinearity: Vec::new(),
        dark_pixels: [0, 1],
        corrections: SpectralCorrections::default(),
        factors_corrected_by: None,
    });
    Run {
        path: Utf8PathBuf::from("run"),
        header,
        readings: Readings::of(rows),
        notices: Vec::new(),
        spectra,
        sweeps: Vec::new(),
    }
}

/// The lamp as it is, by its LEDs.
struct Truth<'a> {
    room: &'a Room,
    /// Phosphor light in the whole light.
    phosphor: f64,
    peak_cd: f64,
}

impl<'a> Truth<'a> {
    fn of(room: &'a Room) -> Self {
        let step = |k: usize| (k as f64 + 0.5) * 180.0 / 240.0;
        let directions: Vec<(f64, f64)> = (0..48)
            .flat_map(|c| (0..240).map(move |k| (7.5 * f64::from(c), step(k))))
            .collect();
        let light = |&(c, gamma): &(f64, f64)| {
            let weight = room.intensity_cd(c, gamma) * gamma.to_radians().sin();
            (weight, room.phosphor(c, gamma))
        };
        let peak = directions.iter().map(|&(c, gamma)| room.intensity_cd(c, gamma));
        Self {
            phosphor: room.spectrum().mixed(directions.iter().map(light)),
            peak_cd: peak.fold(room.intensity_cd(0.0, 0.0), f64::max),
            room,
        }
    }

    fn light(&self, phosphor: f64) -> Spectrum {
        let nm: Vec<f64> = (340..=1000).map(f64::from).collect();
        let value = nm
            .iter()
            .map(|nm| self.room.spectrum().per_lux(*nm, phosphor))
            .collect();
        Spectrum::new(nm, value).unwrap()
    }

    fn at(&self, c_deg: f64, gamma_deg: f64) -> Chromaticity {
        self.light(self.room.phosphor(c_deg, gamma_deg)).chromaticity().unwrap()
    }

    /// LM-79 on four half-planes every 10°, written down a second time.
    fn lm79(&self) -> Chromaticity {
        let (mut x, mut y, mut sum) = (0.0, 0.0, 0.0);
        for k in 0..=9 {
            let gamma = 10.0 * f64::from(k);
            let ring = |deg: f64| (deg * PI / 180.0).cos();
            for c in [0.0, 90.0, 180.0, 270.0] {
                let omega = 0.25 * TAU * (ring((gamma - 5.0).max(0.0)) - ring(gamma + 5.0));
                let weight = omega * self.room.intensity_cd(c, gamma);
                let at = self.at(c, gamma);
                x += weight * at.x;
                y += weight * at.y;
                sum += weight;
            }
        }
        Chromaticity { x: x / sum, y: y / sum }
    }
}

/// How often the truth was inside.
#[derive(Default)]
struct Tally {
    stated: u64,
    within_one: u64,
    within_two: u64,
    u: Vec<f64>,
}

#[derive(Default)]
struct Tallies(BTreeMap<String, Tally>);

impl Tallies {
    fn add(&mut self, what: &str, value: f64, u: Option<f64>, truth: f64) {
        let Some(u) = u else { return };
        let tally = self.0.entry(what.to_owned()).or_default();
        let off = (value - truth).abs();
        tally.stated += 1;
        tally.within_one += u64::from(off <= u);
        tally.within_two += u64::from(off <= 2.0 * u);
        tally.u.push(u);
    }

    fn quantity(&mut self, what: &str, quantity: Option<&Quantity>, truth: Option<f64>) {
        let (Some(quantity), Some(truth)) = (quantity, truth) else {
            return;
        };
        self.add(what, quantity.value, quantity.u, truth);
    }
}

/// Upper end of Wilson's interval of 95 % for a share `p` of `n`.
fn wilson_high(p: f64, n: f64) -> f64 {
    let z = 1.96_f64;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    centre + z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt() / (1.0 + z * z / n)
}

fn reduced(run: &Run) -> Reduction {
    isolux_reduce::reduce(run, &Options::default(), None).unwrap()
}

fn compare(tallies: &mut Tallies, found: &OverAngle, reduction: &Reduction, truth: &Truth<'_>) {
    let whole = truth.light(truth.phosphor);
    let exact = quantities(&whole);
    let colour = &found.facts.total.colour;
    for (what, quantity, exact) in [
        ("total CCT", &colour.cct, exact.cct_k),
        ("total Duv", &colour.duv, exact.duv),
        ("total x", &colour.x, exact.x),
        ("total y", &colour.y, exact.y),
        ("total u'", &colour.u_prime, exact.u_prime),
        ("total v'", &colour.v_prime, exact.v_prime),
        ("total Ra", &colour.ra, exact.ra),
        ("total R9", &colour.r9, exact.r.map(|r| r[8])),
        ("total Rf", &colour.rf, exact.rf),
        ("total Rg", &colour.rg, exact.rg),
    ] {
        tallies.quantity(what, quantity.as_ref(), exact);
    }
    let watts = truth.room.document().lamp.flux_lm / exact.ler_lm_per_w.unwrap();
    let total = &found.facts.total;
    tallies.add(
        "total K, lm/W",
        total.efficacy.value,
        total.efficacy.u,
        exact.ler_lm_per_w.unwrap(),
    );
    tallies.add("radiant flux, W", total.radiant_flux.value, total.radiant_flux.u, watts);
    let lumens = found.total.luminous_integral();
    assert!(
        (lumens / reduction.flux.value - 1.0).abs() < 1e-6,
        "{lumens} {:?}",
        reduction.flux
    );
    let u = found.u_total_w_nm.as_ref().unwrap();
    for nm in [430.0, 457.0, 500.0, 560.0, 620.0, 700.0] {
        let place = (nm - found.total.wavelength_nm()[0]) as usize;
        let exact = truth.room.document().lamp.flux_lm * whole.at_nm(nm);
        tallies.add("spectral flux, W/nm", found.total.value()[place], Some(u[place]), exact);
    }

    let average = truth.lm79();
    let (u_prime, v_prime) = average.uv_1976();
    let found_average = &found.facts.average_lm79;
    let nearest = isolux_spectrum::cct::nearest_planckian(average).unwrap();
    for (what, quantity, exact) in [
        ("LM-79 x", &found_average.x, average.x),
        ("LM-79 y", &found_average.y, average.y),
        ("LM-79 u'", &found_average.u_prime, u_prime),
        ("LM-79 v'", &found_average.v_prime, v_prime),
        ("LM-79 CCT", &found_average.cct, nearest.cct_k),
        ("LM-79 Duv", &found_average.duv, nearest.duv),
    ] {
        tallies.quantity(what, quantity.as_ref(), Some(exact));
    }

    let mut farthest: f64 = 0.0;
    for of in &found.facts.directions {
        let at = truth.at(of.c_deg, of.gamma_deg);
        let (u, v) = at.uv_1976();
        tallies.add("directions, u'", of.u_prime, of.u_u_prime, u);
        tallies.add("directions, v'", of.v_prime, of.u_v_prime, v);
        let nearest = isolux_spectrum::cct::nearest_planckian(at).unwrap();
        tallies.add("directions, CCT", of.cct_k.unwrap(), of.u_cct_k, nearest.cct_k);
        if truth.room.intensity_cd(of.c_deg, of.gamma_deg) >= 0.1 * truth.peak_cd {
            farthest = farthest.max((u - u_prime).hypot(v - v_prime));
        }
    }
    let delta = &found.facts.delta_u_prime_v_prime;
    tallies.add("Δu'v'", delta.value.value, delta.value.u, farthest);
}

#[test]
fn where_a_colour_carries_plus_minus_the_truth_lies_within_two_of_it() {
    let days = std::env::var("ISOLUX_DAYS").map_or(SHORT, |text| text.parse().unwrap());
    let mut tallies = Tallies::default();
    for number in 0..days {
        let mut draws = Draws(number.wrapping_mul(0x5851_F42D_4C95_7F2D) ^ 0xC);
        // Every third lamp has one colour: then noise is all that there is.
        let room = room(&mut draws, number, number % 3 != 0);
        let run = record(&room, &mut draws, 10);
        let reduction = reduced(&run);
        let found = reduction.over_angle.as_ref().unwrap();
        assert_eq!(
            found.facts.directions.len() + found.facts.left_out.len(),
            37,
            "day {number}"
        );
        compare(&mut tallies, found, &reduction, &Truth::of(&room));
    }
    let mut wrong = Vec::new();
    for (what, tally) in &mut tallies.0 {
        tally.u.sort_by(f64::total_cmp);
        // Numbers of one day share its calibration: they count as one.
        let high = wilson_high(tally.within_two as f64 / tally.stated as f64, days as f64);
        println!(
            "{what:20} {:5} with ±; within 2 u {:5.1} %, within 1 u {:5.1} %; median u {:.2e}",
            tally.stated,
            100.0 * tally.within_two as f64 / tally.stated as f64,
            100.0 * tally.within_one as f64 / tally.stated as f64,
            tally.u[tally.u.len() / 2]
        );
        if high < 0.95 || tally.stated < days {
            wrong.push(what.clone());
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// JCGM 101, 8: the budget propagates uncertainties by slopes, the draws whole distributions through the whole
/// reduction.
#[test]
fn draws_of_the_inputs_agree_with_the_budget() {
    const DRAWS: u64 = 200;
    let mut draws = Draws(41);
    let room = room(&mut draws, 7, true);
    let (run, options) = (record(&room, &mut draws, 30), Options::default());
    let drawing = MonteCarlo::new(&run, &options).unwrap();
    let drawn: Vec<Vec<Option<f64>>> = (0..DRAWS).map(|number| drawing.draw(number).unwrap()).collect();
    assert_eq!(drawing.draw(3).unwrap(), drawn[3]);
    let all = drawing.propagated(&drawn);
    for name in [
        "flux",
        "I max",
        "mean irradiance of the sensor",
        "CCT",
        "Duv",
        "x",
        "y",
        "Ra",
        "Rf",
        "Rg",
    ] {
        let one = all.iter().find(|one| one.name == name).unwrap();
        let (ratio, shift) = (one.u / one.u_budget, (one.mean - one.value) / one.u_budget);
        println!(
            "{name}: {ratio:.2} of the budget, mean {shift:+.2} u, not drawn {:?}",
            one.not_drawn
        );
        // 200 draws know a standard deviation to 5 %, and a mean to 0.07 u.
        assert!(
            (0.85..1.15).contains(&ratio) && shift.abs() < 0.25,
            "{name}: {ratio} {shift}"
        );
        assert!(one.interval[0] < one.value && one.value < one.interval[1], "{one:?}");
    }
}
