//! Readings of the same direction, averaged.

use std::collections::BTreeMap;

use isolux_record::{Quality, Reading};

use crate::error::{ReduceError, without_number};
use crate::uncertainty::{MeanOfRepeats, mean_of_repeats};

/// The mean of all usable readings of one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Point {
    /// Mean illuminance in lx.
    pub illuminance_lx: f64,
    /// Middle of the readings in seconds since the lamp was switched on; none where no reading has it.
    pub time_s: Option<f64>,
    /// One digit of the meter in lx, the coarsest of the readings.
    pub digit_lx: f64,
    /// Noise and rounding of the mean.
    pub u: MeanOfRepeats,
}

/// The mean of readings that are all of one quantity; none where no one is usable.
pub(crate) fn mean<'a>(readings: impl IntoIterator<Item = &'a Reading>) -> Option<Point> {
    let (mut n, mut sum, mut noise2, mut digit) = (0usize, 0.0, 0.0, 0.0f64);
    let mut times = Vec::new();
    for reading in readings {
        let Some(illuminance) = reading.illuminance_lx else {
            continue;
        };
        let own_digit = reading.digit_lx.unwrap_or(0.0);
        n += 1;
        sum += illuminance;
        // u_lx of the record holds noise and rounding of one reading: noise² + digit²/12.
        noise2 += (reading.u_lx.unwrap_or(0.0).powi(2) - own_digit * own_digit / 12.0).max(0.0);
        digit = digit.max(own_digit);
        times.extend(reading.time_s);
    }
    (n > 0).then(|| Point {
        illuminance_lx: sum / n as f64,
        time_s: (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64),
        digit_lx: digit,
        u: mean_of_repeats((noise2 / n as f64).sqrt(), digit, n),
    })
}

/// A full grid of points: every half-plane has every γ.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PointGrid {
    /// Half-planes in degrees, rising within [0, 360).
    pub c_deg: Vec<f64>,
    /// γ in degrees, rising within [0, 180].
    pub gamma_deg: Vec<f64>,
    /// Points, half-plane by half-plane.
    pub points: Vec<Point>,
    /// The points of a plane at C = 360°, which closes the circle, one a γ; empty where there is none.
    pub closing: Vec<Point>,
}

/// Orders the lit readings by the direction that the plan asked for; signed γ are unfolded to the opposite half-plane.
pub(crate) fn grid(readings: &[&Reading]) -> Result<PointGrid, ReduceError> {
    // Keys in thousandths of a degree: no plan is finer, and targets that are meant equal are equal.
    let mut cells: BTreeMap<(i64, i64), Vec<&Reading>> = BTreeMap::new();
    let mut closing: BTreeMap<i64, Vec<&Reading>> = BTreeMap::new();
    for reading in readings {
        let (mut c, mut gamma) = (key(reading.c_target_deg), key(reading.gamma_target_deg));
        if gamma < 0 {
            (c, gamma) = (c + 180_000, -gamma);
        }
        if c == 360_000 {
            closing.entry(gamma).or_default().push(reading);
        } else {
            cells.entry((c.rem_euclid(360_000), gamma)).or_default().push(reading);
        }
    }
    let mut planes: Vec<i64> = cells.keys().map(|cell| cell.0).collect();
    planes.dedup();
    let mut gammas: Vec<i64> = cells.keys().map(|cell| cell.1).collect();
    gammas.sort_unstable();
    gammas.dedup();
    if planes.is_empty() || gammas.len() < 2 {
        return Err(ReduceError::TooFew {
            c_planes: planes.len(),
            gammas: gammas.len(),
        });
    }
    let mut points = Vec::with_capacity(planes.len() * gammas.len());
    for &plane in &planes {
        for &gamma in &gammas {
            let readings = cells.get(&(plane, gamma)).map_or(&[][..], Vec::as_slice);
            points.push(mean(readings.iter().copied()).ok_or_else(|| {
                ReduceError::Missing {
                    c_deg: plane as f64 / 1000.0,
                    gamma_deg: gamma as f64 / 1000.0,
                    found: without_number(
                        readings
                            .first()
                            .map(|reading: &&Reading| -> Quality { reading.quality }),
                    ),
                }
            })?);
        }
    }
    let closes: Option<Vec<Point>> = gammas
        .iter()
        .map(|gamma| mean(closing.get(gamma)?.iter().copied()))
        .collect();
    Ok(PointGrid {
        c_deg: planes.iter().map(|&plane| plane as f64 / 1000.0).collect(),
        gamma_deg: gammas.iter().map(|&gamma| gamma as f64 / 1000.0).collect(),
        points,
        closing: closes.unwrap_or_default(),
    })
}

fn key(degrees: f64) -> i64 {
    (degrees * 1000.0).round() as i64
}
