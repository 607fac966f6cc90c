//! Gigahertz-Optik P-9710 optometer with a photometric detector: `gigahertz-p9710:LINK`.
//!
//! A request begins a measurement of its own, of the integration time that is set here; so a reading is of light after
//! its request. Eight ranges of the detector's current, 2 mA to 200 pA, the automatic range by the meter.
//! `a_per_lx=4.2e-10`, the detector's sensitivity from its certificate, says where the ranges end in lx; nothing else
//! depends on it. `integration_ms=100` sets another integration time than 500 ms, in steps of 10 ms: for sweeps. Whole
//! periods of the mains, of 50 and of 60 Hz alike, are multiples of 100 ms.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use isolux_device::{Identity, Kind, LuxRange, LuxReading, OpenError, Target};
use isolux_protocol_ascii::{Lines, Reply};
use isolux_protocol_p9710::{Answer, P9710, RANGES, Range, Request};
use isolux_transport::{Driver, LineSettings, Parity, Place, Probe, printable};

use crate::language::{Converts, Failure, Language, Meaning, Said, Step, Timing};
use crate::meter;

/// Manual, section 15.1.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Integration time where the address states none, ms: an even number of half periods of 50 and of 60 Hz.
const INTEGRATION_MS: f64 = 500.0;

/// The automatic range may measure once more in each of so many ranges before it answers.
const MEASURED_IN: u32 = 8;
/// Everything else about an answer takes less than this.
const BESIDE: Duration = Duration::from_secs(1);

/// Offset error of each range as a share of its full scale, 0 (2 mA) first: manual, section 12.2.
const OFFSET: [f64; 8] = [5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 1e-3, 1e-2];

/// Share of a range above which the stated percentage says what the range is in lx.
const TELLING_PERCENT: f64 = 5.0;

/// The P-9710 of Gigahertz-Optik.
pub const GIGAHERTZ_P9710: Driver = Driver {
    name: Optometer::NAME,
    speaks_to: "Gigahertz-Optik P-9710 lux meter",
    examples: &[(Kind::LuxMeter, "gigahertz-p9710:/dev/ttyUSB0")],
    seen_with: "🧪 its virtual twin; forms printed in its manual",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        request: b"\nGI;TT\n",
        read: |bytes| {
            let text = printable(bytes);
            let (_, rest) = text.split_once("P-9710")?;
            let serial = rest.split_once(';').map_or("", |(_, serial)| serial);
            Some(format!("Gigahertz-Optik P-9710, serial {}", serial.trim()))
        },
    }],
    place: meter::place::<Optometer>,
    display_lx: meter::display_lx::<Optometer>,
    factories: meter::factories::<Optometer>,
};

struct Optometer {
    /// Full scales in lx, rising, by the certificate's sensitivity; empty where the operator does not say it.
    full_scales_lx: Vec<f64>,
    integration_ms: u16,
    /// A/lx, by the certificate or by what the meter itself has said.
    sensitivity: Mutex<Option<f64>>,
}

impl Optometer {
    fn sensitivity(&self) -> MutexGuard<'_, Option<f64>> {
        self.sensitivity.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Language for Optometer {
    type Conversation = Lines<P9710>;

    const NAME: &'static str = "gigahertz-p9710";

    fn of(target: &Target) -> Result<Self, OpenError> {
        target.only(&["a_per_lx", "integration_ms"])?;
        let integration_ms = target.number("integration_ms", INTEGRATION_MS)?;
        if !(20.0..=500.0).contains(&integration_ms) || integration_ms % 10.0 != 0.0 {
            return Err(target.wrong("integration_ms is a multiple of 10 from 20 to 500"));
        }
        let sensitivity = target.number("a_per_lx", f64::NAN)?;
        let sensitivity = target.option("a_per_lx").map(|_| sensitivity);
        if sensitivity.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
            return Err(target.wrong("a_per_lx is the detector's sensitivity in A/lx, above zero"));
        }
        let full_scales = |a_per_lx: f64| RANGES.iter().rev().map(move |amps| amps / a_per_lx);
        Ok(Self {
            integration_ms: integration_ms as u16,
            full_scales_lx: sensitivity.into_iter().flat_map(full_scales).collect(),
            sensitivity: Mutex::new(sensitivity),
        })
    }

    fn place(&self) -> Place {
        let channel = String::new();
        Place { channel, line: LINE }
    }

