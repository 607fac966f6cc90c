//! Scans in motion in the virtual room: real bytes to the twins, a run directory on disk, and the reduction against the
//! light that the room's lamp has.

mod meters;

use std::f64::consts::TAU;
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{self, Place, ScanJob, Target};
use isolux_app::study::in_motion::{InMotion, in_motion};
use isolux_app::{Failure, FailureKind};
use isolux_darkroom::{Darkroom, Room};
use isolux_photometry::IntensityDistribution;
use isolux_record::{Event, Plan, Role, Run};
use isolux_reduce::{Options, ReduceError, Reduction};
use isolux_virtual::station::{calibration, for_sweeps, in_memory, station};
use isolux_virtual::twins::Choice;

/// A lamp with two wings that leans, smooth on its table of 10° × 2.5°.
fn wings(c: f64, gamma: f64) -> f64 {
    // Even in γ, so that it is smooth through the pole.
    let wing = |at: f64| (-((gamma - at) / 22.0).powi(2)).exp();
    let wings = wing(30.0) + wing(-30.0) + 0.7 * (-(gamma / 25.0).powi(2)).exp();
    let lean = 1.0 + 0.25 * gamma.to_radians().sin() * ((c - 40.0) / 360.0 * TAU).cos();
    800.0 * wings * lean
}

/// A room with that lamp, without injected effects but those of `more`.
fn room(more: &str) -> Darkroom {
    room_of(table_of(wings), more)
}

/// A room with the lamp of a table.
fn room_of(table: String, more: &str) -> Darkroom {
    let (before, injected_effects) = more.split_once("[injected_effects]\n").unwrap_or((more, ""));
    let text = format!(
        "[lamp]\ntable = \"lamp.csv\"\nluminous_diameter_mm = 60.0\n{before}\n\
         [injected_effects]\nonly = true\n{injected_effects}"
    );
    Darkroom::complete(
        isolux_record::document::SourceText {
            file: "darkroom.toml".into(),
            text: &text,
        },
        &|_| Ok(table.clone()),
    )
    .unwrap()
    .0
}

/// The table of a lamp in steps of 10° × 2.5°.
fn table_of(light: impl Fn(f64, f64) -> f64) -> String {
    let mut text = "c_deg,gamma_deg,intensity_cd\n".to_owned();
    for c in (0..36).map(|k| 10.0 * f64::from(k)) {
        for gamma in (0..73).map(|k| 2.5 * f64::from(k)) {
            text += &format!("{c},{gamma},{}\n", light(c, gamma));
        }
    }
    text
}

/// Six lobes around the axis, with an edge that falls by its half over 6°.
fn lobes(c: f64, gamma: f64) -> f64 {
    let edge = 0.5 - 0.5 * ((gamma - 35.0) / 6.0).tanh();
    let lobe = 1.0 + 0.2 * (gamma / 30.0).min(1.0).powi(2) * (6.0 * c.to_radians()).cos();
    1000.0 * edge * lobe
}

/// Planes of 30° and γ of 3°, in motion or at rest, and the meter's offset.
fn plan(how: &str) -> Plan {
    plan_at("c_range = [0, 150, 30]\ngamma_range = [-180, 180, 3]", how)
}

/// The same at these angles.
fn plan_at(angles: &str, how: &str) -> Plan {
    let text = format!(
        "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\n{angles}\ndistance_mm = 3000.0\n{how}\n\
         [[block]]\nname = \"capped\"\nkind = \"capped\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 3\ndistance_mm = 3000.0\n"
    );
    Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap()
}

const IN_MOTION: &str = "mode = \"sweep\"\nspeed_deg_s = 10.0\nreference_every = 4";

/// Scans `plan` with a P-9710 that integrates for 100 ms; interrupted after `cancel_s` of the run, if asked.
fn scanned(
    room: &Darkroom,
    plan: &Plan,
    target: Target<'_>,
    cancel_s: Option<f64>,
) -> Result<scan::ScanSummary, Failure> {
    scanned_by("gigahertz-p9710", room, plan, target, cancel_s)
}

/// The same with the lux meter that `driver` speaks to.
fn scanned_by(
    driver: &str,
    room: &Darkroom,
    plan: &Plan,
    target: Target<'_>,
    cancel_s: Option<f64>,
) -> Result<scan::ScanSummary, Failure> {
    scanned_with((driver, "", ""), room, plan, target, cancel_s)
}

