//! The drivers of MAVO-USB and P-9710 against scripted meters on an in-memory link, with the clock paused.
//!
//! The meters below were written from the manuals' text, not from the codecs. The light of second n is 100 + 0.1 n lx:
//! as values two that follow each other agree, and each says when it was taken.

#![expect(clippy::unwrap_used, clippy::single_match_else, reason = "a test")]

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{ErrorKind, LuxMeter, LuxOutcome, LuxRange, OpenError, Target};
use isolux_luxmeter::DRIVERS;
use isolux_transport::{MemoryLinks, Ports};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    /// The answer arrives twice, the second time so many ms later.
    Twice(u64),
    /// An answer that was given before arrives instead of the true one.
    Replaced,
    /// A byte less.
    Torn,
    /// The host's own bytes come back first.
    Echoed,
    Disconnect,
}

struct Script {
    began: Instant,
    heard: Vec<String>,
    faults: VecDeque<Fault>,
    /// Instead of a measurement.
    error: Option<&'static str>,
    unit: &'static str,
    range: u8,
    automatic: bool,
    old: Option<String>,
}

fn light(second: u64) -> f64 {
    100.0 + 0.1 * second as f64
}

impl Script {
    /// The MAVO: a conversion is complete every two seconds.
    fn mavo(&mut self, command: &str) -> (String, u64) {
        let header = command.trim_end_matches('?');
        let text = match command {
            "ECHO ON" | "UNI:PHOT LX" => command.to_owned(),
            "*IDN?" => "*IDN GOSSEN,M 502, 20387,01,V 1.00".to_owned(),
            "RAN?" => format!("RAN {}", self.range),
            "RAN:AUTO ON" | "RAN:AUTO OFF" => {
                self.automatic = command.ends_with("ON");
                command.to_owned()
            }
            _ if command.starts_with("RAN ") => {
                self.range = command[4..].parse().unwrap();
                command.to_owned()
            }
            _ if "PHOTOMETRIC".starts_with(header) && header.len() >= 3 => match self.error {
                Some(error) => error.to_owned(),
                None => {
                    let conversion = (self.began.elapsed().as_secs() / 2).saturating_sub(1);
                    format!("{command} {:.0}E-01 {}", light(2 * conversion) * 10.0, self.unit)
                }
            },
            _ => "ERROR = 101".to_owned(),
        };
        (text, 20)
    }

    /// The P-9710: a measurement begins with its request and takes half a second.
    fn p9710(&mut self, command: &str) -> (String, u64) {
        let spaced: String = command
            .chars()
            .map(|c| if "; ,\t".contains(c) { ' ' } else { c })
            .collect();
        let spacers: Vec<char> = command.chars().filter(|c| "; ,\t".contains(*c)).collect();
        match spaced.as_str() {
            "GI TT GU" => (format!("P-9710 4.7;1234;\"{}\"", self.unit.to_lowercase()), 20),
            "SN5000GS3" => ("5000".to_owned(), 20),
            "SB1GS0" => {
                self.automatic = true;
                ("1".to_owned(), 20)
            }
            "MV GR GP" => match self.error {
                Some(error) => (error.to_owned(), 500),
                None => {
                    let light = light(self.began.elapsed().as_secs());
                    let value = format!("+{:.4}E+02", light / 100.0);
                    (format!("{value}{}{}{}+61.7", spacers[0], self.range, spacers[1]), 500)
                }
            },
            _ if spaced.starts_with("SB0SR") && spaced.ends_with("GS0 GS1") => {
                (self.automatic, self.range) = (false, spaced[5..6].parse().unwrap());
                (format!("0;{}", self.range), 20)
            }
            _ => ("?1".to_owned(), 20),
        }
    }
}

type Shared = Arc<Mutex<Script>>;

async fn bench(
    open: &str,
    answer: fn(&mut Script, &str) -> (String, u64),
) -> (Result<Box<dyn LuxMeter>, OpenError>, Shared) {
    bench_with(open, answer, |_| {}).await
}

