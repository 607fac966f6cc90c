//! A second hand on the controller of a virtual bench, by raw bytes: what it does to axes and outputs while a scan runs
//! is never in a row that calls itself sound.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{Place, ScanJob, ScanSummary, Target};
use isolux_app::{Failure, FailureKind};
use isolux_darkroom::{Darkroom, Room};
use isolux_record::run::StopHow;
use isolux_record::{Plan, Quality, Role, Run};
use isolux_transport::{LineSettings, Links, Parity};
use isolux_virtual::station::{calibration, in_memory, station};
use isolux_virtual::twins::Choice;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

/// A lamp that gives another light in every direction.
const ROOM: &str = r#"format = "isolux-darkroom/1"
[bench]
distance_mm = 1000.0
[lamp]
ring_diameter_mm = [0.0]
leds_per_ring = [1]
exponent = 5.0
flux_lm = 337.0
ellipticity_rel = 0.3
flux_spread_rel = 0.0
aim_spread_deg = 0.0
"#;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 60, 90]
gamma_deg = [-45, -20, 0, 30, 60]
reference_every = 5
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_deg = [0, 40]
repeats = 3
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 3
[[block]]
name = "off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 3
"#;

/// What the second hand sends: axis 1 is C, axis 2 is γ; output 1 is the lamp, 2 the shutter, 3 the baffle.
const HANDS: [&str; 12] = [
    "1 2 move abs 0",
    "1 2 move rel 60000",
    "1 2 move rel -300",
    "1 1 move abs 0",
    "1 1 move rel 90000",
    "1 2 home",
    "1 0 stop",
    "1 0 io set do 1 0",
    "1 0 io set do 1 1",
    "1 0 io set do 2 0",
    "1 0 io set do 2 1",
    "1 0 io set do 3 1",
];

/// Sends one command beside the program.
async fn hand(links: Arc<dyn Links>, command: &str) {
    let line = LineSettings {
        baud: 115_200,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    };
    let mut link = links.open("memory:axes", line).await.unwrap();
    link.write_all(format!("/{command}\n").as_bytes()).await.unwrap();
    let mut answer = [0; 64];
    assert!(link.read(&mut answer).await.unwrap() > 0);
}

/// Scans, and at each of these moments (s) somebody sends a command.
fn scan_beside(target: Target<'_>, hands: Vec<(f64, &'static str)>) -> Result<ScanSummary, Failure> {
    let document = Darkroom::parse(ROOM).unwrap();
    let outlets = in_memory(&Choice::default());
    let text = station(&document, &outlets);
    let source =
        StationFiles::from_text(&text, calibration(&Room::new(document.clone()), &outlets).as_deref()).unwrap();
    let plan = Plan::parse(Utf8Path::new("plan.toml"), PLAN).unwrap();
    session::run(true, async {
        let session = Session::in_room(document, &Choice::default())?;
        for (moment, command) in hands {
            let links = session.links.clone();
            tokio::spawn(async move {
                tokio::time::sleep(Duration::from_secs_f64(moment)).await;
                hand(links, command).await;
            });
        }
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let job = ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(target, false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await
    })
}

/// Light and its standard uncertainty by (point, repeat, role), all visits to the reference point as one; each at the
/// pose that the plan asked for.
fn light(run: &Run) -> BTreeMap<(u64, u32, String), (f64, f64)> {
    run.readings
        .rows
        .iter()
        .filter(|row| row.quality == Quality::Ok)
        .map(|row| {
            assert!((row.c_deg - row.c_target_deg).abs() < 0.0101, "{row:?}");
            assert!((row.gamma_deg - row.gamma_target_deg).abs() < 0.0101, "{row:?}");
            let digit = row.digit_lx.unwrap();
            let point = if row.role == Role::Point { row.point } else { 0 };
            let key = (point, row.repeat, row.role.to_string());
            (key, (row.illuminance_lx.unwrap(), row.u_lx.unwrap() + digit))
        })
        .collect()
}

fn assert_same_light(found: &Run, expected: &Run, what: &str) {
    let expected = light(expected);
    for (key, (lux, u)) in light(found) {
        let (truth, u_truth) = expected[&key];
        assert!(
            (lux - truth).abs() <= 6.0 * u.hypot(u_truth),
            "{what}: {key:?} gave {lux} lx for {truth} lx"
        );
    }
}

fn folder() -> (tempfile::TempDir, Utf8PathBuf) {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    (keep, path)
}

#[test]
fn a_second_hand_is_in_no_row_and_in_no_result() {
    let (_keep, quiet) = folder();
    let undisturbed = scan_beside(Target::New(&quiet), Vec::new()).unwrap();
    assert_eq!(
        undisturbed.visits_again, 0,
        "a sound bench keeps the limits: {undisturbed:?}"
    );
    let truth = Run::read(&quiet).unwrap();
    let (mut again, mut resumed) = (0, 0);
    for round in 0..36_u64 {
        let mut random = ChaCha8Rng::seed_from_u64(round);
        let from = undisturbed.warm_up_s.unwrap();
        let hands: Vec<_> = (0..=round % 3)
            .map(|hand| {
                let command = HANDS[((round + 5 * hand) % HANDS.len() as u64) as usize];
                (random.random_range(from..undisturbed.duration_s), command)
            })
            .collect();
        let what = format!("round {round}, {hands:?}");
        let (_keep, path) = folder();
        match scan_beside(Target::New(&path), hands) {
            Ok(summary) => again += summary.visits_again,
            Err(failure) => {
                resumed += 1;
                assert_eq!(failure.kind, FailureKind::Instrument, "{what}: {failure}");
                assert_same_light(&Run::read(&path).unwrap(), &truth, &what);
                scan_beside(Target::Resume(&path), Vec::new()).unwrap_or_else(|error| panic!("{what}: {error}"));
            }
        }
        let run = Run::read(&path).unwrap();
        assert_same_light(&run, &truth, &what);
        assert_eq!(run.header.stopped.as_ref().unwrap().how, StopHow::Completed, "{what}");
        let keys = |run: &Run| {
            light(run)
                .into_keys()
                .filter(|key| key.2 == "point")
                .collect::<Vec<_>>()
        };
        assert_eq!(keys(&run), keys(&truth), "{what}");
    }
    assert!(again > 10, "{again} visits made again, {resumed} scans resumed");
}
