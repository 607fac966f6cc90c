//! A sweep that was read by a meter with a clock of its own: which conversion each answer gives, and when it ended.
//!
//! Such a meter answers at once with its last conversion, and with the same one again until the next is complete. Where
//! two answers in a row differ, a conversion ended between their requests. The clock whose ends lie between all these
//! pairs of requests is that of the meter; what they leave open of its phase is its uncertainty. How long the meter
//! takes from an end to a new answer is the same for all and displaces the light as any delay does.

use crate::sweeps::{LightSample, SweepRecord};

/// Pairs of answers that a clock needs at least.
const LEAST: usize = 8;
/// By how much a period may differ from the stated one.
const STATED_WITHIN: f64 = 0.02;
/// Over and above the way between two requests, how far from it an end may seem to lie, in periods: delays of answers
/// scatter.
const SCATTER: f64 = 0.04;
/// Rounds of the fit.
const ROUNDS: usize = 8;
/// Share of the pairs that may contradict the limits of the phase, at each of both.
const BEYOND: f64 = 0.05;
/// Share of the pairs of answers that a clock has to explain.
const EXPLAINED: f64 = 0.9;

/// The clock of a meter over one sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnClock {
    /// From the end of one conversion to that of the next, s.
    pub period_s: f64,
    /// The end of one of them, in seconds of the run.
    pub end_s: f64,
    /// Standard uncertainty of that, s.
    pub u_s: f64,
}

/// A conversion of the meter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    /// Place in the sweep's light of the first answer that gives it.
    pub place: usize,
    /// Its light is that from here on, in seconds of the run.
    pub from_s: f64,
    /// And to here.
    pub to_s: f64,
    /// Its value, lx.
    pub illuminance_lx: f64,
}

/// The conversions of a sweep by the meter's own clock.
#[derive(Debug, Clone, PartialEq)]
pub struct ByOwnClock {
    /// The clock.
    pub clock: OwnClock,
    /// Conversions in the order of time.
    pub conversions: Vec<Conversion>,
    /// Periods of the clock whose answers differ: the clock has slipped, or answers are those to other requests.
    pub unclear: usize,
}

impl ByOwnClock {
    /// None for a meter whose conversions begin with their requests.
    pub fn of(sweep: &SweepRecord) -> Option<Self> {
        let nominal_s = sweep.of.update_interval_s?;
        let light: Vec<(usize, &LightSample)> = alone_left_out(&sweep.light).collect();
        let clock = OwnClock::of(&light, nominal_s);
        let margin_s = clock.margin_s(nominal_s);
        let (mut conversions, mut unclear) = (Vec::<Conversion>::new(), 0);
        // Number of a period, its conversion, and whether its answers are one.
        let mut last: Option<(f64, Conversion, bool)> = None;
        let integration_s = sweep.of.integration_s * clock.period_s / nominal_s;
        let mut keep = |last: Option<(f64, Conversion, bool)>| match last {
            Some((_, conversion, true)) => conversions.push(conversion),
            Some(_) => unclear += 1,
            None => {}
        };
        for (place, sample) in light {
            let Some(illuminance_lx) = sample.illuminance_lx else {
                continue;
            };
            let periods = (sample.asked_s - clock.end_s) / clock.period_s;
            let since_s = (periods - periods.floor()) * clock.period_s;
            if since_s < margin_s || since_s > clock.period_s - margin_s {
                continue;
            }
            match &mut last {
                Some((number, conversion, is_one)) if *number == periods.floor() => {
                    *is_one &= conversion.illuminance_lx == illuminance_lx;
                }
                _ => {
                    let to_s = clock.end_s + periods.floor() * clock.period_s;
                    let conversion = Conversion {
                        place,
                        from_s: to_s - integration_s,
                        to_s,
                        illuminance_lx,
                    };
                    keep(last.replace((periods.floor(), conversion, true)));
                }
            }
        }
        keep(last);
        Some(Self {
            clock,
            conversions,
            unclear,
        })
    }
}

/// The light without answers that differ from both neighbours while these are the same: a damaged one.
fn alone_left_out(light: &[LightSample]) -> impl Iterator<Item = (usize, &LightSample)> {
    let lux = |place: Option<usize>| light.get(place?)?.illuminance_lx;
    light.iter().enumerate().filter(move |(place, sample)| {
        let (before, after) = (lux(place.checked_sub(1)), lux(Some(place + 1)));
        before.is_none() || before != after || sample.illuminance_lx == before
    })
}

/// Two requests in a row between which a conversion ended.
#[derive(Debug, Clone, Copy)]
struct Change {
    middle_s: f64,
    half_s: f64,
}

fn changes(light: &[(usize, &LightSample)], nominal_s: f64) -> Vec<Change> {
    let pairs = light.windows(2).filter_map(|pair| {
        let [(place, before), (next, after)] = pair else {
            return None;
        };
        let differ = before.illuminance_lx? != after.illuminance_lx?;
        let half_s = 0.5 * (after.asked_s - before.asked_s);
        // Where no answer was left out between, and no conversion missed.
        (differ && *next == place + 1 && half_s < 0.45 * nominal_s).then_some(Change {
            middle_s: 0.5 * (before.asked_s + after.asked_s),
            half_s,
        })
    });
    pairs.collect()
}

