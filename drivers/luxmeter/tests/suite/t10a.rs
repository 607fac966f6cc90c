//! The T-10A driver against a scripted meter on an in-memory link, with the clock paused.
//!
//! The meter below was written from the manual's text, not from the codec: it converts every half second, and a value
//! says in which conversion it was taken.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{Caution, ErrorKind, LuxMeter, LuxMeterFactory, LuxOutcome, LuxRange, OpenError, Target};
use isolux_luxmeter::KONICA_T10A;
use isolux_transport::{LineSettings, Link, LinkError, Links, MemoryLinks, Parity, Ports, TRIES};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    FlipBit,
    /// An answer that was given before arrives first, the true one after it.
    Replayed,
    /// An answer that was given before arrives instead of the true one.
    Replaced,
    /// The answer arrives twice, the second time so many ms later.
    Twice(u64),
    Disconnect,
}

struct Meter {
    began: Instant,
    remote: bool,
    faults: VecDeque<Fault>,
    /// Overrides of the answer's status: hold, error, battery.
    status: (char, char, char),
    range: char,
    /// Answers until a change of range has happened.
    range_delay: u32,
    heard: Vec<String>,
    /// Overrides the value: what the meter shows, and its exponent.
    shown: Option<(u64, char)>,
    /// What the line replays: the answer at the beginning of the test.
    old: Option<Vec<u8>>,
}

/// Added to the number of a conversion: as values of light, two that follow each other agree.
const BASE: u64 = 9000;

/// A head of a higher number stands in so much less light.
const OTHER_HEAD: u64 = 4000;

impl Meter {
    /// The last three digits: the number of the last complete conversion, whose light is of (n·0.5 s, (n + 1)·0.5 s].
    fn conversion(&self) -> u64 {
        (self.began.elapsed().as_millis() as u64 / 500).saturating_sub(1)
    }
}

fn frame(body: &str) -> Vec<u8> {
    let check = body.bytes().fold(3_u8, |check, byte| check ^ byte);
    format!("\x02{body}\x03{check:02X}\r\n").into_bytes()
}

async fn serve(meter: Arc<Mutex<Meter>>, mut stream: DuplexStream) {
    let mut request = [0; 14];
    while stream.read_exact(&mut request).await.is_ok() {
        let body = String::from_utf8(request[1..9].to_vec()).unwrap();
        assert_eq!(request.to_vec(), frame(&body), "the host's frame");
        let (answer, fault) = {
            let mut meter = meter.lock().unwrap();
            meter.heard.push(body.clone());
            let answer = match &body[2..4] {
                "54" => {
                    meter.remote = true;
                    Some(frame("0054    "))
                }
                "10" if meter.remote => {
                    let wanted = body.chars().nth(6).unwrap();
                    if wanted != '0' && wanted != meter.range {
                        if meter.range_delay == 0 {
                            meter.range = wanted;
                        } else {
                            meter.range_delay -= 1;
                        }
                    }
                    let (hold, error, battery) = meter.status;
                    let value = if let Some((digits, exponent)) = meter.shown {
                        format!("+{digits:04}{exponent}")
                    } else if error == ' ' {
                        let head: u64 = body[..2].parse().unwrap();
                        format!("+{:04}2", BASE - head * OTHER_HEAD + meter.conversion())
                    } else {
                        " ".repeat(6)
                    };
                    Some(frame(&format!(
                        "{}10{hold}{error}{}{battery}{value}{}",
                        &body[..2],
                        meter.range,
                        " ".repeat(12)
                    )))
                }
                _ => None,
            };
            let fault = if answer.is_some() {
                meter.faults.pop_front()
            } else {
                None
            };
            (answer, fault)
        };
        let Some(mut answer) = answer else { continue };
        tokio::time::sleep(Duration::from_millis(15)).await;
        let old = meter.lock().unwrap().old.clone();
        if answer.len() == 32 && old.is_none() {
            meter.lock().unwrap().old = Some(answer.clone());
        }
        let mut again = None;
        match fault {
            Some(Fault::Replayed) => again = Some((20, std::mem::replace(&mut answer, old.unwrap()))),
            Some(Fault::Replaced) => answer = old.unwrap(),
            Some(Fault::Twice(milliseconds)) => again = Some((milliseconds, answer.clone())),
            Some(Fault::Silent) => continue,
            Some(Fault::Disconnect) => return,
            Some(Fault::FlipBit) => answer[12] ^= 1,
            Some(Fault::Late(milliseconds)) => tokio::time::sleep(Duration::from_millis(milliseconds)).await,
            None => {}
        }
        if stream.write_all(&answer).await.is_err() {
            return;
        }
        if let Some((milliseconds, second)) = again {
            tokio::time::sleep(Duration::from_millis(milliseconds)).await;
            if stream.write_all(&second).await.is_err() {
                return;
            }
        }
    }
}

