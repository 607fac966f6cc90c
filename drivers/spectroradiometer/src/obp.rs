//! Ocean Optics STS in the Ocean Binary Protocol: `ocean-obp:usb:…`, or `ocean-obp:LINK` over a serial line.
//!
//! Answers are asked for with an MD5 sum and with the number of their request. What comes without a sum is read twice,
//! and two spectra must agree (see `agreement`). The first spectrum of every acquisition is thrown away: its exposure
//! may have begun before the call, and after a change of integration time it is the old one's (python-seabreeze issues
//! 110, 177).

mod asker;

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, OpenError, RawSpectrum, Spectroradiometer, SpectroradiometerFactory,
    SpectroradiometerProperties, Target,
};
use isolux_protocol_obp::{Answer, FULL_SCALE, Host, INTEGRATION_LIMITS_US, PIXELS, Request, Value};
use isolux_transport::{
    Driver, LineSettings, Parity, Ports, Probe, TRIES, UsbAddress, UsbFraming, UsbModel, UsbProfile, no_display,
    printable, worth_another_try,
};
use tokio::sync::Mutex;
use tokio::time::Instant;

use self::asker::{Asker, LONG_ANSWER, PATIENCE};
use crate::agreement::Pair;
use crate::in_motion::{READY, light_began};
use crate::place::usb_place;
use crate::stored::{factors_can_be, linearity_can_be, polynomial, wavelengths_can_be};

const NAME: &str = "ocean-obp";

/// Of the STS's own RS-232 line.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Messages frame themselves; one endpoint answers them all.
const USB: UsbProfile = UsbProfile {
    ids: &[(0x2457, 0x4000)],
    command: 0x01,
    answers: &[0x81],
    framing: UsbFraming::Bytes,
};

/// A short answer.
const ANSWER: Duration = Duration::from_millis(500);

/// Over and above twice what the read-out of earlier spectra took: a spectrum in motion is given up then.
const BESIDE: Duration = Duration::from_millis(200);

/// Exposures of one spectrum within which two in a row must be good.
const MOST_EXPOSURES: usize = 8;

/// Temperatures that a detector can have, °C.
const TEMPERATURES: std::ops::RangeInclusive<f32> = -40.0..=100.0;

/// Ocean Optics STS.
pub const OCEAN_OBP: Driver = Driver {
    name: NAME,
    speaks_to: "Ocean Optics STS",
    examples: &[(Kind::Spectroradiometer, "ocean-obp:usb:serial=S01234")],
    seen_with: "🧪 its virtual twin; cseabreeze 2.11.0, over USB",
    usb: &[UsbModel {
        id: USB.ids[0],
        model: "Ocean Optics STS",
    }],
    identify: &[Probe {
        line: LINE,
        // 0x000100, the serial number, without a sum.
        request: b"\xC1\xC0\x00\x11\0\0\0\0\x00\x01\0\0\x01\0\0\0\0\0\0\0\0\0\0\0\
                   \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x14\0\0\0\
                   \0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xC5\xC4\xC3\xC2",
        read: |bytes| match isolux_protocol_obp::Message::parse(bytes) {
            Ok(Some((message, _))) => Some(format!("Ocean Optics STS, serial {}", printable(&message.data))),
            _ => None,
        },
    }],
    place: |target, _| usb_place(target, LINE),
    display_lx: no_display,
    factories: |ports| Factories {
        spectroradiometer: Some(Arc::new(OceanObpDriver::new(ports))),
        ..Factories::default()
    },
};

/// Opens STS spectrometers.
pub struct OceanObpDriver {
    ports: Arc<Ports>,
}

impl OceanObpDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }
}

#[async_trait]
impl SpectroradiometerFactory for OceanObpDriver {
    async fn open_spectroradiometer(&self, target: &Target) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        let line = usb_place(target, LINE)?.line;
        let bus = self.ports.usb_bus(target, line, &USB, Host::default).await?;
        let name = target.to_string();
        Ok(Box::new(OceanObp::open(Asker { bus, name }, target).await?))
    }
}

