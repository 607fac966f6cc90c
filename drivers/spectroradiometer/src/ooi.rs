//! Ocean Optics USB2000+ and Flame-S in the OOI language: `ocean-ooi:usb:…`, or `ocean-ooi:LINK` over any byte link
//! that carries one frame a USB transfer (see `isolux-protocol-ooi`).
//!
//! The detector integrates all the time and a request may be answered with an exposure that was begun before it, so
//! each acquisition throws one spectrum away and returns the next (python-seabreeze issues 110 and 177).
//!
//! The language has neither checksum nor request number. What the instrument stores is therefore read twice and held
//! against what its detector can be (see `stored`); a spectrum is given only when it agrees, pixel by pixel, with the
//! exposure before it, which is taken anyway (see `agreement`), and when the instrument's next answer proves that no
//! other spectrum was on its way.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, ErrorKind, Factories, Identity, Kind, OpenError, RawSpectrum, Spectroradiometer,
    SpectroradiometerFactory, SpectroradiometerProperties, Target,
};
use isolux_protocol_ooi::{Answer, DARK_PIXELS, FULL_SCALE, Host, INTEGRATION_LIMITS_US, PIXELS, Request};
use isolux_transport::{
    Driver, LineSettings, Parity, Ports, TRIES, UsbAddress, UsbFraming, UsbModel, UsbProfile, no_display,
    worth_another_try,
};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

use crate::agreement::Pair;
use crate::in_motion::{READY, light_began};
use crate::line::Line;
use crate::place::usb_place;
use crate::stored::Stored;

/// Name of the driver in `open = "ocean-ooi:…"`.
const NAME: &str = "ocean-ooi";

/// For serial adapters that carry the frames; the instrument itself has no line settings.
const LINE: LineSettings = LineSettings {
    baud: 115_200,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Read-out and transfer of a spectrum, over and above the exposure.
const READ_OUT: Duration = Duration::from_secs(1);

/// After command 01.
const INITIALIZE: Duration = Duration::from_millis(100);

/// Over and above twice what the read-out of earlier spectra took: a spectrum in motion is given up then.
const BESIDE: Duration = Duration::from_millis(200);

/// Exposures of one spectrum within which two in a row must agree.
const MOST_EXPOSURES: usize = 8;

/// Commands, short answers, spectra; each a transfer of its own.
const USB: UsbProfile = UsbProfile {
    ids: &[(0x2457, 0x101E)],
    command: 0x01,
    answers: &[0x81, 0x82],
    framing: UsbFraming::Transfers,
};

/// Ocean Optics spectrometers in the OOI language.
pub const OCEAN_OOI: Driver = Driver {
    name: NAME,
    speaks_to: "Ocean Optics USB2000+, Flame-S",
    examples: &[(Kind::Spectroradiometer, "ocean-ooi:usb:serial=USB2+H16355")],
    seen_with: "🧪 its virtual twin; cseabreeze 2.11.0, over USB",
    usb: &[UsbModel {
        id: USB.ids[0],
        model: "Ocean Optics USB2000+ or Flame-S",
    }],
    // Its instruments stand on USB, where their ids say who they are.
    identify: &[],
    place: |target, _| usb_place(target, LINE),
    display_lx: no_display,
    factories: |ports| Factories {
        spectroradiometer: Some(Arc::new(OceanOoiDriver::new(ports))),
        ..Factories::default()
    },
};

/// Opens OOI spectrometers.
pub struct OceanOoiDriver {
    ports: Arc<Ports>,
}

impl OceanOoiDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }
}

