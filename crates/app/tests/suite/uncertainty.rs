//! Days in rooms that differ in lamp, stray light, drift and meter, read by plans that leave something out: where a
//! flux or an intensity carries ±, the truth lies within ± 2 u as often as it should.
//!
//! A day is a pure function of its number. `ISOLUX_DAYS=2000 cargo test -p isolux-app --test suite uncertainty --
//! --nocapture` plays a longer sample and prints its figures.

#![allow(clippy::print_stdout, reason = "the figures of a sample")]

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::output::relative_output;
use isolux_darkroom::{Darkroom, Kind, Observation, Room, meter};
use isolux_record::readings::Readings;
use isolux_record::run::{Run, RunHeader};
use isolux_record::{Plan, Quality, Reading, ReadingKind, Role, Station};
use isolux_reduce::{Correction, Options, Quantity, ReduceError};

use crate::draws::Draws;

/// Days that every test run plays.
const SHORT: u64 = 40;
/// From so many days on, the lower limit of the interval must lie above 95 %.
const LONG: u64 = 500;
/// One reading takes so long, with its move.
const READING_S: f64 = 3.5;

/// What is drawn for a day, besides the room.
struct Day {
    room: Room,
    station: Station,
    plan: Plan,
    distance_mm: f64,
    rows: Vec<Reading>,
    options: Options,
    /// Flux and largest intensity in the middle of the scan.
    truth: [f64; 2],
    words: String,
}

fn room(draws: &mut Draws, seed: u64) -> Room {
    let mut document = Darkroom {
        seed,
        ..Darkroom::default()
    };
    document.lamp.exponent = draws.between(1.5, 14.0);
    document.lamp.ellipticity_rel = draws.between(0.0, 0.15);
    document.lamp.flux_lm = draws.between(300.0, 900.0);
    // The certificate's uncertainty, and the ruler's.
    document.luxmeter.gain_error_rel = draws.normal(0.004);
    document.injected_effects.distance_offset.offset_mm = draws.normal(2.0);
    document.injected_effects.gamma_zero.offset_deg = draws.normal(0.15);
    document.injected_effects.lamp_warmup.amplitude_rel = draws.between(0.0, 0.06);
    document.injected_effects.lamp_warmup.time_constant_s = draws.between(200.0, 700.0);
    document.injected_effects.lamp_drift.rate_per_h = draws.between(-0.003, 0.003);
    document.injected_effects.ambient_stray.illuminance_lx = draws.between(0.0, 0.03);
    document.injected_effects.dark_offset.offset_lx = draws.between(-0.03, 0.03);
    document.injected_effects.floor_reflection.albedo = draws.between(0.0, 0.12);
    document.injected_effects.floor_reflection.height_mm = draws.between(900.0, 1500.0);
    Room::new(document)
}

/// When the lamp has met the criterion of EN 13032-4.
fn stable_s(room: &Room) -> f64 {
    let output = |time| relative_output(&room.document().injected_effects, time, 0.5);
    (0..1000)
        .map(|n| 1800.0 + 60.0 * f64::from(n))
        .find(|&time| (output(time) / output(time - 900.0) - 1.0).abs() < 0.005)
        .unwrap()
}

fn observation(kind: Kind, time_s: f64, c_deg: f64, gamma_deg: f64, distance_mm: f64) -> Observation {
    Observation {
        kind,
        time_s,
        c_deg,
        gamma_deg,
        distance_mm,
        travel: 1.0,
        range: 1,
        ambient_c: 25.0,
    }
}

