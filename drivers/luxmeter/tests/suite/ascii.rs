//! A lux meter by a profile against a scripted meter on an in-memory link, with the clock paused.
//!
//! The meter below answers the language that its profile describes, by its own code. It converts each half second, and
//! the light of conversion n is 100 + 0.05 n lx: as values two that follow each other agree, and each says when it was
//! taken.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{ErrorKind, Kind, LuxMeter, LuxOutcome, LuxRange, OpenError, Target};
use isolux_luxmeter::ASCII_LUX;
use isolux_transport::{MemoryLinks, Ports, TRIES};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

/// What becomes of the next answer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    /// It arrives twice, the second time so many ms later.
    Twice(u64),
    /// The answer before it arrives instead.
    Replaced,
    /// So many bytes, then the rest after a while.
    Split(usize),
    /// A byte less.
    Torn,
    /// Bytes that are none of it come before.
    GarbageBefore,
    GarbageAfter,
    /// This bit of this byte is flipped.
    Flipped(usize, u8),
    /// The host's own bytes come back first.
    Echoed,
    Disconnect,
}

struct Script {
    began: Instant,
    heard: Vec<String>,
    faults: VecDeque<Fault>,
    /// Instead of a reading.
    says: Option<&'static str>,
    dead: bool,
    old: Vec<u8>,
}

fn light(conversion: u64) -> f64 {
    100.0 + 0.05 * conversion as f64
}

/// The conversion under way so long after the beginning.
fn conversion(since: Duration) -> u64 {
    (2.0 * since.as_secs_f64()).floor() as u64
}

impl Script {
    fn answer(&self, command: &str) -> String {
        match command {
            "ID?" => "ID LUX-1,0042,1.7".to_owned(),
            "UNIT LX" => "OK".to_owned(),
            "E?" => match self.says {
                Some(text) => text.to_owned(),
                None => format!("E {:.2} lx", light(conversion(self.began.elapsed()).saturating_sub(1))),
            },
            _ => "ERR 1".to_owned(),
        }
    }
}

type Shared = Arc<Mutex<Script>>;

async fn bench(open: &str, folder: &Path) -> (Result<Box<dyn LuxMeter>, OpenError>, Shared) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("meter").unwrap();
    let script = Arc::new(Mutex::new(Script {
        began: Instant::now(),
        heard: vec![],
        faults: VecDeque::new(),
        says: None,
        dead: false,
        old: vec![],
    }));
    let twin = Arc::clone(&script);
    tokio::spawn(async move {
        let mut stream = listener.accept().await.unwrap();
        let (mut inbox, mut buffer) = (Vec::new(), [0; 64]);
        loop {
            let Ok(count @ 1..) = stream.read(&mut buffer).await else {
                return;
            };
            inbox.extend(&buffer[..count]);
            while let Some(end) = inbox.windows(2).position(|bytes| bytes == b"\r\n") {
                let line: Vec<u8> = inbox.drain(..end + 2).collect();
                let command = String::from_utf8(line[..end].to_vec()).unwrap();
                let (mut bytes, fault, dead) = {
                    let mut script = twin.lock().unwrap();
                    let bytes = format!("{}\r\n", script.answer(&command)).into_bytes();
                    script.heard.push(command);
                    (bytes, script.faults.pop_front(), script.dead)
                };
                if dead {
                    continue;
                }
                let old = std::mem::replace(&mut twin.lock().unwrap().old, bytes.clone());
                let mut wait = 20;
                let mut later = None;
                match fault {
                    Some(Fault::Silent) => continue,
                    Some(Fault::Disconnect) => return,
                    Some(Fault::Late(milliseconds)) => wait = milliseconds,
                    Some(Fault::Twice(milliseconds)) => later = Some((milliseconds, bytes.clone())),
                    Some(Fault::Replaced) => bytes = old,
                    Some(Fault::Split(at)) => later = Some((40, bytes.split_off(at.min(bytes.len())))),
                    Some(Fault::Torn) => drop(bytes.remove(bytes.len() / 2)),
                    Some(Fault::GarbageBefore) => bytes.splice(..0, *b"\x00\xff?").for_each(drop),
                    Some(Fault::GarbageAfter) => bytes.extend(b"?\x80"),
                    Some(Fault::Flipped(at, bit)) => bytes[at] ^= 1 << bit,
                    Some(Fault::Echoed) => bytes = [&line[..], &bytes].concat(),
                    None => {}
                }
                sleep(Duration::from_millis(wait)).await;
                if stream.write_all(&bytes).await.is_err() {
                    return;
                }
                if let Some((milliseconds, bytes)) = later {
                    sleep(Duration::from_millis(milliseconds)).await;
                    let _ = stream.write_all(&bytes).await;
                }
            }
        }
    });
    let target = Target::parse(open).unwrap().within(folder);
    let factory = (ASCII_LUX.factories)(Ports::new(Arc::new(links))).lux_meter.unwrap();
    (factory.open_lux_meter(&target).await, script)
}