/// The same with `to` in place of `from` in the station.
fn scanned_with(
    (driver, from, to): (&str, &str, &str),
    room: &Darkroom,
    plan: &Plan,
    target: Target<'_>,
    cancel_s: Option<f64>,
) -> Result<scan::ScanSummary, Failure> {
    let mut choice = Choice::default();
    choice.choose(isolux_virtual::Instrument::Luxmeter, driver).unwrap();
    let outlets = in_memory(&choice);
    let text = for_sweeps(&station(room, &outlets), &outlets);
    assert!(text.contains(from), "{from} is not in {text}");
    let text = text.replacen(from, to, 1);
    let source = StationFiles::from_text(&text, calibration(&Room::new(room.clone()), &outlets).as_deref()).unwrap();
    session::run(true, async {
        let session = Session::in_room(room.clone(), &choice)?;
        let control = Control::default();
        let cancel = control.cancel.clone();
        if let Some(seconds) = cancel_s {
            let cancel = cancel.clone();
            tokio::spawn(async move {
                tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
                cancel.cancel("SIGTERM");
            });
        }
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let place = Place::take(target, false)?;
        let job = ScanJob {
            source: &source,
            plan,
            place,
            force: None,
            operator: None,
            control: &control,
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await
    })
}

fn folder() -> (tempfile::TempDir, Utf8PathBuf) {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    (keep, path)
}

fn reduced(path: &Utf8Path) -> Reduction {
    isolux_reduce::reduce(&Run::read(path).unwrap(), &Options::default(), None).unwrap()
}

/// Errors at the directions of the grid, and how many lie outside of twice their own uncertainty, of how many: the
/// calibration of the meter is taken out, which all directions share.
fn judged(reduction: &Reduction, room: &Room) -> (f64, f64, usize) {
    judged_by(1.0 + room.document().luxmeter.gain_error_rel, reduction, room)
}

/// The same where the meter reads `gain` times the light.
fn judged_by(gain: f64, reduction: &Reduction, room: &Room) -> (f64, f64, usize) {
    let read = &reduction.grid.distribution;
    let peak = read.peak().intensity_cd;
    let (mut worst, mut outside) = (0.0f64, 0);
    let count = read.intensity_cd().len();
    for (plane, c_deg) in read.c_deg().iter().enumerate() {
        for (column, gamma_deg) in read.gamma_deg().iter().enumerate() {
            let error = read.row(plane)[column] / gain - room.intensity_cd(*c_deg, *gamma_deg);
            let sample = &reduction.grid.nodes[reduction.grid.sample_of[plane * read.gamma_deg().len() + column]];
            worst = worst.max(error.abs() / peak);
            // What all share, drift among it, is a thousandth.
            let u = sample.u_own_cd().hypot(0.001 * sample.intensity_cd);
            outside += usize::from(error.abs() > 2.0 * u);
        }
    }
    (worst, outside as f64 / count as f64, count)
}

#[test]
fn in_motion_a_scan_finds_the_light_of_the_lamp_in_less_time() {
    let document = room(
        "[luxmeter]\nlatency_s = 0.06\nlatency_jitter_s = 0.004\nlag_s = 0.02\n\
         [injected_effects]\nbacklash = { width_deg = 0.2 }\n",
    );
    let truth = Room::new(document.clone());
    let (_keep, moving) = folder();
    let fast = scanned(&document, &plan(IN_MOTION), Target::New(&moving), None).unwrap();
    let reduction = reduced(&moving);
    let (worst, outside, count) = judged(&reduction, &truth);
    assert!(worst < 0.006, "worst {worst} of the peak, {count} directions");
    assert!(outside < 0.06, "{outside} of {count} directions lie outside of 2 u");
    assert!(
        (reduction.flux.value / (1.0 + document.luxmeter.gain_error_rel) / document.lamp.flux_lm - 1.0).abs() < 0.0025
    );
    let run = Run::read(&moving).unwrap();
    let rests = run.readings.rows.iter().filter(|row| row.role == Role::Check).count();
    assert_eq!(rests, 10);
    assert!(
        checked(&reduction).starts_with("10 directions"),
        "{}",
        checked(&reduction)
    );
    // Latency and lag make one delay; play is separated from it.
    let note = reduction.notes.iter().find(|note| note.contains("of delay")).unwrap();
    let words: Vec<&str> = note.split_whitespace().collect();
    // "49.4 ± 3.3 ms of delay", "0.200 ± 0.040° of play"
    let stated = |what: &str, back: usize| {
        let at = words.iter().position(|word| *word == what).unwrap();
        let number = |place: usize| words[place].trim_end_matches('°').parse::<f64>().unwrap();
        (number(at - back), number(at - back + 2))
    };
    // The latency, and 9 bytes of a request at 9600 baud; the lag looks back.
    let (delay_ms, u_ms) = stated("delay", 5);
    assert!((delay_ms - (60.0 + 9.4 - 20.0)).abs() < u_ms && u_ms < 4.0, "{note}");
    let (play_deg, u_deg) = stated("play", 4);
    assert!((play_deg - 0.2).abs() < u_deg && u_deg < 0.06, "{note}");

    let (_keep, resting) = folder();
    let slow = scanned(&document, &plan("reference_every = 91"), Target::New(&resting), None).unwrap();
    let (worst_at_rest, ..) = judged(&reduced(&resting), &truth);
    let from_stable = |summary: &scan::ScanSummary| summary.duration_s - summary.warm_up_s.unwrap();
    // Four of the nine sweeps of this small scan are there to find delay and play.
    assert!(
        from_stable(&slow) > 2.5 * from_stable(&fast),
        "{} {}",
        from_stable(&slow),
        from_stable(&fast)
    );
    assert!(worst_at_rest < 0.006, "{worst_at_rest}");
}

/// What a curve leaves open is no scatter of single directions: taken for it, the six lobes of twelve half-planes are
/// flattened by as much as the edge is uncertain.
#[test]
fn half_planes_are_not_bent_towards_each_other_by_what_their_curves_leave_open() {
    let darkroom = room_of(table_of(lobes), "");
    let (_keep, path) = folder();
    scanned(&darkroom, &plan(IN_MOTION), Target::New(&path), None).unwrap();
    let reduction = reduced(&path);
    let (worst, outside, count) = judged(&reduction, &Room::new(darkroom));
    assert!(outside < 0.05, "{outside} of {count} outside, worst {worst}");
    let in_motion = |sample: &isolux_reduce::Sample| sample.u_curve_cd.is_some_and(|u_cd| u_cd > 0.0);
    assert!(reduction.grid.nodes.iter().all(in_motion));
}

/// A lamp that is even over half of the circle and has a narrow lobe of C in the other.
fn one_lobe(c: f64, gamma: f64) -> f64 {
    let off = (c - 130.0 + 180.0).rem_euclid(360.0) - 180.0;
    let lobe = 0.4 * gamma.to_radians().sin() * (-0.5 * (off / 18.0).powi(2)).exp();
    900.0 * gamma.to_radians().cos().max(0.0).powi(2) * (1.0 + lobe)
}

/// Half-planes every 5° from which some are chosen.
fn chosen() -> Plan {
    plan_at(
        "c_range = [0, 175, 5]\ngamma_range = [-180, 180, 3]",
        &format!("{IN_MOTION}\ntarget = {{ u_map_rel = 0.01 }}"),
    )
}

#[test]
fn chosen_half_planes_give_the_others_with_an_uncertainty_that_holds() {
    let darkroom = room_of(table_of(one_lobe), "");
    let truth = Room::new(darkroom.clone());
    let (_keep, path) = folder();
    scanned(&darkroom, &chosen(), Target::New(&path), None).unwrap();
    let reduction = reduced(&path);
    let between = reduction.between.as_ref().unwrap();
    assert_eq!((between.count, reduction.grid.distribution.c_deg().len()), (72, 72));
    let read = &between.read_c_deg;
    assert!(read.len() < 36, "{read:?}");
    let near = |at: f64| read.iter().filter(|c| (**c - at).abs() <= 30.0).count();
    assert!(near(130.0) > near(40.0), "closer where the light changes: {read:?}");
    let (worst, outside, count) = judged(&reduction, &truth);
    assert!(
        worst < 0.02 && outside < 0.05,
        "worst {worst}, {outside} of {count} outside"
    );
    // Without what rings and left-out half-planes show, the lobe's sides are believed too well.
    let interpolated = reduction.grid.nodes.iter().filter(|node| !between.is_read(node.c_deg));
    assert!(
        interpolated
            .clone()
            .all(|node| node.u_curve_cd.is_some_and(|u_cd| u_cd > 0.0))
    );
    assert!(interpolated.count() > 30 * 59);
    assert!(reduction.flux.parts["interpolation_over_c"] > 0.0);
    let flux = reduction.flux.value / (1.0 + truth.document().luxmeter.gain_error_rel);
    assert!((flux / darkroom.lamp.flux_lm - 1.0).abs() < 0.0025);
    assert!(
        reduction
            .notes
            .iter()
            .any(|note| note.starts_with("half-planes were chosen"))
    );
    is_shown_as_reduced(&shown(&path), &reduction);
    // Interrupted it is no finished choice: the half-planes of the plan are what is missing.
    let (_keep, cut) = folder();
    // In the third sweep behind the rings.
    let cut_s = Run::read(&path).unwrap().sweeps[11].light[20].asked_s;
    scanned(&darkroom, &chosen(), Target::New(&cut), Some(cut_s)).unwrap_err();
    let partial = reduced(&cut).partial.unwrap();
    assert_eq!(partial.planned_c_deg.len(), 72);
    let before = shown(&cut);
    scanned(&darkroom, &chosen(), Target::Resume(&cut), None).unwrap();
    let resumed = reduced(&cut);
    assert_eq!(resumed.between.as_ref().unwrap().read_c_deg, between.read_c_deg);
    let after = shown(&cut);
    is_shown_as_reduced(&after, &resumed);
    // Taken up again it is shown as it was, and goes on with what was shown as the next sweep.
    let [before_u, after_u] = [&before, &after].map(|shown| shown.target.clone().unwrap().after);
    assert_eq!((before.sweeps, before_u.len()), (11, 3), "{before_u:?}");
    assert_eq!(before_u, after_u[..before_u.len()]);
    let next = Run::read(&cut).unwrap().sweeps[before.sweeps].of.c_target_deg;
    assert_eq!(before.next.unwrap().c_deg, [next, next + 180.0]);
}

/// What the page shows of a scan in motion.
fn shown(path: &Utf8Path) -> InMotion {
    in_motion(path).unwrap().unwrap()
}

/// Every direction that was swept is shown with the uncertainty that the reduction states, the others with what the
/// scan was after, and that as it fell.
fn is_shown_as_reduced(shown: &InMotion, reduction: &Reduction) {
    let between = reduction.between.as_ref().unwrap();
    assert_eq!(shown.swept_c_deg, between.read_c_deg);
    assert_eq!(shown.next, None);
    let target = shown.target.as_ref().unwrap();
    let (first, last) = (target.after.first().unwrap(), target.after.last().unwrap());
    assert!(
        first.u_rel > target.wanted_rel && last.u_rel <= target.wanted_rel,
        "{target:?}"
    );
    assert_eq!(last.sweeps, shown.sweeps);
    assert_eq!(shown.sensor, None, "no job, no scene");
    let largest_cd = shown.largest_cd.unwrap();
    let (mut swept, mut others) = (0, 0);
    for node in reduction.grid.nodes.iter().filter(|node| !node.closing) {
        let place = |all: &[f64], angle: f64| all.iter().position(|at| *at == angle).unwrap();
        let cell = place(&shown.c_deg, node.c_deg) * shown.gamma_deg.len() + place(&shown.gamma_deg, node.gamma_deg);
        let u_rel = shown.u_rel[cell].unwrap();
        let is_pole = node.gamma_deg == 0.0 || node.gamma_deg == 180.0;
        if between.is_read(node.c_deg) && !is_pole {
            assert!(
                (u_rel * largest_cd / node.u_own_cd() - 1.0).abs() < 1e-9,
                "{node:?}: {u_rel}"
            );
            swept += 1;
        } else if !is_pole {
            let beside = shown
                .swept_c_deg
                .iter()
                .map(|c| place(&shown.c_deg, *c) * shown.gamma_deg.len());
            let column = place(&shown.gamma_deg, node.gamma_deg);
            let most = beside.filter_map(|row| shown.u_rel[row + column]).fold(0.0, f64::max);
            assert!(u_rel <= last.u_rel.hypot(most) + 1e-12, "{node:?}: {u_rel}");
            others += 1;
        }
    }
    assert!(swept > 500 && others > 500, "{swept} {others}");
    assert!(shown.u_rel.iter().all(Option::is_some));
}

/// A narrow round lamp, dimmed by `depth` about the half-plane at `at_deg` over a full width at half depth of 20°.
fn round(at_deg: f64, depth: f64) -> impl Fn(f64, f64) -> f64 {
    move |c, gamma| {
        let off = (c - at_deg + 180.0).rem_euclid(360.0) - 180.0;
        let dip = 1.0 - depth * (-0.5 * (off / 8.5).powi(2)).exp() * (gamma / 5.0).min(1.0);
        1500.0 * gamma.to_radians().cos().max(0.0).powi(20) * dip
    }
}

/// Sound lamps, lamps that lean by 0.3° and lamps with a dip of 5 % × 20°, each in `ISOLUX_RINGS` rooms (2 by
/// default).
#[expect(clippy::print_stdout, reason = "figures, where somebody asks for more rooms")]
#[test]
fn rings_accept_a_round_lamp_and_refuse_one_that_leans_or_has_a_dip() {
    let plan = plan_at(
        "c_deg = 0\ngamma_range = [0, 180, 3]",
        "mode = \"sweep\"\nsymmetry_max_rel = 0.01\nreference_every = 5",
    );
    let rooms = std::env::var("ISOLUX_RINGS").map_or(2_u32, |count| count.parse().unwrap());
    let meter = "[luxmeter]\nlatency_s = 0.09\nlatency_jitter_s = 0.004\nlag_s = 0.02\n";
    let mut most_s = 0.0_f64;
    for seed in 1..=rooms {
        let at_deg = (f64::from(seed) * 137.5).rem_euclid(360.0);
        let tilt = format!("luminaire_tilt = {{ angle_deg = 0.3, azimuth_deg = {at_deg} }}\n");
        for (what, depth, effects) in [("sound", 0.0, ""), ("tilt", 0.0, tilt.as_str()), ("dip", 0.05, "")] {
            let more = format!("{meter}[injected_effects]\n{effects}");
            let mut darkroom = room_of(table_of(round(at_deg, depth)), &more);
            darkroom.seed = u64::from(seed);
            let (_keep, path) = folder();
            let outcome = scanned(&darkroom, &plan, Target::New(&path), None);
            match outcome {
                Ok(_) => {
                    assert_eq!(what, "sound", "seed {seed} at C {at_deg}°");
                    let notes = reduced(&path).notes;
                    let note = notes
                        .iter()
                        .find(|note| note.contains("was looked at by rings"))
                        .unwrap();
                    assert!(note.contains("a dip of 5 % would have been seen from 1.5°"), "{note}");
                }
                Err(failure) => {
                    assert_ne!(what, "sound", "seed {seed}: {failure}");
                    assert_eq!(failure.kind, FailureKind::No, "{failure}");
                    assert!(failure.to_string().contains("(rotational)"), "{failure}");
                }
            }
            let events = isolux_record::event::read(&path);
            let time = |is: fn(&Event) -> bool| -> jiff::Timestamp {
                let logged = events.iter().find(|logged| is(&logged.event)).unwrap();
                logged.time_utc.parse().unwrap()
            };
            let from = time(|event| matches!(event, Event::Stable { .. }));
            let until = time(|event| matches!(event, Event::Symmetry { .. }));
            most_s = most_s.max(until.duration_since(from).as_secs_f64());
        }
    }
    println!("{rooms} rooms each: at most {most_s:.0} s from a stable lamp");
    assert!(most_s < 200.0, "{most_s}");
}

/// A round spot with a width at half height of 15° and so much dim light all round, the table in steps of 1°.
fn spot(dim_cd: f64) -> String {
    let mut text = "c_deg,gamma_deg,intensity_cd\n".to_owned();
    for c in [0, 90, 180, 270] {
        for gamma in (0..=180).map(f64::from) {
            let dim = dim_cd * gamma.to_radians().cos().max(0.0);
            text += &format!("{c},{gamma},{}\n", 9000.0 * 0.5f64.powf((gamma / 7.5).powi(2)) + dim);
        }
    }
    text
}

/// γ of 2°, in motion as `how` says.
fn fine(how: &str) -> Plan {
    plan_at("c_range = [0, 150, 30]\ngamma_range = [-180, 180, 2]", how)
}

#[test]
fn a_spot_that_is_swept_slowly_within_its_beam_is_better_known() {
    let document = room_of(
        spot(20.0),
        "[luxmeter]\nlatency_s = 0.06\nlatency_jitter_s = 0.005\nlag_s = 0.02\n\
         [injected_effects]\nbacklash = { width_deg = 0.2 }\n",
    );
    let truth = Room::new(document.clone());
    let fast = "mode = \"sweep\"\nspeed_deg_s = 12.0\nreference_every = 4";
    let (_keep, once) = folder();
    scanned(&document, &fine(fast), Target::New(&once), None).unwrap();
    let (_keep, twice) = folder();
    let plan = fine(&format!("{fast}\nbeam_speed_deg_s = 4.0"));
    scanned(&document, &plan, Target::New(&twice), None).unwrap();
    let (once, twice_read) = (judged(&reduced(&once), &truth), judged(&reduced(&twice), &truth));
    assert!(
        twice_read.0 < 0.005 && twice_read.0 < 0.7 * once.0,
        "{once:?} {twice_read:?}"
    );
    assert!(twice_read.1 < 0.05, "{twice_read:?}");
    let run = Run::read(&twice).unwrap();
    let points: Vec<f64> = run.sweeps.iter().map(|sweep| sweep.of.speed_deg_s.round()).collect();
    assert_eq!(points, [vec![12.0; 7], vec![4.0; 7]].concat());
    let note = |words: &str| reduced(&twice).notes.iter().any(|note| note.contains(words));
    assert!(note("7 of them within the beam at 4 °/s") && !note("is not known"));
}

#[test]
fn dim_light_that_a_range_does_not_show_is_swept_in_another() {
    // 0.44 lx at 3 m, and less; the range of 1000 lx shows 1 lx from 0.5 lx on.
    let document = room_of(spot(4.0), "[luxmeter]\nclock_phase_s = 0.21\n[injected_effects]\n");
    let truth = Room::new(document.clone());
    let off = |how: &str| {
        let (_keep, path) = folder();
        scanned_by("konica-t10a", &document, &fine(how), Target::New(&path), None).unwrap();
        let run = Run::read(&path).unwrap();
        let samples = run.sweeps.iter().flat_map(|sweep| &sweep.light);
        assert_eq!(
            samples.filter(|sample| sample.illuminance_lx.is_none()).count(),
            0,
            "no light is over its range"
        );
        let reduction = reduced(&path);
        // Both by the directions of the grid.
        let read = &reduction.grid.distribution;
        let (c_deg, gamma_deg) = (read.c_deg().to_vec(), read.gamma_deg().to_vec());
        let of_plane = |c: &f64| {
            gamma_deg
                .iter()
                .map(|gamma| truth.intensity_cd(*c, *gamma))
                .collect::<Vec<_>>()
        };
        let light = c_deg.iter().flat_map(of_plane).collect();
        let light = IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), light).unwrap();
        let gain = 1.0 + document.luxmeter.gain_error_rel;
        let flux = &reduction.flux;
        (
            (read.flux_lm() / gain / light.flux_lm() - 1.0).abs(),
            2.0 * flux.u_of_parts / flux.value,
        )
    };
    let how = "mode = \"sweep\"\nspeed_deg_s = 6.0\nreference_every = 4";
    let (held, u_held) = off(how);
    let (twice, u_twice) = off(&format!("{how}\ndim_digits = 20.0"));
    assert!(held > 0.01, "{held} ± {u_held}");
    assert!(twice < 0.004 && twice < u_twice, "{twice} ± {u_twice}");
    assert!(u_twice < 0.7 * u_held, "{u_held}, {u_twice}");
}

