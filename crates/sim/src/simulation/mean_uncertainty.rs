//! What the mean of a map is worth: what the model knows of its own measurement, and what it does not.

use isolux_model::{Emitter, Scene, luminous_area_rel};

/// Above this share of the luminous radius an emitter is as large as the luminous area.
const AS_LARGE: f64 = 0.9;

/// Standard uncertainty of a mean, or what is missing in it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanUncertainty {
    /// Standard uncertainty (k = 1); none where something is missing.
    pub u: Option<f64>,
    /// What is missing, one phrase each.
    pub missing: Vec<String>,
}

impl MeanUncertainty {
    /// Of `mean` on the sensor `distance_mm` away. `numeric` is the error of the computation; `efficacy` says that the
    /// mean went through the luminous efficacy.
    pub fn of(scene: &Scene, mean: f64, numeric: f64, efficacy: bool, distance_mm: f64) -> Self {
        let Some(u) = scene.model.uncertainty() else {
            return Self {
                u: None,
                missing: vec!["the model states no uncertainty ([luminaire.u])".to_owned()],
            };
        };
        let mut missing = u.missing.clone();
        if let Some([first, last]) = u.measured_gamma_deg {
            let [low, high] = scene.gamma_range_deg();
            // A file has its angles to 0.01°.
            if low < first - 0.01 || high > last + 0.01 {
                missing.push(format!(
                    "γ {first}° to {last}° alone was measured, and light from γ {low:.1}° to {high:.1}° reaches the \
                     sensor"
                ));
            }
        }
        let mut stated = |key: &str, value: Option<f64>| {
            if value.is_none() && u.missing.is_empty() {
                missing.push(format!("the model states no luminaire.u.{key}"));
            }
            value.unwrap_or(0.0)
        };
        let level = stated("intensity_rel", u.intensity_rel);
        let efficacy = if efficacy { stated("ler_rel", u.ler_rel) } else { 0.0 };
        let near = near_field_rel(scene, u.luminous_diameter_mm, distance_mm);
        let squares = [numeric, level * mean, efficacy * mean, near * mean].map(|part| part * part);
        Self {
            u: missing.is_empty().then(|| squares.iter().sum::<f64>().sqrt()),
            missing,
        }
    }
}

/// Relative standard uncertainty by where in the luminous area the light leaves. An emitter smaller than that area is
/// off by up to a ring of its diameter, (1 + R²/d²)^(−(n + 3)/2), and anything up to it is as likely.
fn near_field_rel(scene: &Scene, diameter_mm: Option<f64>, distance_mm: f64) -> f64 {
    let (Some(diameter_mm), Ok(distribution)) = (diameter_mm, scene.model.distribution()) else {
        return 0.0;
    };
    let (radius, emitter) = (0.5 * diameter_mm, scene.model.luminaire().emitter().extent_mm());
    let modelled = scene
        .model
        .effects()
        .iter()
        .any(|effect| effect.spec().replaces_emitter());
    if modelled {
        return 0.0;
    }
    if emitter >= AS_LARGE * radius {
        // Somebody who writes single LEDs or a ring knows where they are.
        let even = matches!(scene.model.luminaire().emitter(), Emitter::Disc { .. });
        let n = distribution.lobe_exponent();
        return if even {
            luminous_area_rel(diameter_mm, n, distance_mm)
        } else {
            0.0
        };
    }
    let ring =
        |radius: f64| (-0.5 * (distribution.lobe_exponent() + 3.0) * (radius / distance_mm).powi(2).ln_1p()).exp();
    (ring(radius) - ring(emitter)).abs() / 3.0_f64.sqrt()
}
