//! Two items: their quantities with Eₙ, and the difference of their intensities over the sphere.

use isolux_photometry::IntensityDistribution;
use isolux_reduce::Quantity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::item::{Item, Value};

/// Share of the largest intensity from which on a relative difference of intensities counts.
const BRIGHT: f64 = 0.1;
/// Share of directions that must lie within U of their difference.
const WITHIN: f64 = 0.95;
/// The part of a budget that two runs with one meter and one calibration share.
const SHARED: &str = "calibration";

/// One item against the first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pair {
    /// The item.
    pub name: String,
    /// Quantities that both have.
    pub rows: Vec<Row>,
    /// The difference of the intensities.
    pub sphere: Sphere,
    /// Whether both runs were read by one meter under one calibration: its error is in both alike, and taken out of U.
    pub same_meter: bool,
    /// Whether everything that is judged agrees; none where nothing is judged.
    pub agree: Option<bool>,
}

/// One quantity of two items.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// What it is.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Of the first.
    pub first: f64,
    /// Of the other.
    pub other: f64,
    /// Other less first.
    pub difference: f64,
    /// Expanded uncertainty (k = 2) of the difference, where both are known.
    pub expanded: Option<f64>,
    /// Eₙ of ISO 13528, 9.7: the difference over its expanded uncertainty.
    pub e_n: Option<f64>,
    /// |Eₙ| ≤ 1, or within the tolerance that was given; none where neither is there.
    pub agrees: Option<bool>,
}

/// The difference of two distributions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Sphere {
    /// Root mean square over solid angle, relative to the largest intensity of the first.
    pub rms_of_peak: f64,
    /// The largest difference, with its sign, relative to the same.
    pub largest_of_peak: f64,
    /// Where it is.
    pub largest_c_deg: f64,
    /// Where it is.
    pub largest_gamma_deg: f64,
    /// Root mean square over solid angle of the relative difference, where the first has a tenth of its largest
    /// intensity or more.
    pub rms_rel_where_bright: f64,
    /// Of directions that both runs have, the share whose difference is within its expanded uncertainty.
    pub share_within_u: Option<f64>,
    /// As of a row: 95 % of the directions are within U, or the largest difference within the tolerance.
    pub agrees: Option<bool>,
}

/// The intensities of two items on one scale.
pub(super) struct Difference<'a> {
    first: &'a IntensityDistribution,
    other: &'a IntensityDistribution,
    scale: f64,
    peak_cd: f64,
}

impl<'a> Difference<'a> {
    pub fn of(first: &'a Item, other: &'a Item, shape: bool) -> Self {
        let (first, other) = (&first.distribution, &other.distribution);
        let scale = if shape { first.flux_lm() / other.flux_lm() } else { 1.0 };
        let peak_cd = first.peak().intensity_cd;
        Self {
            first,
            other,
            scale,
            peak_cd,
        }
    }

    /// Other less first, relative to the largest intensity of the first.
    pub fn of_peak(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let other_cd = self.scale * self.other.intensity_cd_at(c_deg, gamma_deg);
        (other_cd - self.first.intensity_cd_at(c_deg, gamma_deg)) / self.peak_cd
    }

    /// The last γ at which either has a thousandth of the largest intensity.
    pub fn last_gamma_deg(&self) -> f64 {
        let reach = |of: &IntensityDistribution| {
            let bright = |place: usize| {
                let planes = 0..of.c_deg().len();
                planes
                    .into_iter()
                    .any(|plane| of.row(plane)[place] > 1e-3 * self.peak_cd)
            };
            let last = (0..of.gamma_deg().len()).rfind(|place| bright(*place));
            last.map_or(0.0, |place| of.gamma_deg()[place])
        };
        reach(self.first).max(reach(self.other)).max(10.0)
    }

    /// Along the plane through C and its opposite, by whole degrees of signed γ.
    pub fn along(&self, c_deg: f64) -> Vec<(f64, f64)> {
        let last = self.last_gamma_deg().ceil() as i32;
        let at = |gamma: i32| {
            let half = if gamma < 0 { c_deg + 180.0 } else { c_deg };
            (f64::from(gamma), self.of_peak(half, f64::from(gamma.abs())))
        };
        (-last..=last).map(at).collect()
    }
}

impl Pair {
    pub(super) fn of(first: &Item, other: &Item, tolerance_rel: Option<f64>, shape: bool) -> Self {
        let same_meter = first.meter.is_some() && first.meter == other.meter;
        let of_light = |value: &Value| matches!(value.unit.as_str(), "lm" | "cd");
        let rows: Vec<Row> = first
            .values
            .iter()
            // Of two shapes the light says nothing.
            .filter(|value| !shape || !of_light(value))
            .filter_map(|a| {
                let b = other.values.iter().find(|b| b.name == a.name)?;
                Some(row(a, b, same_meter, tolerance_rel))
            })
            .collect();
        let sphere = sphere(first, other, same_meter, tolerance_rel, shape);
        let verdicts: Vec<bool> = rows
            .iter()
            .map(|row| row.agrees)
            .chain([sphere.agrees])
            .flatten()
            .collect();
        Self {
            name: other.name.clone(),
            agree: (!verdicts.is_empty()).then(|| verdicts.iter().all(|agrees| *agrees)),
            rows,
            sphere,
            same_meter,
        }
    }
}

