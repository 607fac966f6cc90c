//! Sweeps → readings at the directions of the plan, as if γ had rested there.
//!
//! From the raw samples alone, so that a better way can be applied to an old record: the line of the positions, the
//! displacement of the light against them by the pair of sweeps in both directions, and the light without the blur of
//! its windows. The formulas stand in the book, "Scans in motion".

mod basis;
mod curve;
mod delay;
mod track;

use std::borrow::Cow;

use isolux_record::plan::Block;
use isolux_record::sweeps::SweepRecord;
use isolux_record::{Electrical, Quality, Reading, ReadingKind, Role, Run, Station};

use crate::error::ReduceError;
use curve::{Curve, Window};
use delay::{Delay, Shift};
use track::Track;

/// Noise of a reading where the station states none, relative to it.
const NOISE_REL: f64 = 0.002;
/// Least noise that is believed, relative to the largest light of the sweep.
const NOISE_LEAST: f64 = 1e-5;
/// Speeds that differ by less are one.
const SAME_SPEED: f64 = 0.02;
/// Share of the largest light that γ = 0° needs to show the lamp's drift.
const LEAST_REFERENCE: f64 = 0.05;

/// A run whose sweeps are readings.
pub struct AtRest<'a> {
    /// With a row for every direction of a sweep, in the order of time; the run itself where there are no sweeps.
    pub run: Cow<'a, Run>,
    /// The number that a row of it has in the record, by its number there; empty where they are the same.
    recorded: Vec<Option<u64>>,
    /// What a person should know of the sweeps.
    pub notes: Vec<String>,
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
/// [`ReduceError::Sweeps`] where the displacement of the light cannot be found.
pub fn as_readings(run: &Run) -> Result<AtRest<'_>, ReduceError> {
    let mut notes = Vec::new();
    if run.sweeps.is_empty() {
        return Ok(AtRest {
            run: Cow::Borrowed(run),
            recorded: Vec::new(),
            notes,
        });
    }
    let mut rows: Vec<(Option<u64>, Reading)> = run
        .readings
        .rows
        .iter()
        .map(|row| (Some(row.index), row.clone()))
        .collect();
    for block in run
        .header
        .plan
        .blocks()
        .iter()
        .filter(|block| block.sweep_deg_s.is_some())
    {
        let of_block = run.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
        let tracked: Vec<Swept<'_>> = of_block
            .filter_map(|record| Swept::of(record, &run.header.station))
            .collect();
        if tracked.is_empty() {
            continue;
        }
        let (readings, note) = block_readings(block, &tracked)?;
        notes.push(note);
        let visited = run
            .readings
            .rows
            .iter()
            .any(|row| row.block == block.name && row.role == Role::Reference);
        let wanted = readings.into_iter().filter(|row| row.role == Role::Point || !visited);
        rows.extend(wanted.map(|reading| (None, reading)));
    }
    // A burning of the lamp is a stretch of rows: they stand in the order of time.
    rows.sort_by(|a, b| {
        a.1.time_s
            .unwrap_or_default()
            .total_cmp(&b.1.time_s.unwrap_or_default())
    });
    let mut with = run.clone();
    let numbered = rows
        .iter()
        .zip(0..)
        .map(|((_, row), index)| Reading { index, ..row.clone() });
    with.readings.rows = numbered.collect();
    Ok(AtRest {
        run: Cow::Owned(with),
        recorded: rows.into_iter().map(|(recorded, _)| recorded).collect(),
        notes,
    })
}

/// A sweep with the line of its positions and the windows of its light, not displaced yet.
struct Swept<'a> {
    record: &'a SweepRecord,
    track: Track,
    windows: Vec<Window>,
}

impl<'a> Swept<'a> {
    fn of(record: &'a SweepRecord, station: &Station) -> Option<Self> {
        let track = Track::of(record)?;
        let meter = station.luxmeter();
        let lit = |sample: &isolux_record::sweeps::LightSample| sample.illuminance_lx;
        let largest = record.light.iter().filter_map(lit).fold(0.0, f64::max);
        let windows = record.light.iter().filter_map(|sample| {
            let value = sample.illuminance_lx?;
            let noise = meter.noise_rel.unwrap_or(NOISE_REL) * value.abs();
            let rounding = sample.digit_lx / 12.0_f64.sqrt();
            let least = NOISE_LEAST * largest;
            Some(Window {
                from_deg: track.gamma_deg(sample.asked_s),
                to_deg: track.gamma_deg(sample.asked_s + record.of.integration_s),
                value,
                sigma: noise.hypot(meter.noise_lx.unwrap_or(0.0)).hypot(rounding).hypot(least),
            })
        });
        Some(Self {
            record,
            windows: windows.collect(),
            track,
        })
    }

    fn sign(&self) -> f64 {
        self.track.speed_deg_s.signum()
    }

