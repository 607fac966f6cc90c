//! The check before a scan: the lamp must be stable.

use std::collections::VecDeque;
use std::time::Duration;

use isolux_device::{LuxOutcome, PowerMeter};
use isolux_record::event::PowerSample;
use isolux_record::{Limits, Station};
use tokio::time::{Instant, sleep_until};

use crate::electrical;
use crate::error::ScanError;
use crate::settle::{Noise, Photometer};

/// When a lamp counts as stable: on for at least `least_s`, and (max − min)/mean of its light over the last
/// `window_s` within `spread_rel`, and of its power within `power_spread_rel` where a power meter is there. The
/// defaults are the stabilisation of EN 13032-4 and CIE S 025: 30 min, 15 min, 0.5 %; LM-79 asks for light and power
/// too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// Least time on.
    pub least_s: f64,
    /// Length of the window.
    pub window_s: f64,
    /// Allowed (max − min)/mean over it.
    pub spread_rel: f64,
    /// Allowed (max − min)/mean of the power over it.
    pub power_spread_rel: f64,
    /// When to give up.
    pub most_s: f64,
}

impl Criterion {
    /// The criterion of a station, and of the limits of a plan.
    pub fn of(station: &Station, limits: &Limits) -> Self {
        let stable = station.lamp().and_then(|lamp| lamp.stable.as_ref());
        let least_s = stable.map_or(1800.0, |stable| stable.least_s);
        let window_s = stable.map_or(900.0, |stable| stable.window_s);
        Self {
            least_s,
            window_s,
            spread_rel: stable.map_or(0.005, |stable| stable.spread_rel),
            power_spread_rel: limits.power_spread_rel(),
            most_s: (4.0 * least_s).max(4.0 * window_s).max(60.0),
        }
    }

    /// The same for a lamp that is watched from `on_for_s` after it was switched on: the patience counts from there.
    #[must_use]
    pub fn beginning_at(self, on_for_s: f64) -> Self {
        Self {
            most_s: self.most_s + on_for_s.max(0.0),
            ..self
        }
    }

    /// The earliest time at which the check can pass.
    pub fn least_s(&self) -> f64 {
        self.least_s.max(self.window_s)
    }
}

/// One look at the lamp: the mean of a few consecutive readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WarmupSample {
    /// Seconds since the lamp was switched on.
    pub elapsed_s: f64,
    /// Mean illuminance.
    pub illuminance_lx: f64,
    /// Coarsest digit of the display among them.
    pub digit_lx: f64,
    /// (max − min)/mean over the window, once it is full.
    pub spread_rel: Option<f64>,
    /// The power; none without a power meter.
    pub power: Option<PowerSample>,
}

/// The lamp is stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stable {
    /// Seconds since it was switched on.
    pub elapsed_s: f64,
    /// (max − min)/mean over the window.
    pub spread_rel: f64,
    /// Illuminance at the end.
    pub illuminance_lx: f64,
    /// Scatter of single readings over the window.
    pub noise: Noise,
}

const READINGS_A_LOOK: usize = 5;

/// Digits of the display that the light must have: below them the window shows the display, not the lamp. A capped
/// detector or a lamp that is off shows a few digits of offset and room light that are very stable.
const LEAST_DIGITS: f64 = 10.0;

/// A lamp may take so long to give light.
const DARK_AT_MOST_S: f64 = 60.0;

/// The window over which a lamp is watched.
pub struct StabilityCheck {
    criterion: Criterion,
    on_at: Instant,
    window: Window,
    power: Window,
    scatter: VecDeque<(f64, f64, f64)>,
    next: Instant,
}

impl StabilityCheck {
    /// An empty window for a lamp that was switched on at `on_at`.
    pub fn new(criterion: Criterion, on_at: Instant) -> Self {
        Self {
            criterion,
            on_at,
            window: Window::default(),
            power: Window::default(),
            scatter: VecDeque::new(),
            next: Instant::now(),
        }
    }

