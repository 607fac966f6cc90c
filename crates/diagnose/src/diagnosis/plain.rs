//! What was found, for somebody who never read of σ: a plain sentence for each effect, and what it does to the gap.

use isolux_model::effects;

use super::entries::OUTSIDE;
use crate::document::{EffectEntry, GapEntry, Independence, KnownEntry, UnexplainedEntry, Verdict};

/// A term that the readings move by more of its uncertainties is said.
const MOVED_SIGMA: f64 = 1.0;

/// Where a pattern runs along, in words.
pub fn along(coordinate: &str) -> &str {
    match coordinate {
        "time_s" => "time",
        "gamma_deg" => "γ",
        "c_deg" => "C",
        "distance_mm" => "the distance",
        "travel" => "the direction of travel",
        "range" => "the meter's range",
        "ambient_c" => "the temperature",
        "level" => "the level of the light",
        "x_mm" => "x",
        "y_mm" => "y",
        "radius_mm" => "the radius on the sensor",
        "incidence_deg" => "the angle of incidence",
        "exposure" => "the exposure",
        "wavelength_nm" => "the wavelength",
        "index" => "the order of the readings",
        _ => "no coordinate that was recorded",
    }
}

/// The sentence of an effect with the values that were fitted.
fn described(effect: &EffectEntry) -> String {
    effects::by_name(&effect.name).map_or_else(
        || effect.standard_name.to_string(),
        |spec| spec.described(|key| effect.parameters.get(key).map(|parameter| parameter.value)),
    )
}

/// The sentence of a look-alike, whose values were not fitted.
fn told_by_label(label: &str) -> String {
    if label == OUTSIDE {
        return "Something that is not in the catalogue: the values found are beyond what a bench shows.".to_owned();
    }
    match label.strip_prefix("unnamed:") {
        Some(coordinate) => format!("A pattern along {} that has no name.", along(coordinate)),
        None => effects::by_name(label).map_or_else(|| label.to_owned(), |spec| spec.described(|_| None)),
    }
}

/// Where the readings put what the model knows, where that is no chance: the farthest.
fn farthest(known: &[KnownEntry]) -> Option<String> {
    let far = known
        .iter()
        .max_by(|a, b| a.before_sigma.abs().total_cmp(&b.before_sigma.abs()))?;
    let moved = far.before_sigma * far.u;
    let amount = match far.unit.as_ref() {
        "" => format!("{:+.2} %", 100.0 * moved),
        unit => format!("{moved:+.3} {unit}"),
    };
    (far.before_sigma.abs() > MOVED_SIGMA).then(|| {
        format!(
            "The readings move {} by {amount}, {:.1} times its stated uncertainty.",
            far.what,
            far.before_sigma.abs()
        )
    })
}

/// What was found, in plain sentences.
pub(super) fn plain(
    verdict: Verdict,
    effects: &[EffectEntry],
    unexplained: Option<&UnexplainedEntry>,
    gap: &GapEntry,
    known: &[KnownEntry],
    independence: Independence,
) -> String {
    let same_run = independence == Independence::SameRun;
    let mut sentences: Vec<String> = Vec::new();
    match verdict {
        Verdict::Consistent if same_run => {
            sentences.push(
                "The record is consistent with itself: nothing in it disagrees with the model that was made from it."
                    .to_owned(),
            );
        }
        Verdict::Consistent if known.is_empty() => {
            sentences.push("Model and measurement agree to the noise of the readings.".to_owned());
        }
        Verdict::Consistent => {
            sentences.push(
                "Model and measurement agree within the noise of the readings and what the model states of its own uncertainty."
                    .to_owned(),
            );
            sentences.extend(farthest(known));
        }
        Verdict::Named => sentences.extend(effects.iter().map(described)),
        Verdict::Ambiguous => {
            sentences
                .push("Something is missing in the model, and these data cannot tell which of these it is.".to_owned());
            for effect in effects {
                sentences.push(described(effect));
                sentences.extend(
                    effect
                        .equivalents
                        .iter()
                        .map(|label| format!("Or: {}", told_by_label(label))),
                );
            }
        }
        Verdict::Unexplained => {
            let where_ = unexplained.map_or("no coordinate", |found| along(&found.coordinate));
            sentences.push(format!(
                "The readings have a pattern along {where_} that no effect of the catalogue makes."
            ));
            if !effects.is_empty() {
                sentences.push("Besides it:".to_owned());
                sentences.extend(effects.iter().map(described));
            }
        }
    }
    if !effects.is_empty()
        && let Some(held) = &gap.held_out
    {
        let it = if effects.len() == 1 { "it" } else { "them" };
        // Nearer to the floor than a tenth of what was there: what is left cannot be told from noise.
        let to_noise = held.after - held.floor <= 0.1 * (held.before - held.floor).max(0.0);
        sentences.push(if to_noise {
            format!("With {it}, readings that were not fitted agree to the noise.")
        } else {
            format!(
                "With {it}, {:.0} % of the disagreement is gone from readings that were not fitted.",
                100.0 * held.removed.clamp(0.0, 1.0)
            )
        });
    }
    sentences.join(" ")
}