struct OceanObp {
    line: Asker,
    identity: Identity,
    properties: SpectroradiometerProperties,
    has_temperature: bool,
    /// The integration time can be asked for.
    reads_back: bool,
    /// Held while a spectrum is taken.
    state: Mutex<State>,
}

struct State {
    /// Integration time in use.
    integration: Duration,
    /// A spectrum in motion was given up and may still come, or bytes came that nobody asked for.
    in_doubt: bool,
    /// Count of the bus when the line was last known to be in step.
    unsolicited: u64,
    /// The longest that read-out and transfer took, over and above the exposure.
    read_out: Duration,
}

impl OceanObp {
    async fn open(line: Asker, target: &Target) -> Result<Self, DeviceError> {
        // An instrument that knows no sums refuses, and is read twice; one without an acquisition has none to abort.
        line.ask(Request::Checksum(true)).await?;
        line.ask(Request::Abort).await?;
        line.command(Request::SetTrigger(0)).await?;
        let Value::Text(serial) = line.ask(Request::Serial).await? else {
            return Err(line.fault("the serial number is none"));
        };
        let wanted = UsbAddress::parse(target.link())
            .ok()
            .flatten()
            .and_then(|address| address.serial);
        if let Some(wanted) = wanted.filter(|wanted| *wanted != serial) {
            return Err(DeviceError::unsupported(
                &line.name,
                "use this instrument",
                format!("its serial number is {serial}, not {wanted}"),
            ));
        }
        let wavelength = line.coefficients(Request::WavelengthCount, Request::Wavelength).await?;
        let wavelength_nm: Vec<f64> = (0..PIXELS).map(|pixel| polynomial(&wavelength, pixel as f64)).collect();
        wavelengths_can_be(&wavelength_nm)
            .map_err(|reason| line.fault(&format!("the wavelength coefficients {wavelength:?}: {reason}")))?;
        let nonlinearity = line
            .coefficients(Request::NonlinearityCount, Request::Nonlinearity)
            .await?;
        if !nonlinearity.is_empty() {
            linearity_can_be(&nonlinearity, FULL_SCALE)
                .map_err(|reason| line.fault(&format!("the non-linearity {nonlinearity:?}: {reason}")))?;
        }
        let saturation_counts = match line.ask(Request::Saturation).await? {
            Value::Count(counts @ 4096..=16_383) => counts as u16,
            Value::Refused { .. } => FULL_SCALE,
            other => return Err(line.fault(&format!("saturation at {other:?} counts of {FULL_SCALE}"))),
        };
        let irradiance_factor = irradiance(&line, &wavelength_nm).await?;
        let reads_back = matches!(line.ask(Request::Integration).await?, Value::Count(_));
        let has_temperature = matches!(line.ask(Request::TemperatureCount).await?, Value::Count(1..));
        let limits = INTEGRATION_LIMITS_US;
        let microseconds = |us: u32| Duration::from_micros(u64::from(us));
        let properties = SpectroradiometerProperties {
            wavelength_nm,
            dark_pixels: 0..0,
            integration_limits: (microseconds(limits.0), microseconds(limits.1)),
            saturation_counts,
            // Its counts are used as they are: nothing is scaled to more bits.
            full_scale_counts: saturation_counts,
            nonlinearity,
            irradiance_factor,
        };
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: "Ocean Optics STS".to_owned(),
            serial: Some(serial),
            firmware: None,
        };
        let first = Duration::from_millis(10);
        let instrument = Self {
            line,
            identity,
            properties,
            has_temperature,
            reads_back,
            state: Mutex::new(State {
                integration: first,
                // Opening it may have left something on its way.
                in_doubt: true,
                unsolicited: 0,
                read_out: Duration::ZERO,
            }),
        };
        instrument.set_integration_time(first).await?;
        Ok(instrument)
    }

    /// One spectrum as it comes, begun at the earliest one integration time before the call.
    async fn expose(&self, time: Duration, deadline: Instant) -> Result<(Vec<u16>, bool, Instant), DeviceError> {
        let mut tries = 1;
        loop {
            let requested = Instant::now();
            let answer = self
                .line
                .once(Request::Spectrum, 2 * time + LONG_ANSWER, deadline)
                .await;
            let error = match answer {
                Ok(Answer {
                    value: Value::Spectrum(counts),
                    checked,
                }) => return Ok((counts, checked, requested)),
                Ok(other) => return Err(self.line.refused(Request::Spectrum, &other.value)),
                Err(error) => error,
            };
            if tries >= TRIES || !worth_another_try(error.kind()) {
                return Err(error);
            }
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
    }

    /// Whether nothing else is on its way: the instrument answers in order, so what is asked for must be the next
    /// answer. The integration time must be the one that was set; after a restart, or where another program uses it, it
    /// is not.
    async fn in_step(&self, integration: Duration, unsolicited: u64) -> Result<bool, DeviceError> {
        let (request, expected) = if self.reads_back {
            (Request::Integration, Value::Count(integration.as_micros() as u32))
        } else {
            (
                Request::Serial,
                Value::Text(self.identity.serial.clone().unwrap_or_default()),
            )
        };
        match self.line.once(request, ANSWER, Instant::now() + PATIENCE).await {
            Ok(answer) if answer.checked && answer.value != expected => {
                let reason = format!(
                    "{expected:?} was expected and {:?} is read back: it was restarted",
                    answer.value
                );
                Err(self.line.fault(&reason))
            }
            Ok(answer) => Ok(answer.value == expected && self.line.bus.unsolicited() == unsolicited),
            Err(error) if worth_another_try(error.kind()) => Ok(false),
            Err(error) => Err(error),
        }
    }

    async fn temperature(&self) -> Result<Option<f64>, DeviceError> {
        if !self.has_temperature {
            return Ok(None);
        }
        Ok(match self.line.ask(Request::Temperature(0)).await? {
            Value::Number(found) if TEMPERATURES.contains(&found) => Some(f64::from(found)),
            _ => None,
        })
    }
}