/// What the directions say that were read at rest after the sweeps.
fn checked(reduction: &Reduction) -> &str {
    let note = reduction.notes.iter().find(|note| note.contains("were read at rest"));
    note.expect("a note of them")
}

#[test]
fn where_ten_directions_at_rest_say_something_else_the_scan_is_refused() {
    // A lag of 0.3 s blurs by 3° at 10 °/s: both directions alike, so that no sweep shows it.
    let document = room("[luxmeter]\nlag_s = 0.3\n[injected_effects]\n");
    let (_keep, path) = folder();
    scanned(&document, &plan(IN_MOTION), Target::New(&path), None).unwrap();
    let run = Run::read(&path).unwrap();
    let error = isolux_reduce::reduce(&run, &Options::default(), None).unwrap_err();
    let ReduceError::Unsteady { findings } = &error else {
        panic!("{error}");
    };
    assert!(
        findings[0].what.contains("were read at rest after the sweeps disagree"),
        "{error}"
    );
    for row in &findings[0].rows {
        let read = &run.readings.rows[row.row as usize];
        assert_eq!(
            (read.role, read.c_target_deg, read.gamma_target_deg),
            (Role::Check, row.c_deg, row.gamma_deg)
        );
    }
    let accepting = Options {
        accept_drift: Some("the lag is known".to_owned()),
        ..Options::default()
    };
    let reduction = isolux_reduce::reduce(&run, &accepting, None).unwrap();
    assert_eq!(&reduction.accepted.as_ref().unwrap().findings, findings);
    assert!(reduction.flux.u.is_none(), "{:?}", reduction.flux);
}