fn row(a: &Value, b: &Value, same_meter: bool, tolerance_rel: Option<f64>) -> Row {
    let difference = b.value - a.value;
    let u = a
        .known
        .as_ref()
        .zip(b.known.as_ref())
        .and_then(|(a, b)| u_of_difference(a, b, same_meter));
    let expanded = u.map(|u| 2.0 * u).filter(|expanded| *expanded > 0.0);
    let e_n = expanded.map(|expanded| difference / expanded);
    let within = tolerance_rel.map(|rel| difference.abs() <= rel * a.value.abs());
    Row {
        quantity: a.name.clone(),
        unit: a.unit.clone(),
        first: a.value,
        other: b.value,
        difference,
        expanded,
        e_n,
        agrees: e_n.map(|e_n| e_n.abs() <= 1.0).or(within),
    }
}

/// Standard uncertainty of a difference; none where something is missing in either.
fn u_of_difference(a: &Quantity, b: &Quantity, same_meter: bool) -> Option<f64> {
    let (u_a, u_b) = (a.u?, b.u?);
    if !same_meter {
        return Some(u_a.hypot(u_b));
    }
    let shared = |of: &Quantity| of.parts.get(SHARED).copied().unwrap_or(0.0);
    let (shared_a, shared_b) = (shared(a), shared(b));
    let own = |u: f64, shared: f64| (u * u - shared * shared).max(0.0);
    Some((own(u_a, shared_a) + own(u_b, shared_b) + (shared_a - shared_b).powi(2)).sqrt())
}

fn sphere(first: &Item, other: &Item, same_meter: bool, tolerance_rel: Option<f64>, shape: bool) -> Sphere {
    let difference = Difference::of(first, other, shape);
    let grid = &first.distribution;
    let weights = grid.flux_weights_sr();
    let gammas = grid.gamma_deg();
    let (mut square, mut solid) = (0.0, 0.0);
    let (mut bright_square, mut bright_solid) = (0.0, 0.0);
    let mut largest = (0.0_f64, 0.0, 0.0);
    for (place, weight) in weights.iter().enumerate() {
        let (c_deg, gamma_deg) = (grid.c_deg()[place / gammas.len()], gammas[place % gammas.len()]);
        let of_peak = difference.of_peak(c_deg, gamma_deg);
        square += weight * of_peak * of_peak;
        solid += weight;
        let share = grid.intensity_cd()[place] / difference.peak_cd;
        if share >= BRIGHT {
            bright_square += weight * (of_peak / share).powi(2);
            bright_solid += weight;
        }
        if of_peak.abs() > largest.0.abs() {
            largest = (of_peak, c_deg, gamma_deg);
        }
    }
    let share_within_u = if shape {
        None
    } else {
        share_within_u(first, other, same_meter)
    };
    let within = tolerance_rel.map(|rel| largest.0.abs() <= rel);
    Sphere {
        rms_of_peak: (square / solid).sqrt(),
        largest_of_peak: largest.0,
        largest_c_deg: largest.1,
        largest_gamma_deg: largest.2,
        rms_rel_where_bright: (bright_square / bright_solid).sqrt(),
        share_within_u,
        agrees: share_within_u.map(|share| share >= WITHIN).or(within),
    }
}

/// None without uncertainties of both, or without a direction that both have.
fn share_within_u(first: &Item, other: &Item, same_meter: bool) -> Option<f64> {
    let (u_first, u_other) = (first.u_cd.as_ref()?, other.u_cd.as_ref()?);
    let (a, b) = (&first.distribution, &other.distribution);
    let shared = |item: &Item| -> Option<f64> {
        let of = item
            .values
            .iter()
            .find(|value| value.name == "maximum intensity")?
            .known
            .as_ref()?;
        Some(of.parts.get(SHARED)? / of.value)
    };
    let shared_rel = if same_meter {
        shared(first).zip(shared(other))
    } else {
        None
    };
    let (mut within, mut count) = (0.0, 0.0);
    for (plane, &c_deg) in a.c_deg().iter().enumerate() {
        let Some(there) = b.plane_at(c_deg) else { continue };
        for (place, &gamma_deg) in a.gamma_deg().iter().enumerate() {
            let Some(at) = b.gamma_deg().iter().position(|gamma| *gamma == gamma_deg) else {
                continue;
            };
            let (one, two) = (a.row(plane)[place], b.row(there)[at]);
            let (u_one, u_two) = (
                u_first[plane * a.gamma_deg().len() + place],
                u_other[there * b.gamma_deg().len() + at],
            );
            let taken = shared_rel.map_or(0.0, |(x, y)| {
                let (x, y) = (x * one, y * two);
                x * x + y * y - (x - y).powi(2)
            });
            let u = (u_one * u_one + u_two * u_two - taken).max(0.0).sqrt();
            count += 1.0;
            within += f64::from(u8::from((one - two).abs() <= 2.0 * u));
        }
    }
    (count > 0.0).then(|| within / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_calibration_is_no_uncertainty_of_a_difference() {
        let one = Quantity::new(100.0, "lm", [("calibration", 3.0), ("noise", 0.4)]);
        let two = Quantity::new(101.0, "lm", [("calibration", 3.03), ("noise", 0.3)]);
        let apart = u_of_difference(&one, &two, false).unwrap();
        assert!(
            (apart - (9.0_f64 + 0.16 + 3.03 * 3.03 + 0.09).sqrt()).abs() < 1e-12,
            "{apart}"
        );
        let together = u_of_difference(&one, &two, true).unwrap();
        assert!(
            (together - (0.16_f64 + 0.09 + 0.0009).sqrt()).abs() < 1e-12,
            "{together}"
        );
    }
}
