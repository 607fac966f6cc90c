//! Single intensities that their neighbours contradict: a digit lost or changed, a decimal point moved.
//!
//! Every value is compared with what its neighbours along γ, and those in the planes beside it, suggest. The least of
//! these departures is measured against what is usual around the value. Rugged light departs in many places; a wrong
//! number departs in one. So nothing is reported where several places depart alike.

use super::{Stored, at, decimals};
use crate::finding::{Finding, Findings};

/// A departure is looked at from this part of the peak on, and from this part of the larger of value and suggestion.
const LEAST: (f64, f64) = (0.03, 0.35);
/// How many times the departure is above what is usual around the value.
const PROMINENT: f64 = 15.0;
/// Places in a file beyond which its light is rugged, and how far those that are reported stand above the rest.
const MOST: usize = 3;
const ABOVE_THE_REST: f64 = 2.0;
/// Values on either side along γ, and planes on either side, that tell what is usual.
const AROUND: (usize, usize) = (8, 3);

/// Looks at every value that has two neighbours on either side.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let Some(field) = Field::new(stored) else { return };
    let mut places = field.places();
    places.sort_by(|a, b| b.prominence.total_cmp(&a.prominence));
    let rest = places.get(MOST).map_or(0.0, |place| place.prominence);
    places.truncate(MOST);
    places.retain(|place| place.prominence > ABOVE_THE_REST * rest);
    places.sort_by_key(|place| place.index);
    for place in places {
        let message = format!(
            "this intensity (γ = {}°) does not fit its neighbours, which suggest about {:.4}",
            stored.angles_deg[place.index % field.ng],
            place.suggested
        );
        let finding = Finding::warning("intensity-outlier", message).assumed("the value as it stands");
        findings.push(at(stored, place.index, finding).fix("compare it with the source; a digit may be wrong"));
    }
}

/// A value that its neighbours contradict.
struct Place {
    index: usize,
    suggested: f64,
    prominence: f64,
}

struct Field<'s, 'f> {
    stored: &'s Stored<'f>,
    planes: usize,
    ng: usize,
    /// How the two neighbours on either side along γ suggest a value; none at the ends.
    weights: Vec<Option<Weights>>,
    /// The least departure of each value from its neighbours' suggestions; none at the ends of a plane.
    departures: Vec<Option<f64>>,
    peak: f64,
    /// What the rounding of the numbers alone makes usual.
    rounding: f64,
}

impl<'s, 'f> Field<'s, 'f> {
    fn new(stored: &'s Stored<'f>) -> Option<Self> {
        let (planes, ng) = (stored.planes_deg.len(), stored.angles_deg.len());
        let peak = stored.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let usable = ng >= 7 && stored.values.len() == planes * ng && peak > 0.0 && peak.is_finite();
        if !usable {
            return None;
        }
        let mut field = Self {
            stored,
            planes,
            ng,
            weights: (0..ng).map(|angle| weights(stored.angles_deg, angle)).collect(),
            departures: Vec::new(),
            peak,
            rounding: 10f64.powi(-decimals(stored)),
        };
        field.departures = (0..stored.values.len())
            .map(|index| field.departure(index).map(f64::abs))
            .collect();
        Some(field)
    }

    /// A dip at the horizon, where a luminaire is seen edge on.
    fn edge_on(&self, index: usize) -> bool {
        let values = self.stored.values;
        let horizon = self.stored.poles && self.stored.angles_deg[index % self.ng] == 90.0;
        horizon && values[index] < values[index - 1].min(values[index + 1])
    }

    /// The departure of smallest size: from the cubic through the neighbours, from the lines through those on one side
    /// (light that is cut off follows one of them), from the planes beside. None for a value between its two
    /// neighbours.
    fn departure(&self, index: usize) -> Option<f64> {
        let values = self.stored.values;
        let value = values[index];
        let weights = self.weights[index % self.ng].as_ref()?;
        let [a, b, c, d] = [
            values[index - 2],
            values[index - 1],
            values[index + 1],
            values[index + 2],
        ];
        if (b.min(c)..=b.max(c)).contains(&value) {
            return Some(0.0);
        }
        let along = [
            weights.cubic[0] * a + weights.cubic[1] * b + weights.cubic[2] * c + weights.cubic[3] * d,
            b + weights.left * (b - a),
            c + weights.right * (c - d),
        ];
        let suggestions = along.into_iter().chain(self.beside(index));
        suggestions
            .map(|suggested| value - suggested)
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The same direction in the planes beside: their mean, or the one there is at either end.
    fn beside(&self, index: usize) -> Option<f64> {
        let (plane, angle) = (index / self.ng, index % self.ng);
        let value = |plane: usize| (plane < self.planes).then(|| self.stored.values[plane * self.ng + angle]);
        match (plane.checked_sub(1).and_then(value), value(plane + 1)) {
            (Some(before), Some(after)) => Some(0.5 * (before + after)),
            (one, other) => one.or(other),
        }
    }

    /// The places that stand out, one for every group of neighbours.
    fn places(&self) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for (index, departure) in self.departures.iter().enumerate() {
            let Some(departure) = *departure else { continue };
            let value = self.stored.values[index];
            let suggested = value - self.departure(index).unwrap_or_default();
            let large = departure >= LEAST.0 * self.peak && departure >= LEAST.1 * value.abs().max(suggested.abs());
            if !large || self.edge_on(index) {
                continue;
            }
            let prominence = departure / self.usual(index);
            if prominence < PROMINENT {
                continue;
            }
            let place = Place {
                index,
                suggested,
                prominence,
            };
            // A wrong value makes its neighbours depart too: the largest of a group speaks for it.
            match places.iter_mut().find(|other| self.near(other.index, index)) {
                Some(other) if other.prominence < prominence => *other = place,
                Some(_) => {}
                None => places.push(place),
            }
        }
        places
    }

