//! Lit readings → intensities in directions, with the independent part of their uncertainty.

use std::collections::BTreeMap;

use isolux_record::{Quality, Reading};

use crate::background::{noise_of_one, rounding};
use crate::error::ReduceError;

/// How far a read-back may lie from the plan's direction before the row is taken for a fault of the axes.
const ASTRAY_DEG: f64 = 1.0;

/// A reading that the curve of a sweep gives, beside its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfCurve {
    /// Standard uncertainty that the curve leaves open, lx.
    pub u_lx: f64,
    /// What it counts for beside those of other sweeps at the direction, 1/lx².
    pub weight: f64,
}

/// The mean of all readings of one direction of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Half-plane of the plan, in [0, 360).
    pub c_deg: f64,
    /// γ of the plan, not negative.
    pub gamma_deg: f64,
    /// Whether it belongs to the closing half-plane at C 360°, a check of C 0°.
    pub closing: bool,
    /// Half-plane that the intensity truly belongs to: read back, or as a model of the bench has it.
    pub true_c_deg: f64,
    /// γ that it truly belongs to.
    pub true_gamma_deg: f64,
    /// Intensity.
    pub intensity_cd: f64,
    /// Its standard uncertainty from the scatter of the readings.
    pub u_noise_cd: f64,
    /// Its standard uncertainty by what the curve of a sweep leaves open beside its noise: displacement and smoothing.
    /// None where it was read at rest.
    pub u_curve_cd: Option<f64>,
    /// Its standard uncertainty from the rounding of the display.
    pub u_digit_cd: f64,
    /// What the display showed, in digits: equal displays are rounded alike. None where the scatter dithers the
    /// rounding.
    pub display: Option<i64>,
    /// Mean age of the lamp, in s since it was switched on; none where a reading does not say it.
    pub lamp_s: Option<f64>,
}

impl Sample {
    /// Its standard uncertainty by all that no other direction shares, cd.
    pub fn u_own_cd(&self) -> f64 {
        self.u_noise_cd
            .hypot(self.u_digit_cd)
            .hypot(self.u_curve_cd.unwrap_or(0.0))
    }
}

/// One lit reading made into an intensity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corrected {
    /// Intensity in candela.
    pub intensity_cd: f64,
    /// Candela of one lux at this reading's distance.
    pub cd_per_lx: f64,
    /// True half-plane.
    pub c_deg: f64,
    /// True γ, signed or not.
    pub gamma_deg: f64,
}

/// The mean of every direction of the plan, sorted by half-plane (the closing one last) and γ. `of_curves` are the
/// rows that the curves of sweeps give: these are weighted by their uncertainty, readings at rest alike.
///
/// # Errors
/// [`ReduceError::Missing`] when a direction has no reading with a number, [`ReduceError::Astray`] when an axis was
/// read back far from where it was sent.
pub fn samples(
    rows: &[&Reading],
    of_curves: &BTreeMap<u64, OfCurve>,
    mut correct: impl FnMut(&Reading, f64) -> Corrected,
) -> Result<Vec<Sample>, ReduceError> {
    let closing = closing(rows);
    let mut keyed: Vec<((bool, f64, f64), &Reading)> = Vec::with_capacity(rows.len());
    for &row in rows {
        let off_c = (row.c_deg - row.c_target_deg).abs();
        if off_c > ASTRAY_DEG || (row.gamma_deg - row.gamma_target_deg).abs() > ASTRAY_DEG {
            return Err(ReduceError::Astray {
                row: row.index,
                c_deg: row.c_deg,
                gamma_deg: row.gamma_deg,
            });
        }
        let (c, gamma) = unsigned(row.c_target_deg, row.gamma_target_deg);
        keyed.push(((closing(row), c, gamma), row));
    }
    keyed.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)));
    let mut samples = Vec::new();
    let (mut missing, mut expected, mut first) = (0, 0, None);
    for group in keyed.chunk_by(|a, b| a.0 == b.0) {
        let (closing, c_deg, gamma_deg) = group[0].0;
        expected += 1;
        let usable: Vec<(&Reading, f64)> = group
            .iter()
            .filter(|(_, row)| row.quality == Quality::Ok)
            .filter_map(|(_, row)| row.illuminance_lx.map(|lux| (*row, lux)))
            .collect();
        if usable.is_empty() {
            missing += 1;
            first.get_or_insert((c_deg, gamma_deg));
            continue;
        }
        samples.push(mean((closing, c_deg, gamma_deg), &usable, of_curves, &mut correct));
    }
    match first {
        Some((c_deg, gamma_deg)) => Err(ReduceError::Missing {
            missing,
            expected,
            c_deg,
            gamma_deg,
        }),
        None => Ok(samples),
    }
}

