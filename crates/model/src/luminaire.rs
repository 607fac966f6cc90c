//! The luminaire itself: how much light in which direction, from where, of what spectrum.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_spectrum::Spectrum;

use crate::emitter::Emitter;

/// What links illuminance and irradiance.
#[derive(Debug, Clone, PartialEq)]
pub enum Spectral {
    /// A spectrum, any scale.
    Spectrum(Spectrum),
    /// The luminous efficacy of radiation alone, in lm/W.
    Efficacy(f64),
    /// Nothing is known: results stay in lx.
    None,
}

/// Intensity distribution (absolute, scaled to `flux_lm` where that is given), emitter and spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Luminaire {
    distribution: IntensityDistribution,
    emitter: Emitter,
    spectral: Spectral,
    lookup: Lookup,
    pub(crate) floor: FloorMemory,
}

impl Luminaire {
    /// A luminaire from its parts.
    pub fn new(distribution: IntensityDistribution, emitter: Emitter, spectral: Spectral) -> Self {
        let lookup = Lookup::new(&distribution);
        Self {
            distribution,
            emitter,
            spectral,
            lookup,
            floor: FloorMemory::default(),
        }
    }

    /// The intensity distribution as the model's files give it: nothing refitted, no effects.
    pub fn distribution(&self) -> &IntensityDistribution {
        &self.distribution
    }

    /// The luminous shape as the model's file gives it.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }

    /// What links lx and W/m².
    pub fn spectral(&self) -> &Spectral {
        &self.spectral
    }

    /// Luminous efficacy of radiation in lm/W, where it is known.
    pub fn ler_lm_per_w(&self) -> Option<f64> {
        match &self.spectral {
            Spectral::Spectrum(spectrum) => spectrum.ler_lm_per_w(),
            Spectral::Efficacy(ler) => Some(*ler),
            Spectral::None => None,
        }
    }

    /// Intensity in cd towards (C, γ), γ ≥ 0; bilinear, the mean over C at the poles.
    pub(crate) fn intensity_cd(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        self.lookup.at(&self.distribution, c_deg, gamma_deg)
    }

    /// The directions of the file between which (C, γ) lies, by their number `[ic * ng + ig]`, with their bilinear
    /// weights; all half-planes of a pole are its first one. Weights are 0 outside the file's γ.
    pub(crate) fn corners(&self, c_deg: f64, gamma_deg: f64) -> [(usize, f64); 4] {
        let (cs, gammas) = (self.distribution.c_deg(), self.distribution.gamma_deg());
        let (planes, last) = (cs.len(), gammas.len() - 1);
        if gamma_deg < gammas[0] || gamma_deg > gammas[last] {
            return [(0, 0.0); 4];
        }
        let low = (gammas.partition_point(|at| *at <= gamma_deg).max(1) - 1).min(last - 1);
        let v = (gamma_deg - gammas[low]) / (gammas[low + 1] - gammas[low]);
        let turned = c_deg.rem_euclid(360.0);
        let next = cs.partition_point(|at| *at <= turned) % planes;
        let before = (next + planes - 1) % planes;
        let gap = (cs[next] - cs[before]).rem_euclid(360.0);
        let u = if gap == 0.0 {
            0.0
        } else {
            (turned - cs[before]).rem_euclid(360.0) / gap
        };
        let number = |plane: usize, row: usize| {
            let pole = gammas[row] == 0.0 || gammas[row] == 180.0;
            if pole { row } else { plane * gammas.len() + row }
        };
        [
            (number(before, low), (1.0 - u) * (1.0 - v)),
            (number(before, low + 1), (1.0 - u) * v),
            (number(next, low), u * (1.0 - v)),
            (number(next, low + 1), u * v),
        ]
    }
}

/// C and γ of a direction of any length; γ in [0, 180].
pub(crate) fn angles_deg(direction: DVec3) -> (f64, f64) {
    (direction.y.atan2(direction.x).to_degrees(), polar_deg(direction))
}

/// γ alone, in [0, 180].
pub(crate) fn polar_deg(direction: DVec3) -> f64 {
    direction.truncate().length().atan2(direction.z).to_degrees()
}

/// What the floor returns, once computed: a diagnosis asks for the same places hundreds of times.
#[derive(Debug, Clone, Default)]
pub(crate) struct FloorMemory {
    places: Arc<Mutex<HashMap<FloorKey, FloorLight>>>,
    lattice: Arc<Mutex<HashMap<FloorKey, FloorLight>>>,
}

/// C, γ, lean of the axis, distance, stated distance, height.
pub(crate) type FloorKey = [u64; 6];

/// Light from the floor at albedo 1, and where it left the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FloorLight {
    pub illuminance_lx: f64,
    /// Sum of the directions in which it left, weighted by what each contributes.
    pub whence: DVec3,
}

impl FloorLight {
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            illuminance_lx: factor * self.illuminance_lx,
            whence: factor * self.whence,
        }
    }

    pub fn plus(self, other: Self) -> Self {
        Self {
            illuminance_lx: self.illuminance_lx + other.illuminance_lx,
            whence: self.whence + other.whence,
        }
    }
}

impl FloorMemory {
    /// Entries kept; a fit of the height asks for new ones at every step.
    const LARGEST: usize = 200_000;