/// Notes the line settings that are asked for: a pty or a pipe would drop them.
struct Noted {
    links: MemoryLinks,
    lines: Arc<Mutex<Vec<LineSettings>>>,
}

#[async_trait::async_trait]
impl Links for Noted {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        self.lines.lock().unwrap().push(line);
        self.links.open(address, line).await
    }
}

type Lines = Arc<Mutex<Vec<LineSettings>>>;

/// A driver, the meter on its line, and the line settings that are asked for.
fn driver(ports: Arc<Ports>) -> Arc<dyn LuxMeterFactory> {
    (KONICA_T10A.factories)(ports).lux_meter.unwrap()
}

fn line() -> (Arc<dyn LuxMeterFactory>, Arc<Mutex<Meter>>, Lines) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("meter").unwrap();
    let meter = Arc::new(Mutex::new(Meter {
        began: Instant::now(),
        remote: false,
        faults: VecDeque::new(),
        status: ('0', ' ', '0'),
        range: '2',
        range_delay: 0,
        heard: vec![],
        shown: None,
        old: None,
    }));
    let twin = Arc::clone(&meter);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    let lines = Arc::new(Mutex::new(vec![]));
    let driver = driver(Ports::new(Arc::new(Noted {
        links,
        lines: Arc::clone(&lines),
    })));
    (driver, meter, lines)
}

async fn bench() -> (Box<dyn LuxMeter>, Arc<Mutex<Meter>>) {
    let (driver, meter, lines) = line();
    let opened = driver
        .open_lux_meter(&Target::parse("konica-t10a:memory:meter?head=0").unwrap())
        .await
        .unwrap();
    let line = LineSettings {
        baud: 9600,
        data_bits: 7,
        parity: Parity::Even,
        stop_bits: 1,
    };
    assert_eq!(*lines.lock().unwrap(), [line]);
    (opened, meter)
}

/// A reading and the moments between which its light fell, by the meter's own word.
async fn read(meter: &dyn LuxMeter, truth: &Arc<Mutex<Meter>>, not_before: Instant) -> (f64, Instant, Instant) {
    let reading = meter
        .read(not_before, Instant::now() + Duration::from_secs(20))
        .await
        .unwrap();
    let LuxOutcome::Measured(lux) = reading.outcome else {
        panic!("{reading:?}")
    };
    let conversion = (lux.value() * 100.0).round() - BASE as f64;
    let from = truth.lock().unwrap().began + Duration::from_millis(500 * conversion as u64);
    let until = from + Duration::from_millis(500);
    assert!(
        reading.began <= from && until <= reading.ended,
        "the stated interval holds the true one"
    );
    (conversion, from, until)
}

#[tokio::test(start_paused = true)]
async fn connects_runs_and_reads() {
    let (meter, truth) = bench().await;
    assert_eq!(truth.lock().unwrap().heard, ["00541   ", "99550  0"]);
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_secs(5))
        .await
        .unwrap();
    assert_eq!((reading.range, reading.digit.value(), reading.caution), (2, 0.01, None));
    assert_eq!(reading.evidence.len(), 32);
    assert_eq!(truth.lock().unwrap().heard[2], "00100200");
}