/// Whether a row belongs to the closing half-plane, a check of the one at C 0°.
fn closing(rows: &[&Reading]) -> impl Fn(&Reading) -> bool + use<> {
    let full_circle = rows.iter().any(|row| row.c_target_deg == 0.0);
    move |row| full_circle && row.c_target_deg == 360.0 && row.gamma_target_deg >= 0.0
}

/// Numbers of the readings that make the distribution, in their order: those with a value, without the closing
/// half-plane.
pub fn made_of(rows: &[&Reading]) -> Vec<u64> {
    let closing = closing(rows);
    let usable = |row: &&&Reading| row.quality == Quality::Ok && row.illuminance_lx.is_some() && !closing(row);
    rows.iter().filter(usable).map(|row| row.index).collect()
}

fn mean(
    (closing, c_deg, gamma_deg): (bool, f64, f64),
    usable: &[(&Reading, f64)],
    of_curves: &BTreeMap<u64, OfCurve>,
    correct: &mut impl FnMut(&Reading, f64) -> Corrected,
) -> Sample {
    let n = usable.len() as f64;
    let of_curve = |row: &Reading| of_curves.get(&row.index);
    let weight = |row: &Reading| of_curve(row).map_or(1.0, |of| of.weight);
    let all = usable.iter().map(|(row, _)| weight(row)).sum::<f64>();
    let (mut intensity, mut per_lx, mut d_c, mut d_gamma) = (0.0, 0.0, 0.0, 0.0);
    let (mut scatter2, mut noise2, mut raw, mut digit) = (0.0, 0.0, 0.0, 0.0_f64);
    let mut curve2: Option<f64> = None;
    for &(row, lux) in usable {
        // It is one of so many.
        let many = all / weight(row);
        let corrected = correct(row, lux);
        intensity += corrected.intensity_cd / many;
        per_lx += corrected.cd_per_lx / many;
        let (true_c, true_gamma) = unsigned(corrected.c_deg, corrected.gamma_deg);
        // Near the pole an unsigned γ may lie just across it; the difference along the meridian keeps its sign.
        let across = angle_between(true_c, c_deg).abs() > 90.0;
        d_c += if across {
            0.0
        } else {
            angle_between(true_c, c_deg) / many
        };
        d_gamma += (if across { -true_gamma } else { true_gamma } - gamma_deg) / many;
        let row_digit = row.digit_lx.unwrap_or(0.0);
        let row_noise = noise_of_one(row.u_lx.unwrap_or(0.0), row_digit);
        scatter2 += row_noise.powi(2) / many;
        noise2 += (row_noise / many).powi(2);
        raw += lux / many;
        match of_curve(row) {
            Some(of) => {
                curve2 = Some(curve2.unwrap_or(0.0) + (of.u_lx / many).powi(2));
                digit += row_digit / many;
            }
            None => digit = digit.max(row_digit),
        }
    }
    let scatter = scatter2.sqrt();
    let quiet = scatter <= 0.5 * digit && digit > 0.0;
    Sample {
        c_deg,
        gamma_deg,
        closing,
        true_c_deg: c_deg + d_c,
        true_gamma_deg: gamma_deg + d_gamma,
        intensity_cd: intensity,
        u_noise_cd: noise2.sqrt() * per_lx,
        u_curve_cd: curve2.map(|curve2| curve2.sqrt() * per_lx),
        u_digit_cd: rounding(digit, scatter, usable.len()) * per_lx,
        display: quiet.then(|| (raw / digit).round() as i64),
        lamp_s: usable
            .iter()
            .map(|(row, _)| row.lamp_age_s())
            .sum::<Option<f64>>()
            .map(|sum| sum / n),
    }
}

/// The direction with γ ≥ 0 and C in [0, 360): (C, −γ) is (C + 180°, γ).
pub fn unsigned(c_deg: f64, gamma_deg: f64) -> (f64, f64) {
    let (c, gamma) = if gamma_deg < 0.0 {
        (c_deg + 180.0, -gamma_deg)
    } else {
        (c_deg, gamma_deg + 0.0)
    };
    let c = c.rem_euclid(360.0);
    (if c >= 360.0 { 0.0 } else { c + 0.0 }, gamma)
}

fn angle_between(a_deg: f64, b_deg: f64) -> f64 {
    (a_deg - b_deg + 180.0).rem_euclid(360.0) - 180.0
}