/// The bounds that an operator states, each somewhere above what there is.
fn station(draws: &mut Draws, room: &Room, distance_mm: f64) -> Station {
    let injected_effects = &room.document().injected_effects;
    let mut bench = String::new();
    if draws.chance(0.5) {
        bench.push_str(&format!(
            "floor_mm = {:.1}\n",
            injected_effects.floor_reflection.height_mm
        ));
    }
    if draws.chance(0.6) {
        let at = |kind, gamma| observation(kind, 1e6, 0.0, gamma, distance_mm);
        let floor = (0..=12)
            .map(|n| room.floor_lx(&at(Kind::Baffled, 15.0 * f64::from(n))))
            .fold(0.0, f64::max);
        let share = floor / room.direct_lx(&at(Kind::Lit, 0.0));
        let bound = (share * draws.between(1.0, 2.0)).max(0.0005);
        bench.push_str(&format!("stray_max_rel = {bound:.6}\n"));
    }
    if draws.chance(0.6) {
        bench.push_str("ambient_max_lx = 0.03\n");
    }
    if draws.chance(0.6) {
        bench.push_str("dark_max_lx = 0.03\n");
    }
    let axis = |name: &str| {
        format!(
            "[axis.{name}]\nopen = \"fake:{name}\"\ncounts_per_deg = \"1000/1\"\nzero_deg = 0.0\nsense = 1\n\
             limit_deg = [-185.0, 365.0]\nspeed_deg_s = 20.0\naccel_deg_s2 = 40.0\n"
        )
    };
    let text = format!(
        "format = \"isolux-station/1\"\n[bench]\ntype = \"turning_luminaire\"\ndistance_mm = {distance_mm:.1}\n\
         u_distance_mm = 2.0\nu_gamma_deg = 0.15\n{bench}{}{}[luxmeter]\nopen = \"fake:lux\"\n\
         calibration_factor = 1.0\nu_rel = 0.004\n\
         [lamp]\nprompt = \"switch\"\ndiameter_mm = 73.0\n",
        axis("c"),
        axis("gamma")
    );
    Station::parse(Utf8Path::new("s.toml"), &text).unwrap()
}

fn day(number: u64) -> Day {
    let mut draws = Draws(number.wrapping_mul(0x5851_F42D_4C95_7F2D) ^ 0xE);
    let room = room(&mut draws, number);
    let distance_mm = draws.pick(&[3000.0, 5000.0, 10_000.0]);
    let station = station(&mut draws, &room, distance_mm);
    let (c_step, gamma_step) = draws.pick(&[
        (15.0, 5.0),
        (15.0, 15.0),
        (30.0, 10.0),
        (30.0, 15.0),
        (45.0, 15.0),
        (30.0, 30.0),
    ]);
    let closing = draws.chance(0.5);
    let last_c = if closing { 360.0 } else { 360.0 - c_step };
    let visits = draws.chance(0.6);
    let reference = if visits { "reference_every = 30\n" } else { "" };
    let mut text = format!(
        "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, {last_c}, {c_step}]\n\
         gamma_range = [0, 180, {gamma_step}]\n{reference}"
    );
    let mut words = format!("{distance_mm} mm, {c_step}°/{gamma_step}°");
    for (kind, share, angles) in [
        (
            "baffled",
            0.6,
            draws.pick(&[
                "gamma_range = [0, 180, 10]",
                "gamma_range = [0, 180, 30]",
                "gamma_deg = 0",
            ]),
        ),
        ("capped", 0.6, "gamma_deg = 0\nrepeats = 10"),
        ("lamp_off", 0.6, "gamma_deg = 0\nrepeats = 10"),
    ] {
        if draws.chance(share) {
            text.push_str(&format!(
                "[[block]]\nname = \"{kind}\"\nkind = \"{kind}\"\nc_deg = 0\n{angles}\n"
            ));
            words.push_str(&format!(", {kind}"));
        }
    }
    words.push_str(if visits { ", visits" } else { "" });
    let mut options = Options::default();
    for correction in [
        Correction::Stray,
        Correction::Ambient,
        Correction::Dark,
        Correction::Drift,
    ] {
        if draws.chance(0.05) {
            options.without.insert(correction);
            words.push_str(&format!(", without {correction}"));
        }
    }
    let plan = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap();
    let (rows, middle_s) = read(&room, &plan, distance_mm);
    let output = relative_output(&room.document().injected_effects, middle_s, 0.5);
    let peak = (0..24)
        .flat_map(|c| (0..90).map(move |gamma| (15.0 * f64::from(c), 0.5 * f64::from(gamma))))
        .map(|(c, gamma)| room.intensity_cd(c, gamma))
        .fold(0.0, f64::max);
    let truth = [output * room.document().lamp.flux_lm, output * peak];
    Day {
        room,
        station,
        plan,
        distance_mm,
        rows,
        options,
        truth,
        words,
    }
}