impl OwnClock {
    /// By answers that differ; where they do not tell it, one of the stated period at any phase.
    fn of(light: &[(usize, &LightSample)], nominal_s: f64) -> Self {
        let changes = changes(light, nominal_s);
        Self::fitted(&changes, nominal_s).unwrap_or_else(|| {
            let any_s = light.first().map_or(0.0, |(_, sample)| sample.asked_s);
            let strongest = Self::phase(&changes, nominal_s, any_s).0;
            Self {
                period_s: nominal_s,
                end_s: strongest,
                u_s: nominal_s / 12.0_f64.sqrt(),
            }
        })
    }

    /// The end near `about_s` of a clock with this period that the changes lie nearest to, and how near they lie: 1
    /// where all are at one phase.
    fn phase(changes: &[Change], period_s: f64, about_s: f64) -> (f64, f64) {
        let turn = std::f64::consts::TAU / period_s;
        let (mut x, mut y) = (0.0, 0.0);
        for change in changes {
            let (sin, cos) = (turn * (change.middle_s - about_s)).sin_cos();
            (x, y) = (x + cos, y + sin);
        }
        let nearness = x.hypot(y) / (changes.len().max(1) as f64);
        (about_s + y.atan2(x) / turn, nearness)
    }

    fn fitted(changes: &[Change], nominal_s: f64) -> Option<Self> {
        if changes.len() < LEAST {
            return None;
        }
        let count = changes.len() as f64;
        let about_s = changes.iter().map(|change| change.middle_s).sum::<f64>() / count;
        let span_s = changes[changes.len() - 1].middle_s - changes[0].middle_s;
        // The next one differs by a tenth of a period over the whole sweep.
        let steps = (10.0 * STATED_WITHIN * span_s / nominal_s).ceil().max(1.0);
        let periods =
            (-(steps as i32)..=steps as i32).map(|k| nominal_s * (1.0 + STATED_WITHIN * f64::from(k) / steps));
        let tried = periods.map(|period_s| (period_s, Self::phase(changes, period_s, about_s)));
        let (mut period_s, (mut end_s, _)) = tried.max_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
        let mut kept: Vec<Change> = Vec::new();
        for _ in 0..ROUNDS {
            let number = |change: &Change| ((change.middle_s - end_s) / period_s).round();
            let off = |change: &Change| (change.middle_s - end_s - number(change) * period_s).abs();
            kept = changes
                .iter()
                .copied()
                .filter(|change| off(change) <= change.half_s + SCATTER * period_s)
                .collect();
            // Least squares of the middles over the numbers.
            let weight = |change: &Change| change.half_s.powi(-2);
            let sum = |of: &dyn Fn(&Change) -> f64| kept.iter().map(|change| weight(change) * of(change)).sum::<f64>();
            let total = sum(&|_| 1.0);
            let (n, t) = (sum(&number) / total, sum(&|change| change.middle_s) / total);
            let square = sum(&|change| (number(change) - n).powi(2));
            if kept.len() < LEAST || square <= 0.0 {
                return None;
            }
            let slope = sum(&|change| (number(change) - n) * (change.middle_s - t)) / square;
            (period_s, end_s) = (slope, t - n * slope);
        }
        let is_stated = (period_s / nominal_s - 1.0).abs() < 1.5 * STATED_WITHIN;
        if (kept.len() as f64) < EXPLAINED * count || !is_stated {
            return None;
        }
        // How far the ends may be moved, earlier and later, until they contradict.
        let beyond = (BEYOND * kept.len() as f64) as usize;
        let limit = |sign: f64| {
            let off = |change: &Change| {
                let number = ((change.middle_s - end_s) / period_s).round();
                change.half_s + sign * (change.middle_s - end_s - number * period_s)
            };
            let mut room: Vec<f64> = kept.iter().map(off).collect();
            room.sort_by(f64::total_cmp);
            room[beyond]
        };
        let (earlier_s, later_s) = (limit(-1.0), limit(1.0));
        let width_s = (earlier_s + later_s).max(0.0);
        let count = kept.len() as f64;
        let half_s2 = kept.iter().map(|change| change.half_s.powi(2)).sum::<f64>() / count;
        // A clock that slipped a little, or answers that are late by different times, lie farther from its ends than
        // requests at any moment do (a third of the square of half their way, by up to three standard deviations more).
        let off_s2 = |change: &Change| {
            let number = ((change.middle_s - end_s) / period_s).round();
            (change.middle_s - end_s - number * period_s).powi(2)
        };
        let scatter_s2 = kept.iter().map(off_s2).sum::<f64>() / count;
        let excess_s2 = (scatter_s2 - half_s2 / 3.0 * (1.0 + 3.0 * (0.8 / count).sqrt())).max(0.0);
        Some(Self {
            period_s,
            end_s: end_s + 0.5 * (later_s - earlier_s),
            // The width of what is left of the phase, the scatter of the middles for the period, and what is beyond.
            u_s: (width_s * width_s / 12.0 + half_s2 / (3.0 * count) + excess_s2).sqrt(),
        })
    }

    /// Answers nearer than this to an end may give either conversion.
    fn margin_s(&self, nominal_s: f64) -> f64 {
        let is_known = self.u_s < 0.1 * nominal_s;
        if is_known {
            (SCATTER * self.period_s).max(3.0 * self.u_s)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests;
