//! Sweeps → readings at the directions of the plan, as if γ had rested there.
//!
//! From the raw samples alone, so that a better way can be applied to an old record: the line of the positions, the
//! displacement of the light against them by the pair of sweeps in both directions, and the light without the blur of
//! its windows. The formulas stand in the book, "Scans in motion".

mod at_rest;
mod basis;
mod curve;
mod delay;
mod guard;
mod merged;
mod swept;
mod symmetry;
mod track;

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_record::plan::Block;
use isolux_record::run::StopHow;
use isolux_record::{Reading, Role, Run};

use crate::between::HalfPlanes;
use crate::error::ReduceError;
use crate::samples::OfCurve;
pub use at_rest::{Check, Checked};
use delay::{Delay, Shift};
use guard::LeftOut;
use merged::Fitted;
use swept::{Along, Swept};

/// Speeds that differ by less are one.
const SAME_SPEED: f64 = 0.02;
/// Share of the largest light that γ = 0° needs to show the lamp's drift.
const LEAST_REFERENCE: f64 = 0.05;
/// And the largest relative standard uncertainty of it.
const MOST_U_OF_REFERENCE: f64 = 0.005;

/// What is known of readings that were taken in motion.
#[derive(Default)]
pub struct InMotion {
    /// Directions that were read at rest after them.
    pub checks: Vec<Check>,
    /// What is known of half-planes that the scan did not choose.
    pub half_planes: Option<HalfPlanes>,
    /// What is known of the rows that the curves of sweeps give, by their numbers.
    pub of_curves: BTreeMap<u64, OfCurve>,
}

/// A run whose sweeps are readings.
pub struct AtRest<'a> {
    /// With a row for every direction of a sweep, in the order of time; the run itself where there are no sweeps.
    pub run: Cow<'a, Run>,
    /// The number that a row of it has in the record, by its number there; empty where they are the same.
    recorded: Vec<Option<u64>>,
    /// What a person should know of the sweeps.
    pub notes: Vec<String>,
    /// What is known of those readings.
    pub in_motion: InMotion,
}

impl AtRest<'_> {
    /// Numbers of rows as the record has them, those of sweeps left out.
    pub fn in_record(&self, rows: Vec<u64>) -> Vec<u64> {
        if self.recorded.is_empty() {
            return rows;
        }
        rows.into_iter()
            .filter_map(|row| self.recorded.get(row as usize).copied()?)
            .collect()
    }
}

/// The run with readings for its sweeps.
///
/// # Errors
/// [`ReduceError::Sweeps`] where the displacement of the light cannot be found, [`ReduceError::NoSweep`] where no sweep
/// of a scan that was finished has light.
pub fn as_readings(run: &Run) -> Result<AtRest<'_>, ReduceError> {
    let (mut notes, mut checks, mut half_planes) = (Vec::new(), Vec::new(), None);
    if run.sweeps.is_empty() {
        return Ok(AtRest {
            run: Cow::Borrowed(run),
            recorded: Vec::new(),
            notes,
            in_motion: InMotion::default(),
        });
    }
    let stopped = run.header.stopped.as_ref();
    let complete = stopped.is_some_and(|stopped| stopped.how == StopHow::Completed);
    let mut rows: Vec<MergedRow> = run.readings.rows.iter().map(MergedRow::recorded).collect();
    for block in run
        .header
        .plan
        .blocks()
        .iter()
        .filter(|block| block.sweep_deg_s.is_some())
    {
        let of_block = run.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
        let of_block = of_block.filter_map(|record| Swept::of(record, &run.header.station));
        let (tracked, around): (Vec<Swept<'_>>, Vec<Swept<'_>>) =
            of_block.partition(|swept| swept.record.of.way().half_plane_deg().is_some());
        if tracked.is_empty() {
            continue;
        }
        if block.target.is_some() && complete {
            half_planes = Some(HalfPlanes::of(block, around.iter().filter_map(Swept::ring)));
        }
        notes.extend(symmetry::note(block, &around));
        let of_block = block_readings(run, block, &tracked, complete)?;
        notes.push(of_block.note);
        checks.extend(of_block.checks);
        // The engine visits the reference point when the lamp was switched on again: that ties no earlier burning.
        let is_visited = |burning: u32| {
            let mut rows = run.readings.rows.iter();
            rows.any(|row| row.block == block.name && row.role == Role::Reference && row.burning == Some(burning))
        };
        let visited = tracked.iter().all(|swept| is_visited(swept.record.of.burning));
        let wanted = of_block
            .readings
            .into_iter()
            .filter(|row| row.reading.role == Role::Point || !visited);
        rows.extend(wanted);
    }
    // A burning of the lamp is a stretch of rows: they stand in the order of time.
    let time_s = |row: &MergedRow| row.reading.time_s.unwrap_or_default();
    rows.sort_by(|a, b| time_s(a).total_cmp(&time_s(b)));
    if checks.is_empty() && complete {
        notes.push("no direction was read at rest after the sweeps: nothing shows that they say the same".to_owned());
    }
    let mut with = run.clone();
    let numbered = rows.iter().zip(0..).map(|(row, index)| Reading {
        index,
        ..row.reading.clone()
    });
    with.readings.rows = numbered.collect();
    let of_curves = rows
        .iter()
        .zip(0..)
        .filter_map(|(row, index)| Some((index, row.of_curve?)));
    Ok(AtRest {
        run: Cow::Owned(with),
        in_motion: InMotion {
            of_curves: of_curves.collect(),
            half_planes,
            checks,
        },
        recorded: rows.into_iter().map(|row| row.recorded).collect(),
        notes,
    })
}