/// The readings of the plan, and the time in the middle of the lit ones.
fn read(room: &Room, plan: &Plan, distance_mm: f64) -> (Vec<Reading>, f64) {
    let (start_s, mut time_s) = (stable_s(room), stable_s(room));
    let mut rows: Vec<Reading> = Vec::new();
    let mut end_s = time_s;
    let (mut range, mut lights) = (1, Vec::<((f64, f64), f64)>::new());
    for block in plan.blocks() {
        let mut points: Vec<(Role, f64, f64)> = Vec::new();
        for &c in &block.c_deg {
            for &gamma in &block.gamma_deg {
                if block
                    .reference_every
                    .is_some_and(|every| points.len().is_multiple_of(every as usize + 1))
                {
                    points.push((Role::Reference, 0.0, 0.0));
                }
                let repeats = if let isolux_record::plan::Repeats::Exactly(count) = block.repeats {
                    count
                } else {
                    1
                };
                points.extend((0..repeats).map(|_| (Role::Point, c, gamma)));
            }
        }
        if block.reference_every.is_some() {
            points.push((Role::Reference, 0.0, 0.0));
        }
        let kind = match block.kind {
            ReadingKind::Lit => Kind::Lit,
            ReadingKind::Baffled => Kind::Baffled,
            ReadingKind::LampOff => Kind::LampOff,
            ReadingKind::Capped => Kind::Capped,
        };
        for (role, c, gamma) in points {
            time_s += READING_S;
            let mut at = observation(kind, time_s, c, gamma, distance_mm);
            // The floor's light of the warm lamp is the same whenever it is asked for.
            let key = (c.rem_euclid(360.0), gamma);
            let known = lights.iter().find(|(known, _)| *known == key).map(|(_, floor)| *floor);
            let floor = known.unwrap_or_else(|| room.floor_lx(&at));
            if known.is_none() {
                lights.push((key, floor));
            }
            let light = room.illuminance_with_floor_lx(&at, 0.5, floor);
            range = meter::auto_range(light, range);
            at.range = range;
            let indicated = room.indicated_for_lx(light, 25.0, range);
            let noise = room.reading_noise_lx(indicated);
            let noisy = indicated + noise * room.meter_noise(rows.len() as u64);
            // At the end of a range the offset may lift a reading into the next.
            range += u8::from(meter::displayed_lx(noisy, range).is_none());
            let shown = meter::displayed_lx(noisy, range).unwrap();
            let digit = meter::digit_lx(range);
            rows.push(Reading {
                index: rows.len() as u64,
                block: block.name.clone(),
                kind: block.kind,
                time_s: Some(time_s),
                lamp_s: Some(time_s),
                c_deg: c,
                gamma_deg: gamma,
                distance_mm,
                travel: 1,
                range: i32::from(range),
                ambient_c: Some(25.0),
                illuminance_lx: Some(shown),
                u_lx: Some(noise.hypot(digit / 12.0_f64.sqrt())),
                quality: Quality::Ok,
                role,
                point: 0,
                repeat: 0,
                c_target_deg: c,
                gamma_target_deg: gamma,
                digit_lx: Some(digit),
                integration_s: Some(0.5),
                session: 0,
                burning: None,
                electrical: isolux_record::Electrical::default(),
                raw: String::new(),
            });
        }
        if block.kind == ReadingKind::Lit {
            end_s = time_s;
        }
    }
    (rows, 0.5 * (start_s + end_s))
}

/// Wilson's interval of 95 % for `hits` of `count`.
fn wilson(hits: u64, count: u64) -> (f64, f64) {
    let (n, z) = (count as f64, 1.96_f64);
    let p = hits as f64 / n;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt() / (1.0 + z * z / n);
    (centre - half, centre + half)
}

/// How often the truth was inside.
#[derive(Default)]
struct Tally {
    stated: u64,
    within_one: u64,
    within_two: u64,
    u_rel: Vec<f64>,
}