#[test]
fn a_torn_sweep_is_kept_as_evidence_and_made_again() {
    // The meter falls silent for eight seconds in the third sweep.
    let fault = "[[fault]]\ninstrument = \"luxmeter\"\nkind = \"silent\"\nat_s = 1950.0\nfor_s = 8.0\n";
    let document = room(&format!("{fault}[injected_effects]\n"));
    let (_keep, path) = folder();
    let summary = scanned(&document, &plan(IN_MOTION), Target::New(&path), None).unwrap();
    assert!(summary.visits_again >= 1, "{summary:?}");
    let run = Run::read(&path).unwrap();
    let torn = run.header.sweep.iter().filter(|entry| entry.torn).count();
    assert!(
        torn >= 1 && run.notices.iter().any(|notice| notice.contains("torn sweep")),
        "{:?}",
        run.notices
    );
    assert_eq!(run.sweeps.len(), 4 + 5);
    let (worst, ..) = judged(&reduced(&path), &Room::new(document));
    assert!(worst < 0.006, "{worst}");
}

#[test]
fn interrupted_in_a_sweep_it_goes_on_at_that_sweep() {
    // Without reference_every the lamp that burns again is visited at rest, and no burning before it.
    for how in [IN_MOTION, "mode = \"sweep\"\nspeed_deg_s = 10.0"] {
        interrupted_in_a_sweep(how);
    }
}