#[async_trait]
impl SpectroradiometerFactory for OceanOoiDriver {
    async fn open_spectroradiometer(&self, target: &Target) -> Result<Box<dyn Spectroradiometer>, OpenError> {
        let bus = self
            .ports
            .usb_bus(target, usb_place(target, LINE)?.line, &USB, Host::default)
            .await?;
        let line = Line::new(bus, target.to_string());
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
    /// A spectrum was given up and may still come, or bytes came that nobody asked for.
    in_doubt: bool,
    /// Count of the bus when the line was last known to be in step.
    unsolicited: u64,
    /// The longest that read-out and transfer took, over and above the exposure.
    read_out: Duration,
}

impl OceanOoi {
    async fn open(line: Line, target: &Target) -> Result<Self, DeviceError> {
        line.send(Request::Initialize).await?;
        sleep(INITIALIZE).await;
        // An interrupted program may have left it waiting for a trigger.
        line.send(Request::Trigger(0)).await?;
        let status = line.status_twice().await?;
        if usize::from(status.pixels) != PIXELS || status.trigger != 0 {
            let reason = format!(
                "{} pixels and trigger mode {}: not a USB2000+ or Flame-S in free run",
                status.pixels, status.trigger
            );
            return Err(DeviceError::unsupported(&line.name, "use this instrument", reason));
        }
        let stored = Stored::read_twice(&line).await?.checked(&line)?;
        // The descriptors of some have no serial number, so it was not known which one was opened.
        let wanted = UsbAddress::parse(target.link())
            .ok()
            .flatten()
            .and_then(|address| address.serial);
        if let Some(wanted) = wanted.filter(|wanted| Some(wanted) != stored.serial.as_ref()) {
            let found = stored.serial.as_deref().unwrap_or("none");
            return Err(DeviceError::unsupported(
                &line.name,
                "use this instrument",
                format!("its serial number is {found}, not {wanted}"),
            ));
        }
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: "Ocean Optics USB2000+ / Flame-S".to_owned(),
            serial: stored.serial,
            firmware: None,
        };
        let limits = INTEGRATION_LIMITS_US;
        let microseconds = |us: u32| Duration::from_micros(u64::from(us));
        let properties = SpectroradiometerProperties {
            wavelength_nm: stored.wavelength_nm,
            dark_pixels: DARK_PIXELS,
            integration_limits: (microseconds(limits.0), microseconds(limits.1)),
            saturation_counts: stored.saturation_counts,
            full_scale_counts: FULL_SCALE,
            nonlinearity: stored.nonlinearity,
            irradiance_factor: stored.irradiance_factor,
        };
        let state = Mutex::new(State {
            integration: microseconds(status.integration_us),
            in_doubt: false,
            unsolicited: line.unsolicited(),
            read_out: Duration::ZERO,
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
            let error = match self.exposed(state, 2 * exposure + READ_OUT, deadline).await {
                Ok(exposed) => return Ok(exposed),
                // A spectrum that does not come costs its exposure: it is not asked for again.
                Err((what, error)) if tries >= TRIES || !what.is_worth_another_try(&error) => return Err(error),
                Err((_, error)) => error,
            };
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
    }

    /// One try at a spectrum: where the line may be out of step, the proof that nothing older is on its way, then the
    /// request.
    async fn exposed(
        &self,
        state: &mut State,
        patience: Duration,
        deadline: Instant,
    ) -> Result<(Vec<u16>, Instant), (Asked, DeviceError)> {
        if state.in_doubt {
            self.line.status_once().await.map_err(|error| (Asked::Status, error))?;
            state.in_doubt = false;
            state.unsolicited = self.line.unsolicited();
        }
        state.in_doubt = true;
        let requested = Instant::now();
        let answer = self
            .line
            .ask_within(Request::Spectrum, "spectrum", patience, deadline)
            .await;
        match answer {
            Ok(Answer::Spectrum(counts)) => {
                state.in_doubt = false;
                let beside = requested.elapsed().saturating_sub(state.integration);
                state.read_out = state.read_out.max(beside);
                Ok((counts, requested))
            }
            Ok(_) => Err((Asked::Spectrum, self.line.fault("another answer than a spectrum", &[]))),
            Err(error) => Err((Asked::Spectrum, error)),
        }
    }

    /// See [`Spectroradiometer::sample`].
    async fn next(&self, state: &mut State, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let too_much = || self.line.fault("bytes arrived that nobody asked for", &[]);
        if !state.in_doubt && self.surplus(state) {
            return Err(too_much());
        }
        let integration_time = state.integration;
        let patience = 2 * (integration_time + state.read_out) + BESIDE;
        let exposed = self.exposed(state, patience, deadline).await;
        let (counts, requested) = exposed.map_err(|(_, error)| error)?;
        let ended = Instant::now();
        if self.surplus(state) {
            return Err(too_much());
        }
        let Some(began) = light_began(requested, ended, integration_time) else {
            state.in_doubt = true;
            return Err(self.line.fault(READY, &[]));
        };
        Ok(RawSpectrum {
            counts,
            integration_time,
            detector_c: None,
            began,
            ended,
        })
    }
}

/// What was asked when a try at a spectrum failed.
enum Asked {
    Status,
    Spectrum,
}

impl Asked {
    fn is_worth_another_try(&self, error: &DeviceError) -> bool {
        match self {
            Self::Status => worth_another_try(error.kind()),
            Self::Spectrum => error.kind() == ErrorKind::Malformed,
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
            return Err(DeviceError::unsupported(&self.line.name, action, reason));
        };
        // The instrument counts whole microseconds; a part of one is neither set nor read back.
        let time = Duration::from_micros(u64::from(us));
        let mut state = self.state.lock().await;
        self.line.send(Request::IntegrationTime(us)).await?;
        let status = self.line.status_twice().await?;
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
        let mut before: Option<Vec<u16>> = None;
        let mut disagreement = String::new();
        for _ in 0..MOST_EXPOSURES {
            if self.surplus(&mut state) {
                before = None;
            }
            let (counts, began) = self.expose(&mut state, integration_time, deadline).await?;
            let ended = Instant::now();
            // The first was begun before the call, perhaps. If nothing has changed since, it agrees with the second.
            if let Some(before) = before.replace(counts.clone()) {
                let pair = Pair {
                    before: &before,
                    after: &counts,
                    dark: self.properties.dark_pixels.clone(),
                    saturation: self.properties.saturation_counts,
                };
                match pair.agree() {
                    Ok(()) => {
                        if self.in_step(&mut state).await? {
                            return Ok(RawSpectrum {
                                counts,
                                integration_time,
                                detector_c: None,
                                began,
                                ended,
                            });
                        }
                        "an answer came that nothing had asked for".clone_into(&mut disagreement);
                    }
                    Err(difference) => {
                        tracing::warn!(%difference, "two exposures disagree");
                        disagreement = difference.to_string();
                        // One of them may be an old one, with the true one still on its way.
                        state.in_doubt = true;
                    }
                }
            }
        }
        Err(DeviceError::malformed(
            &self.line.name,
            "spectrum",
            format!("of {MOST_EXPOSURES} exposures no two in a row agree; of the last two: {disagreement}"),
            Vec::new(),
        ))
    }

