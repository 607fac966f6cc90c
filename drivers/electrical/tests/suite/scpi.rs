//! Power meters and supplies in SCPI against scripted instruments on an in-memory link, with the clock paused.
//!
//! The instruments were written from captures and programming guides, not from the codec.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{ErrorKind, Factories, Quantity, Target};
use isolux_electrical::DRIVERS;
use isolux_transport::{MemoryLinks, Ports};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    Twice,
    /// The answer to the request before comes instead.
    Shifted,
    Torn,
}

struct Script {
    heard: Vec<String>,
    faults: VecDeque<Fault>,
    settings: BTreeMap<String, String>,
    errors: VecDeque<&'static str>,
    reading: String,
    last: String,
}

impl Script {
    fn new(reading: &str) -> Self {
        Self {
            heard: vec![],
            faults: VecDeque::new(),
            settings: BTreeMap::new(),
            errors: VecDeque::new(),
            reading: reading.to_owned(),
            last: String::new(),
        }
    }

    fn answer(&mut self, message: &str) -> Option<String> {
        self.heard.push(message.to_owned());
        let setting = |settings: &BTreeMap<String, String>, key: &str| settings.get(key).cloned().unwrap_or_default();
        Some(match message {
            "*IDN?" => "GWInstek,GPM-8213,GES913349,V1.05".to_owned(),
            "SYST:ERR?" | ":SYST:ERR?" => self.errors.pop_front().unwrap_or("0, \"No error\"").to_owned(),
            // The captures show this header.
            ":NUM:NORM:NUMBER?" => format!(":NUM:NORM:NUMB {}", setting(&self.settings, ":NUM:NORM:NUMBER")),
            ":NUM:NORM:VAL?" => self.reading.clone(),
            ":OUTP:OVP:QUES? CH1" | ":OUTP:OCP:QUES? CH1" => match self.settings.get("tripped") {
                Some(word) => word.clone(),
                None => "NO".to_owned(),
            },
            ":OUTP? CH1" => match self.settings.get(":OUTP") {
                Some(word) => word.trim_start_matches("CH1,").to_owned(),
                None => "OFF".to_owned(),
            },
            _ => match (message.strip_suffix('?'), message.split_once(' ')) {
                (Some(key), _) => setting(&self.settings, key),
                (None, Some((key, value))) => {
                    self.settings.insert(key.to_owned(), value.to_owned());
                    return None;
                }
                _ => return None,
            },
        })
    }
}

type Shared = Arc<Mutex<Script>>;

fn bench(driver: &str, idn: &'static str, reading: &str) -> (Factories, Shared) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("instrument").unwrap();
    let script = Arc::new(Mutex::new(Script::new(reading)));
    let twin = Arc::clone(&script);
    tokio::spawn(async move {
        let mut stream = listener.accept().await.unwrap();
        let (mut inbox, mut byte) = (Vec::new(), [0]);
        while stream.read_exact(&mut byte).await.is_ok() {
            if byte[0] != b'\n' {
                inbox.push(byte[0]);
                continue;
            }
            let message = String::from_utf8(std::mem::take(&mut inbox)).unwrap();
            let (answer, fault) = {
                let mut script = twin.lock().unwrap();
                let answer = match message.trim_end() {
                    "*IDN?" => script.answer("*IDN?").map(|_| idn.to_owned()),
                    message => script.answer(message),
                };
                let fault = answer.as_ref().and_then(|_| script.faults.pop_front());
                (answer, fault)
            };
            let Some(mut answer) = answer else { continue };
            let last = std::mem::replace(&mut twin.lock().unwrap().last, answer.clone());
            sleep(Duration::from_millis(15)).await;
            match fault {
                Some(Fault::Silent) => continue,
                Some(Fault::Late(milliseconds)) => sleep(Duration::from_millis(milliseconds)).await,
                Some(Fault::Shifted) => answer = last,
                Some(Fault::Torn) => drop(answer.remove(answer.len() / 2)),
                Some(Fault::Twice) => stream.write_all(format!("{answer}\r\n").as_bytes()).await.unwrap(),
                None => {}
            }
            if stream.write_all(format!("{answer}\r\n").as_bytes()).await.is_err() {
                return;
            }
        }
    });
    let driver = DRIVERS.iter().find(|known| known.name == driver).unwrap();
    ((driver.factories)(Ports::new(Arc::new(links))), script)
}