async fn template() -> (Box<dyn LuxMeter>, Shared) {
    let (meter, script) = bench("ascii-lux:memory:meter?profile=template", Path::new("")).await;
    (meter.unwrap(), script)
}

fn later() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

/// Whether a reading shows light of after `not_before`: to half a per cent, within which two exchanges confirm each
/// other.
async fn read(meter: &dyn LuxMeter, script: &Shared, not_before: Instant) -> Result<(), String> {
    let reading = meter.read(not_before, later()).await.unwrap();
    let began = script.lock().unwrap().began;
    let Some(lux) = reading.illuminance() else {
        return Ok(());
    };
    let least = light(conversion(not_before - began)) * 0.995 - 0.01;
    let most = light(conversion(began.elapsed())) * 1.005 + 0.01;
    let right = (least..=most).contains(&lux.value()) && reading.confirmed_by.is_some();
    right
        .then_some(())
        .ok_or(format!("{reading:?}, the light was {least} to {most} lx"))
}

#[tokio::test(start_paused = true)]
async fn the_template_opens_says_who_it_is_and_reads_no_light_from_before() {
    let (meter, script) = template().await;
    let identity = meter.identity().clone();
    assert_eq!(identity.model, "template, no real meter (LUX-1)");
    assert_eq!(
        (identity.serial.as_deref(), identity.firmware.as_deref()),
        (Some("0042"), Some("1.7"))
    );
    assert_eq!(script.lock().unwrap().heard, ["ID?", "UNIT LX", "E?"]);
    let target = Target::parse("ascii-lux:/dev/null?profile=template").unwrap();
    assert_eq!(
        (ASCII_LUX.place)(&target, Kind::LuxMeter).unwrap().line.to_string(),
        "9600 8N1"
    );
    for pause in [0, 3700, 10_000] {
        sleep(Duration::from_millis(pause)).await;
        let not_before = Instant::now();
        let reading = meter.read(not_before, later()).await.unwrap();
        let shown = ((reading.illuminance().unwrap().value() - 100.0) / 0.05).round();
        let from = script.lock().unwrap().began + Duration::from_secs_f64(0.5 * shown);
        assert!(from >= not_before, "light of {:?} before", not_before - from);
        assert!(reading.began <= from && reading.confirmed_by.is_some(), "{reading:?}");
    }
    let reading = meter.read(Instant::now(), later()).await.unwrap();
    assert!(
        reading.illuminance().is_some() && reading.digit.value() == 0.01,
        "{reading:?}"
    );
    meter.set_range(LuxRange::Fixed(1)).await.unwrap();
    assert_eq!(
        meter.set_range(LuxRange::Fixed(2)).await.unwrap_err().kind(),
        ErrorKind::Unsupported
    );
}

