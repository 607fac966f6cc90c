//! The driver of Modbus lux meters against a scripted meter on an in-memory link, with the clock paused.
//!
//! The meter below was written from the specification's text, not from the codec. It converts every second, and a value
//! says in which conversion it was taken.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{ErrorKind, LuxMeter, LuxMeterFactory, LuxOutcome, LuxRange, OpenError, Target};
use isolux_luxmeter::MODBUS_LUX;
use isolux_transport::{LineSettings, Link, LinkError, Links, MemoryLinks, Ports, TRIES};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::sync::mpsc;
use tokio::time::Instant;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    FlipBit,
    /// The first answer of the test comes first, the true one after it.
    Replayed,
    /// The first answer of the test comes instead of the true one.
    Replaced,
    /// The answer arrives twice, the second time so many ms later.
    Twice(u64),
    Refused,
    Echo,
    Disconnect,
}

struct Meter {
    began: Instant,
    /// Answers in MBAP frames.
    network: bool,
    /// What the registers hold instead of the conversion.
    shown: Option<u32>,
    /// Every answer comes so much later than it should.
    always_late_ms: u64,
    /// Says nothing to requests for another number of registers than two.
    stubborn: bool,
    faults: VecDeque<Fault>,
    /// Function, first register and count of each request.
    heard: Vec<(u8, u16, u16)>,
    old: Option<Vec<u8>>,
}

/// Added to the number of a conversion: as values of light, two that follow each other agree.
const BASE: u32 = 9000;

impl Meter {
    /// The last complete conversion, whose light is of (n s, (n + 1) s].
    fn conversion(&self) -> u32 {
        (self.began.elapsed().as_secs() as u32).saturating_sub(1)
    }

    /// The PDU of the answer to `pdu`.
    fn answer(&mut self, pdu: &[u8]) -> Option<Vec<u8>> {
        let word = |at: usize| u16::from_be_bytes([pdu[at], pdu[at + 1]]);
        let (function, from, count) = (pdu[0], word(1), word(3));
        self.heard.push((function, from, count));
        if self.stubborn && count != 2 {
            return None;
        }
        let shown = self.shown.unwrap_or(BASE + self.conversion()).to_be_bytes();
        let mut answer = vec![function, count as u8 * 2];
        answer.extend(shown.iter().cycle().take(usize::from(count) * 2));
        Some(answer)
    }
}

fn check(bytes: &[u8]) -> [u8; 2] {
    let mut register = 0xFFFF_u32;
    for byte in bytes {
        register ^= u32::from(*byte);
        for _ in 0..8 {
            let carry = register & 1;
            register >>= 1;
            if carry == 1 {
                register ^= 0xA001;
            }
        }
    }
    [register as u8, (register >> 8) as u8]
}

async fn serve(meter: Arc<Mutex<Meter>>, stream: DuplexStream) {
    let (mut stream, mut answers) = tokio::io::split(stream);
    // Requests go on being read while answers are on their way.
    let (sender, mut queue) = mpsc::unbounded_channel::<(Instant, Vec<u8>)>();
    tokio::spawn(async move {
        while let Some((at, bytes)) = queue.recv().await {
            tokio::time::sleep_until(at).await;
            if answers.write_all(&bytes).await.is_err() {
                return;
            }
        }
    });
    let network = meter.lock().unwrap().network;
    // Each request reads registers: five bytes of PDU.
    let mut request = vec![0; if network { 12 } else { 8 }];
    while stream.read_exact(&mut request).await.is_ok() {
        let (header, unit, pdu) = if network {
            assert_eq!(request[2..6], [0, 0, 0, 6], "protocol and length");
            (request[..4].to_vec(), request[6], &request[7..])
        } else {
            assert_eq!(check(&request[..6]), request[6..], "the host's check");
            (vec![], request[0], &request[1..6])
        };
        let framed = |pdu: &[u8]| {
            if network {
                [&header[..], &[0, pdu.len() as u8 + 1, unit], pdu].concat()
            } else {
                let body = [&[unit], pdu].concat();
                [&body[..], &check(&body)].concat()
            }
        };
        let (answer, fault, late) = {
            let mut meter = meter.lock().unwrap();
            let answer = meter.answer(pdu);
            let fault = answer.as_ref().and_then(|_| meter.faults.pop_front());
            (answer, fault, meter.always_late_ms)
        };
        let Some(pdu) = answer else { continue };
        let mut answer = if fault == Some(Fault::Refused) {
            framed(&[pdu[0] | 0x80, 2])
        } else {
            framed(&pdu)
        };
        let old = {
            let mut meter = meter.lock().unwrap();
            if meter.old.is_none() && pdu[1] == 4 {
                meter.old = Some(answer.clone());
            }
            meter.old.clone()
        };
        let (mut wait_ms, mut again) = (15 + late, None);
        match fault {
            Some(Fault::Replayed) => again = Some((20, std::mem::replace(&mut answer, old.unwrap()))),
            Some(Fault::Replaced) => answer = old.unwrap(),
            Some(Fault::Twice(milliseconds)) => again = Some((milliseconds, answer.clone())),
            Some(Fault::Silent) => continue,
            Some(Fault::Echo) => answer.clone_from(&request),
            Some(Fault::Disconnect) => return,
            Some(Fault::FlipBit) => {
                let at = answer.len() - 4;
                answer[at] ^= 1;
            }
            Some(Fault::Late(milliseconds)) => wait_ms += milliseconds,
            Some(Fault::Refused) | None => {}
        }
        let send = |wait_ms, bytes| {
            let at = Instant::now() + Duration::from_millis(wait_ms);
            sender.send((at, bytes)).is_ok()
        };
        let sent = send(wait_ms, answer) && again.is_none_or(|(later_ms, bytes)| send(wait_ms + later_ms, bytes));
        if !sent {
            return;
        }
    }
}