    pub fn get_or(&self, key: FloorKey, compute: impl FnOnce() -> FloorLight) -> FloorLight {
        Self::remembered(&self.places, key, compute)
    }

    pub fn get_or_on_lattice(&self, key: FloorKey, compute: impl FnOnce() -> FloorLight) -> FloorLight {
        Self::remembered(&self.lattice, key, compute)
    }

    fn remembered(
        memory: &Mutex<HashMap<FloorKey, FloorLight>>,
        key: FloorKey,
        compute: impl FnOnce() -> FloorLight,
    ) -> FloorLight {
        let known = memory.lock().unwrap_or_else(PoisonError::into_inner).get(&key).copied();
        known.unwrap_or_else(|| {
            let light = compute();
            let mut memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
            if memory.len() >= Self::LARGEST {
                memory.clear();
            }
            memory.insert(key, light);
            light
        })
    }
}

impl PartialEq for FloorMemory {
    /// Memory is no part of what a luminaire is.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Steps of an equidistant grid, so that its cell is found without a search.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lookup {
    gamma_step_deg: Option<f64>,
    /// Step of planes that divide the whole circle evenly from 0.
    c_step_deg: Option<f64>,
    pole_cd: [f64; 2],
}

impl Lookup {
    fn new(distribution: &IntensityDistribution) -> Self {
        let gamma = distribution.gamma_deg();
        let step = (gamma[gamma.len() - 1] - gamma[0]) / (gamma.len() - 1) as f64;
        let even = gamma
            .iter()
            .enumerate()
            .all(|(i, g)| (g - gamma[0] - step * i as f64).abs() < 1e-9);
        let c_step = 360.0 / distribution.c_deg().len() as f64;
        let around = distribution
            .c_deg()
            .iter()
            .enumerate()
            .all(|(i, c)| (c - c_step * i as f64).abs() < 1e-9);
        Self {
            gamma_step_deg: even.then_some(step),
            c_step_deg: around.then_some(c_step),
            pole_cd: [distribution.pole_cd(0.0), distribution.pole_cd(180.0)],
        }
    }

    fn at(&self, distribution: &IntensityDistribution, c_deg: f64, gamma_deg: f64) -> f64 {
        if !distribution.is_rotational() {
            if gamma_deg < 1e-9 {
                return self.pole_cd[0];
            }
            if gamma_deg > 180.0 - 1e-9 {
                return self.pole_cd[1];
            }
        }
        let (Some(step), Some(c_step)) = (self.gamma_step_deg, self.c_step_deg) else {
            return distribution.intensity_cd_at(c_deg, gamma_deg);
        };
        let gamma = distribution.gamma_deg();
        let last = gamma.len() - 1;
        if gamma_deg < gamma[0] || gamma_deg > gamma[last] {
            return 0.0;
        }
        let place = (gamma_deg - gamma[0]) / step;
        let cell = (place as usize).min(last - 1);
        let values = distribution.intensity_cd();
        let v = place - cell as f64;
        let along = |plane: usize| {
            let row = &values[plane * gamma.len()..];
            row[cell] + v * (row[cell + 1] - row[cell])
        };
        if distribution.is_rotational() {
            return along(0);
        }
        let planes = distribution.c_deg().len();
        let turn = c_deg.rem_euclid(360.0) / c_step;
        let before = (turn as usize).min(planes - 1);
        let first = along(before);
        first + (turn - before as f64) * (along((before + 1) % planes) - first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_lookup_is_the_interpolant() {
        let gamma: Vec<f64> = (0..=45).map(|i| 2.0 * i as f64).collect();
        let intensity: Vec<f64> = gamma
            .iter()
            .map(|g| 1000.0 * g.to_radians().cos().max(0.0).powi(3))
            .collect();
        let distribution = IntensityDistribution::new(vec![0.0], gamma, intensity).unwrap();
        let luminaire = Luminaire::new(distribution.clone(), Emitter::Point {}, Spectral::None);
        for i in 0..1900 {
            let gamma = i as f64 * 0.0501;
            assert!(
                (luminaire.intensity_cd(0.0, gamma) - distribution.intensity_cd_at(0.0, gamma)).abs() < 1e-9,
                "{gamma}"
            );
        }
    }

    #[test]
    fn the_quick_lookup_around_c_is_the_interpolant() {
        let gamma: Vec<f64> = (0..=36).map(|i| 5.0 * i as f64).collect();
        let c: Vec<f64> = (0..24).map(|k| 15.0 * k as f64).collect();
        let intensity: Vec<f64> = (0..24 * 37).map(|i| f64::from(i * 7919 % 1000)).collect();
        let distribution = IntensityDistribution::new(c, gamma, intensity).unwrap();
        let luminaire = Luminaire::new(distribution.clone(), Emitter::Point {}, Spectral::None);
        for i in 0..4000 {
            let (c, gamma) = (i as f64 * 0.37 - 360.0, 0.01 + i as f64 * 0.0449);
            assert!(
                (luminaire.intensity_cd(c, gamma) - distribution.intensity_cd_at(c, gamma)).abs() < 1e-6,
                "{c} {gamma}"
            );
        }
    }
}
