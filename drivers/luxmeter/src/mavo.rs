//! Gossen MAVO-USB (MAVOLUX 5032): `gossen-mavo-usb:LINK`.
//!
//! The meter converts once in two seconds and a request gets the latest value, so the driver waits two intervals after
//! `not_before` in a fixed range, three in automatic range, and more than one between two requests. A measurement is
//! followed by the question for its range; both together are one exchange.

use std::time::Duration;

use isolux_device::{Identity, Kind, LuxRange, OpenError, Target};
use isolux_protocol_ascii::{Lines, Number, Reply};
use isolux_protocol_mavo::{Answer, Mavo, Request};
use isolux_transport::{Driver, LineSettings, Parity, Place, Probe, printable};

use crate::language::{Converts, Failure, Language, Meaning, Said, Step, Timing};
use crate::meter;

/// Interface description, section 1.2.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 7,
    parity: Parity::Even,
    stop_bits: 2,
};

/// "0,5 measurements per second", section 4.1.
const UPDATE: Duration = Duration::from_secs(2);

/// An answer takes some 30 ms at 9600 baud; the meter may finish a conversion first.
const ANSWER: Duration = Duration::from_secs(3);

/// The MAVO-USB interface of Gossen.
pub const GOSSEN_MAVO_USB: Driver = Driver {
    name: MavoUsb::NAME,
    speaks_to: "Gossen MAVOLUX 5032 with MAVO-USB",
    examples: &[(Kind::LuxMeter, "gossen-mavo-usb:/dev/ttyUSB0")],
    seen_with: "🧪 its virtual twin; exchanges printed in its description",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        request: b"\n*IDN?\n",
        read: |bytes| {
            let text = printable(bytes);
            let (_, name) = text.split_once("GOSSEN,")?;
            Some(format!("Gossen {}", name.trim()))
        },
    }],
    place: meter::place::<MavoUsb>,
    display_lx: meter::display_lx::<MavoUsb>,
    factories: meter::factories::<MavoUsb>,
};

struct MavoUsb;

impl Language for MavoUsb {
    type Conversation = Lines<Mavo>;

    const NAME: &'static str = "gossen-mavo-usb";

    fn of(target: &Target) -> Result<Self, OpenError> {
        target.only(&[])?;
        Ok(Self)
    }

    fn place(&self) -> Place {
        let channel = String::new();
        Place { channel, line: LINE }
    }

    fn conversation(&self, _: &Target) -> Lines<Mavo> {
        Lines::default()
    }

    // Its ranges differ between the models, which it names by a number that no public document explains.

    fn timing(&self) -> Timing {
        Timing {
            update_interval: UPDATE,
            integration: UPDATE,
            converts: Converts::AlwaysAndRepeats,
            answer: ANSWER,
        }
    }

    fn opening(&self) -> Vec<Step<Self>> {
        vec![
            (Request::Echo, "ECHO ON".to_owned()),
            (Request::Identify, "*IDN?".to_owned()),
            (Request::Lux, "UNI:PHOT LX".to_owned()),
            (Request::SetAuto(true), "RAN:AUTO ON".to_owned()),
        ]
    }

    fn choosing(&self, range: LuxRange) -> Result<Vec<Step<Self>>, String> {
        match range {
            LuxRange::Auto => Ok(vec![(Request::SetAuto(true), "RAN:AUTO ON".to_owned())]),
            LuxRange::Fixed(number @ 1..=5) => Ok(vec![
                (Request::SetAuto(false), "RAN:AUTO OFF".to_owned()),
                (Request::SetRange(number - 1), format!("RAN {}", number - 1)),
            ]),
            LuxRange::Fixed(_) => Err("the meter has ranges 1 to 5 (0 to 4 in its own count)".to_owned()),
        }
    }

    fn taken(&self, request: &Request, reply: &Reply<Answer>, identity: &mut Identity) -> Result<(), Failure> {
        match (request, &reply.answer) {
            (Request::Identify, Answer::Identity(text)) => {
                let fields: Vec<&str> = text.split(',').map(str::trim).collect();
                let [maker, model, serial, _, firmware] = fields[..] else {
                    let reason = "expected five fields: maker, type, serial, hardware, firmware";
                    return Err(Failure::malformed(reason));
                };
                identity.model = format!("{maker} {model}");
                identity.serial = Some(serial.to_owned());
                identity.firmware = Some(firmware.to_owned());
                Ok(())
            }
            (_, Answer::Done) => Ok(()),
            (_, Answer::Error(code)) => Err(Failure::Refused(format!("error {}, {}", code.0, code.meaning()))),
            _ => Err(Failure::malformed("not the answer to a setting")),
        }
    }

    fn reading(&self, _: LuxRange) -> Vec<Step<Self>> {
        vec![
            (Request::Measure, "PHOT?".to_owned()),
            (Request::Range, "RAN?".to_owned()),
        ]
    }

    fn stated(&self, wanted: LuxRange, answers: &[Reply<Answer>]) -> Result<Said, Failure> {
        let [measured, range] = answers else {
            return Err(Failure::malformed("no measurement with its range"));
        };
        let Answer::Range(range) = range.answer else {
            return Err(Failure::malformed("no range"));
        };
        // Its numbers begin at 0; a reading's begin at 1, the most sensitive.
        let range = range + 1;
        if matches!(wanted, LuxRange::Fixed(wanted) if wanted != range) {
            return Err(Failure::malformed("the range that was asked for is not in use yet"));
        }
        let (meaning, digit_lx) = match &measured.answer {
            Answer::Measurement(measurement) => {
                let Number { value, step } = measurement.lux;
                (Meaning::Lux(value), step)
            }
            Answer::Error(code) if code.is_over_range() => (Meaning::OverRange, 1.0),
            // The request was damaged on its way to the meter.
            Answer::Error(code) if code.is_transmission() => return Err(Failure::malformed(code.meaning())),
            Answer::Error(code) => (Meaning::Error(format!("error {}, {}", code.0, code.meaning())), 1.0),
            _ => return Err(Failure::malformed("no measurement")),
        };
        Ok(Said {
            meaning,
            digit_lx,
            range,
            caution: None,
        })
    }

    fn bytes(reply: &Reply<Answer>) -> &[u8] {
        &reply.bytes
    }

    fn proof(&self) -> Option<Step<Self>> {
        Some((Request::Identify, "*IDN?".to_owned()))
    }
}
