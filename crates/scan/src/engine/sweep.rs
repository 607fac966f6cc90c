//! One sweep: γ goes through its half-plane, or C around a ring, at one speed while the meter reads, and everything is
//! kept as it came.
//!
//! The axis gets one absolute target inside its limits, so that it comes to rest there whatever becomes of this
//! program; the driver follows the move and stops it after a failure. A sweep that was disturbed, or in which too much
//! is missing, is recorded as torn and made again.

use std::cell::{Cell, RefCell};
use std::time::Duration;

use isolux_device::{Axis, Conversions, DeviceError, LuxOutcome, LuxRange, LuxSample};
use isolux_photometry::Ring;
use isolux_record::Event;
use isolux_record::plan::{Block, Pass, Way};
use isolux_record::sweeps::{LightSample, PositionSample, SweepOf, SweepRecord};
use tokio::time::{Instant, sleep, sleep_until};

use super::session::Session;
use crate::conversions::{conversions, middles_s};
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::sweeps;

/// Between two positions: other devices on the same line have their turn.
const BETWEEN_POSITIONS: Duration = Duration::from_millis(15);

/// Over and above the integration, how long one conversion may take with everything that is done to prove the line.
const SAMPLE_WITHIN: Duration = Duration::from_secs(3);

/// Between two requests to a meter that converts by a clock of its own, in shares of its interval: from this on, and up
/// to so much more. Requests that kept step with its clock would not show its phase, and each that is lost costs a
/// second.
const BETWEEN_REQUESTS: [f64; 2] = [0.1, 0.4];

/// The golden ratio: shares of it, times whole numbers, lie evenly and never in step.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Failures in a row after which the meter is taken for lost.
const MOST_FAILURES: u32 = 5;

/// Share of the way of a sweep that may be without light: another one fills it.
const MOST_WITHOUT: f64 = 1.0 / 3.0;

/// Ways without light from which on they count, in those between most conversions.
const GAP: f64 = 2.5;

/// What the instruments gave while the axis moved.
#[derive(Default)]
struct Caught {
    positions: RefCell<Vec<(Instant, f64)>>,
    light: RefCell<Vec<Conversion>>,
    over_range: Cell<bool>,
    ended: Cell<bool>,
}

impl Caught {
    /// Takes its number from the last conversion: it may have been the answer to another request.
    fn doubt_last(&self) {
        if let Some(last) = self.light.borrow_mut().last_mut()
            && let Ok(sample) = &last.sample
        {
            last.sample = Err(format!("in doubt: {}", hex::encode(&sample.evidence)));
        }
    }
}

/// One conversion, or why there is none.
struct Conversion {
    requested: Instant,
    answered: Instant,
    sample: Result<LuxSample, String>,
}

