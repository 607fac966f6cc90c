//! A spectroradiometer as the light meter of a bench: the spectrum of each exposure, weighted by V(λ), is illuminance.
//!
//! Its ranges are integration times: the first, which is the most sensitive, is the one that the address states, and
//! the others are shares of it. It gives no number before its dark was taken, at each of these times. Each exposure
//! begins after its request, so that it can be read while the light moves.

mod settings;
mod weights;

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    Conversions, DeviceError, ErrorKind, Identity, LuxMeter, LuxMeterProperties, LuxOutcome, LuxRange, LuxReading,
    LuxSample, OpenError, RawSpectrum, Spectroradiometer,
};
use isolux_record::disk::sha256;
use isolux_units::Lux;
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep_until};

pub(crate) use self::settings::{EXAMPLE, Settings};

/// Integration times of the ranges, as parts of the longest.
const PARTS: [u32; 7] = [1, 2, 5, 10, 20, 50, 100];

/// Spectra that are the dark of a range.
const DARKS: u32 = 8;

/// Share of saturation by which the dark of all pixels but this share may grow from the shortest integration time to
/// the longest: dark current is less, light is more, and some pixels are hot.
const MOST_DARK: f64 = 0.005;
const HOT: f64 = 0.01;

/// Of a peak in the automatic range, as shares of saturation: above the first it takes a less sensitive range, in which
/// it is at most the second, and a more sensitive one where it is at most the third there.
const AUTO: [f64; 3] = [0.9, 0.8, 0.7];

/// Exposures of one reading within which the automatic range must have been found.
const MOST_EXPOSURES: usize = 8;

/// Light of so long is in a reading at rest, of so many exposures at most.
const AT_REST: Duration = Duration::from_secs(1);
const MOST_AT_REST: u32 = 10;

/// Exposures by which it is seen how long one takes.
const TIMED: usize = 3;

/// A spectroradiometer that reads illuminance.
pub(crate) struct SpectralLuxMeter {
    device: Box<dyn Spectroradiometer>,
    properties: LuxMeterProperties,
    /// Integration time of each range, falling.
    times: Vec<Duration>,
    /// Illuminance of one linear count a second in each pixel, lx.
    weight_lx: Vec<f64>,
    /// The calibration, for the record.
    calibration: String,
    state: Mutex<State>,
}

struct State {
    /// As it was chosen.
    range: LuxRange,
    /// Place of the range in use.
    place: usize,
    /// The dark of each range; empty before it was taken.
    dark: Vec<RawSpectrum>,
}

impl SpectralLuxMeter {
    /// Puts `device` to use as `settings` say.
    ///
    /// # Errors
    /// [`OpenError`]: a calibration that is not there or does not cover V(λ), an integration time that the instrument
    /// has not; what it reports.
    pub async fn open(device: Box<dyn Spectroradiometer>, settings: Settings) -> Result<Self, OpenError> {
        let (factor, calibration) = settings.factors(device.properties())?;
        let weights = weights::of(&device.properties().wavelength_nm, &factor);
        let weight_lx = weights.map_err(|reason| settings.wrong(reason))?;
        let longest = device.set_integration_time(settings.integration).await?;
        let (shortest, _) = device.properties().integration_limits;
        let times = PARTS.map(|part| longest / part).into_iter();
        // The instrument counts microseconds.
        let whole = times.map(|time| Duration::from_micros(time.as_micros() as u64));
        let times: Vec<Duration> = whole.filter(|time| *time >= shortest).collect();
        let full_scale = |time: &Duration| {
            let share = longest.as_secs_f64() / time.as_secs_f64();
            Lux::new(settings.full_scale_lx? * share).ok()
        };
        let properties = LuxMeterProperties {
            range_full_scale: times.iter().filter_map(full_scale).collect(),
            update_interval: one_exposure(device.as_ref(), longest).await?,
            integration: longest,
            range_integration: times.clone(),
            converts: Conversions::OnRequest,
            needs_dark: true,
        };
        Ok(Self {
            device,
            properties,
            times,
            weight_lx,
            calibration,
            state: Mutex::new(State {
                range: LuxRange::Auto,
                place: 0,
                dark: Vec::new(),
            }),
        })
    }

    async fn choose(&self, state: &mut State, place: usize) -> Result<(), DeviceError> {
        if let Some(time) = self.times.get(place).filter(|_| place != state.place) {
            self.device.set_integration_time(*time).await?;
            state.place = place;
        }
        Ok(())
    }

    /// Counts of the brightest pixel that has a weight, and its place.
    fn peak(&self, raw: &RawSpectrum) -> (u16, usize) {
        let weighed = raw.counts.iter().zip(&self.weight_lx).enumerate();
        let weighed = weighed.filter(|(_, (_, weight))| **weight > 0.0);
        let peak = weighed.max_by_key(|(_, (counts, _))| **counts);
        peak.map_or((0, 0), |(pixel, (counts, _))| (*counts, pixel))
    }

