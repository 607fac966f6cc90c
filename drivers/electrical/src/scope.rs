//! Oscilloscopes in SCPI that record a photodiode: `scpi-scope:LINK?profile=ds1000z&channel=1`.
//!
//! One record in the memory of the instrument, which is then at rest and read in blocks. SCPI has no request numbers:
//! every block is read until two in a row are the same bytes.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, ErrorKind, Factories, Identity, Kind, OpenError, Target, VoltageRecord, WaveformRecorder,
    WaveformRecorderFactory,
};
use isolux_protocol_scpi::Reading;
use isolux_transport::{Driver, Place, Ports, TRIES, no_display};
use tokio::time::{Instant, sleep};

use crate::instrument::Instrument;
use crate::scope_profile::{Origin, Scope};

const NAME: &str = "scpi-scope";

/// Over and above the length of a record until it has stopped.
const SPARE: Duration = Duration::from_secs(20);
/// Between two questions whether it has stopped.
const PAUSE: Duration = Duration::from_millis(200);
/// Time bases are 1, 2 and 5 times powers of ten, from 1 µs a division on.
const FIRST_TIME_BASE_S: f64 = 1e-6;
const LAST_TIME_BASE_S: f64 = 50.0;
/// The rate that a record has may differ from the one that was set by this share.
const RATE: f64 = 0.5;

/// Oscilloscopes in SCPI.
pub const SCPI_SCOPE: Driver = Driver {
    name: NAME,
    speaks_to: "oscilloscopes in SCPI by a profile, with a photodiode at an input: Rigol DS1000Z",
    examples: &[(
        Kind::WaveformRecorder,
        "scpi-scope:tcp://192.168.1.7:5555?profile=ds1000z&channel=1",
    )],
    seen_with: "🧪 its virtual twin",
    usb: &[],
    // A power meter asks the same.
    identify: &[],
    place: |target, _| Ok(Address::parse(target)?.place),
    display_lx: no_display,
    factories: |ports| Factories {
        waveform_recorder: Some(Arc::new(ScpiScopeDriver { ports })),
        ..Factories::default()
    },
};

/// A target in the words of the oscilloscope.
struct Address {
    profile: Scope,
    channel: u8,
    place: Place,
}

impl Address {
    fn parse(target: &Target) -> Result<Self, OpenError> {
        target.only(&["profile", "channel"])?;
        let profile = Scope::of(target)?;
        let channel = target.number("channel", 1_u8)?;
        if !(1..=profile.channels).contains(&channel) {
            return Err(target.wrong(format!(
                "channel={channel}: this oscilloscope has 1 to {}",
                profile.channels
            )));
        }
        let place = Place {
            channel: format!("input {channel}"),
            line: profile.manners.line,
        };
        Ok(Self {
            profile,
            channel,
            place,
        })
    }
}

struct ScpiScopeDriver {
    ports: Arc<Ports>,
}

#[async_trait]
impl WaveformRecorderFactory for ScpiScopeDriver {
    async fn open_waveform_recorder(&self, target: &Target) -> Result<Box<dyn WaveformRecorder>, OpenError> {
        let Address { profile, channel, .. } = Address::parse(target)?;
        let instrument = Instrument::open(&self.ports, target, NAME, &profile.manners).await?;
        let scope = ScpiScope {
            instrument,
            profile,
            channel,
        };
        scope.dc_coupled().await?;
        Ok(Box::new(scope))
    }
}

struct ScpiScope {
    instrument: Instrument,
    profile: Scope,
    channel: u8,
}

/// What a preamble says.
struct Preamble {
    points: u64,
    interval_s: f64,
    y: [f64; 3],
}

impl ScpiScope {
    fn of_channel(&self, message: &str) -> String {
        message.replace("{channel}", &self.channel.to_string())
    }

    async fn set(&self, message: &str, value: impl std::fmt::Display) -> Result<(), DeviceError> {
        self.send(&message.replace("{value}", &value.to_string())).await
    }

    /// A command for this channel, again where it was damaged on its way: sent twice, each does what it does once.
    async fn send(&self, message: &str) -> Result<(), DeviceError> {
        let message = self.of_channel(message);
        let lost = |error: &DeviceError| matches!(error.kind(), ErrorKind::Disconnected | ErrorKind::TakenOver);
        let mut tries = 1;
        loop {
            match self.instrument.command(&message).await {
                Err(error) if tries < TRIES && !lost(&error) => tries += 1,
                sent => return sent,
            }
        }
    }

    /// An input without the mean of its signal shows no light.
    async fn dc_coupled(&self) -> Result<(), DeviceError> {
        let query = self.of_channel(&self.profile.coupling);
        let found = self.instrument.twice(&query).await?;
        if found.eq_ignore_ascii_case(&self.profile.dc) {
            return Ok(());
        }
        let reason = format!("the input is coupled {found}: set it to {}", self.profile.dc);
        Err(self.instrument.fault(&query, reason, Vec::new()))
    }

