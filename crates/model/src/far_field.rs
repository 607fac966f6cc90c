//! The far field of a model: its distribution with the refit and every effect on directions and parts.

use std::sync::Arc;

use isolux_photometry::{DistributionError, IntensityDistribution, direction};

use crate::effects::{Act, DirectionFactor, PartLaw, Ray, Values};
use crate::emitter::{Emitter, Node};
use crate::lobe::Lobe;
use crate::model::Model;
use crate::refined::Refined;
use crate::sector::Sectors;

impl Model {
    /// The lobe of one LED where the emitter's LEDs lean inward: LED i carries
    /// weight · I(direction) · [`Lobe::share`]`(axis, direction)`, so that all of them at infinity are I.
    pub fn lobe(&self) -> Option<Arc<Lobe>> {
        let emitter = self.emitter();
        let aim_deg = emitter.aim_deg();
        if aim_deg == 0.0 {
            return None;
        }
        // A circle of eight LEDs or more is as good as even; other places need their own sum.
        let on_circles =
            matches!(&emitter, Emitter::Leds { count, .. } if !count.is_empty() && count.iter().all(|n| *n >= 8));
        let nodes = emitter.nodes(1);
        let key = if on_circles {
            // Wherever the circles are: only LEDs on the axis do not lean.
            vec![aim_deg.to_bits(), Lobe::upright(&nodes).to_bits()]
        } else {
            nodes.iter().flat_map(Node::bits).collect()
        };
        let luminaire = self.luminaire();
        luminaire.memory.lobe_or(key, || {
            let target = luminaire.memory.lobe_target_or(|| Lobe::target_cd(luminaire.grid()));
            Lobe::fit(&target, &nodes, aim_deg, on_circles)
        })
    }

    /// The intensity distribution with everything that was refitted and every effect on directions, on a grid fine
    /// enough for them. The luminaire's own grid, untouched, where there is none.
    ///
    /// # Errors
    /// [`DistributionError`] if a factor is not finite.
    pub fn distribution(&self) -> Result<IntensityDistribution, DistributionError> {
        let directions = self.directions();
        if directions.are_unity() && !self.luminaire().is_corrected() {
            return Ok(self.luminaire().grid().clone());
        }
        let base = self.luminaire().grid();
        let turns = directions.turn();
        let c_deg = if turns {
            with_steps(base.c_deg(), 360.0, 5.0)
        } else {
            base.c_deg().to_vec()
        };
        let gamma_deg = with_steps(base.gamma_deg(), base.gamma_deg()[base.gamma_deg().len() - 1], 1.0);
        let mut intensity_cd = Vec::with_capacity(c_deg.len() * gamma_deg.len());
        for c in &c_deg {
            for gamma in &gamma_deg {
                let factor = directions.factor(*c, *gamma) * self.luminaire().correction_at(*c, *gamma);
                intensity_cd.push(base.intensity_cd_at(*c, *gamma) * factor);
            }
        }
        IntensityDistribution::new(c_deg, gamma_deg, intensity_cd)
    }

    pub(crate) fn direction_factors(&self) -> Vec<DirectionFactor> {
        self.acts()
            .filter_map(|(act, values)| match act {
                Act::Direction(law) => Some(law(values)),
                _ => None,
            })
            .collect()
    }

    pub(crate) fn directions(&self) -> Directions<'_> {
        Directions {
            refined: self.refined(),
            factors: self.direction_factors(),
            sectors: self.sectors(),
            mean_cosine: self.luminaire().mean_cosine(),
        }
    }

    /// The parts of the emitter with what each still gives; none where no effect dims a part. The parts are those of the
    /// emitter that the file states: what stands in its place to find another shape has the same loss, or the loss would
    /// pass for that shape.
    pub fn sectors(&self) -> Option<Sectors> {
        let (law, values) = self.part_laws().next()?;
        let aim_deg = (law.aim_deg)(values);
        let given = |azimuth_deg| self.given_at(azimuth_deg);
        let luminaire = self.luminaire();
        let lobe = luminaire.memory.part_lobe_or(|| Sectors::lobe(luminaire.grid()));
        Some(Sectors::of(lobe, luminaire.stated_emitter(), aim_deg, given))
    }

    /// What the part of the emitter at an azimuth in degrees still gives: 1 where no effect dims it.
    pub fn given_at(&self, azimuth_deg: f64) -> f64 {
        let given = |(law, values): (&PartLaw, &Values)| (law.given)(values, azimuth_deg);
        self.part_laws().map(given).product()
    }

    fn part_laws(&self) -> impl Iterator<Item = (&'static PartLaw, &Values)> {
        self.acts().filter_map(|(act, values)| match act {
            Act::Part(law) => Some((law, values)),
            _ => None,
        })
    }
}