    /// The range in which `raw` would be better read, in the automatic one.
    fn better(&self, state: &State, raw: &RawSpectrum) -> Option<usize> {
        let (peak, pixel) = self.peak(raw);
        let saturation = self.device.properties().saturation_counts;
        let [most, down_to, up_to] = AUTO.map(|share| share * f64::from(saturation));
        let last = self.times.len() - 1;
        if peak >= saturation {
            return (state.place < last).then(|| (state.place + 2).min(last));
        }
        let dark = |place: usize| state.dark.get(place).map_or(0.0, |dark| f64::from(dark.counts[pixel]));
        let net = f64::from(peak) - dark(state.place);
        let there = |place: usize| {
            let share = self.times[place].as_secs_f64() / self.times[state.place].as_secs_f64();
            net * share + dark(place)
        };
        if f64::from(peak) > most {
            let next = (state.place + 1..=last).find(|place| there(*place) <= down_to);
            return next.or((state.place < last).then_some(last));
        }
        (0..state.place).find(|place| there(*place) <= up_to)
    }

    /// One digit in a range: a count in each pixel, as their roundings are independent.
    fn digit(&self, place: usize) -> Result<Lux, DeviceError> {
        let properties = self.device.properties();
        let scale = f64::from(properties.full_scale_counts) / f64::from(properties.saturation_counts);
        let squares: f64 = self.weight_lx.iter().map(|weight| weight * weight).sum();
        self.lux(squares.sqrt() * scale / self.times[place].as_secs_f64())
    }

    fn lux(&self, value: f64) -> Result<Lux, DeviceError> {
        Lux::new(value)
            .map_err(|error| DeviceError::fault(&self.identity().target, "read", error.to_string(), Vec::new()))
    }

    /// What `raw` says.
    fn said(&self, state: &State, raw: &RawSpectrum) -> Result<LuxOutcome, DeviceError> {
        let fault = |reason: String| DeviceError::fault(&self.identity().target, "read", reason, evidence(raw));
        let Some(dark) = state.dark.get(state.place) else {
            return Err(fault(
                "it has no dark yet, and gives no number without one: close the shutter, or cap it, first".to_owned(),
            ));
        };
        let properties = self.device.properties();
        if self.peak(raw).0 >= properties.saturation_counts {
            return Ok(LuxOutcome::OverRange);
        }
        let linear = properties.linear_counts(raw, Some(dark));
        let linear = linear.map_err(|error| fault(error.to_string()))?;
        let weighed = linear.iter().zip(&self.weight_lx);
        let sum: f64 = weighed.map(|(counts, weight)| counts * weight).sum();
        let of_one = 1.0 / raw.integration_time.as_secs_f64();
        Ok(LuxOutcome::Measured(self.lux(sum * of_one)?))
    }

    /// `first` and as many spectra after it as make `count`, their mean in whole counts; a pixel that is full in one of
    /// them stays full.
    async fn mean(&self, first: RawSpectrum, count: u32, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let saturation = self.device.properties().saturation_counts;
        let mut sums: Vec<(u32, bool)> = vec![(0, false); first.counts.len()];
        let mut add = |raw: &RawSpectrum| {
            for ((sum, full), counts) in sums.iter_mut().zip(&raw.counts) {
                *sum += u32::from(*counts);
                *full |= *counts >= saturation;
            }
        };
        add(&first);
        let mut ended = first.ended;
        for _ in 1..count {
            let next = self.device.acquire(deadline).await?;
            add(&next);
            ended = next.ended;
        }
        let mean = |(sum, full): (u32, bool)| {
            if full {
                saturation
            } else {
                ((sum + count / 2) / count) as u16
            }
        };
        Ok(RawSpectrum {
            counts: sums.into_iter().map(mean).collect(),
            ended,
            ..first
        })
    }

    /// The mean spectrum of one reading at rest, in the range that was chosen or in the one that suits the light.
    async fn taken(&self, state: &mut State, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        let mut first = self.device.acquire(deadline).await?;
        for _ in 1..MOST_EXPOSURES {
            let better = if state.range == LuxRange::Auto {
                self.better(state, &first)
            } else {
                None
            };
            let Some(place) = better else { break };
            self.choose(state, place).await?;
            first = self.device.acquire(deadline).await?;
        }
        self.mean(first, self.exposures(state.place), deadline).await
    }

    /// Exposures of one reading at rest: about [`AT_REST`] of light.
    fn exposures(&self, place: usize) -> u32 {
        let count = AT_REST.as_secs_f64() / self.times[place].as_secs_f64();
        (count.round() as u32).clamp(1, MOST_AT_REST)
    }
}

/// Counts by which the dark grows from the shortest integration time to the longest, in all pixels but the hot ones.
fn growth(dark: &[RawSpectrum]) -> f64 {
    let (Some(longest), Some(shortest)) = (dark.first(), dark.last()) else {
        return 0.0;
    };
    let pixels = longest.counts.iter().zip(&shortest.counts);
    let mut grown: Vec<f64> = pixels.map(|(more, less)| f64::from(*more) - f64::from(*less)).collect();
    grown.sort_by(f64::total_cmp);
    let place = ((1.0 - HOT) * grown.len() as f64) as usize;
    grown
        .get(place.min(grown.len().saturating_sub(1)))
        .copied()
        .unwrap_or(0.0)
}