const GPM: &str = "GWInstek,GPM-8213,GES913349,V1.05";
const DP: &str = "RIGOL TECHNOLOGIES,DP832,DP8C194205678,00.01.14";

async fn meter(reading: &str) -> (Box<dyn isolux_device::PowerMeter>, Shared) {
    let (factories, script) = bench("scpi-meter", GPM, reading);
    let target = Target::parse("scpi-meter:memory:instrument?profile=gpm-8213").unwrap();
    (
        factories.power_meter.unwrap().open_power_meter(&target).await.unwrap(),
        script,
    )
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(30)
}

#[tokio::test(start_paused = true)]
async fn a_meter_is_set_up_checked_and_read_in_one_query() {
    // U, I, P and λ of the capture G1.
    let (meter, script) = meter("127.58E+00,240.02E-03,17.688E+00,0.5776E+00").await;
    assert_eq!(
        (meter.identity().model.as_str(), meter.identity().serial.as_deref()),
        ("GWInstek GPM-8213", Some("GES913349"))
    );
    let not_before = Instant::now();
    let reading = meter.read(not_before, soon()).await.unwrap();
    assert!(reading.steady && reading.began >= not_before && reading.retries == 0);
    let values = [reading.voltage, reading.current, reading.power, reading.power_factor].map(Quantity::value);
    assert_eq!(values, [Some(127.58), Some(0.240_02), Some(17.688), Some(0.5776)]);
    let heard = script.lock().unwrap().heard.clone();
    assert!(
        heard.contains(&":NUM:NORM:ITEM4 LAMBDA".to_owned())
            && heard.iter().filter(|text| *text == ":NUM:NORM:VAL?").count() == 2,
        "{heard:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn sentinels_are_qualities_and_mixed_up_answers_damage() {
    let (meter, script) = meter("230.0,NAN,9.9E37,0.5").await;
    let reading = meter.read(Instant::now(), soon()).await.unwrap();
    assert_eq!(
        (reading.current, reading.power),
        (Quantity::NoData, Quantity::OverRange)
    );
    for (text, reason) in [
        // Logged as volts by others; a range answer that came late.
        ("1.000E+00;1;300.0E+00;1", "1 values, expected 4"),
        ("230.0,0.2,46.0", "3 values, expected 4"),
        ("230.0,0.2,ERR,0.5", "no value of Power"),
        ("230.0,0.2000,92.00,0.5000", "cannot be"),
        ("230.0,0.2000,46.00,0.1000", "cannot be"),
        ("0.2000,230.0,46.00,1.4000", "cannot be"),
    ] {
        script.lock().unwrap().reading = text.to_owned();
        let error = meter.read(Instant::now(), soon()).await.unwrap_err();
        assert!(
            error.kind() == ErrorKind::Malformed && error.to_string().contains(reason),
            "{text}: {error}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn lost_late_doubled_and_shifted_answers_are_never_the_reading() {
    for fault in [
        Fault::Silent,
        Fault::Late(1500),
        Fault::Late(2900),
        Fault::Twice,
        Fault::Shifted,
        Fault::Torn,
    ] {
        for at in 0..2 {
            let (meter, script) = meter("230.0,0.1000,20.00,0.8696").await;
            meter.read(Instant::now(), soon()).await.unwrap();
            {
                let mut script = script.lock().unwrap();
                // The load has changed; what is still on its way shows the old one.
                script.reading = "230.0,0.2000,40.00,0.8696".to_owned();
                script.last = "230.0,0.1000,20.00,0.8696".to_owned();
                script.faults.extend([Fault::Late(0)].repeat(at));
                script.faults.push_back(fault);
            }
            for _ in 0..2 {
                let reading = meter.read(Instant::now(), soon()).await.unwrap();
                assert!(
                    reading.steady && reading.power.value() == Some(40.0),
                    "{fault:?} at {at}: {reading:?}"
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_load_that_changes_is_not_steady() {
    let (meter, script) = meter("230.0,0.1000,20.00,0.8700").await;
    let changing = tokio::spawn(async move {
        for n in 1.. {
            sleep(Duration::from_millis(200)).await;
            let power = 20.0 + 0.2 * f64::from(n % 10);
            script.lock().unwrap().reading = format!("230.0,0.1000,{power:.2},{:.4}", power / 23.0);
        }
    });
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_secs(4))
        .await
        .unwrap();
    assert!(!reading.steady, "{reading:?}");
    changing.abort();
}

#[tokio::test(start_paused = true)]
async fn a_refused_setting_another_instrument_and_a_bad_address_are_one_message() {
    let (factories, script) = bench("scpi-supply", DP, "");
    let target = Target::parse("scpi-supply:memory:instrument?profile=dp800&voltage_v=24&current_a=0.35").unwrap();
    // What an earlier program left in the queue is nobody's failure now.
    script.lock().unwrap().errors.push_back("-222,\"Data out of range\"");
    let lamp = factories.switch.unwrap().open_switch(&target).await.unwrap();
    script.lock().unwrap().errors.push_back("-113,\"Undefined header\"");
    let error = lamp.set(true).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Refused && error.to_string().contains("-113, Undefined header"),
        "{error}"
    );
    let target = Target::parse("scpi-meter:memory:instrument?profile=gpm-8213").unwrap();
    let (factories, _) = bench("scpi-meter", DP, "");
    let error = factories
        .power_meter
        .unwrap()
        .open_power_meter(&target)
        .await
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("DP832") && error.contains("the profile is for GPM-8213"),
        "{error}"
    );
    for (open, word) in [
        ("scpi-meter:/dev/null", "profile=NAME"),
        ("scpi-meter:/dev/null?profile=nosuch", "gpm-8213, pw3336"),
        (
            "scpi-supply:/dev/null?profile=dp800&channel=4&voltage_v=1&current_a=1",
            "1 to 3",
        ),
        ("scpi-supply:/dev/null?profile=dp800&voltage_v=24", "current_a"),
        (
            "scpi-supply:/dev/null?profile=dp800&voltage_v=-1&current_a=1",
            "voltage_v, above zero",
        ),
    ] {
        let target = Target::parse(open).unwrap();
        let driver = DRIVERS.iter().find(|driver| driver.name == target.driver()).unwrap();
        let error = (driver.place)(&target, isolux_device::Kind::Switch)
            .unwrap_err()
            .to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_supply_sets_its_limits_before_it_switches_and_tells_a_trip() {
    let (factories, script) = bench("scpi-supply", DP, "");
    let target = Target::parse("scpi-supply:memory:instrument?profile=dp800&voltage_v=24&current_a=0.35").unwrap();
    let lamp = factories.switch.unwrap().open_switch(&target).await.unwrap();
    assert!(!lamp.state().await.unwrap());
    lamp.set(true).await.unwrap();
    assert!(lamp.state().await.unwrap());
    let commands: Vec<String> = script
        .lock()
        .unwrap()
        .heard
        .iter()
        .filter(|text| !text.contains('?'))
        .cloned()
        .collect();
    assert_eq!(commands, [":SOUR1:CURR 0.35", ":SOUR1:VOLT 24", ":OUTP CH1,ON"]);
    lamp.set(false).await.unwrap();
    assert!(!lamp.state().await.unwrap());
    script
        .lock()
        .unwrap()
        .settings
        .insert("tripped".to_owned(), "YES".to_owned());
    for error in [lamp.state().await.unwrap_err(), lamp.set(true).await.unwrap_err()] {
        assert!(
            error.kind() == ErrorKind::Fault && error.to_string().contains("a protection has tripped"),
            "{error}"
        );
    }
    assert_eq!(script.lock().unwrap().settings.get(":OUTP").unwrap(), "CH1,OFF");
}
