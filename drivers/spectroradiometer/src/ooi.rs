//! Ocean Optics USB2000+ and Flame-S in the OOI language: `ocean-ooi:LINK`, over any byte link that carries one frame a USB
//! transfer (see `isolux-protocol-ooi`). USB itself is not built yet.
//!
//! The detector integrates all the time and a request may be answered with an exposure that was begun before it, so each
//! acquisition throws one spectrum away and returns the next (python-seabreeze issues 110 and 177).

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, ErrorKind, Identity, OpenError, RawSpectrum, Spectroradiometer, SpectroradiometerFactory,
    SpectroradiometerProperties, Target,
};
use isolux_protocol_ooi::{
    Answer, Conversation, DARK_PIXELS, EepromSlot, Event, FULL_SCALE, INTEGRATION_LIMITS_US, IRRADIANCE_BLOCK,
    InstrumentStatus, PIXELS, Request, slots,
};
use isolux_transport::{Bus, LineSettings, Links, Outcome, Parity};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

/// Name of the driver in `open = "ocean-ooi:…"`.
const NAME: &str = "ocean-ooi";

/// For serial adapters that carry the frames; the instrument itself has no line settings.
const LINE: LineSettings = LineSettings {
    baud: 115_200,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// A short answer.
const ANSWER: Duration = Duration::from_millis(500);

/// Read-out and transfer of a spectrum, over and above the exposure.
const READ_OUT: Duration = Duration::from_secs(1);

/// After command 01.
const INITIALIZE: Duration = Duration::from_millis(100);

/// Tries at one request before its error is told.
const TRIES: usize = 3;

/// Opens OOI spectrometers.
pub struct OceanOoiDriver {
    links: Arc<dyn Links>,
}

impl OceanOoiDriver {
    /// A driver that opens its links through `links`.
    pub fn new(links: Arc<dyn Links>) -> Self {
        Self { links }
    }
}

#[async_trait]
impl SpectroradiometerFactory for OceanOoiDriver {
    async fn open_spectroradiometer(&self, target: &Target) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        target.only(&[])?;
        let link = self
            .links
            .open(target.link(), LINE)
            .await
            .map_err(|error| error.opening(target))?;
        let line = Line {
            bus: Bus::spawn(link, Talk::default()),
            name: target.to_string(),
        };
        Ok(Box::new(OceanOoi::open(line, target).await?))
    }
}

struct OceanOoi {
    line: Line,
    identity: Identity,
    properties: SpectroradiometerProperties,
    /// Held while a spectrum is taken.
    state: Mutex<State>,
}

struct State {
    /// Integration time in use.
    integration: Duration,
    /// A spectrum was given up and may still come.
    in_doubt: bool,
}

