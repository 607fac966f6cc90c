//! Konica Minolta T-10A: `konica-t10a:LINK?head=0`.
//!
//! The meter converts all the time, a new value every half second, and a request gets the latest one. So a request sent
//! at `t` is answered with light of (t − 1 s, t], and while the automatic range is changing the old value is repeated
//! for one interval more (manual, section 1). The driver therefore waits two intervals after `not_before` in a fixed
//! range, three in automatic range, and more than one interval between two requests, so that no conversion is returned
//! twice.
//!
//! An answer carries no number that would tie it to its request: see the module `confirmed` for when a value is
//! believed.
//!
//! Several heads on one line are as many meters that share the line: while one of them waits for its answer, and for as
//! long after it as the true answer could still come, no other request is sent; a byte that nothing had asked for
//! discards what was read from every head. The commands 54 and 55 concern all heads alike.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{Caution, DeviceError, Identity, Kind, LuxRange, OpenError, Target};
use isolux_protocol_t10a::{Answer, Host, QUIET, Range, Request, Status, Value};
use isolux_transport::{Driver, LineSettings, Parity, Place, Probe, TRIES, printable, worth_another_try};
use tokio::time::{Instant, sleep};

use crate::language::{Converts, Failure, Language, Link, Meaning, Said, Step, Timing};
use crate::meter;

/// Konica Minolta T-10A.
pub const KONICA_T10A: Driver = Driver {
    name: T10a::NAME,
    speaks_to: "Konica Minolta T-10A lux meter",
    examples: &[(Kind::LuxMeter, "konica-t10a:/dev/ttyUSB1?head=0")],
    seen_with: "🧪 its virtual twin",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        // Command 54, the only one that a meter answers when it was just switched on: it goes into PC mode.
        request: b"\x0200541   \x0313\r\n",
        read: |bytes| {
            let text = printable(bytes);
            // Its status, and no echo of the request.
            let status = text.strip_prefix("0054")?;
            (!status.starts_with("1   ")).then(|| "Konica Minolta T-10A, in PC mode".to_owned())
        },
    }],
    place: meter::place::<T10a>,
    display_lx: meter::display_lx::<T10a>,
    factories: meter::factories::<T10a>,
};

/// Manual, section 2.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 7,
    parity: Parity::Even,
    stop_bits: 1,
};

/// A new value appears this often, and integrates as long.
const UPDATE: Duration = Duration::from_millis(500);

/// An answer of 32 bytes takes 33 ms at 9600 baud; the meter may finish a conversion first.
const ANSWER: Duration = Duration::from_millis(800);

/// 14 bytes of a request and 32 of its answer take 47.9 ms, ten bits a byte; less what clocks and links differ by.
const EXCHANGE: Duration = Duration::from_millis(45);

/// For one try at commands 54 and 55, silence of the line before and other heads' readings included.
const OPENING: Duration = Duration::from_secs(6);

/// After commands 54 and 55 the meter wants half a second (manual, sections 5.4 and 5.5).
const SETTLE: Duration = Duration::from_millis(500);

/// Upper ends of the five ranges in lx.
const FULL_SCALE_LX: [f64; 5] = [29.99, 299.9, 2999.0, 29_990.0, 299_900.0];

struct T10a {
    head: u8,
}

#[async_trait]
impl Language for T10a {
    type Conversation = Host;

    const NAME: &'static str = "konica-t10a";

    fn of(target: &Target) -> Result<Self, OpenError> {
        target.only(&["head"])?;
        match target.number("head", 0_u8)? {
            head @ 0..=29 => Ok(Self { head }),
            head => Err(target.wrong(format!("head={head} is not 0 to 29"))),
        }
    }

    fn place(&self) -> Place {
        let channel = format!("head {}", self.head);
        Place { channel, line: LINE }
    }

    fn conversation(&self, _: &Target) -> Host {
        Host::default()
    }

    /// The language has no word for it, nor for its serial number.
    fn model(&self) -> String {
        "Konica Minolta T-10A".to_owned()
    }

    // Four digits (manual, specifications): 29.99 lx in steps of 0.01 lx, and so on by tens.
    fn ranges_lx(&self) -> Vec<(f64, Option<f64>)> {
        let digits = (0..).map(|range| Some(0.01 * 10_f64.powi(range)));
        FULL_SCALE_LX.into_iter().zip(digits).collect()
    }

    fn timing(&self) -> Timing {
        Timing {
            update_interval: UPDATE,
            integration: UPDATE,
            converts: Converts::AlwaysAndRepeats,
            answer: ANSWER,
        }
    }