fn interrupted_in_a_sweep(how: &str) {
    let document = room("");
    let (_keep, path) = folder();
    let failure = scanned(&document, &plan(how), Target::New(&path), Some(1960.0)).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Interrupted, "{failure}");
    let cut = Run::read(&path).unwrap();
    assert!(cut.header.stopped.as_ref().unwrap().axes_at_rest);
    let before = cut.sweeps.len();
    assert!((1..9).contains(&before), "{before}");
    scanned(&document, &plan(how), Target::Resume(&path), None).unwrap();
    let run = Run::read(&path).unwrap();
    let points: Vec<u64> = run.sweeps.iter().map(|sweep| sweep.of.point).collect();
    assert_eq!(points, (0..9).collect::<Vec<u64>>(), "every sweep once");
    assert_eq!(run.sweeps[..before], cut.sweeps[..]);
    let reduction = reduced(&path);
    let (worst, ..) = judged(&reduction, &Room::new(document));
    assert!(worst < 0.006, "{worst}");
    let missing = &reduction.flux.missing;
    assert!(missing.iter().all(|what| !what.contains("burnings")), "{missing:?}");
}

/// Every other half-plane of [`plan`]: what a meter or a link does is the same in each.
fn every_other(how: &str) -> Plan {
    plan_at("c_range = [0, 120, 60]\ngamma_range = [-180, 180, 3]", how)
}