/// Every address is the meter's; the line settings that are asked for are noted.
struct Noted {
    links: MemoryLinks,
    lines: Arc<Mutex<Vec<(String, LineSettings)>>>,
}

#[async_trait::async_trait]
impl Links for Noted {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        self.lines.lock().unwrap().push((address.to_owned(), line));
        self.links.open("memory:meter", line).await
    }
}

type Lines = Arc<Mutex<Vec<(String, LineSettings)>>>;

fn line(network: bool) -> (Arc<dyn LuxMeterFactory>, Arc<Mutex<Meter>>, Lines) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("meter").unwrap();
    let meter = Arc::new(Mutex::new(Meter {
        began: Instant::now(),
        network,
        shown: None,
        always_late_ms: 0,
        stubborn: false,
        faults: VecDeque::new(),
        heard: vec![],
        old: None,
    }));
    let twin = Arc::clone(&meter);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    let lines = Lines::default();
    let links = Noted {
        links,
        lines: Arc::clone(&lines),
    };
    let driver = (MODBUS_LUX.factories)(Ports::new(Arc::new(links)));
    (driver.lux_meter.unwrap(), meter, lines)
}

async fn opened(driver: &Arc<dyn LuxMeterFactory>, open: &str) -> Result<Box<dyn LuxMeter>, OpenError> {
    driver.open_lux_meter(&Target::parse(open).unwrap()).await
}

const RTU: &str = "modbus-lux:/dev/x?profile=rs485-u32&unit=1";

async fn bench() -> (Box<dyn LuxMeter>, Arc<Mutex<Meter>>) {
    let (driver, meter, lines) = line(false);
    let opened = opened(&driver, RTU).await.unwrap();
    let lines = lines.lock().unwrap();
    assert_eq!(lines.len(), 1);
    assert_eq!(lines[0].1.to_string(), "9600 8N1", "the profile's line settings");
    (opened, meter)
}

fn within(seconds: u64) -> Instant {
    Instant::now() + Duration::from_secs(seconds)
}

/// A reading and the moment from which on its light fell, by the meter's own word.
async fn read(meter: &dyn LuxMeter, truth: &Arc<Mutex<Meter>>, not_before: Instant) -> (u32, Instant) {
    let reading = meter.read(not_before, within(40)).await.unwrap();
    let LuxOutcome::Measured(lux) = reading.outcome else {
        panic!("{reading:?}")
    };
    let conversion = lux.value() as u32 - BASE;
    let from = truth.lock().unwrap().began + Duration::from_secs(conversion.into());
    let until = from + Duration::from_secs(1);
    assert!(
        reading.began <= from && until <= reading.ended,
        "the stated interval holds the true one"
    );
    (conversion, from)
}