/// Everything that changes the far field: the refit, the effects on directions, dimmed parts.
pub(crate) struct Directions<'m> {
    refined: &'m Refined,
    factors: Vec<DirectionFactor>,
    sectors: Option<Sectors>,
    mean_cosine: f64,
}

impl Directions<'_> {
    fn are_unity(&self) -> bool {
        self.factors.is_empty() && self.sectors.is_none() && self.refined.is_unity()
    }

    /// Whether the factor depends on C.
    fn turn(&self) -> bool {
        !self.factors.is_empty() || self.sectors.is_some() || self.refined.depends_on_c()
    }

    /// Factor on the intensity towards (C, γ).
    pub fn factor(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let mut factor = self.refined.factor(c_deg, gamma_deg);
        if !self.factors.is_empty() || self.sectors.is_some() {
            let ray = Ray {
                c_deg,
                gamma_deg,
                direction: direction(c_deg, gamma_deg),
                mean_cosine: self.mean_cosine,
            };
            for of_effect in &self.factors {
                factor *= of_effect(&ray);
            }
            if let Some(sectors) = &self.sectors {
                factor *= sectors.left_towards(ray.direction);
            }
        }
        factor
    }
}

/// The angles of a grid and between them others, so that none are farther apart than `step`.
fn with_steps(grid: &[f64], end: f64, step: f64) -> Vec<f64> {
    let mut angles = Vec::new();
    for (index, &from) in grid.iter().enumerate() {
        let to = grid.get(index + 1).copied().unwrap_or(end);
        let parts = ((to - from) / step - 1e-9).ceil().max(1.0) as usize;
        for part in 0..parts {
            let angle = from + (to - from) * part as f64 / parts as f64;
            if part == 0 || angle < end {
                angles.push(angle);
            }
        }
    }
    angles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Effect, Emitter, Interpolation, Luminaire, Spectral};

    /// What a simulation takes: with and without an effect on directions, between the directions of the file.
    #[test]
    fn a_smooth_luminaire_is_smooth_in_its_far_field() {
        let gamma: Vec<f64> = (0..=9).map(|i| 10.0 * f64::from(i)).collect();
        let cosine = |gamma: f64| 1000.0 * gamma.to_radians().cos().powi(3);
        let intensity = gamma.iter().map(|gamma| cosine(*gamma)).collect();
        let file = IntensityDistribution::new(vec![0.0], gamma, intensity).unwrap();
        let of = |how| {
            Model::of(Luminaire::interpolated(
                file.clone(),
                how,
                Emitter::Point {},
                Spectral::None,
            ))
        };
        let [linear, smooth] = [Interpolation::Linear, Interpolation::Smooth].map(of);
        let keys = [
            ("depth_rel", 0.1),
            ("azimuth_deg", 0.0),
            ("gamma_deg", 40.0),
            ("width_deg", 30.0),
        ];
        let shade = vec![Effect::from_keys("self_absorption", keys).unwrap()];
        for gamma in [25.0, 45.0, 55.0] {
            let bare = |model: &Model| model.distribution().unwrap().intensity_cd_at(90.0, gamma) / cosine(gamma) - 1.0;
            assert!(bare(&smooth).abs() < 2e-3, "γ {gamma}: {}", bare(&smooth));
            assert!(bare(&linear).abs() > 4e-3, "γ {gamma}: {}", bare(&linear));
            let left = |model: &Model| {
                model
                    .with_effects(shade.clone())
                    .distribution()
                    .unwrap()
                    .intensity_cd_at(0.0, gamma)
            };
            let factor = smooth.with_effects(shade.clone()).directions().factor(0.0, gamma);
            assert!(factor < 0.99, "γ {gamma}: {factor}");
            let off = left(&smooth) / (cosine(gamma) * factor) - 1.0;
            assert!(off.abs() < 2e-3, "γ {gamma}: {off}");
        }
    }
}