    /// The median departure of the values around, those that the value itself makes depart left out.
    fn usual(&self, index: usize) -> f64 {
        let (plane, angle) = (index / self.ng, index % self.ng);
        let planes = plane.saturating_sub(AROUND.1)..(plane + AROUND.1 + 1).min(self.planes);
        let angles = angle.saturating_sub(AROUND.0)..(angle + AROUND.0 + 1).min(self.ng);
        let mut around: Vec<f64> = planes
            .flat_map(|plane| angles.clone().map(move |angle| plane * self.ng + angle))
            .filter(|&other| !self.near(index, other))
            .filter_map(|other| self.departures[other])
            .collect();
        around.sort_unstable_by(f64::total_cmp);
        let median = around.get(around.len() / 2).copied().unwrap_or(self.peak);
        median.max(self.rounding).max(1e-4 * self.peak)
    }

    /// Whether one value takes part in the suggestion for the other.
    fn near(&self, one: usize, other: usize) -> bool {
        let planes = (one / self.ng).abs_diff(other / self.ng);
        let angles = (one % self.ng).abs_diff(other % self.ng);
        planes <= 1 && angles <= 2
    }
}

/// How neighbours along γ suggest a value.
struct Weights {
    /// Lagrange weights of the cubic through all four.
    cubic: [f64; 4],
    /// Steps beyond the nearest neighbour, in steps between the two of the same side.
    left: f64,
    right: f64,
}

fn weights(angles_deg: &[f64], at: usize) -> Option<Weights> {
    if at < 2 || at + 2 >= angles_deg.len() {
        return None;
    }
    let x = angles_deg[at];
    let [a, b, c, d] = [-2, -1, 1, 2].map(|step: isize| angles_deg[at.saturating_add_signed(step)]);
    let weight = |own: f64, others: [f64; 3]| others.iter().map(|other| (x - other) / (own - other)).product();
    Some(Weights {
        cubic: [
            weight(a, [b, c, d]),
            weight(b, [a, c, d]),
            weight(c, [a, b, d]),
            weight(d, [a, b, c]),
        ],
        left: (x - b) / (b - a),
        right: (x - c) / (c - d),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NG: usize = 37;

    fn lines(values: &[f64], planes: usize) -> Vec<usize> {
        let ng = values.len() / planes;
        let planes_deg: Vec<f64> = (0..planes).map(|plane| plane as f64 * 15.0).collect();
        let angles_deg: Vec<f64> = (0..ng).map(|angle| angle as f64 * 2.5).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let stored = Stored {
            planes_deg: &planes_deg,
            angles_deg: &angles_deg,
            values,
            places: &places,
            raw: &|_| "1.01",
            poles: true,
            ends_with_newline: true,
        };
        let mut findings = Findings::new();
        check(&stored, &mut findings);
        findings.into_vec().iter().filter_map(|finding| finding.line).collect()
    }

    fn lobe(planes: usize) -> Vec<f64> {
        let cosine = |index: usize| ((index % NG) as f64 * 2.5).to_radians().cos().max(0.0);
        (0..planes * NG).map(|index| 500.0 * cosine(index).powf(1.5)).collect()
    }

    #[test]
    fn smooth_light_is_quiet_and_a_wrong_value_is_reported() {
        for planes in [1, 7] {
            let mut values = lobe(planes);
            assert!(lines(&values, planes).is_empty());
            let wrong = (planes - 1) * NG + 12;
            values[wrong] /= 10.0;
            assert_eq!(lines(&values, planes), [wrong + 1]);
        }
    }

    #[test]
    fn rugged_light_is_quiet() {
        // Every third direction in the shadow of a louvre.
        let values: Vec<f64> = (0..3 * NG).map(|at| if at % 3 == 0 { 60.0 } else { 400.0 }).collect();
        assert!(lines(&values, 3).is_empty());
    }

    #[test]
    fn a_dip_at_the_horizon_is_the_luminaires_edge() {
        let both = |at: usize| (2.5 * at as f64).to_radians().cos().abs();
        let mut values: Vec<f64> = (0..73).map(|at| 60.0 + 400.0 * both(at)).collect();
        values[36] = 5.0;
        assert!(lines(&values, 1).is_empty());
        values[36] = 60.0;
        values[35] = 5.0;
        assert_eq!(lines(&values, 1), [36]);
    }

    #[test]
    fn a_cut_off_in_all_planes_is_light() {
        let values: Vec<f64> = (0..7 * NG).map(|at| if at % NG < 9 { 400.0 } else { 0.0 }).collect();
        assert!(lines(&values, 7).is_empty());
    }
}