#[tokio::test(start_paused = true)]
async fn no_light_from_before_the_move_and_no_conversion_twice() {
    let (meter, truth) = bench().await;
    for range in [LuxRange::Fixed(2), LuxRange::Auto] {
        meter.set_range(range).await.unwrap();
        // Whatever the phase between the axes and the meter's half seconds.
        for phase in 0..25 {
            tokio::time::sleep(Duration::from_millis(137 * phase)).await;
            let rest = Instant::now();
            let (mut last, from, _) = read(&*meter, &truth, rest).await;
            assert!(from >= rest, "light from before the axes came to rest");
            for _ in 0..5 {
                let (conversion, ..) = read(&*meter, &truth, rest).await;
                assert!(conversion > last, "the same conversion twice");
                last = conversion;
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_late_reading_never_becomes_the_next_one() {
    let (meter, truth) = bench().await;
    for late in [100, 750, 900, 1500, 2500] {
        truth.lock().unwrap().faults.push_back(Fault::Late(late));
        let rest = Instant::now();
        let (_, from, _) = read(&*meter, &truth, rest).await;
        assert!(from >= rest, "late by {late} ms");
        for _ in 0..4 {
            let rest = Instant::now();
            let (_, from, _) = read(&*meter, &truth, rest).await;
            assert!(from >= rest, "after one late by {late} ms");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_process_that_was_stopped_in_a_reading_blames_no_meter() {
    let (meter, truth) = bench().await;
    for after_ms in [0, 30, 400, 1100, 1900, 2600] {
        let rest = Instant::now();
        let stopped = async {
            tokio::time::sleep(Duration::from_millis(after_ms)).await;
            tokio::time::advance(Duration::from_secs(45)).await;
        };
        let ((_, from, _), ()) = tokio::join!(read(&*meter, &truth, rest), stopped);
        assert!(from >= rest, "stopped after {after_ms} ms");
    }
}

#[tokio::test(start_paused = true)]
async fn damage_and_silence_are_asked_again_and_then_told() {
    let (meter, truth) = bench().await;
    for fault in [Fault::FlipBit, Fault::Silent] {
        truth.lock().unwrap().faults.push_back(fault);
        read(&*meter, &truth, Instant::now()).await;
    }
    truth.lock().unwrap().faults.extend([Fault::FlipBit; 12]);
    let deadline = || Instant::now() + Duration::from_secs(30);
    assert_eq!(
        meter.read(Instant::now(), deadline()).await.unwrap_err().kind(),
        ErrorKind::Malformed
    );
    truth.lock().unwrap().faults.clear();
    truth.lock().unwrap().faults.extend([Fault::Silent; 12]);
    assert_eq!(
        meter.read(Instant::now(), deadline()).await.unwrap_err().kind(),
        ErrorKind::Timeout
    );
    truth.lock().unwrap().faults.clear();
    let soon = Instant::now() + Duration::from_millis(300);
    assert_eq!(
        meter.read(Instant::now(), soon).await.unwrap_err().kind(),
        ErrorKind::Timeout
    );
    assert_eq!(Instant::now(), soon, "the deadline was kept");
    truth.lock().unwrap().faults.push_back(Fault::Disconnect);
    assert_eq!(
        meter.read(Instant::now(), deadline()).await.unwrap_err().kind(),
        ErrorKind::Disconnected
    );
}

#[tokio::test(start_paused = true)]
async fn a_meter_that_lost_its_power_is_connected_again() {
    let (meter, truth) = bench().await;
    truth.lock().unwrap().remote = false;
    read(&*meter, &truth, Instant::now()).await;
    assert_eq!(
        truth
            .lock()
            .unwrap()
            .heard
            .iter()
            .filter(|body| *body == "00541   ")
            .count(),
        2
    );
}

#[tokio::test(start_paused = true)]
async fn over_range_is_a_quality_and_a_broken_head_a_fault() {
    let (meter, truth) = bench().await;
    let deadline = || Instant::now() + Duration::from_secs(10);
    truth.lock().unwrap().status = ('0', '5', '0');
    let over = meter.read(Instant::now(), deadline()).await.unwrap();
    assert_eq!((over.outcome, over.illuminance()), (LuxOutcome::OverRange, None));
    truth.lock().unwrap().status = ('0', '1', '0');
    assert_eq!(
        meter.read(Instant::now(), deadline()).await.unwrap_err().kind(),
        ErrorKind::Fault
    );
    truth.lock().unwrap().status = ('1', ' ', '0');
    let held = meter.read(Instant::now(), deadline()).await.unwrap_err();
    assert!(
        held.kind() == ErrorKind::Fault && held.to_string().contains("HOLD"),
        "{held}"
    );
    truth.lock().unwrap().status = ('0', ' ', '1');
    let low = meter.read(Instant::now(), deadline()).await.unwrap();
    assert_eq!(low.caution, Some(Caution::LowBattery));
}

#[tokio::test(start_paused = true)]
async fn a_range_is_waited_for() {
    let (meter, truth) = bench().await;
    truth.lock().unwrap().range_delay = 2;
    meter.set_range(LuxRange::Fixed(4)).await.unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    assert_eq!(meter.read(Instant::now(), deadline).await.unwrap().range, 4);
    assert_eq!(
        meter.set_range(LuxRange::Fixed(6)).await.unwrap_err().kind(),
        ErrorKind::Unsupported
    );
}

#[tokio::test(start_paused = true)]
async fn wrong_addresses_are_refused() {
    let driver = driver(Ports::new(Arc::new(MemoryLinks::default())));
    for open in ["konica-t10a:memory:x?head=30", "konica-t10a:memory:x?hed=0"] {
        let error = driver
            .open_lux_meter(&Target::parse(open).unwrap())
            .await
            .err()
            .unwrap();
        assert!(matches!(error, OpenError::Address { .. }), "{error}");
    }
}

/// Issue 10, B9: a frame that is played back 0.6 s late was taken for the next answer.
#[tokio::test(start_paused = true)]
async fn an_old_answer_is_never_the_reading() {
    use Fault::{FlipBit, Replaced, Replayed, Silent, Twice};
    for faults in [
        vec![Replayed],
        vec![Replaced],
        vec![Replayed, Replayed],
        vec![FlipBit, Replayed],
        vec![Silent, Replaced],
        vec![Twice(30)],
        vec![Twice(600)],
    ] {
        for first in 0..2 {
            let (meter, truth) = bench().await;
            truth.lock().unwrap().shown = Some((812, '2'));
            meter
                .read(Instant::now(), Instant::now() + Duration::from_secs(10))
                .await
                .unwrap();
            // The axes move; the light is another one.
            truth.lock().unwrap().shown = Some((1234, '2'));
            let good = std::iter::repeat_n(Fault::Late(0), first);
            truth.lock().unwrap().faults = good.chain(faults.iter().copied()).collect();
            for _ in 0..4 {
                let reading = meter
                    .read(Instant::now(), Instant::now() + Duration::from_secs(20))
                    .await
                    .unwrap();
                let lux = reading.illuminance().unwrap().value();
                assert_eq!(
                    (lux, reading.confirmed_by),
                    (12.34, Some(reading.outcome)),
                    "{faults:?}"
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_value_that_its_range_cannot_show_is_damage() {
    let (meter, truth) = bench().await;
    // Range 2 ends at 299.9 lx and shows 0.1 lx.
    for shown in [(3001, '3'), (340, '4'), (9999, '9')] {
        truth.lock().unwrap().shown = Some(shown);
        let error = meter
            .read(Instant::now(), Instant::now() + Duration::from_secs(20))
            .await
            .unwrap_err();
        assert!(
            error.kind() == ErrorKind::Malformed && error.to_string().contains("range 2 can show"),
            "{error}"
        );
    }
    truth.lock().unwrap().shown = Some((2999, '3'));
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_secs(20))
        .await
        .unwrap();
    assert_eq!(reading.illuminance().unwrap().value(), 299.9);
}

#[tokio::test(start_paused = true)]
async fn light_that_does_not_stay_has_no_number() {
    let (meter, truth) = bench().await;
    let changing = async {
        for step in 0_u64.. {
            truth.lock().unwrap().shown = Some((1000 + 100 * (step % 7), '2'));
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
    };
    let reading = tokio::select! {
        reading = meter.read(Instant::now(), Instant::now() + Duration::from_secs(20)) => reading.unwrap(),
        () = changing => panic!(),
    };
    assert_eq!((reading.outcome, reading.illuminance()), (LuxOutcome::Unsteady, None));
}

/// One reading costs two exchanges, each further one of the same light one.
#[tokio::test(start_paused = true)]
async fn confirmation_costs_one_exchange_a_series() {
    let (meter, truth) = bench().await;
    truth.lock().unwrap().shown = Some((812, '2'));
    truth.lock().unwrap().heard.clear();
    let rest = Instant::now();
    for requested in 2..6 {
        meter
            .read(rest, Instant::now() + Duration::from_secs(10))
            .await
            .unwrap();
        assert_eq!(truth.lock().unwrap().heard.len(), requested);
    }
    meter
        .read(Instant::now(), Instant::now() + Duration::from_secs(10))
        .await
        .unwrap();
    assert_eq!(truth.lock().unwrap().heard.len(), 7);
}

/// In a coarse range an old value is easily one digit away: the display of the same light is that near, too.
#[tokio::test(start_paused = true)]
async fn an_old_answer_one_digit_away_is_never_the_reading() {
    for first in 0..3 {
        let (meter, truth) = bench().await;
        let deadline = || Instant::now() + Duration::from_secs(20);
        truth.lock().unwrap().shown = Some((1, '3'));
        meter.read(Instant::now(), deadline()).await.unwrap();
        truth.lock().unwrap().shown = Some((2, '3'));
        let faults = std::iter::repeat_n(Fault::Late(0), first).chain([Fault::Replaced]);
        truth.lock().unwrap().faults = faults.collect();
        let rest = Instant::now();
        for _ in 0..3 {
            let reading = meter.read(rest, deadline()).await.unwrap();
            assert_eq!(reading.illuminance().unwrap().value(), 0.2, "{first}");
        }
        // Light between two values of the display is still read.
        let flicker = async {
            for step in 0_u64.. {
                truth.lock().unwrap().shown = Some((1 + step % 2, '3'));
                tokio::time::sleep(Duration::from_millis(550)).await;
            }
        };
        let reading = tokio::select! {
            reading = meter.read(Instant::now(), deadline()) => reading.unwrap(),
            () = flicker => panic!(),
        };
        assert!(matches!(reading.outcome, LuxOutcome::Measured(_)), "{reading:?}");
    }
}

/// One request in flight at a time over the whole line, and a surplus byte discards what was read from either head.
#[tokio::test(start_paused = true)]
async fn two_heads_on_one_line_never_take_each_others_light() {
    use Fault::{FlipBit, Late, Replaced, Replayed, Silent, Twice};
    for faults in [
        vec![],
        vec![Replayed, Replayed],
        vec![Replaced, Replayed],
        vec![Twice(30), Twice(90), Twice(600)],
        vec![Late(900), Twice(60)],
        vec![FlipBit, Silent, Replayed],
    ] {
        let (driver, truth, lines) = line();
        let head = async |number: u8| {
            let target = Target::parse(&format!("konica-t10a:memory:meter?head={number}")).unwrap();
            driver.open_lux_meter(&target).await.unwrap()
        };
        let heads = [head(0).await, head(1).await];
        assert_eq!(lines.lock().unwrap().len(), 1, "the port is opened once");
        for round in 0..6 {
            if round == 1 {
                truth.lock().unwrap().faults.extend(faults.iter().copied());
            }
            let rest = Instant::now();
            let soon = rest + Duration::from_secs(40);
            let (first, second) = tokio::join!(heads[0].read(rest, soon), heads[1].read(rest, soon));
            for (number, reading) in [first, second].into_iter().enumerate() {
                let reading = reading.unwrap();
                let LuxOutcome::Measured(lux) = reading.outcome else {
                    panic!("{faults:?}: {reading:?}")
                };
                let shown = (lux.value() * 100.0).round() as u64;
                let conversion = shown - (BASE - number as u64 * OTHER_HEAD);
                let from = truth.lock().unwrap().began + Duration::from_millis(500 * conversion);
                assert!(
                    conversion < OTHER_HEAD && from >= rest,
                    "{faults:?}: {reading:?} is of {from:?}"
                );
                assert!(reading.began <= from, "{faults:?}");
            }
        }
    }
}

/// Tries are counted in one place: requests of one reading, and of one opening, until a dead meter is told.
#[tokio::test(start_paused = true)]
async fn a_dead_meter_is_asked_as_often_as_is_stated() {
    let (meter, truth) = bench().await;
    truth.lock().unwrap().faults.extend([Fault::Silent; 40]);
    truth.lock().unwrap().heard.clear();
    let error = meter
        .read(Instant::now(), Instant::now() + Duration::from_mins(1))
        .await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
    let heard = truth.lock().unwrap().heard.clone();
    assert_eq!(heard, ["00100200", "00541   ", "00541   ", "00541   "]);
    assert_eq!(heard.len(), TRIES as usize);

    let (driver, truth, _) = line();
    truth.lock().unwrap().faults.extend([Fault::Silent; 40]);
    let target = Target::parse("konica-t10a:memory:meter").unwrap();
    assert!(matches!(
        driver.open_lux_meter(&target).await,
        Err(OpenError::Device(_))
    ));
    assert_eq!(truth.lock().unwrap().heard, vec!["00541   "; TRIES as usize]);
}