/// How long one exposure takes from its request to its end, read out and sent.
async fn one_exposure(device: &dyn Spectroradiometer, time: Duration) -> Result<Duration, DeviceError> {
    let mut longest: Option<Duration> = None;
    let mut last = Ok(());
    for _ in 0..=TIMED {
        let requested = Instant::now();
        // The first may have been stored, which is no moment.
        match device.sample(requested + 3 * time + Duration::from_secs(10)).await {
            Ok(_) => longest = longest.max(Some(requested.elapsed())),
            Err(error) => last = Err(error),
        }
    }
    match longest {
        Some(longest) => Ok(longest),
        None => last.map(|()| time),
    }
}

/// What the record keeps of a spectrum that a number came from: the counts of its brightest pixel, their sum over all
/// pixels, and the first bytes of their SHA-256 (most significant byte first).
fn evidence(raw: &RawSpectrum) -> Vec<u8> {
    let bytes: Vec<u8> = raw.counts.iter().flat_map(|counts| counts.to_be_bytes()).collect();
    let peak = raw.counts.iter().copied().max().unwrap_or_default();
    let sum: u32 = raw.counts.iter().map(|counts| u32::from(*counts)).sum();
    let digest = hex::decode(sha256(&bytes)).unwrap_or_default();
    let parts = peak.to_be_bytes().into_iter().chain(sum.to_be_bytes());
    parts.chain(digest.into_iter().take(4)).collect()
}

#[async_trait]
impl LuxMeter for SpectralLuxMeter {
    fn identity(&self) -> &Identity {
        self.device.identity()
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let mut state = self.state.lock().await;
        sleep_until(not_before).await;
        let asked = Instant::now();
        let taken = self.taken(&mut state, deadline).await;
        let digit = self.digit(state.place)?;
        let (outcome, bounds, evidence) = match taken {
            Ok(raw) => (self.said(&state, &raw)?, (raw.began, raw.ended), evidence(&raw)),
            // No two exposures agree: the light changes, or the link damages them.
            Err(error) if error.kind() == ErrorKind::Malformed => {
                (LuxOutcome::Unsteady, (asked, Instant::now()), Vec::new())
            }
            Err(error) => return Err(error),
        };
        Ok(LuxReading {
            outcome,
            range: state.place as u8 + 1,
            confirmed_by: None,
            digit,
            began: bounds.0,
            ended: bounds.1,
            caution: None,
            retries: 0,
            evidence,
        })
    }

    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError> {
        let state = self.state.lock().await;
        let raw = self.device.sample(deadline).await?;
        Ok(LuxSample {
            outcome: self.said(&state, &raw)?,
            range: state.place as u8 + 1,
            digit: self.digit(state.place)?,
            requested: raw.began,
            answered: raw.ended,
            evidence: evidence(&raw),
        })
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        let mut state = self.state.lock().await;
        if let LuxRange::Fixed(number) = range {
            let place = usize::from(number).checked_sub(1);
            let Some(place) = place.filter(|place| *place < self.times.len()) else {
                let last = self.times.len();
                return Err(DeviceError::unsupported(
                    &self.identity().target,
                    format!("use range {number}"),
                    format!("its integration times are ranges 1 ({:?}) to {last}", self.times[0]),
                ));
            };
            self.choose(&mut state, place).await?;
        }
        state.range = range;
        Ok(())
    }

    async fn take_dark(&self, deadline: Instant) -> Result<Option<String>, DeviceError> {
        let mut state = self.state.lock().await;
        let before = state.place;
        let (mut dark, mut levels) = (Vec::new(), Vec::new());
        for place in 0..self.times.len() {
            self.choose(&mut state, place).await?;
            let first = self.device.acquire(deadline).await?;
            let mean = self.mean(first, DARKS, deadline).await?;
            let counts = mean.counts.iter().map(|counts| f64::from(*counts));
            levels.push(counts.sum::<f64>() / mean.counts.len().max(1) as f64);
            dark.push(mean);
        }
        self.choose(&mut state, before).await?;
        let growth = growth(&dark);
        if growth > MOST_DARK * f64::from(self.device.properties().saturation_counts) {
            return Err(DeviceError::fault(
                &self.identity().target,
                "take the dark",
                format!(
                    "light falls on it: {growth:.0} counts more at {:?} than at {:?}: close the shutter, or cap it",
                    self.times[0],
                    self.times[self.times.len() - 1]
                ),
                Vec::new(),
            ));
        }
        state.dark = dark;
        let levels = levels.iter().zip(&self.times);
        let levels: Vec<String> = levels.map(|(level, time)| format!("{level:.1} at {time:?}")).collect();
        Ok(Some(format!(
            "dark of the lux meter, counts in the mean of its pixels: {}; {}",
            levels.join(", "),
            self.calibration
        )))
    }
}

#[cfg(test)]
mod tests;