#[tokio::test(start_paused = true)]
async fn opens_and_reads_in_both_frames() {
    for (network, open) in [
        (false, RTU),
        (false, "modbus-lux:tcp://10.0.0.5:4001?profile=rs485-u32"),
        (true, "modbus-lux:modbus-tcp://10.0.0.5:502?profile=rs485-u32&unit=255"),
    ] {
        let (driver, truth, lines) = line(network);
        let meter = opened(&driver, open).await.unwrap();
        assert_eq!(meter.identity().model, "RS-485 illuminance transmitter, u32 at 0007h");
        assert_eq!(meter.properties().range_full_scale[0].value(), 200_000.0);
        let reading = meter.read(Instant::now(), within(10)).await.unwrap();
        assert!(matches!(reading.outcome, LuxOutcome::Measured(_)), "{reading:?}");
        assert_eq!((reading.range, reading.digit.value()), (0, 1.0));
        assert_eq!(reading.evidence.len(), if network { 13 } else { 9 });
        assert_eq!(truth.lock().unwrap().heard[0], (3, 7, 2));
        let address = lines.lock().unwrap()[0].0.clone();
        assert!(open.contains(&address), "{address}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_profile_of_the_operators_own_is_read_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let text = "format = \"isolux-modbus-lux/1\"\nmodel = \"mine\"\n[line]\nbaud = 19200\ndata_bits = 8\nparity = \"even\"\n\
                stop_bits = 1\n[reading]\nfunction = 4\nregister = 0x10\ntype = \"f32\"\nword_order = \"high_first\"\n\
                scale = 1.0\nunit = \"klx\"\nrange = [-1.0, 120.0]\nresolution = 0.001\n[reading.errors]\n\
                \"head missing\" = -9999\n[timing]\nupdate_interval_s = 1.0\nintegration_s = 0.5\n";
    std::fs::write(&file, text).unwrap();
    let (driver, truth, lines) = line(false);
    let open = format!("modbus-lux:/dev/x?profile={}&unit=7", file.display());
    let show = |value: f32| truth.lock().unwrap().shown = Some(value.to_bits());
    show(1.25);
    let meter = opened(&driver, &open).await.unwrap();
    assert_eq!(lines.lock().unwrap()[0].1.to_string(), "19200 8E1");
    for (raw, lux) in [(1.25, 1250.0), (-0.5, -500.0)] {
        show(raw);
        let reading = meter.read(Instant::now(), within(20)).await.unwrap();
        assert_eq!(reading.illuminance().unwrap().value(), lux);
    }
    assert_eq!(truth.lock().unwrap().heard[0], (4, 0x10, 2));
    for (raw, outcome) in [
        (121.0, LuxOutcome::OverRange),
        (f32::INFINITY, LuxOutcome::OverRange),
        (-2.0, LuxOutcome::UnderRange),
    ] {
        show(raw);
        let reading = meter.read(Instant::now(), within(20)).await.unwrap();
        assert_eq!(
            (reading.outcome, reading.illuminance()),
            (outcome, None),
            "over-range is a quality"
        );
    }
    for (raw, part) in [(-9999.0, "head missing"), (f32::NAN, "no number")] {
        show(raw);
        let error = meter.read(Instant::now(), within(20)).await.unwrap_err();
        assert!(
            error.kind() == ErrorKind::Fault && error.to_string().contains(part),
            "{error}"
        );
    }
    std::fs::write(&file, text.replace("scale = 1.0", "scale = 1.0\nfactor = 2.0")).unwrap();
    let error = opened(&driver, &open).await.err().unwrap().to_string();
    assert!(error.contains("mine.toml:14: unknown field `factor`"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn no_light_from_before_the_move_and_no_conversion_twice() {
    let (meter, truth) = bench().await;
    // Whatever the phase between the axes and the meter's seconds.
    for phase in 0..25 {
        tokio::time::sleep(Duration::from_millis(137 * phase)).await;
        let rest = Instant::now();
        let (mut last, from) = read(&*meter, &truth, rest).await;
        assert!(from >= rest, "light from before the axes came to rest");
        for _ in 0..5 {
            let (conversion, _) = read(&*meter, &truth, rest).await;
            assert!(conversion > last, "the same conversion twice");
            last = conversion;
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_late_reading_never_becomes_the_next_one() {
    let (meter, truth) = bench().await;
    for late in [100, 450, 750, 900, 1500, 2500] {
        truth.lock().unwrap().faults.push_back(Fault::Late(late));
        for _ in 0..5 {
            let rest = Instant::now();
            let (_, from) = read(&*meter, &truth, rest).await;
            assert!(from >= rest, "late by {late} ms");
        }
    }
}

/// Where every answer is later than the silence after a failure, each fits the next request: it is the answer to the
/// request for another number of registers that tells them apart.
#[tokio::test(start_paused = true)]
async fn a_line_that_is_always_late_gives_no_reading() {
    for late in [600, 1000, 1520, 1600, 2000, 3100] {
        let (meter, truth) = bench().await;
        truth.lock().unwrap().always_late_ms = late;
        let rest = Instant::now();
        let result = meter.read(rest, within(60)).await;
        assert!(result.is_err(), "late by {late} ms: {result:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn damage_and_silence_are_asked_again_and_then_told() {
    let (meter, truth) = bench().await;
    for fault in [Fault::FlipBit, Fault::Silent, Fault::Echo] {
        truth.lock().unwrap().faults.push_back(fault);
        read(&*meter, &truth, Instant::now()).await;
    }
    for (fault, kind) in [
        (Fault::FlipBit, ErrorKind::Malformed),
        (Fault::Silent, ErrorKind::Timeout),
        (Fault::Refused, ErrorKind::Refused),
    ] {
        truth.lock().unwrap().faults.extend([fault; 12]);
        assert_eq!(meter.read(Instant::now(), within(60)).await.unwrap_err().kind(), kind);
        truth.lock().unwrap().faults.clear();
    }
    let soon = Instant::now() + Duration::from_millis(300);
    assert_eq!(
        meter.read(Instant::now(), soon).await.unwrap_err().kind(),
        ErrorKind::Timeout
    );
    assert_eq!(Instant::now(), soon, "the deadline was kept");
    truth.lock().unwrap().faults.push_back(Fault::Disconnect);
    assert_eq!(
        meter.read(Instant::now(), within(60)).await.unwrap_err().kind(),
        ErrorKind::Disconnected
    );
}

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
            let (driver, truth, _) = line(false);
            truth.lock().unwrap().shown = Some(812);
            let meter = opened(&driver, RTU).await.unwrap();
            meter.read(Instant::now(), within(20)).await.unwrap();
            // The axes move; the light is another one.
            truth.lock().unwrap().shown = Some(1234);
            let good = std::iter::repeat_n(Fault::Late(0), first);
            truth.lock().unwrap().faults = good.chain(faults.iter().copied()).collect();
            for _ in 0..4 {
                let reading = meter.read(Instant::now(), within(40)).await.unwrap();
                let lux = reading.illuminance().unwrap().value();
                assert_eq!(
                    (lux, reading.confirmed_by),
                    (1234.0, Some(reading.outcome)),
                    "{faults:?}"
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn light_that_does_not_stay_has_no_number() {
    let (meter, truth) = bench().await;
    let changing = async {
        for step in 0_u32.. {
            truth.lock().unwrap().shown = Some(1000 + 100 * (step % 7));
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
    };
    let reading = tokio::select! {
        reading = meter.read(Instant::now(), within(60)) => reading.unwrap(),
        () = changing => panic!(),
    };
    assert_eq!((reading.outcome, reading.illuminance()), (LuxOutcome::Unsteady, None));
}

#[tokio::test(start_paused = true)]
async fn a_meter_that_answers_readings_alone_is_read_too() {
    let (driver, truth, _) = line(false);
    truth.lock().unwrap().stubborn = true;
    let meter = opened(&driver, RTU).await.unwrap();
    for fault in [Fault::FlipBit, Fault::Silent, Fault::Late(700)] {
        truth.lock().unwrap().faults.push_back(fault);
        let rest = Instant::now();
        let (_, from) = read(&*meter, &truth, rest).await;
        assert!(from >= rest);
    }
}

#[tokio::test(start_paused = true)]
async fn wrong_addresses_are_refused() {
    let (driver, _truth, lines) = line(false);
    for (open, part) in [
        ("modbus-lux:/dev/x", "needs profile=NAME"),
        ("modbus-lux:/dev/x?profile=rs485", "no such profile"),
        ("modbus-lux:/dev/x?profile=rs485-u32&unit=0", "unit=0 is not 1 to 247"),
        (
            "modbus-lux:/dev/x?profile=rs485-u32&head=0",
            "unknown option head; known: profile, unit",
        ),
        (
            "modbus-lux:modbus-tcp://h:502?profile=rs485-u32&unit=256",
            "unit=256 is not 0 to 255",
        ),
    ] {
        let error = opened(&driver, open).await.err().unwrap();
        assert!(
            matches!(error, OpenError::Address { .. }) && error.to_string().contains(part),
            "{open}: {error}"
        );
    }
    assert!(lines.lock().unwrap().is_empty(), "nothing was opened");
    let meter = opened(&driver, RTU).await.unwrap();
    assert_eq!(meter.set_range(LuxRange::Auto).await, Ok(()));
    assert_eq!(
        meter.set_range(LuxRange::Fixed(1)).await.unwrap_err().kind(),
        ErrorKind::Unsupported
    );
}

/// Tries are counted in one place.
#[tokio::test(start_paused = true)]
async fn a_dead_meter_is_asked_as_often_as_is_stated() {
    let (meter, truth) = bench().await;
    truth.lock().unwrap().faults.extend([Fault::Silent; 40]);
    truth.lock().unwrap().heard.clear();
    let error = meter.read(Instant::now(), within(60)).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
    assert_eq!(truth.lock().unwrap().heard.len(), TRIES as usize);

    let (driver, truth, _) = line(false);
    truth.lock().unwrap().faults.extend([Fault::Silent; 40]);
    assert!(matches!(opened(&driver, RTU).await, Err(OpenError::Device(_))));
    assert_eq!(truth.lock().unwrap().heard.len(), TRIES as usize);
}