impl OceanOoi {
    async fn open(line: Line, target: &Target) -> Result<Self, DeviceError> {
        line.send(Request::Initialize).await?;
        sleep(INITIALIZE).await;
        // An interrupted program may have left it waiting for a trigger.
        line.send(Request::Trigger(0)).await?;
        let status = line.status().await?;
        if usize::from(status.pixels) != PIXELS || status.trigger != 0 {
            let reason = format!(
                "{} pixels and trigger mode {}: not a USB2000+ or Flame-S in free run",
                status.pixels, status.trigger
            );
            return Err(DeviceError::Unsupported {
                device: line.name,
                action: "use this instrument".to_owned(),
                reason,
            });
        }
        let serial = line.slot(slots::SERIAL).await?;
        let mut wavelength = Vec::new();
        for slot in slots::WAVELENGTH {
            wavelength.push(line.coefficient(slot).await?);
        }
        let order = line.coefficient(slots::NONLINEARITY_ORDER).await?;
        if order.fract() != 0.0 || !(0.0..=7.0).contains(&order) {
            return Err(line.fault(
                &format!("EEPROM slot 14 gives {order} as the order of a polynomial"),
                &[],
            ));
        }
        let mut nonlinearity = Vec::new();
        for slot in slots::NONLINEARITY.take(order as usize + 1) {
            nonlinearity.push(line.coefficient(slot).await?);
        }
        let saturation = line.slot(slots::SATURATION).await?.saturation().unwrap_or(FULL_SCALE);
        let irradiance_factor = line.irradiance().await?;

        let polynomial = |pixel: usize| {
            wavelength
                .iter()
                .rev()
                .fold(0.0, |sum, coefficient| sum * pixel as f64 + coefficient)
        };
        let wavelength_nm: Vec<f64> = (0..PIXELS).map(polynomial).collect();
        if !wavelength_nm.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(line.fault(
                &format!("the wavelength polynomial {wavelength:?} of the EEPROM does not rise"),
                &[],
            ));
        }
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: "Ocean Optics USB2000+ / Flame-S".to_owned(),
            serial: serial.text().map(str::to_owned),
            firmware: None,
        };
        let limits = INTEGRATION_LIMITS_US;
        let microseconds = |us: u32| Duration::from_micros(u64::from(us));
        let properties = SpectroradiometerProperties {
            wavelength_nm,
            dark_pixels: DARK_PIXELS,
            integration_limits: (microseconds(limits.0), microseconds(limits.1)),
            saturation_counts: saturation,
            full_scale_counts: FULL_SCALE,
            nonlinearity,
            irradiance_factor,
        };
        let state = Mutex::new(State {
            integration: microseconds(status.integration_us),
            in_doubt: false,
        });
        Ok(Self {
            line,
            identity,
            properties,
            state,
        })
    }

    /// One spectrum as it comes, begun at the earliest one integration time before the call.
    async fn expose(
        &self,
        state: &mut State,
        exposure: Duration,
        deadline: Instant,
    ) -> Result<(Vec<u16>, Instant), DeviceError> {
        let mut tries = 1;
        loop {
            if state.in_doubt {
                self.line.synchronise().await?;
                state.in_doubt = false;
            }
            state.in_doubt = true;
            let asked = Instant::now();
            let answer = self
                .line
                .ask_within(Request::Spectrum, "spectrum", 2 * exposure + READ_OUT, deadline)
                .await;
            let error = match answer {
                Ok(Answer::Spectrum(counts)) => {
                    state.in_doubt = false;
                    return Ok((counts, asked));
                }
                Ok(_) => self.line.fault("another answer than a spectrum", &[]),
                Err(error) => error,
            };
            if tries >= TRIES || error.kind() != ErrorKind::Malformed {
                return Err(error);
            }
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
    }
}

#[async_trait]
impl Spectroradiometer for OceanOoi {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &SpectroradiometerProperties {
        &self.properties
    }

    async fn set_integration_time(&self, time: Duration) -> Result<Duration, DeviceError> {
        let (shortest, longest) = self.properties.integration_limits;
        let action = format!("integrate for {time:?}");
        let Some(us) = u32::try_from(time.as_micros())
            .ok()
            .filter(|_| (shortest..=longest).contains(&time))
        else {
            let reason = format!("the integration time is {shortest:?} to {longest:?}");
            return Err(DeviceError::Unsupported {
                device: self.line.name.clone(),
                action,
                reason,
            });
        };
        let mut state = self.state.lock().await;
        self.line.send(Request::IntegrationTime(us)).await?;
        let status = self.line.status().await?;
        if status.integration_us != us {
            return Err(self.line.fault(
                &format!("{us} µs were set, {} µs are read back", status.integration_us),
                &[],
            ));
        }
        let longer = time.max(state.integration);
        state.integration = time;
        // The exposure under way was begun with the old time.
        self.expose(&mut state, longer, Instant::now() + 3 * (2 * longer + READ_OUT))
            .await?;
        Ok(time)
    }

    async fn acquire(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let mut state = self.state.lock().await;
        let integration_time = state.integration;
        // Begun before the call, perhaps.
        self.expose(&mut state, integration_time, deadline).await?;
        let (counts, began) = self.expose(&mut state, integration_time, deadline).await?;
        Ok(RawSpectrum {
            counts,
            integration_time,
            detector_c: None,
            began,
            ended: Instant::now(),
        })
    }
}

/// The bus, with the words for what went wrong on it.
struct Line {
    bus: Bus<Talk>,
    name: String,
}

impl Line {
    /// Sends what nobody answers.
    async fn send(&self, request: Request) -> Result<(), DeviceError> {
        let deadline = Instant::now() + 4 * ANSWER;
        match self.bus.ask(request, deadline).await {
            Ok(_) => Ok(()),
            Err(error) => Err(error.during(&self.name, &format!("{request:?}"))),
        }
    }

    async fn ask_within(
        &self,
        request: Request,
        action: &str,
        patience: Duration,
        deadline: Instant,
    ) -> Result<Answer, DeviceError> {
        match self.bus.ask_within(request, patience, deadline).await {
            Ok(Some(answer)) => Ok(answer),
            Ok(None) => Err(self.fault("nobody answers this command", &[])),
            Err(error) => Err(error.during(&self.name, action)),
        }
    }