    fn conversation(&self, _: &Target) -> Lines<P9710> {
        Lines::default()
    }

    // Five digits: of 2.0000 the last is 1/20000.
    fn ranges_lx(&self) -> Vec<(f64, Option<f64>)> {
        let tops = self.full_scales_lx.iter();
        tops.map(|top_lx| (*top_lx, Some(top_lx / 20_000.0))).collect()
    }

    fn timing(&self) -> Timing {
        let integration = Duration::from_millis(self.integration_ms.into());
        Timing {
            update_interval: integration,
            integration,
            converts: Converts::OnRequest,
            answer: MEASURED_IN * integration + BESIDE,
        }
    }

    fn opening(&self) -> Vec<Step<Self>> {
        // The meter counts in 0.1 ms.
        let tenths = 10 * self.integration_ms;
        vec![
            (Request::Identify, "GI;TT;GU".to_owned()),
            (Request::SetIntegration(tenths), format!("SN{tenths}")),
            (Request::SetRange(Range::Auto), "SB1".to_owned()),
        ]
    }

    fn choosing(&self, range: LuxRange) -> Result<Vec<Step<Self>>, String> {
        let wanted = match range {
            LuxRange::Auto => Range::Auto,
            LuxRange::Fixed(number @ 1..=8) => Range::Fixed(8 - number),
            LuxRange::Fixed(_) => return Err("the meter has ranges 1 (200 pA) to 8 (2 mA)".to_owned()),
        };
        Ok(vec![(Request::SetRange(wanted), "SB, SR".to_owned())])
    }

    fn taken(&self, _: &Request, reply: &Reply<Answer>, identity: &mut Identity) -> Result<(), Failure> {
        match &reply.answer {
            Answer::Identity { unit, .. } if !unit.eq_ignore_ascii_case("lx") => Err(Failure::NoLuxMeter(format!(
                "the meter answers in \"{unit}\": select the detector's calibration data in lx"
            ))),
            Answer::Identity { software, serial, .. } => {
                let (model, firmware) = software.split_once(' ').unwrap_or((software, ""));
                identity.model = format!("Gigahertz-Optik {model}");
                identity.firmware = (!firmware.is_empty()).then(|| firmware.to_owned());
                identity.serial = Some(serial.clone());
                Ok(())
            }
            Answer::Done => Ok(()),
            Answer::Error(code) => Err(Failure::Refused(format!("error {}, {}", code.0, code.meaning()))),
            Answer::Measurement(_) => Err(Failure::malformed("it reads back otherwise")),
        }
    }

    fn reading(&self, _: LuxRange) -> Vec<Step<Self>> {
        vec![(Request::Measure, "MV".to_owned())]
    }

    fn stated(&self, _: LuxRange, answers: &[Reply<Answer>]) -> Result<Said, Failure> {
        let (meaning, range, digit_lx) = match answers.first().map(|reply| &reply.answer) {
            Some(Answer::Measurement(measurement)) => {
                let lux = measurement.value.value;
                let full_scale = RANGES.get(usize::from(measurement.range));
                if let Some(full_scale) = full_scale.filter(|_| measurement.percent.abs() >= TELLING_PERCENT) {
                    let amps = full_scale * measurement.percent / 100.0;
                    self.sensitivity().get_or_insert((amps / lux).abs());
                }
                // Its numbers fall as the range rises, 0 for 2 mA; a reading's begin at 1, the most sensitive.
                (Meaning::Lux(lux), 8 - measurement.range, measurement.value.step)
            }
            Some(Answer::Error(code)) if code.is_overload() => (Meaning::OverRange, 0, 1.0),
            Some(Answer::Error(code)) if code.is_underload() => (Meaning::UnderRange, 0, 1.0),
            Some(Answer::Error(code)) => (Meaning::Error(code.meaning().to_owned()), 0, 1.0),
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
        Some((Request::Identify, "GI;TT;GU".to_owned()))
    }

    /// The offset error of the range: 0.05 % to 1 % of its full scale.
    fn indistinct_lx(&self, reading: &LuxReading) -> f64 {
        let range = usize::from(8_u8.saturating_sub(reading.range));
        let sensitivity = *self.sensitivity();
        match (RANGES.get(range), OFFSET.get(range), sensitivity) {
            (Some(full_scale), Some(offset), Some(a_per_lx)) => full_scale * offset / a_per_lx,
            _ => 0.0,
        }
    }
}