/// A scan of which every hundredth answer of the meter is `kind`.
fn with_one_answer_in_a_hundred(kind: &str) {
    let sweeps = with_some_answers("gigahertz-p9710", IN_MOTION, (kind, 0.01), 0.004);
    assert!((6..=14).contains(&sweeps), "{kind}: {sweeps}");
}

/// A scan with the lux meter that `driver` speaks to, in motion as `how` says, of whose answers a share is `kind` from
/// the lamp's warm-up on: no direction is wrong by more than `most` of the peak. The number of sweeps.
fn with_some_answers(driver: &str, how: &str, (kind, share): (&str, f64), most: f64) -> usize {
    // Longer than is waited for.
    let delay_s = match (kind, driver) {
        ("double", _) => 0.05,
        (_, "konica-t10a") => 0.9,
        _ => 0.35,
    };
    let fault = format!(
        "[[fault]]\ninstrument = \"luxmeter\"\nkind = \"{kind}\"\nat_s = 1900.0\nfor_s = 9000.0\n\
         probability = {share}\ndelay_s = {delay_s}\n"
    );
    let document = room(&format!("{fault}[injected_effects]\n"));
    let (_keep, path) = folder();
    scanned_by(driver, &document, &every_other(how), Target::New(&path), None).unwrap();
    let reduction = reduced(&path);
    let (worst, outside, _) = judged(&reduction, &Room::new(document));
    let sweeps = Run::read(&path).unwrap().sweeps.len();
    assert!(
        worst < most && outside < 0.05,
        "{kind}: worst {worst} of the peak, {outside} outside of 2 u; {sweeps} sweeps"
    );
    let note = reduction
        .notes
        .iter()
        .find(|note| note.contains("was read in motion"))
        .unwrap();
    assert!(note.contains("are left out"), "{kind}: {note}");
    sweeps
}