#[tokio::test(start_paused = true)]
async fn damaged_late_doubled_old_and_echoed_answers_are_never_the_reading() {
    let length = "E 100.00 lx\r\n".len();
    let flipped = (0..length).flat_map(|at| (0..8).map(move |bit| Fault::Flipped(at, bit)));
    let faults = [
        Fault::Silent,
        Fault::Late(900),
        Fault::Late(1300),
        Fault::Late(2900),
        Fault::Twice(10),
        Fault::Twice(90),
        Fault::Twice(1000),
        Fault::Replaced,
        Fault::Torn,
        Fault::GarbageBefore,
        Fault::GarbageAfter,
        Fault::Echoed,
    ];
    let split = (1..length).map(Fault::Split);
    for fault in faults.into_iter().chain(split).chain(flipped) {
        for at in [0, 1] {
            let (meter, script) = template().await;
            read(&*meter, &script, Instant::now()).await.unwrap();
            sleep(Duration::from_secs(40)).await;
            let normal = std::iter::repeat_n(Fault::Late(20), at);
            script.lock().unwrap().faults.extend(normal.chain([fault]));
            for _ in 0..3 {
                let shown = read(&*meter, &script, Instant::now()).await;
                shown.unwrap_or_else(|wrong| panic!("{fault:?} at {at}: {wrong}"));
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn codes_are_qualities_errors_are_told_and_a_dead_meter_is_asked_four_times() {
    let (meter, script) = template().await;
    for (says, outcome) in [
        ("E OVER", LuxOutcome::OverRange),
        ("E UNDER", LuxOutcome::UnderRange),
        ("E 200000.1 lx", LuxOutcome::OverRange),
    ] {
        script.lock().unwrap().says = Some(says);
        assert_eq!(meter.read(Instant::now(), later()).await.unwrap().outcome, outcome);
    }
    script.lock().unwrap().says = Some("E -0.02 lx");
    let reading = meter.read(Instant::now(), later()).await.unwrap();
    assert_eq!(reading.illuminance().unwrap().value(), -0.02);
    script.lock().unwrap().says = Some("ERR 7");
    let error = meter.read(Instant::now(), later()).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("the meter reports an error"),
        "{error}"
    );
    for says in ["E NAN lx", "E 12,5 lx", "E 12.5 fc"] {
        script.lock().unwrap().says = Some(says);
        let error = meter.read(Instant::now(), later()).await.unwrap_err();
        assert!(
            error.kind() == ErrorKind::Malformed && error.to_string().contains(says),
            "{error}"
        );
    }
    script.lock().unwrap().says = None;
    read(&*meter, &script, Instant::now()).await.unwrap();
    script.lock().unwrap().dead = true;
    script.lock().unwrap().heard.clear();
    let error = meter.read(Instant::now(), later()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert_eq!(
        script.lock().unwrap().heard.len(),
        TRIES as usize,
        "{:?}",
        script.lock().unwrap().heard
    );
    script.lock().unwrap().dead = false;
    script.lock().unwrap().faults.push_back(Fault::Disconnect);
    let error = meter.read(Instant::now(), later()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Disconnected);
}

#[tokio::test(start_paused = true)]
async fn a_file_begins_in_the_folder_of_the_station_and_what_is_wrong_is_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let template = include_str!("../../profiles/template.toml");
    std::fs::write(
        folder.path().join("meter.toml"),
        template.replace("template, no real", "our"),
    )
    .unwrap();
    let open = "ascii-lux:memory:meter?profile=meter.toml";
    let (meter, _) = bench(open, folder.path()).await;
    assert_eq!(meter.unwrap().identity().model, "our meter (LUX-1)");
    for (open, words) in [
        (
            open,
            &["elsewhere/meter.toml", "that come with the program: template"][..],
        ),
        (
            "ascii-lux:memory:meter",
            &["profile=NAME (template, template-on-request) or profile=FILE.toml"],
        ),
        ("ascii-lux:memory:meter?profile=other", &["no such profile"]),
        (
            "ascii-lux:memory:meter?profile=template&head=1",
            &["unknown option head"],
        ),
        (
            "ascii-lux:memory:meter?profile=template&address=1",
            &["template:", "address=1 is given"],
        ),
    ] {
        let error = bench(open, Path::new("elsewhere")).await.0.err().unwrap();
        assert!(matches!(error, OpenError::Address { .. }));
        let error = error.to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
    // A profile for another instrument: the answer that has no form is shown.
    std::fs::write(
        folder.path().join("meter.toml"),
        template.replace("ID {model}", "IDN {model}"),
    )
    .unwrap();
    let error = bench(open, folder.path()).await.0.err().unwrap().to_string();
    assert!(error.contains("\"ID LUX-1,0042,1.7\" has no form"), "{error}");
}