async fn bench_with(
    open: &str,
    answer: fn(&mut Script, &str) -> (String, u64),
    prepare: fn(&mut Script),
) -> (Result<Box<dyn LuxMeter>, OpenError>, Shared) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("meter").unwrap();
    let mut script = Script {
        began: Instant::now(),
        heard: vec![],
        faults: VecDeque::new(),
        error: None,
        unit: "LX",
        range: 3,
        automatic: true,
        old: None,
    };
    prepare(&mut script);
    let script = Arc::new(Mutex::new(script));
    let twin = Arc::clone(&script);
    tokio::spawn(async move {
        let mut stream = listener.accept().await.unwrap();
        let mut inbox = Vec::new();
        let mut byte = [0];
        while stream.read_exact(&mut byte).await.is_ok() {
            if byte[0] != b'\n' {
                inbox.push(byte[0]);
                continue;
            }
            let command = String::from_utf8(std::mem::take(&mut inbox)).unwrap();
            let (stated, fault) = {
                let mut script = twin.lock().unwrap();
                script.heard.push(command.clone());
                (answer(&mut script, &command), script.faults.pop_front())
            };
            let (mut text, mut wait) = stated;
            let old = twin.lock().unwrap().old.replace(text.clone());
            let mut again = None;
            match fault {
                Some(Fault::Silent) => continue,
                Some(Fault::Disconnect) => return,
                Some(Fault::Late(milliseconds)) => wait += milliseconds,
                Some(Fault::Twice(milliseconds)) => again = Some((milliseconds, text.clone())),
                Some(Fault::Replaced) => text = old.unwrap(),
                Some(Fault::Torn) => drop(text.remove(text.len() / 2)),
                Some(Fault::Echoed) => text = format!("{command}\n{text}"),
                None => {}
            }
            sleep(Duration::from_millis(wait)).await;
            if stream.write_all(format!("{text}\n").as_bytes()).await.is_err() {
                return;
            }
            if let Some((milliseconds, text)) = again {
                sleep(Duration::from_millis(milliseconds)).await;
                let _ = stream.write_all(format!("{text}\n").as_bytes()).await;
            }
        }
    });
    let target = Target::parse(open).unwrap();
    let driver = DRIVERS.iter().find(|driver| driver.name == target.driver()).unwrap();
    let factory = (driver.factories)(Ports::new(Arc::new(links))).lux_meter.unwrap();
    (factory.open_lux_meter(&target).await, script)
}

async fn mavo() -> (Box<dyn LuxMeter>, Shared) {
    let (meter, script) = bench("gossen-mavo-usb:memory:meter", Script::mavo).await;
    (meter.unwrap(), script)
}

async fn p9710() -> (Box<dyn LuxMeter>, Shared) {
    let (meter, script) = bench("gigahertz-p9710:memory:meter?a_per_lx=1e-8", Script::p9710).await;
    (meter.unwrap(), script)
}

/// Automatic or not, and the range in the meter's own count.
fn range(script: &Shared) -> (bool, u8) {
    let script = script.lock().unwrap();
    (script.automatic, script.range)
}

/// A reading, and the second whose light it shows, by the meter's own word.
async fn read(meter: &dyn LuxMeter, not_before: Instant) -> (u64, Instant, Instant) {
    let reading = meter
        .read(not_before, Instant::now() + Duration::from_mins(1))
        .await
        .unwrap();
    let LuxOutcome::Measured(lux) = reading.outcome else {
        panic!("{reading:?}")
    };
    assert!(reading.confirmed_by.is_some());
    (
        ((lux.value() - 100.0) / 0.1).round() as u64,
        reading.began,
        reading.ended,
    )
}

