//! Gigahertz-Optik P-9710 optometer with a photometric detector: `gigahertz-p9710:LINK`.
//!
//! A request begins a measurement of its own, of the integration time that is set here; so a reading is of light after
//! its request. Eight ranges of the detector's current, 2 mA to 200 pA, the automatic range by the meter.
//! `a_per_lx=4.2e-10`, the detector's sensitivity from its certificate, says where the ranges end in lx; nothing else
//! depends on it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome, LuxRange,
    LuxReading, OpenError, Target,
};
use isolux_protocol_ascii::Lines;
use isolux_protocol_p9710::{Answer, ErrorCode, P9710, RANGES, Range, Request};
use isolux_transport::{Alone, Bus, Driver, LineSettings, Parity, Place, Ports, Probe, printable};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::{Confirmed, Meter, Pace};

const NAME: &str = "gigahertz-p9710";

/// Manual, section 15.1.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Integration time: an even number of half periods of 50 and of 60 Hz.
const INTEGRATION: Duration = Duration::from_millis(500);

/// The same in the meter's units of 0.1 ms.
const INTEGRATION_TENTHS: u16 = 5000;

/// The automatic range may measure once more in each of the eight ranges before it answers.
const ANSWER: Duration = Duration::from_secs(5);

/// Offset error of each range as a share of its full scale, 0 (2 mA) first: manual, section 12.2.
const OFFSET: [f64; 8] = [5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 5e-4, 1e-3, 1e-2];

/// Share of a range above which the stated percentage says what the range is in lx.
const TELLING_PERCENT: f64 = 5.0;

/// A second answer to the same request comes within this; an old one does not fit the request that is due.
const GUARD: Duration = Duration::from_millis(100);

/// The P-9710 of Gigahertz-Optik.
pub const GIGAHERTZ_P9710: Driver = Driver {
    name: NAME,
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
    place: |target, _| Ok(Address::parse(target)?.place),
    display_lx: |target| {
        let ranges = Address::parse(target).map(|address| address.full_scales_lx());
        // Five digits: of 2.0000 the last is 1/20000.
        ranges
            .unwrap_or_default()
            .into_iter()
            .map(|top_lx| (top_lx, top_lx / 20_000.0))
            .collect()
    },
    factories: |ports| Factories {
        lux_meter: Some(Arc::new(P9710Driver { ports })),
        ..Factories::default()
    },
};

struct Address {
    /// A/lx; none where the operator does not say.
    sensitivity: Option<f64>,
    place: Place,
}

impl Address {
    fn parse(target: &Target) -> Result<Self, OpenError> {
        target.only(&["a_per_lx"])?;
        let sensitivity = target.number("a_per_lx", f64::NAN)?;
        let sensitivity = target.option("a_per_lx").map(|_| sensitivity);
        if sensitivity.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
            return Err(target.wrong("a_per_lx is the detector's sensitivity in A/lx, above zero"));
        }
        let channel = String::new();
        Ok(Self {
            sensitivity,
            place: Place { channel, line: LINE },
        })
    }

    /// Upper ends of the ranges in lx, rising.
    fn full_scales_lx(&self) -> Vec<f64> {
        let sensitivity = self.sensitivity.iter();
        sensitivity
            .flat_map(|sensitivity| RANGES.iter().rev().map(move |amps| amps / sensitivity))
            .collect()
    }
}

struct P9710Driver {
    ports: Arc<Ports>,
}

#[async_trait]
impl LuxMeterFactory for P9710Driver {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let address = Address::parse(target)?;
        let bus = self
            .ports
            .bus(target, address.place.line, Lines::<P9710>::default)
            .await?;
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: String::new(),
            serial: None,
            firmware: None,
        };
        let full_scales = address.full_scales_lx();
        let mut meter = Optometer {
            bus,
            name: target.to_string(),
            identity,
            properties: LuxMeterProperties {
                range_full_scale: full_scales.iter().filter_map(|lx| Lux::new(*lx).ok()).collect(),
                update_interval: INTEGRATION,
                integration: INTEGRATION,
            },
            sensitivity: Mutex::new(address.sensitivity),
            confirmed: Confirmed::default(),
        };
        meter.begin().await?;
        Ok(Box::new(meter))
    }
}

struct Optometer {
    bus: Bus<Lines<P9710>>,
    name: String,
    identity: Identity,
    properties: LuxMeterProperties,
    /// A/lx, by the certificate or by what the meter itself has said.
    sensitivity: Mutex<Option<f64>>,
    confirmed: Confirmed,
}