impl Session<'_> {
    /// Makes one sweep. A torn one is recorded before its error is returned.
    pub(super) async fn sweep(&mut self, block: &Block, visit: &Visit, pass: &Pass) -> Result<SweepRecord, ScanError> {
        let way = pass.way;
        let moving = self.axes.moving(&way).1;
        let [start, end] = pass.ends_deg(moving.settings().acceleration());
        let meter = self.devices.meter.as_ref();
        let range = self.range(pass);
        let (start_c_deg, start_gamma_deg) = way.at_deg(start);
        self.axes.go_to(start_c_deg, start_gamma_deg).await?;
        let c_deg = self.axes.pose().await?.c_deg;
        let ambient_c = self.ambient_c().await?;
        meter
            .set_range(LuxRange::Fixed(range))
            .await
            .map_err(ScanError::device("luxmeter"))?;
        if meter.properties().converts == Conversions::ByOwnClock {
            self.range_in_use().await;
        }
        let caught = Caught::default();
        let motion = self.axes.start_sweep(&way, end, pass.speed_deg_s).await?;
        let outcome = {
            let left = self.left();
            let work = async {
                let (moved, ()) = tokio::join!(
                    async {
                        let moved = self.axes.follow(&way, motion).await;
                        caught.ended.set(true);
                        moved
                    },
                    async { tokio::join!(self.positions(moving, &caught), self.light(&caught)).0 },
                );
                moved
            };
            left.during(work).await
        };
        let target = way.at_deg(motion.target.value());
        let outcome = match outcome {
            Ok(()) => {
                self.axes.swept(target);
                self.verify().await
            }
            Err(error) => Err(error),
        };
        let of = SweepOf {
            index: 0,
            block: block.name.clone(),
            point: visit.point,
            torn: None,
            c_deg,
            c_target_deg: visit.c_deg,
            ring_to_c_deg: way.half_plane_deg().is_none().then(|| pass.to_deg().0),
            gamma_deg: [pass.from_deg().1, pass.to_deg().1],
            speed_deg_s: motion.speed,
            distance_mm: self.distance_mm,
            range: i32::from(range),
            integration_s: meter.properties().integration_in(range).as_secs_f64(),
            update_interval_s: (meter.properties().converts == Conversions::ByOwnClock)
                .then_some(meter.properties().update_interval.as_secs_f64()),
            lamp_on_s: self.lamp_on_s,
            ambient_c,
            session: 0,
            burning: 0,
        };
        let over_range = caught.over_range.get();
        let mut record = self.record(of, caught);
        // A sweep of dim light has no number where there is too much of it, and the one before it has.
        let torn_by_range = over_range && pass.range.is_none();
        let outcome = outcome.and_then(|()| match missing(&record, torn_by_range) {
            None => Ok(()),
            Some(why) => Err(ScanError::Torn {
                c_deg: visit.c_deg,
                why,
            }),
        });
        match outcome {
            Ok(()) => {
                self.dim_range_up = 0;
                // The reference point is read at rest, in the range that suits it.
                meter
                    .set_range(LuxRange::Auto)
                    .await
                    .map_err(ScanError::device("luxmeter"))?;
                Ok(record)
            }
            Err(error) => {
                let up = if pass.range.is_some() {
                    &mut self.dim_range_up
                } else {
                    &mut self.range_up
                };
                *up += u8::from(over_range);
                record.of.torn = Some(error.to_string());
                self.run.sweep(record)?;
                if error.can_be_measured_again() {
                    meter
                        .set_range(LuxRange::Auto)
                        .await
                        .map_err(ScanError::device("luxmeter"))?;
                }
                Err(error)
            }
        }
    }

    /// The range that a sweep holds.
    fn range(&self, pass: &Pass) -> u8 {
        let properties = self.devices.meter.properties();
        let held = sweeps::range(self.engine.station, properties, self.distance_mm, self.range_up);
        let dim = pass.range.map(|range| range + self.dim_range_up);
        // In the range that was held it would say the same again.
        dim.map_or(held, |dim| dim.min(held.saturating_sub(1)).max(1))
    }

    /// Waits until a meter that converts all the time tells a value of the range that was chosen: until then it repeats
    /// one of the range before. What it says instead shows in the sweep.
    async fn range_in_use(&self) {
        let meter = self.devices.meter.as_ref();
        for _ in 0..MOST_FAILURES {
            let deadline = Instant::now() + meter.properties().integration + SAMPLE_WITHIN;
            if meter.sample(deadline).await.is_ok() {
                return;
            }
        }
    }

    /// Asks for positions until the move has ended. What cannot be read is left out: the driver that follows the move
    /// judges whether the axis is lost.
    async fn positions(&self, moving: &dyn Axis, caught: &Caught) {
        while !caught.ended.get() {
            if let Ok(position) = moving.position().await {
                let at = (position.at, position.place.value());
                caught.positions.borrow_mut().push(at);
            }
            sleep(BETWEEN_POSITIONS).await;
        }
    }

    /// Reads light until the move has ended.
    async fn light(&self, caught: &Caught) {
        let meter = self.devices.meter.as_ref();
        let own_interval = match meter.properties().converts {
            Conversions::ByOwnClock => meter.properties().update_interval,
            Conversions::OnRequest | Conversions::Unknown => Duration::ZERO,
        };
        let (mut failures, mut answers) = (0, 0_u32);
        while !caught.ended.get() && failures < MOST_FAILURES {
            let requested = Instant::now();
            let deadline = requested + meter.properties().integration + SAMPLE_WITHIN;
            match meter.sample(deadline).await {
                Ok(sample) => {
                    failures = 0;
                    caught
                        .over_range
                        .set(caught.over_range.get() || sample.outcome == LuxOutcome::OverRange);
                    caught.light.borrow_mut().push(Conversion {
                        requested: sample.requested,
                        answered: sample.answered,
                        sample: Ok(sample),
                    });
                    answers += 1;
                    let [least, more] = BETWEEN_REQUESTS;
                    let share = least + more * (f64::from(answers) * GOLDEN).fract();
                    sleep_until(requested + own_interval.mul_f64(share)).await;
                }
                Err(error) => {
                    failures += 1;
                    caught.doubt_last();
                    caught.light.borrow_mut().push(Conversion {
                        requested,
                        answered: Instant::now(),
                        sample: Err(error.to_string()),
                    });
                    // A lost link answers at once.
                    if !matches!(error, DeviceError::Timeout { .. }) {
                        sleep(BETWEEN_POSITIONS).await;
                    }
                }
            }
        }
    }

    fn record(&self, of: SweepOf, caught: Caught) -> SweepRecord {
        let factor = self.engine.station.luxmeter().calibration_factor;
        let positions = caught
            .positions
            .into_inner()
            .into_iter()
            .map(|(at, place_deg)| PositionSample {
                answered_s: self.time_s(at),
                place_deg,
            });
        let held = of.range;
        let light = caught.light.into_inner().into_iter().map(|caught| {
            let (illuminance_lx, digit_lx, raw) = match caught.sample {
                Ok(sample) if ![0, held].contains(&i32::from(sample.range)) => {
                    // A range is held: this is another one's answer, or a damaged one.
                    let stated = hex::encode(&sample.evidence);
                    (None, 0.0, format!("in range {}: {stated}", sample.range))
                }
                Ok(sample) => {
                    let lux = match sample.outcome {
                        LuxOutcome::Measured(lux) => Some(lux.value() * factor),
                        LuxOutcome::OverRange | LuxOutcome::UnderRange | LuxOutcome::Unsteady => None,
                    };
                    (lux, sample.digit.value() * factor, hex::encode(&sample.evidence))
                }
                Err(why) => (None, 0.0, why),
            };
            LightSample {
                asked_s: self.time_s(caught.requested),
                answered_s: self.time_s(caught.answered),
                illuminance_lx,
                digit_lx,
                raw,
            }
        });
        SweepRecord {
            of,
            positions: positions.collect(),
            light: light.collect(),
        }
    }

    /// Records a whole sweep.
    pub(super) fn keep_sweep(&mut self, record: SweepRecord) -> Result<(), ScanError> {
        let way = record.of.way();
        let (conversions, positions) = (record.light.len() as u64, record.positions.len() as u64);
        let mut blocks = self.run.header().plan.blocks().iter();
        if let Some(block) = blocks.find(|block| block.name == record.of.block) {
            self.coverage.add(block, &record);
            self.chosen.entry(block.name.clone()).or_default().add(block, &record);
        }
        let block = record.of.block.clone();
        let index = self.run.sweep(record)?;
        let [(from_c, from_gamma), (to_c, to_gamma)] = way.moving_deg().map(|place| way.at_deg(place));
        self.event(Event::Sweep {
            index,
            block,
            c_deg: [from_c, to_c],
            gamma_deg: [from_gamma, to_gamma],
            conversions,
            positions,
        })
    }
}