    /// Time base in s a division and depth of memory in points for a record.
    fn settings(&self, duration_s: f64, least_rate_hz: f64) -> Option<(f64, u64)> {
        let divisions = f64::from(self.profile.divisions);
        let mut decade = FIRST_TIME_BASE_S;
        let mut bases = Vec::new();
        while decade <= LAST_TIME_BASE_S * 1.01 {
            bases.extend([1.0, 2.0, 5.0].map(|step| step * decade));
            decade *= 10.0;
        }
        let base = bases
            .into_iter()
            .filter(|base| *base <= LAST_TIME_BASE_S * 1.01)
            .find(|base| base * divisions >= duration_s)?;
        let wanted = base * divisions * least_rate_hz;
        let depth = self
            .profile
            .depths
            .iter()
            .find(|depth| **depth as f64 >= wanted * (1.0 - 1e-9));
        depth.map(|depth| (base, *depth))
    }

    /// Starts one record and waits until it has stopped.
    async fn fill(&self, length: Duration) -> Result<(), DeviceError> {
        for command in &self.profile.start {
            self.send(command).await?;
        }
        let deadline = Instant::now() + length + SPARE;
        loop {
            let (state, bytes) = self.instrument.query(&self.profile.state).await?;
            if state.eq_ignore_ascii_case(&self.profile.stopped) {
                // Once more: the answer may have belonged to an older question.
                let again = self.instrument.twice(&self.profile.state).await?;
                if again.eq_ignore_ascii_case(&self.profile.stopped) {
                    return Ok(());
                }
            }
            if Instant::now() > deadline {
                let reason = format!("the record does not end: the state is \"{state}\"");
                return Err(self.instrument.fault(&self.profile.state, reason, bytes));
            }
            sleep(PAUSE).await;
        }
    }

    async fn preamble(&self) -> Result<Preamble, DeviceError> {
        let query = &self.profile.preamble;
        let text = self.instrument.twice(query).await?;
        let wrong = |reason: &str| self.instrument.malformed(query, reason, text.clone().into_bytes());
        let values: Vec<f64> = text
            .split(',')
            .map(|field| match Reading::parse(field, "") {
                Reading::Value(number) => Ok(number.value),
                _ => Err(wrong("a field of the preamble is no number")),
            })
            .collect::<Result<_, _>>()?;
        let [form, _, points, _, interval_s, _, _, increment, origin, reference] = values[..] else {
            return Err(wrong("a preamble has ten fields"));
        };
        if form != 0.0 {
            return Err(wrong("the samples are no bytes"));
        }
        if !(interval_s > 0.0 && increment > 0.0 && points >= 1.0 && points.fract() == 0.0) {
            return Err(wrong("points, x increment and y increment must be above zero"));
        }
        Ok(Preamble {
            points: points as u64,
            interval_s,
            y: [increment, origin, reference],
        })
    }

    fn volts(&self, code: u8, [increment, origin, reference]: [f64; 3]) -> f64 {
        match self.profile.origin {
            Origin::Codes => (f64::from(code) - origin - reference) * increment,
            Origin::Volts => (f64::from(code) - reference) * increment + origin,
        }
    }
}

#[async_trait]
impl WaveformRecorder for ScpiScope {
    fn identity(&self) -> &Identity {
        self.instrument.identity()
    }

    async fn record(&self, duration: Duration, least_rate_hz: f64) -> Result<VoltageRecord, DeviceError> {
        const ACTION: &str = "record a waveform";
        let duration_s = duration.as_secs_f64();
        let Some((base_s, depth)) = self.settings(duration_s, least_rate_hz) else {
            let most = self.profile.depths.last().copied().unwrap_or_default();
            return Err(DeviceError::unsupported(
                self.instrument.name(),
                ACTION,
                format!(
                    "{duration_s} s at {least_rate_hz} Hz: its memory holds {most} points in {} divisions; record \
                     shorter or at a lower rate",
                    self.profile.divisions
                ),
            ));
        };
        for command in &self.profile.before {
            self.send(command).await?;
        }
        self.set(&self.profile.time_base, base_s).await?;
        self.set(&self.profile.depth, depth).await?;
        let length = Duration::from_secs_f64(base_s * f64::from(self.profile.divisions));
        self.fill(length).await?;
        let preamble = self.preamble().await?;
        let rate_hz = 1.0 / preamble.interval_s;
        let expected = depth as f64 / length.as_secs_f64();
        let wanted = (duration_s * rate_hz).ceil();
        if (rate_hz / expected - 1.0).abs() > RATE
            || rate_hz < least_rate_hz * (1.0 - 1e-6)
            || wanted > preamble.points as f64
        {
            let reason = format!(
                "{} points at {rate_hz} Hz in place of {depth} at {expected} Hz: is another channel switched on?",
                preamble.points
            );
            return Err(self.instrument.fault(&self.profile.preamble, reason, Vec::new()));
        }
        let wanted = wanted as u64;
        let mut voltage_v = Vec::with_capacity(wanted as usize);
        let mut from = 1;
        while from <= wanted {
            let to = wanted.min(from + self.profile.points_a_read - 1);
            self.set(&self.profile.from, from).await?;
            self.set(&self.profile.to, to).await?;
            let codes = self
                .instrument
                .block_twice(&self.profile.data, (to - from + 1) as usize)
                .await?;
            voltage_v.extend(codes.into_iter().map(|code| self.volts(code, preamble.y)));
            from = to + 1;
        }
        let [low, high] = self.profile.codes;
        Ok(VoltageRecord {
            voltage_v,
            rate_hz,
            range_v: (self.volts(low, preamble.y), self.volts(high, preamble.y)),
            step_v: preamble.y[0],
        })
    }
}