impl Tally {
    fn add(&mut self, quantity: &Quantity, truth: f64, words: &str) {
        let Some(u) = quantity.u else { return };
        let z = (quantity.value - truth) / u;
        self.stated += 1;
        self.within_one += u64::from(z.abs() <= 1.0);
        self.within_two += u64::from(z.abs() <= 2.0);
        self.u_rel.push(u / truth);
        if z.abs() > 2.0 {
            println!(
                "{z:+.2} u: {:.2} ± {u:.2} {}, truth {truth:.2}; {words}",
                quantity.value, quantity.unit
            );
        }
    }

    fn judge(&mut self, what: &str, days: u64) {
        self.u_rel.sort_by(f64::total_cmp);
        let (low, high) = wilson(self.within_two, self.stated);
        println!(
            "{what}: {} of {days} days carry ±; within 2 u {} ({:.1} %, Wilson {:.1} to {:.1} %), within 1 u {} ({:.1} %); median u {:.2} %",
            self.stated,
            self.within_two,
            100.0 * self.within_two as f64 / self.stated as f64,
            100.0 * low,
            100.0 * high,
            self.within_one,
            100.0 * self.within_one as f64 / self.stated as f64,
            100.0 * self.u_rel[self.u_rel.len() / 2]
        );
        // A short sample may not contradict 95 %, a long one has to show it.
        let limit = if days >= LONG { low } else { high };
        assert!(
            limit >= 0.95,
            "{what}: {} of {} within 2 u",
            self.within_two,
            self.stated
        );
        // Nor may the uncertainty hide everything: a fifth of all days is worth more than 5 %.
        assert!(self.u_rel[self.u_rel.len() / 5] < 0.05, "{what}: {:?}", self.u_rel);
    }
}

#[test]
fn where_a_number_carries_plus_minus_the_truth_lies_within_two_of_it() {
    let days = std::env::var("ISOLUX_DAYS").map_or(SHORT, |text| text.parse().unwrap());
    let mut tallies = [Tally::default(), Tally::default()];
    let mut refused = 0;
    for number in 0..days {
        let day = day(number);
        let run = Run {
            path: Utf8PathBuf::from("run"),
            header: RunHeader::new(
                "test".to_owned(),
                "2026-01-01T00:00:00Z".to_owned(),
                Vec::new(),
                None,
                day.station.clone(),
                day.plan.clone(),
            ),
            readings: Readings::of(day.rows.clone()),
            notices: Vec::new(),
            spectra: Vec::new(),
            sweeps: Vec::new(),
        };
        let words = format!("day {number}: {}", day.words);
        match isolux_reduce::reduce(&run, &day.options, None) {
            Ok(reduction) => {
                tallies[0].add(&reduction.flux, day.truth[0], &words);
                tallies[1].add(&reduction.i_max, day.truth[1], &words);
                assert_eq!(reduction.distance_mm, day.distance_mm);
                // Stray light that nobody measured, bounded or corrected leaves no ±.
                let has = |kind| run.readings.rows.iter().any(|row| row.kind == kind);
                let on = |correction| !day.options.without.contains(&correction);
                // Alone, baffled readings are taken off as a whole while any of the three corrections is on.
                let apart = has(ReadingKind::LampOff) || has(ReadingKind::Capped);
                let whole = !apart && (on(Correction::Dark) || on(Correction::Ambient));
                let corrected = has(ReadingKind::Baffled) && (whole || on(Correction::Stray));
                if !corrected && day.station.bench().stray_max_rel.is_none() {
                    assert_eq!(reduction.flux.u, None, "{words}");
                }
            }
            Err(ReduceError::Unsteady { findings }) => {
                println!("{words}: refused, {findings:?}");
                refused += 1;
            }
            Err(error) => panic!("{words}, {:?}: {error}", day.room.document().injected_effects),
        }
    }
    println!("{refused} of {days} days refused");
    for (tally, what) in tallies.iter_mut().zip(["flux", "largest intensity"]) {
        tally.judge(what, days);
    }
    assert!(
        50 * refused <= days,
        "a stable lamp on a sound bench is not refused: {refused} of {days}"
    );
}