    /// A short request, again if the line damaged or lost the answer.
    async fn ask(&self, request: Request) -> Result<Answer, DeviceError> {
        let mut tries = 1;
        loop {
            let deadline = Instant::now() + 4 * ANSWER;
            match self
                .ask_within(request, &format!("{request:?}"), ANSWER, deadline)
                .await
            {
                Err(error) if tries < TRIES && matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Malformed) => {
                    tracing::warn!(%error, tries, "asking again");
                    tries += 1;
                    if request != Request::Status {
                        self.synchronise().await?;
                    }
                }
                result => return result,
            }
        }
    }

    /// Proves that nothing older is on its way: the instrument answers in order, and the status looks like no other answer.
    async fn synchronise(&self) -> Result<(), DeviceError> {
        Box::pin(self.status()).await.map(|_| ())
    }

    async fn status(&self) -> Result<InstrumentStatus, DeviceError> {
        match self.ask(Request::Status).await? {
            Answer::Status(status) => Ok(status),
            _ => Err(self.fault("another answer than the status", &[])),
        }
    }

    async fn slot(&self, slot: u8) -> Result<EepromSlot, DeviceError> {
        match self.ask(Request::Eeprom(slot)).await? {
            Answer::Eeprom(slot) => Ok(slot),
            _ => Err(self.fault("another answer than an EEPROM slot", &[])),
        }
    }

    /// A number of the EEPROM: without it a wavelength or a count would be a guess.
    async fn coefficient(&self, slot: u8) -> Result<f64, DeviceError> {
        let stored = self.slot(slot).await?;
        stored
            .number()
            .ok_or_else(|| self.fault(&format!("EEPROM slot {slot} holds no number"), &stored.data))
    }

    /// The irradiance calibration; `None` when it is blank or the instrument does not know the command.
    async fn irradiance(&self) -> Result<Option<Vec<f64>>, DeviceError> {
        let size = 4 * PIXELS;
        let mut bytes = Vec::with_capacity(size + usize::from(IRRADIANCE_BLOCK));
        while bytes.len() < size {
            match self.ask(Request::Irradiance(bytes.len() as u16)).await {
                Ok(Answer::Irradiance(_, block)) => bytes.extend_from_slice(&block),
                Ok(_) => return Err(self.fault("another answer than an irradiance block", &[])),
                Err(error) if bytes.is_empty() && error.kind() == ErrorKind::Timeout => {
                    tracing::warn!(%error, "the instrument gives no irradiance calibration");
                    return Ok(None);
                }
                Err(error) => return Err(error),
            }
        }
        let floats = bytes[..size]
            .chunks_exact(4)
            .map(|word| f32::from_be_bytes([word[0], word[1], word[2], word[3]]));
        let factors: Vec<f64> = floats.map(f64::from).collect();
        // An erased memory reads as NaN, a blank one as zeros.
        let sound = factors.iter().all(|factor| factor.is_finite() && *factor >= 0.0);
        Ok((sound && factors.iter().any(|factor| *factor > 0.0)).then_some(factors))
    }

    fn fault(&self, reason: &str, evidence: &[u8]) -> DeviceError {
        let (device, action) = (self.name.clone(), "read the instrument".to_owned());
        DeviceError::Fault {
            device,
            action,
            reason: reason.to_owned(),
            evidence: evidence.to_vec(),
        }
    }
}

/// The codec as the owner of a bus.
#[derive(Default)]
struct Talk(Conversation);

impl isolux_transport::Conversation for Talk {
    type Request = Request;
    /// `None`: sent, and nobody answers.
    type Answer = Option<Answer>;

    fn ready_at(&self, now: Instant) -> Instant {
        Instant::from_std(self.0.ready_at(now.into_std()))
    }

    fn start(&mut self, _: Instant, request: Request) -> (Vec<u8>, Option<Self::Answer>) {
        let (frame, answered) = self.0.start(request);
        (frame, if answered { None } else { Some(None) })
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Option<Outcome<Self::Answer>> {
        Some(match self.0.handle_input(now.into_std(), bytes)? {
            Event::Answer(answer) => Outcome::Answer(Some(answer)),
            Event::Damaged { reason, frame } => Outcome::Malformed { reason, frame },
        })
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.0.abandon(now.into_std())
    }
}