/// The irradiance calibration that is stored: W/(m²·nm) for one linear count a second. `None` where there is none
/// that can be one.
///
/// Stored are µJ a count and the area in cm²; a pixel sees the wavelengths up to halfway to its neighbours:
/// E = factor · counts ÷ (time · area · width), and 1 µW/cm² = 0.01 W/m².
async fn irradiance(line: &Asker, wavelength_nm: &[f64]) -> Result<Option<Vec<f64>>, DeviceError> {
    let (Value::Numbers(stored), Value::Number(area_cm2)) = (
        line.ask(Request::Irradiance).await?,
        line.ask(Request::IrradianceArea).await?,
    ) else {
        return Ok(None);
    };
    let area_cm2 = f64::from(area_cm2);
    if !area_cm2.is_finite() || area_cm2 <= 0.0 || stored.iter().all(|factor| *factor == 0.0 || factor.is_nan()) {
        return Ok(None);
    }
    let last = wavelength_nm.len() - 1;
    let width_nm = |pixel: usize| {
        let (from, to) = (pixel.saturating_sub(1), (pixel + 1).min(last));
        (wavelength_nm[to] - wavelength_nm[from]) / (to - from) as f64
    };
    let factors: Vec<f64> = stored
        .iter()
        .enumerate()
        .map(|(pixel, factor)| 0.01 * f64::from(*factor) / (area_cm2 * width_nm(pixel)))
        .collect();
    match factors_can_be(&factors) {
        Ok(()) => Ok(Some(factors)),
        // An instrument with a calibration of its own in a file can still be used.
        Err(reason) => {
            tracing::warn!(device = line.name, reason, "the stored irradiance factors are not used");
            Ok(None)
        }
    }
}