#[tokio::test(start_paused = true)]
async fn both_say_who_they_are_and_how_their_line_is_set() {
    let (meter, script) = mavo().await;
    assert_eq!(meter.identity().model, "GOSSEN M 502");
    assert_eq!(meter.identity().serial.as_deref(), Some("20387"));
    assert_eq!(
        script.lock().unwrap().heard,
        ["ECHO ON", "*IDN?", "UNI:PHOT LX", "RAN:AUTO ON"]
    );
    let (meter, script) = p9710().await;
    assert_eq!(
        (meter.identity().model.as_str(), meter.identity().firmware.as_deref()),
        ("Gigahertz-Optik P-9710", Some("4.7"))
    );
    assert_eq!(script.lock().unwrap().heard, ["GI;TT;GU", "SN5000GS3", "SB1GS0"]);
    let full_scales: Vec<f64> = meter
        .properties()
        .range_full_scale
        .iter()
        .map(|lux| lux.value())
        .collect();
    assert!(
        (full_scales[0] / 0.02 - 1.0).abs() < 1e-9 && (full_scales[7] / 2e5 - 1.0).abs() < 1e-9,
        "{full_scales:?}"
    );
    for (open, line) in [
        ("gossen-mavo-usb:/dev/null", "9600 7E2"),
        ("gigahertz-p9710:/dev/null", "9600 8N1"),
    ] {
        let target = Target::parse(open).unwrap();
        let driver = DRIVERS.iter().find(|driver| driver.name == target.driver()).unwrap();
        let place = (driver.place)(&target, isolux_device::Kind::LuxMeter).unwrap();
        assert_eq!(place.line.to_string(), line);
    }
}

#[tokio::test(start_paused = true)]
async fn no_light_from_before_the_move_and_no_conversion_twice() {
    let (meter, script) = mavo().await;
    let began = script.lock().unwrap().began;
    let mut last = 0;
    for pause in [0, 700, 3100] {
        sleep(Duration::from_millis(pause)).await;
        let not_before = Instant::now();
        let (second, from, _) = read(&*meter, not_before).await;
        assert!(
            began + Duration::from_secs(second) >= not_before,
            "light of second {second}"
        );
        assert!(from >= not_before && from <= began + Duration::from_secs(second));
        assert!(second > last);
        last = second;
    }
    let (meter, script) = p9710().await;
    let began = script.lock().unwrap().began;
    sleep(Duration::from_millis(12_345)).await;
    let not_before = Instant::now();
    let (second, from, ended) = read(&*meter, not_before).await;
    assert!(from >= not_before && ended - from < Duration::from_millis(700));
    assert!(began + Duration::from_secs(second + 1) >= not_before);
}