/// Why a sweep cannot be used, if it cannot.
fn missing(record: &SweepRecord, over_range: bool) -> Option<String> {
    if over_range {
        return Some(format!(
            "the light is over range {}; the next try takes the range above",
            record.of.range
        ));
    }
    if let Way::Ring { gamma_deg, .. } = record.of.way()
        && Ring::of(gamma_deg, conversions(record).into_iter()).is_none()
    {
        return Some("a ring has to have light all round, and a stretch of C has none".to_owned());
    }
    let light_s: Vec<f64> = middles_s(record).into_iter().map(|(middle_s, _)| middle_s).collect();
    let first_and_last = |all: &[LightSample]| Some((all.first()?.asked_s, all.last()?.answered_s));
    let Some((began_s, ended_s)) = first_and_last(&record.light).filter(|_| light_s.len() > 8) else {
        return Some(format!("{} conversions have a number", light_s.len()));
    };
    let mut between: Vec<f64> = light_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    between.push(ended_s - light_s.last().copied().unwrap_or(ended_s));
    between.sort_by(f64::total_cmp);
    let usual_s = between[between.len() / 2];
    let without_s: f64 = between.iter().filter(|way| **way > GAP * usual_s).sum();
    (without_s > MOST_WITHOUT * (ended_s - began_s)).then(|| {
        format!(
            "there is no light over {:.0}° of the way, and at most {:.0} % of it can be filled by another sweep",
            without_s * record.of.speed_deg_s,
            100.0 * MOST_WITHOUT
        )
    })
}

#[cfg(test)]
mod tests {
    use isolux_record::plan::ring;

    use super::*;
    use crate::chosen::tests::swept;

    #[test]
    fn a_ring_with_a_stretch_without_light_is_torn() {
        let mut record = swept(0, &ring(30.0, true, 12.0), &|_, _| 100.0);
        assert_eq!(missing(&record, false), None);
        // A twentieth of the way: a half-plane would be kept, and swept again around the gap.
        let count = record.light.len();
        for sample in &mut record.light[count / 2..count / 2 + count / 20] {
            sample.illuminance_lx = None;
        }
        assert!(missing(&record, false).is_some_and(|why| why.contains("all round")));
    }
}