    /// Looks at the light where the detector now is, and at the power.
    ///
    /// # Errors
    /// [`ScanError::NoNumber`] for light out of range; what the meters report.
    pub async fn look(
        &mut self,
        photometer: &mut Photometer<'_>,
        power: Option<&dyn PowerMeter>,
    ) -> Result<WarmupSample, ScanError> {
        let window_s = self.criterion.window_s;
        let (mean, elapsed_s, digit_lx) = look(photometer, self.on_at, &mut self.scatter).await?;
        self.window.push(elapsed_s, mean, window_s);
        let power = match power {
            Some(meter) => Some(self.power(meter).await?),
            None => None,
        };
        while self
            .scatter
            .front()
            .is_some_and(|(at, _, _)| *at < elapsed_s - window_s)
        {
            self.scatter.pop_front();
        }
        Ok(WarmupSample {
            elapsed_s,
            illuminance_lx: mean,
            digit_lx,
            spread_rel: self.window.spread(window_s),
            power,
        })
    }

    async fn power(&mut self, meter: &dyn PowerMeter) -> Result<PowerSample, ScanError> {
        let reading = electrical::read(meter, Instant::now()).await?;
        let power_w = electrical::recorded(&reading).power_w;
        let Some(watts) = power_w else {
            return Ok(PowerSample {
                power_w,
                power_spread_rel: None,
            });
        };
        let window_s = self.criterion.window_s;
        let at = reading.ended.saturating_duration_since(self.on_at).as_secs_f64();
        self.power.push(at, watts, window_s);
        Ok(PowerSample {
            power_w,
            power_spread_rel: self.power.spread(window_s),
        })
    }

    /// Whether the lamp is stable by this look.
    ///
    /// # Errors
    /// [`ScanError::NoLight`] when there is no light to judge, [`ScanError::NotStable`] when time is up.
    pub fn judge(&self, look: &WarmupSample) -> Result<Option<Stable>, ScanError> {
        let WarmupSample {
            elapsed_s,
            illuminance_lx,
            digit_lx,
            spread_rel,
            power,
        } = *look;
        let least_lx = LEAST_DIGITS * digit_lx;
        if (spread_rel.is_some() || elapsed_s >= DARK_AT_MOST_S) && illuminance_lx <= least_lx {
            return Err(ScanError::NoLight {
                illuminance_lx,
                least_lx,
            });
        }
        let Some(spread_rel) = spread_rel else {
            return Ok(None);
        };
        let criterion = &self.criterion;
        let steady_light = spread_rel < criterion.spread_rel;
        let steady_power = power.is_none_or(|power| {
            power
                .power_spread_rel
                .is_some_and(|spread_rel| spread_rel < criterion.power_spread_rel)
        });
        if steady_light && steady_power && elapsed_s >= criterion.least_s {
            return Ok(Some(Stable {
                elapsed_s,
                spread_rel,
                illuminance_lx,
                noise: noise(&self.scatter, illuminance_lx),
            }));
        }
        if elapsed_s <= criterion.most_s {
            return Ok(None);
        }
        let (of, spread_rel, allowed_rel) = match power {
            Some(power) if steady_light => match power.power_spread_rel {
                Some(spread_rel) => ("power", spread_rel, criterion.power_spread_rel),
                None => return Err(ScanError::NoPower { elapsed_s }),
            },
            _ => ("light", spread_rel, criterion.spread_rel),
        };
        Err(ScanError::NotStable {
            of,
            elapsed_s,
            window_s: criterion.window_s,
            spread_rel,
            allowed_rel,
        })
    }

    /// Waits until the next look is due.
    pub async fn pause(&mut self) {
        self.next += Duration::from_secs_f64((self.criterion.window_s / 30.0).clamp(0.1, 30.0));
        sleep_until(self.next).await;
    }
}