#[async_trait]
impl Spectroradiometer for OceanObp {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &SpectroradiometerProperties {
        &self.properties
    }

    async fn set_integration_time(&self, time: Duration) -> Result<Duration, DeviceError> {
        let (shortest, longest) = self.properties.integration_limits;
        let Some(us) = u32::try_from(time.as_micros())
            .ok()
            .filter(|_| (shortest..=longest).contains(&time))
        else {
            return Err(DeviceError::unsupported(
                &self.line.name,
                format!("integrate for {time:?}"),
                format!("the integration time is {shortest:?} to {longest:?}"),
            ));
        };
        let mut state = self.state.lock().await;
        self.line.command(Request::SetIntegration(us)).await?;
        // Where it cannot be read back the acknowledgement has to do.
        if self.reads_back {
            let found = self.line.ask(Request::Integration).await?;
            if found != Value::Count(us) {
                return Err(self.line.fault(&format!("{us} µs were set, {found:?} is read back")));
            }
        }
        let longer = time.max(state.integration);
        state.integration = time;
        // The exposure under way was begun with the old time.
        let (.., requested) = self
            .expose(longer, Instant::now() + 3 * (2 * longer + LONG_ANSWER))
            .await?;
        state.read_out = state.read_out.max(requested.elapsed().saturating_sub(longer));
        Ok(time)
    }

    async fn acquire(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let state = self.state.lock().await;
        let integration = state.integration;
        let mut before: Option<Vec<u16>> = None;
        let mut reason = String::new();
        for _ in 0..MOST_EXPOSURES {
            let unsolicited = self.line.bus.unsolicited();
            let (counts, checked, began) = self.expose(integration, deadline).await?;
            let ended = Instant::now();
            let Some(before) = before.replace(counts.clone()) else {
                continue;
            };
            let pair = Pair {
                before: &before,
                after: &counts,
                dark: self.properties.dark_pixels.clone(),
                saturation: self.properties.saturation_counts,
            };
            match pair.agree() {
                Err(difference) if !checked => {
                    reason = format!("of the last two: {difference}");
                    continue;
                }
                _ => {}
            }
            if !self.in_step(integration, unsolicited).await? {
                "an answer came that nothing had asked for".clone_into(&mut reason);
                continue;
            }
            return Ok(RawSpectrum {
                counts,
                integration_time: integration,
                detector_c: self.temperature().await?,
                began,
                ended,
            });
        }
        Err(self
            .line
            .fault(&format!("{MOST_EXPOSURES} exposures gave no good spectrum: {reason}")))
    }

    async fn sample(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let mut state = self.state.lock().await;
        let integration_time = state.integration;
        let unsolicited = self.line.bus.unsolicited();
        if state.in_doubt {
            if !self.in_step(integration_time, unsolicited).await? {
                return Err(self.line.fault("answers are on their way that nobody asked for"));
            }
            state.unsolicited = unsolicited;
        }
        state.in_doubt = true;
        let too_much = || self.line.fault("bytes arrived that nobody asked for");
        if state.unsolicited != unsolicited {
            return Err(too_much());
        }
        let requested = Instant::now();
        let patience = 2 * (integration_time + state.read_out) + BESIDE;
        let counts = match self.line.once(Request::Spectrum, patience, deadline).await?.value {
            Value::Spectrum(counts) => counts,
            other => return Err(self.line.refused(Request::Spectrum, &other)),
        };
        let ended = Instant::now();
        if self.line.bus.unsolicited() != unsolicited {
            return Err(too_much());
        }
        let began = light_began(requested, ended, integration_time).ok_or_else(|| self.line.fault(READY))?;
        state.in_doubt = false;
        Ok(RawSpectrum {
            counts,
            integration_time,
            detector_c: None,
            began,
            ended,
        })
    }
}