    fn soonest(&self) -> Option<Duration> {
        Some(EXCHANGE)
    }

    fn choosing(&self, range: LuxRange) -> Result<Vec<Step<Self>>, String> {
        match range {
            LuxRange::Auto | LuxRange::Fixed(1..=5) => Ok(Vec::new()),
            LuxRange::Fixed(_) => Err("the T-10A has ranges 1 to 5".to_owned()),
        }
    }

    fn reading(&self, range: LuxRange) -> Vec<Step<Self>> {
        let (head, hold) = (self.head, false);
        let range = match range {
            LuxRange::Auto => Range::Auto,
            LuxRange::Fixed(range) => Range::Fixed(range),
        };
        vec![(Request::Read { head, range, hold }, "read".to_owned())]
    }

    fn stated(&self, wanted: LuxRange, answers: &[Option<(Answer, Vec<u8>)>]) -> Result<Said, Failure> {
        let measurement = match answers {
            [Some((Answer::Long { measurement, .. }, _))] => measurement,
            [Some((Answer::Short { .. }, _))] => return Err(Failure::malformed("no measurement")),
            _ => return Err(Failure::malformed("nobody answers this request")),
        };
        let status = measurement.status;
        // A range that was asked for and is not there yet: the value is an old one.
        if matches!(wanted, LuxRange::Fixed(range) if status.range != range) {
            return Err(Failure::malformed("the range that was asked for is not in use yet"));
        }
        let (meaning, digit_lx) = match (status.over_range, measurement.illuminance_lx) {
            _ if status.error.is_some() || status.hold => (Meaning::Error(fault(status)), 1.0),
            (true, value) => (Meaning::OverRange, value.map_or(1.0, |value| value.digit())),
            (false, Some(value)) => {
                shown_in(status.range, value).map_err(Failure::Malformed)?;
                (Meaning::Lux(value.number()), value.digit())
            }
            (false, None) => return Err(Failure::malformed("no error, and no value")),
        };
        Ok(Said {
            meaning,
            digit_lx,
            range: status.range,
            caution: status.low_battery.then_some(Caution::LowBattery),
        })
    }

    fn bytes(answer: &Option<(Answer, Vec<u8>)>) -> &[u8] {
        answer.as_ref().map_or(&[], |(_, bytes)| bytes)
    }

    async fn put_in_service(&mut self, link: &Link<Host>, _: &mut Identity) -> Result<(), DeviceError> {
        let mut tries = 1;
        while let Err(error) = self.put_in_step(link, Instant::now() + OPENING).await {
            if tries >= TRIES || !worth_another_try(error.kind()) {
                return Err(error);
            }
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
        Ok(())
    }

    /// PC mode, then all heads running. The short answer to 54 proves that no reading is on its way, and a meter that
    /// was switched off and on answers nothing else. No head is asked anything before the meter is ready again.
    async fn put_in_step(&self, link: &Link<Host>, deadline: Instant) -> Result<(), DeviceError> {
        let action = "connect (command 54)";
        let line = link.bus.exclusive(deadline).await;
        let line = line.map_err(|error| error.during(&link.name, action))?;
        link.ask(&line, (Request::Connect, action), ANSWER, deadline).await?;
        sleep(SETTLE).await;
        let (running, run) = (Instant::now() + 2 * QUIET, "run (command 55)");
        link.ask(&line, (Request::Hold(false), run), ANSWER, running).await?;
        sleep(SETTLE).await;
        Ok(())
    }
}

/// What a meter that is at fault, or held by its key, says.
fn fault(status: Status) -> String {
    match status.error {
        Some(error) => error.to_string(),
        None => "the meter holds its reading (HOLD key): the value is old; release it".to_owned(),
    }
}

/// Refuses a value that a meter in `range` cannot show: above the range's end, or in steps coarser than its digit. A
/// meter that states no range (0) is held to its widest.
fn shown_in(range: u8, value: Value) -> Result<(), String> {
    let place = if range == 0 {
        FULL_SCALE_LX.len()
    } else {
        usize::from(range)
    };
    let Some(top_lx) = FULL_SCALE_LX.get(place - 1) else {
        return Err(format!("the meter has no range {range}"));
    };
    // Four digits, of which the first goes up to 2: range 1 ends at 29.99 lx and shows 0.01 lx.
    let digit_lx = top_lx / 2999.0;
    if value.number().abs() > top_lx * 1.000_001 || value.digit() > digit_lx * 1.000_001 {
        return Err(format!(
            "{} lx in steps of {} lx is nothing that range {range} can show (up to {top_lx} lx)",
            value.number(),
            value.digit()
        ));
    }
    Ok(())
}