/// Watches the light where the detector now is until the lamp that was switched on at `on_at` is stable.
///
/// # Errors
/// [`ScanError::NotStable`] when it does not become so, [`ScanError::NoLight`] when there is no light to judge, or what
/// the meter reports.
pub async fn until_stable(
    photometer: &mut Photometer<'_>,
    power: Option<&dyn PowerMeter>,
    criterion: &Criterion,
    on_at: Instant,
    mut look_at: impl FnMut(WarmupSample),
) -> Result<Stable, ScanError> {
    let mut check = StabilityCheck::new(*criterion, on_at);
    loop {
        let look = check.look(photometer, power).await?;
        look_at(look);
        if let Some(stable) = check.judge(&look)? {
            return Ok(stable);
        }
        check.pause().await;
    }
}

/// Mean of a few readings in lx, the middle of their time in s, the coarsest digit in lx.
async fn look(
    photometer: &mut Photometer<'_>,
    on_at: Instant,
    scatter: &mut VecDeque<(f64, f64, f64)>,
) -> Result<(f64, f64, f64), ScanError> {
    let requested = Instant::now();
    let (mut sum, mut middle_s, mut digit_lx) = (0.0, 0.0, 0.0_f64);
    let (mut before, mut count) = (None::<f64>, 0.0);
    for _ in 0..READINGS_A_LOOK {
        let reading = photometer.read(requested).await?;
        let lux = match reading.outcome {
            LuxOutcome::Measured(lux) => lux,
            // A change while the lamp settles: the look goes on without this reading.
            LuxOutcome::Unsteady => {
                before = None;
                continue;
            }
            LuxOutcome::OverRange => return Err(ScanError::NoNumber { word: "over range" }),
            LuxOutcome::UnderRange => return Err(ScanError::NoNumber { word: "under range" }),
        };
        count += 1.0;
        let at = reading.middle().saturating_duration_since(on_at).as_secs_f64();
        if let Some(before) = before {
            scatter.push_back((at, lux.value() - before, reading.digit.value()));
        }
        before = Some(lux.value());
        digit_lx = digit_lx.max(reading.digit.value());
        sum += lux.value();
        middle_s += at;
    }
    if count == 0.0 {
        return Err(photometer.unsteady());
    }
    Ok((sum / count, middle_s / count, digit_lx))
}

/// Values of the last `window_s`, each with its time in s.
#[derive(Debug, Default)]
struct Window(VecDeque<(f64, f64)>);

impl Window {
    fn push(&mut self, at_s: f64, value: f64, window_s: f64) {
        self.0.push_back((at_s, value));
        // The window is full when what remains still spans it.
        while self.0.len() > 2 && self.0[1].0 <= at_s - window_s {
            self.0.pop_front();
        }
    }

    /// (max − min)/mean, once it is full.
    fn spread(&self, window_s: f64) -> Option<f64> {
        let (first_s, last_s) = (self.0.front()?.0, self.0.back()?.0);
        if last_s - first_s < window_s {
            return None;
        }
        let values = || self.0.iter().map(|(_, value)| *value);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        Some((high - low) / (values().sum::<f64>() / self.0.len() as f64))
    }
}

/// Scatter of single readings from successive differences, drift cancelled; the variance of rounding is taken out of
/// it, because it is stated apart.
fn noise(scatter: &VecDeque<(f64, f64, f64)>, level_lx: f64) -> Noise {
    if scatter.is_empty() {
        return Noise::UNKNOWN;
    }
    let count = scatter.len() as f64;
    let variance = scatter
        .iter()
        .map(|(_, difference, _)| difference * difference / 2.0)
        .sum::<f64>()
        / count;
    let rounding = scatter.iter().map(|(_, _, digit)| digit * digit / 12.0).sum::<f64>() / count;
    // Below the digit the scatter cannot be seen. What it could be at most without showing is about a tenth of the
    // digit.
    let hidden = scatter.iter().map(|(_, _, digit)| *digit).fold(0.0, f64::max) * 0.1;
    let sigma = (variance - rounding).max(0.0).sqrt().max(hidden);
    Noise {
        relative: sigma / level_lx,
        absolute_lx: 0.0,
    }
}