    async fn sample(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let mut state = self.state.lock().await;
        self.next(&mut state, deadline).await
    }
}

impl OceanOoi {
    /// Whether bytes have arrived that answer no request; the line is put in step again before the next.
    fn surplus(&self, state: &mut State) -> bool {
        let unsolicited = self.line.unsolicited();
        let surplus = unsolicited != state.unsolicited;
        if surplus {
            tracing::warn!(device = self.line.name, "bytes arrived that nobody asked for");
            state.unsolicited = unsolicited;
            state.in_doubt = true;
        }
        surplus
    }

    /// Whether no spectrum is on its way: the instrument answers in order, so its status must be the next answer. It
    /// also says whether the integration time is still the one that was set; after a restart, or where another program
    /// uses the instrument, it is not.
    async fn in_step(&self, state: &mut State) -> Result<bool, DeviceError> {
        let integration = state.integration;
        let expected = |us: u32, trigger: u8| Duration::from_micros(u64::from(us)) == integration && trigger == 0;
        match self.line.status_once().await {
            Ok(status) if expected(status.integration_us, status.trigger) => return Ok(!self.surplus(state)),
            Ok(_) => {}
            Err(error) if worth_another_try(error.kind()) => {
                state.in_doubt = true;
                return Ok(false);
            }
            Err(error) => return Err(error),
        }
        let status = self.line.status_twice().await?;
        if expected(status.integration_us, status.trigger) {
            return Ok(false);
        }
        let reason = format!(
            "{:?} was set and {} µs with trigger mode {} is read back: it was restarted, or another program uses it",
            state.integration, status.integration_us, status.trigger
        );
        Err(self.line.fault(&reason, &[]))
    }
}