#[tokio::test(start_paused = true)]
async fn lost_late_doubled_torn_old_and_echoed_answers_are_never_the_reading() {
    for fault in [
        Fault::Silent,
        Fault::Late(3300),
        Fault::Late(6100),
        Fault::Twice(10),
        Fault::Twice(90),
        Fault::Twice(1000),
        Fault::Replaced,
        Fault::Torn,
        Fault::Echoed,
    ] {
        for (at, which) in [(0, "mavo"), (1, "mavo"), (2, "mavo"), (0, "p9710"), (1, "p9710")] {
            let (meter, script) = if which == "mavo" { mavo().await } else { p9710().await };
            let (first, ..) = read(&*meter, Instant::now()).await;
            sleep(Duration::from_secs(40)).await;
            let began = script.lock().unwrap().began;
            for _ in 0..at {
                script.lock().unwrap().faults.push_back(Fault::Late(0));
            }
            script.lock().unwrap().faults.push_back(fault);
            for _ in 0..3 {
                let not_before = Instant::now();
                let (second, ..) = read(&*meter, not_before).await;
                let known = began + Duration::from_secs(second + 1);
                assert!(
                    known > not_before,
                    "{which}, {fault:?} at {at}: light of second {second} (first {first})"
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn without_answers_a_reading_ends_at_its_deadline() {
    for half_seconds in 2..40 {
        let patience = Duration::from_millis(500 * half_seconds);
        for answered in 0..4 {
            let (meter, script) = p9710().await;
            script.lock().unwrap().faults.extend(vec![Fault::Late(0); answered]);
            script.lock().unwrap().faults.extend([Fault::Silent; 12]);
            let began = Instant::now();
            let outcome = meter.read(began, began + patience).await;
            assert!(
                began.elapsed() <= patience + Duration::from_secs(1),
                "{patience:?}: {outcome:?}"
            );
            assert!(outcome.is_err() || answered > 1, "{patience:?}: {outcome:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn over_range_is_a_quality_and_a_fault_is_told() {
    let later = || Instant::now() + Duration::from_mins(1);
    let (meter, script) = mavo().await;
    for (error, outcome) in [
        ("ERROR = 019", LuxOutcome::OverRange),
        ("ERROR = 18", LuxOutcome::OverRange),
    ] {
        script.lock().unwrap().error = Some(error);
        assert_eq!(meter.read(Instant::now(), later()).await.unwrap().outcome, outcome);
    }
    script.lock().unwrap().error = Some("ERROR = 202");
    let error = meter.read(Instant::now(), later()).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("sensor is not suitable"),
        "{error}"
    );
    script.lock().unwrap().error = Some("ERROR = 3");
    assert_eq!(
        meter.read(Instant::now(), later()).await.unwrap_err().kind(),
        ErrorKind::Malformed
    );
    let (meter, script) = p9710().await;
    for (error, outcome) in [("?16", LuxOutcome::OverRange), ("?32", LuxOutcome::UnderRange)] {
        script.lock().unwrap().error = Some(error);
        assert_eq!(meter.read(Instant::now(), later()).await.unwrap().outcome, outcome);
    }
    script.lock().unwrap().faults.push_back(Fault::Disconnect);
    assert_eq!(
        meter.read(Instant::now(), later()).await.unwrap_err().kind(),
        ErrorKind::Disconnected
    );
}

#[tokio::test(start_paused = true)]
async fn ranges_are_set_and_those_that_are_not_there_refused() {
    let (meter, script) = mavo().await;
    meter.set_range(LuxRange::Fixed(2)).await.unwrap();
    assert_eq!(range(&script), (false, 1));
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_mins(1))
        .await
        .unwrap();
    assert_eq!(reading.range, 2);
    let error = meter.set_range(LuxRange::Fixed(6)).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    let (meter, script) = p9710().await;
    meter.set_range(LuxRange::Fixed(8)).await.unwrap();
    assert_eq!(range(&script), (false, 0));
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_mins(1))
        .await
        .unwrap();
    assert_eq!(reading.range, 8);
    assert_eq!(
        meter.set_range(LuxRange::Fixed(0)).await.unwrap_err().kind(),
        ErrorKind::Unsupported
    );
}

#[tokio::test(start_paused = true)]
async fn another_unit_and_unknown_options_are_refused_with_a_remedy() {
    let (opened, _) = bench_with("gigahertz-p9710:memory:meter", Script::p9710, |script| {
        script.unit = "W";
    })
    .await;
    let error = opened.err().unwrap().to_string();
    assert!(
        error.contains("\"w\"") && error.contains("calibration data in lx"),
        "{error}"
    );
    let (meter, _) = bench_with("gossen-mavo-usb:memory:meter", Script::mavo, |script| {
        script.unit = "FC";
    })
    .await;
    let error = meter
        .unwrap()
        .read(Instant::now(), Instant::now() + Duration::from_mins(1))
        .await
        .unwrap_err();
    assert!(error.to_string().contains("FC, not LX"), "{error}");
    for (open, word) in [
        ("gossen-mavo-usb:memory:meter?head=1", "head"),
        ("gigahertz-p9710:memory:meter?a_per_lx=-1", "above zero"),
        ("gigahertz-p9710:memory:meter?a_per_lx=x", "not a number"),
    ] {
        let (opened, _) = bench(open, Script::mavo).await;
        let error = opened.err().unwrap().to_string();
        assert!(error.contains(word), "{error}");
    }
}
