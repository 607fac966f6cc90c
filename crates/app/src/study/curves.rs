//! What was measured and simulated of a diagnosis, half-plane by half-plane.

use std::collections::BTreeMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::Model;
use isolux_record::ReadingKind;
use isolux_record::observation::{Need, Observations, ReadingCoordinates, Readings, open};
use serde::Serialize;

use crate::Failure;

/// A pair of half-planes: signed γ, what was read and what the models say.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Curve {
    /// C of the half-plane with positive γ.
    pub c_deg: f64,
    /// Distance of the detector.
    pub distance_mm: f64,
    /// Signed γ, rising.
    pub gamma_deg: Vec<f64>,
    /// Mean of the readings there, lx.
    pub measured_lx: Vec<f64>,
    /// Expanded uncertainty of one reading (k = 2), lx.
    pub u_lx: Vec<f64>,
    /// By the model without the effects.
    pub before_lx: Vec<f64>,
    /// By the model with them.
    pub after_lx: Vec<f64>,
}

/// Lit readings of the observations and what the models before and after in `folder`, that of a diagnosis, say there;
/// empty where none are readings.
///
/// # Errors
/// Bad input (exit 2) for a model that cannot be read.
pub(super) fn curves(folder: &Utf8Path, observations: &[Utf8PathBuf]) -> Result<Vec<Curve>, Failure> {
    let model = |name: &str| Model::load(&folder.join(name)).map_err(Failure::bad_input);
    let models = [model("model.baseline.toml")?, model("model.after.toml")?];
    let mut pairs: BTreeMap<(u64, u64), BTreeMap<i64, Sums>> = BTreeMap::new();
    for path in observations {
        // An observation that has moved since takes its curves with it, and nothing else.
        let Ok(Observations::Readings(readings)) = open(path, Need::Values) else {
            continue;
        };
        add(&mut pairs, &readings, &models);
    }
    Ok(pairs
        .into_iter()
        .map(|((c, distance), at)| {
            let mut curve = Curve {
                c_deg: f64::from_bits(c),
                distance_mm: f64::from_bits(distance),
                ..Curve::default()
            };
            for (gamma, sums) in at {
                let mean = |sum: f64| sum / sums.count;
                curve.gamma_deg.push(gamma as f64 / PER_DEG);
                curve.measured_lx.push(mean(sums.lux));
                curve.u_lx.push(2.0 * mean(sums.u_lx));
                curve.before_lx.push(mean(sums.models[0]));
                curve.after_lx.push(mean(sums.models[1]));
            }
            curve
        })
        .filter(|curve| curve.gamma_deg.len() > 2)
        .collect())
}

/// Sums over the readings of one direction.
#[derive(Default)]
struct Sums {
    count: f64,
    lux: f64,
    u_lx: f64,
    models: [f64; 2],
}

/// Directions are told apart to a tenth of a degree.
const PER_DEG: f64 = 10.0;

fn add(pairs: &mut BTreeMap<(u64, u64), BTreeMap<i64, Sums>>, readings: &Readings, models: &[Model; 2]) {
    let illuminated: Vec<(ReadingCoordinates, f64, f64)> = readings
        .rows()
        .iter()
        .filter(|row| row.at.kind == ReadingKind::Lit)
        .filter_map(|row| Some((row.at, row.illuminance_lx?, row.u_lx?)))
        .collect();
    let at: Vec<ReadingCoordinates> = illuminated.iter().map(|(at, ..)| *at).collect();
    let predicted = models.each_ref().map(|model| model.predict_readings(&at));
    for (k, (at, lux, u_lx)) in illuminated.iter().enumerate() {
        let c = at.c_deg.rem_euclid(360.0);
        // C + 180° at γ is C at −γ.
        let (c, gamma) = if c >= 180.0 {
            (c - 180.0, -at.gamma_deg)
        } else {
            (c, at.gamma_deg)
        };
        let plane = (c * PER_DEG).round() / PER_DEG;
        let plane = if plane >= 180.0 { 0.0 } else { plane };
        let pair = pairs.entry((plane.to_bits(), at.distance_mm.to_bits())).or_default();
        let sums = pair.entry((gamma * PER_DEG).round() as i64).or_default();
        sums.count += 1.0;
        sums.lux += lux;
        sums.u_lx += u_lx;
        for (sum, values) in sums.models.iter_mut().zip(&predicted) {
            *sum += values[k];
        }
    }
}