impl Optometer {
    fn sensitivity(&self) -> MutexGuard<'_, Option<f64>> {
        self.sensitivity.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Identity, unit, integration time, automatic range.
    async fn begin(&mut self) -> Result<(), DeviceError> {
        let action = "GI;TT;GU";
        let (software, serial, unit) = match self.setting(Request::Identify, action).await? {
            (Answer::Identity { software, serial, unit }, _) => (software, serial, unit),
            (_, bytes) => return Err(self.malformed(action, "no identity", bytes)),
        };
        if !unit.eq_ignore_ascii_case("lx") {
            return Err(DeviceError::Unsupported {
                device: self.name.clone(),
                action: "measure illuminance".to_owned(),
                reason: format!("the meter answers in \"{unit}\": select the detector's calibration data in lx"),
            });
        }
        let (model, firmware) = software.split_once(' ').unwrap_or((&software, ""));
        self.identity.model = format!("Gigahertz-Optik {model}");
        self.identity.firmware = (!firmware.is_empty()).then(|| firmware.to_owned());
        self.identity.serial = Some(serial);
        self.set(Request::SetIntegration(INTEGRATION_TENTHS), "SN5000").await?;
        self.set(Request::SetRange(Range::Auto), "SB1").await?;
        self.confirmed.in_service(self).await;
        Ok(())
    }

    /// A request whose answer cannot be a reading; once more after the identity where its answer is lost.
    async fn setting(&self, request: Request, action: &str) -> Result<(Answer, Vec<u8>), DeviceError> {
        let deadline = Instant::now() + 4 * ANSWER;
        let asked = self
            .bus
            .ask_again(request, Some(Request::Identify), ANSWER, deadline)
            .await;
        let reply = asked.map_err(|error| error.during(&self.name, action))?;
        match reply.answer {
            Answer::Error(code) => Err(self.refused(action, code, reply.bytes)),
            answer => Ok((answer, reply.bytes)),
        }
    }

    async fn set(&self, request: Request, action: &str) -> Result<(), DeviceError> {
        match self.setting(request, action).await? {
            (Answer::Done, _) => Ok(()),
            (_, bytes) => Err(self.malformed(action, "it reads back otherwise", bytes)),
        }
    }

    fn refused(&self, action: &str, code: ErrorCode, frame: Vec<u8>) -> DeviceError {
        DeviceError::Refused {
            device: self.name.clone(),
            action: action.to_owned(),
            reason: format!("error {}, {}", code.0, code.meaning()),
            frame,
        }
    }
}

#[async_trait]
impl Meter for Optometer {
    type Language = Lines<P9710>;

    fn bus(&self) -> &Bus<Lines<P9710>> {
        &self.bus
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn pace(&self) -> Pace {
        Pace {
            interval: Duration::ZERO,
            reach: Duration::ZERO,
            patience: ANSWER,
            guard: GUARD,
        }
    }

    async fn exchange(&self, line: &Alone<'_, Lines<P9710>>, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let measured = self.ask(line, Request::Measure, "MV", deadline).await?;
        let ended = Instant::now();
        let evidence = measured.answer.bytes;
        let (outcome, range, digit) = match measured.answer.answer {
            Answer::Measurement(measurement) => {
                let amps = RANGES
                    .get(usize::from(measurement.range))
                    .map(|full| full * measurement.percent / 100.0);
                if let Some(amps) = amps.filter(|_| measurement.percent.abs() >= TELLING_PERCENT) {
                    self.sensitivity().get_or_insert((amps / measurement.value.value).abs());
                }
                let lux = Lux::new(measurement.value.value).map(LuxOutcome::Measured);
                // Its numbers fall as the range rises, 0 for 2 mA; a reading's begin at 1, the most sensitive.
                (lux, 8 - measurement.range, measurement.value.step)
            }
            Answer::Error(code) if code.is_overload() => (Ok(LuxOutcome::OverRange), 0, 1.0),
            Answer::Error(code) if code.is_underload() => (Ok(LuxOutcome::UnderRange), 0, 1.0),
            Answer::Error(code) => return Err(self.fault("MV", code.meaning().to_owned(), evidence)),
            _ => return Err(self.malformed("MV", "no measurement", evidence)),
        };
        let unusable = |error: isolux_units::NotFinite| self.malformed("MV", &error.to_string(), evidence.clone());
        Ok(LuxReading {
            outcome: outcome.map_err(unusable)?,
            range,
            confirmed_by: None,
            digit: Lux::new(digit).map_err(unusable)?,
            began: measured.sent,
            ended,
            caution: None,
            retries: 0,
            evidence,
        })
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

    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError> {
        let asked = self.bus.ask_within(Request::Identify, ANSWER, deadline).await;
        asked.map(|_| ()).map_err(|error| error.during(&self.name, "GI;TT;GU"))
    }
}

#[async_trait]
impl LuxMeter for Optometer {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        self.confirmed.read(self, not_before, deadline).await
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        let mut state = self.confirmed.state().await;
        let wanted = match range {
            LuxRange::Auto => Range::Auto,
            LuxRange::Fixed(number @ 1..=8) => Range::Fixed(8 - number),
            LuxRange::Fixed(number) => {
                return Err(DeviceError::Unsupported {
                    device: self.name.clone(),
                    action: format!("use range {number}"),
                    reason: "the meter has ranges 1 (200 pA) to 8 (2 mA)".to_owned(),
                });
            }
        };
        self.set(Request::SetRange(wanted), "SB, SR").await?;
        state.forget();
        Ok(())
    }
}