#[test]
fn lost_answers_leave_gaps_that_another_sweep_fills() {
    with_one_answer_in_a_hundred("silent");
}

#[test]
fn late_answers_move_no_reading_to_another_angle() {
    with_one_answer_in_a_hundred("late");
}

#[test]
fn answers_that_come_twice_move_no_reading_to_another_angle() {
    with_one_answer_in_a_hundred("double");
}

#[test]
fn a_wrong_digit_bends_no_curve() {
    with_one_answer_in_a_hundred("wrong_digit");
}

#[test]
fn damaged_answers_bend_no_curve() {
    with_one_answer_in_a_hundred("flip_bit");
    with_one_answer_in_a_hundred("drop_byte");
}

#[test]
fn where_no_answer_comes_the_scan_ends_with_its_gaps_named() {
    // Five in a hundred: all further sweeps are not enough.
    let fault =
        "[[fault]]\ninstrument = \"luxmeter\"\nkind = \"silent\"\nat_s = 1900.0\nfor_s = 9000.0\nprobability = 0.05\n";
    let document = room(&format!("{fault}[injected_effects]\n"));
    let (_keep, path) = folder();
    let failure = scanned(&document, &plan(IN_MOTION), Target::New(&path), None)
        .map(drop)
        .unwrap_err();
    assert!(
        failure.kind == FailureKind::Instrument
            && ["torn", "further sweeps"]
                .iter()
                .any(|word| failure.message.contains(word)),
        "{failure}"
    );
    assert!(Run::read(&path).unwrap().header.stopped.unwrap().axes_at_rest);
}