    /// The curve over those of `gamma_deg` that the sweep reached, with the light displaced by `shift_deg`.
    fn curve(&self, gamma_deg: &[f64], shift_deg: f64) -> Option<(Curve, Vec<f64>)> {
        let nodes = self.nodes(gamma_deg);
        let by = self.sign() * shift_deg;
        let (low, high) = (*nodes.first()?, *nodes.last()?);
        let windows: Vec<Window> = self
            .windows
            .iter()
            .map(|window| Window {
                from_deg: window.from_deg + by,
                to_deg: window.to_deg + by,
                ..*window
            })
            .filter(|window| window.from_deg.min(window.to_deg) >= low && window.from_deg.max(window.to_deg) <= high)
            .collect();
        Some((Curve::through(&nodes, &windows)?, nodes))
    }

    /// The γ of the plan that the sweep was to reach.
    fn nodes(&self, gamma_deg: &[f64]) -> Vec<f64> {
        let [a, b] = self.record.of.gamma_deg;
        let (low, high) = (a.min(b), a.max(b));
        gamma_deg
            .iter()
            .copied()
            .filter(|gamma| (low..=high).contains(gamma))
            .collect()
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
        let Some(((there, nodes), (here, _))) = forward
            .curve(&block.gamma_deg, 0.0)
            .zip(back.curve(&block.gamma_deg, 0.0))
        else {
            continue;
        };
        shifts.extend(Shift::between(&there, &here, &nodes, speed));
    }
    shifts.sort_by(|a, b| b.speed_deg_s.total_cmp(&a.speed_deg_s));
    shifts
}

/// Readings at the directions of a block, and the sentence on its sweeps.
fn block_readings(block: &Block, swept: &[Swept<'_>]) -> Result<(Vec<Reading>, String), ReduceError> {
    let shifts = shifts(block, swept);
    let Some(fast) = shifts.first() else {
        return Err(ReduceError::Sweeps {
            block: block.name.clone(),
        });
    };
    let delay = shifts.iter().find_map(|slow| Delay::of(fast, slow));
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
    let mut readings = Vec::new();
    let mut parts = Parts::default();
    for one in swept {
        let Some(shift) = shift_at(one.track.speed_deg_s.abs()) else {
            continue;
        };
        let Some((curve, nodes)) = one.curve(&block.gamma_deg, shift.shift_deg) else {
            continue;
        };
        // Without light near its ends a curve goes on as it likes; its noise says so.
        let largest = nodes.iter().map(|gamma| curve.at(*gamma)).fold(0.0, f64::max);
        for &gamma in &nodes {
            let noise = curve.u_noise(gamma);
            let time =
                shift.u_deg.hypot(one.track.rms_deg / (one.windows.len() as f64).sqrt()) * curve.slope(gamma).abs();
            let smoothing = curve.u_smoothing(gamma);
            parts.add([noise, time, smoothing], largest);
            let time_s = one.track.time_s(gamma - one.sign() * shift.shift_deg);
            let u_lx = noise.hypot(time).hypot(smoothing);
            readings.push(one.reading(
                Role::Point,
                (one.record.of.c_target_deg, gamma),
                time_s,
                (curve.at(gamma), u_lx),
            ));
        }
        let [low, high] = curve.range_deg();
        if low <= 0.0 && high >= 0.0 && curve.at(0.0) > LEAST_REFERENCE * largest {
            let time_s = one.track.time_s(-one.sign() * shift.shift_deg);
            let light = (curve.at(0.0), curve.u_noise(0.0));
            readings.push(one.reading(Role::Reference, (0.0, 0.0), time_s, light));
        }
    }
    Ok((readings, note(block, swept.len(), fast, delay, &parts)))
}

/// Sums of squares of the parts of u, in shares of the largest light of their sweep.
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

fn note(block: &Block, sweeps: usize, fast: &Shift, delay: Option<Delay>, parts: &Parts) -> String {
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
    format!(
        "block {:?} was read in motion, in {sweeps} sweeps at up to {:.2} °/s: its light is displaced against the positions by \
         {:.3} ± {:.3}° (k = 2), {separated}; u of a direction, in root mean squares of the largest light: noise {noise:.3} %, \
         displacement {time:.3} %, smoothing {smoothing:.3} %; every value is deconvolved, none was read at rest",
        block.name,
        fast.speed_deg_s,
        fast.shift_deg,
        2.0 * fast.u_deg
    )
}

impl Swept<'_> {
    fn reading(&self, role: Role, (c_deg, gamma_deg): (f64, f64), time_s: f64, (lux, u_lx): (f64, f64)) -> Reading {
        let of = &self.record.of;
        Reading {
            index: 0,
            block: of.block.clone(),
            kind: ReadingKind::Lit,
            time_s: Some(time_s),
            c_deg: if role == Role::Point { of.c_deg } else { c_deg },
            gamma_deg,
            distance_mm: of.distance_mm,
            // The play is out of it.
            travel: 0,
            range: of.range,
            ambient_c: of.ambient_c,
            illuminance_lx: Some(lux),
            u_lx: Some(u_lx),
            quality: Quality::Ok,
            role,
            point: of.point,
            repeat: 0,
            c_target_deg: c_deg,
            gamma_target_deg: gamma_deg,
            digit_lx: None,
            integration_s: Some(of.integration_s),
            raw: String::new(),
            session: of.session,
            burning: Some(of.burning),
            lamp_s: of.lamp_on_s.map(|on| time_s - on),
            electrical: Electrical::default(),
        }
    }
}