/// A reading at rest, or one that the curve of a sweep gives.
struct MergedRow {
    /// Its number in the record, where it has one.
    recorded: Option<u64>,
    reading: Reading,
    of_curve: Option<OfCurve>,
}

impl MergedRow {
    fn recorded(row: &Reading) -> Self {
        Self {
            recorded: Some(row.index),
            reading: row.clone(),
            of_curve: None,
        }
    }
}

/// The displacements of the pairs of a block, the fastest first.
fn shifts(block: &Block, swept: &[Swept<'_>]) -> Vec<Shift> {
    let mut shifts: Vec<Shift> = Vec::new();
    for forward in swept.iter().filter(|one| one.sign() > 0.0) {
        let speed = forward.track.speed_deg_s;
        let back = swept.iter().find(|other| {
            let (a, b) = (&other.record.of, &forward.record.of);
            let same = (other.track.speed_deg_s + speed).abs() < SAME_SPEED * speed;
            same && a.c_target_deg == b.c_target_deg
                && (a.gamma_deg[0], a.gamma_deg[1]) == (b.gamma_deg[1], b.gamma_deg[0])
        });
        let Some(back) = back else { continue };
        let there = forward.along(&block.gamma_deg, 0.0);
        let Some((there, here)) = there.zip(back.along(&block.gamma_deg, 0.0)) else {
            continue;
        };
        let shift = Shift::between(&there.curve, &here.curve, &there.nodes, speed);
        // What the clocks of both leave open displaces one against the other; their lines are seen in the curves.
        let of_clocks = |one: &Swept<'_>| one.clock.map_or(0.0, |clock| 0.5 * speed * clock.u_s);
        shifts.extend(shift.map(|shift| Shift {
            u_deg: shift.u_deg.hypot(of_clocks(forward)).hypot(of_clocks(back)),
            ..shift
        }));
    }
    shifts.sort_by(|a, b| b.speed_deg_s.total_cmp(&a.speed_deg_s));
    shifts
}

/// What the sweeps of a block give.
struct OfBlock {
    /// Readings at its directions.
    readings: Vec<MergedRow>,
    /// The sentence on its sweeps.
    note: String,
    /// Its directions that were read at rest.
    checks: Vec<Check>,
}

fn block_readings(run: &Run, block: &Block, swept: &[Swept<'_>], complete: bool) -> Result<OfBlock, ReduceError> {
    let shifts = shifts(block, swept);
    let Some(fast) = shifts.first() else {
        return Err(ReduceError::Sweeps {
            block: block.name.clone(),
        });
    };
    let delays = shifts.iter().filter_map(|slow| Delay::of(fast, slow));
    let delay = delays.min_by(|a, b| a.play_deg.1.total_cmp(&b.play_deg.1));
    let shift_at = |speed: f64| {
        let own = shifts
            .iter()
            .find(|shift| (shift.speed_deg_s - speed).abs() < SAME_SPEED * speed);
        own.copied().or_else(|| {
            let delay = delay?;
            Some(Shift {
                speed_deg_s: speed,
                shift_deg: speed * delay.delay_s.0 + 0.5 * delay.play_deg.0,
                u_deg: (speed * delay.delay_s.1).hypot(0.5 * delay.play_deg.1),
            })
        })
    };
    let along: Vec<(&Swept<'_>, Shift, Along)> = swept
        .iter()
        .filter_map(|one| {
            let shift = shift_at(one.track.speed_deg_s.abs())?;
            let along = one.along(&block.gamma_deg, shift.shift_deg)?;
            Some((one, shift, along))
        })
        .collect();
    let fitted = Fitted::all(along, &block.gamma_deg);
    let mut readings = Vec::new();
    let mut parts = Parts::default();
    let largest = fitted.iter().map(Fitted::largest).fold(0.0, f64::max);
    for &c_deg in &block.c_deg {
        let of_plane: Vec<&Fitted<'_>> = fitted.iter().filter(|sweep| sweep.c_target_deg() == c_deg).collect();
        for &gamma_deg in block.gamma_deg.iter().filter(|_| !of_plane.is_empty()) {
            let giving = merged::giving(&of_plane, gamma_deg);
            // A scan that is not finished goes on where a sweep is missing.
            if giving.is_empty() && complete {
                return Err(ReduceError::NoSweep {
                    block: block.name.clone(),
                    c_deg,
                    gamma_deg,
                });
            }
            for sweep in giving {
                let [noise, time, smoothing] = sweep.parts(gamma_deg);
                parts.add([noise, time, smoothing], largest);
                readings.push(MergedRow {
                    recorded: None,
                    reading: sweep.reading(Role::Point, (c_deg, gamma_deg), noise),
                    of_curve: Some(OfCurve {
                        u_lx: time.hypot(smoothing),
                        weight: sweep.weight(gamma_deg),
                    }),
                });
            }
        }
    }
    // A slow sweep blurs the beam less than a fast one: beside each other they would look like a drift.
    let as_fast = |sweep: &&Fitted<'_>| {
        let of_beam = sweep.shift.speed_deg_s < (1.0 - SAME_SPEED) * fast.speed_deg_s;
        block.beam_speed_deg_s.is_none() || !of_beam
    };
    for sweep in fitted.iter().filter(as_fast) {
        let curve = &sweep.along.curve;
        let [low, high] = curve.range_deg();
        // A curve that ends at the pole is held there from one side: what it says is no reference.
        let is_known = curve.u_noise(0.0) < MOST_U_OF_REFERENCE * curve.at(0.0);
        let is_lit = curve.at(0.0) > LEAST_REFERENCE * sweep.largest();
        if low <= 0.0 && high >= 0.0 && sweep.covers(0.0) && is_lit && is_known {
            readings.push(MergedRow {
                recorded: None,
                reading: sweep.reading(Role::Reference, (0.0, 0.0), curve.u_noise(0.0)),
                of_curve: None,
            });
        }
    }
    Ok(OfBlock {
        readings,
        note: note(block, swept, fast, delay, &parts) + &without_shift(swept.len() - fitted.len()),
        checks: at_rest::checks(run, block, &fitted, delay),
    })
}

/// Sums of squares of the parts of u, in shares of the largest light.
#[derive(Default)]
struct Parts {
    squares: [f64; 3],
    count: f64,
}

impl Parts {
    fn add(&mut self, parts: [f64; 3], largest: f64) {
        for (square, part) in self.squares.iter_mut().zip(parts) {
            *square += (part / largest).powi(2);
        }
        self.count += 1.0;
    }

    fn percent(&self) -> [f64; 3] {
        self.squares.map(|square| 100.0 * (square / self.count.max(1.0)).sqrt())
    }
}

fn note(block: &Block, swept: &[Swept<'_>], fast: &Shift, delay: Option<Delay>, parts: &Parts) -> String {
    let [noise, time, smoothing] = parts.percent();
    let separated = delay.map_or_else(
        || "at one speed delay and play are not separated".to_owned(),
        |delay| {
            format!(
                "{:.1} ± {:.1} ms of delay and {:.3} ± {:.3}° of play (k = 2)",
                1e3 * delay.delay_s.0,
                2e3 * delay.delay_s.1,
                delay.play_deg.0,
                2.0 * delay.play_deg.1
            )
        },
    );
    let (sweeps, left_out, clock) = (swept.len(), left_out(swept), own_clock(swept));
    let second = second_sweeps(block, swept);
    format!(
        "block {:?} was read in motion, in {sweeps} sweeps at up to {:.2} °/s{second}: its light is displaced against the \
         positions by {:.3} ± {:.3}° (k = 2), {separated}; u of a direction, in root mean squares of the largest \
         light: noise {noise:.3} %, displacement {time:.3} %, smoothing {smoothing:.3} %; every value is deconvolved, \
         none was read at rest{clock}{left_out}",
        block.name,
        fast.speed_deg_s,
        fast.shift_deg,
        2.0 * fast.u_deg
    )
}

/// How many sweeps give no value, as no pair of their speed shows their displacement; empty where there are none.
fn without_shift(count: usize) -> String {
    if count == 0 {
        return String::new();
    }
    format!("; {count} of the sweeps give no value, as their displacement is not known")
}

/// How many of them were swept a second time over a part of their way, and why; empty where none was.
fn second_sweeps(block: &Block, swept: &[Swept<'_>]) -> String {
    let speed_deg_s = |one: &Swept<'_>| one.track.speed_deg_s.abs();
    let beam = block.beam_speed_deg_s.map(|beam| {
        let count = swept
            .iter()
            .filter(|one| (speed_deg_s(one) - beam).abs() < SAME_SPEED * beam)
            .count();
        format!(", {count} of them within the beam at {beam} °/s")
    });
    let dim = block.dim_digits.map(|digits| {
        let held = swept.iter().map(|one| one.record.of.range).max();
        let count = swept.iter().filter(|one| Some(one.record.of.range) < held).count();
        format!(", {count} of them in a more sensitive range, where the light was below {digits} digits")
    });
    beam.into_iter().chain(dim).collect()
}

/// What is known of the meter's own clock; empty where it has none.
fn own_clock(swept: &[Swept<'_>]) -> String {
    let clocks: Vec<_> = swept.iter().filter_map(|one| one.clock).collect();
    let mean = clocks.iter().map(|clock| clock.period_s).sum::<f64>() / clocks.len() as f64;
    let Some(worst) = clocks.iter().map(|clock| clock.u_s).max_by(f64::total_cmp) else {
        return String::new();
    };
    format!(
        "; by its answers the meter converted every {:.2} ms on its own, the instant known to {:.1} ms (k = 2) \
         or better in each sweep",
        1e3 * mean,
        2e3 * worst
    )
}

/// How many conversions no value is made of, and why; empty where there are none.
fn left_out(swept: &[Swept<'_>]) -> String {
    let mut sum = LeftOut::default();
    for one in swept {
        sum += one.left_out;
    }
    if sum.count() == 0 {
        return String::new();
    }
    let all: usize = swept.iter().map(|one| one.record.light.len()).sum();
    format!(
        "; {} of {all} answers are left out: {} without a number (lost, late, or more bytes than were asked \
         for), {} that answer an earlier request, {} that do not fit their neighbours (as with a wrong digit){}",
        sum.without_number + sum.early + sum.astray,
        sum.without_number,
        sum.early,
        sum.astray,
        if sum.unclear > 0 {
            format!(", and {} conversions whose answers differ", sum.unclear)
        } else {
            String::new()
        }
    )
}