#[test]
fn a_meter_that_cannot_follow_is_refused_before_motion_with_the_speed_that_would_do() {
    let document = room("");
    let (_keep, path) = folder();
    let fast = plan(&IN_MOTION.replace("10.0", "19.0"));
    let failure = scanned(&document, &fast, Target::New(&path), None).map(drop);
    // 19 °/s: no way for the run-up before −180°.
    let failure = failure.unwrap_err();
    assert!(
        failure.kind == FailureKind::BadInput && failure.message.contains("run-up"),
        "{failure}"
    );
    let fine = plan_at("c_range = [0, 150, 30]\ngamma_range = [-180, 180, 1]", IN_MOTION);
    let (_keep, path) = folder();
    let failure = scanned(&document, &fine, Target::New(&path), None)
        .map(drop)
        .unwrap_err();
    assert!(
        failure.kind == FailureKind::BadInput && failure.message.contains("7.6 °/s would do"),
        "{failure}"
    );
    assert!(Run::read(&path).unwrap().readings.rows.is_empty());
}

/// In motion by a meter that converts twice a second: 3° a conversion, as the grid has.
const BY_ITS_CLOCK: &str = "mode = \"sweep\"\nspeed_deg_s = 6.0\nreference_every = 4";

#[test]
fn a_meter_with_a_clock_of_its_own_is_read_in_motion() {
    let document = room(
        "[luxmeter]\nlatency_s = 0.03\nlatency_jitter_s = 0.003\nclock_ppm = 150.0\nclock_phase_s = 0.21\n\
         [injected_effects]\nbacklash = { width_deg = 0.2 }\n",
    );
    let truth = Room::new(document.clone());
    let (_keep, path) = folder();
    scanned_by("konica-t10a", &document, &plan(BY_ITS_CLOCK), Target::New(&path), None).unwrap();
    let reduction = reduced(&path);
    let (worst, outside, count) = judged(&reduction, &truth);
    assert!(worst < 0.008, "worst {worst} of the peak, {count} directions");
    assert!(outside < 0.05, "{outside} of {count} directions lie outside of 2 u");
    let note = reduction.notes.iter().find(|note| note.contains("of delay")).unwrap();
    assert!(
        note.contains("the meter converted every 500.0") || note.contains("every 500.1"),
        "{note}"
    );
    // Faster than its conversions, it is refused before anything moves, with what would do.
    let (_keep, path) = folder();
    let refused = scanned_by("konica-t10a", &document, &plan(IN_MOTION), Target::New(&path), None).unwrap_err();
    assert!(refused.to_string().contains("9.0 °/s would do"), "{refused}");
    let (_keep, path) = folder();
    let of_modbus = scanned_by("modbus-lux", &document, &plan(IN_MOTION), Target::New(&path), None).unwrap_err();
    assert!(
        of_modbus.to_string().contains("does not say when it converts"),
        "{of_modbus}"
    );
}

#[test]
fn lost_late_and_doubled_answers_of_a_meter_with_a_clock_of_its_own_move_no_reading() {
    for kind in ["silent", "late", "double"] {
        // It is asked more often than it converts, and each that fails costs two seconds.
        let sweeps = with_some_answers("konica-t10a", BY_ITS_CLOCK, (kind, 0.01), 0.008);
        assert!((6..=22).contains(&sweeps), "{kind}: {sweeps}");
    }
}
