//! The luminaire itself: how much light in which direction, from where, of what spectrum.

use std::sync::Arc;

use isolux_photometry::{DistributionError, IntensityDistribution};
use isolux_spectrum::Spectrum;
use serde::{Deserialize, Serialize};

use crate::emitter::Emitter;
use crate::memory::Memory;

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

/// What the light is between the directions of the distribution's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Bilinear in (C, γ): the convention of photometric files.
    #[default]
    Linear,
    /// Smooth, through the file's directions: that of light.
    Smooth,
}

impl Interpolation {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde asks")]
    pub(crate) fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    /// The grid whose bilinear interpolant is meant; `u_cd` as in [`IntensityDistribution::on_smooth_grid`].
    pub(crate) fn grid_of(
        self,
        distribution: &IntensityDistribution,
        u_cd: &dyn Fn(f64) -> f64,
    ) -> IntensityDistribution {
        match self {
            Self::Linear => distribution.clone(),
            Self::Smooth => distribution.on_smooth_grid(u_cd),
        }
    }

    /// `distribution` scaled so that the flux of its interpolant is `flux_lm`.
    ///
    /// # Errors
    /// [`DistributionError::NoFlux`] when it integrates to nothing.
    pub(crate) fn scaled_to_flux_lm(
        self,
        distribution: &IntensityDistribution,
        flux_lm: f64,
    ) -> Result<IntensityDistribution, DistributionError> {
        // In the unit of the file, in which no uncertainty is stated.
        let own = self.grid_of(distribution, &not_known).flux_lm();
        if own <= 0.0 {
            return Err(DistributionError::NoFlux {
                flux_lm: own,
                wanted_lm: flux_lm,
            });
        }
        distribution.scaled(flux_lm / own)
    }
}

/// cos 85°: light beyond is hardly that of a lobe.
const LEAST_COSINE: f64 = 0.087_155_742_747_658_18;

/// cos γ, at least cos 85°.
pub(crate) fn lobe_cosine(direction_z: f64) -> f64 {
    direction_z.max(LEAST_COSINE)
}

fn mean_cosine(grid: &IntensityDistribution) -> f64 {
    let logarithms: Vec<f64> = grid
        .gamma_deg()
        .iter()
        .map(|gamma| lobe_cosine(gamma.to_radians().cos()).ln())
        .collect();
    let (mut flux, mut sum) = (0.0, 0.0);
    for (at, (weight, intensity)) in grid.flux_weights_sr().iter().zip(grid.intensity_cd()).enumerate() {
        flux += weight * intensity;
        sum += weight * intensity * logarithms[at % logarithms.len()];
    }
    if flux > 0.0 { (sum / flux).exp() } else { 1.0 }
}

/// The uncertainty of a direction of which none is stated.
fn not_known(_intensity_cd: f64) -> f64 {
    0.0
}

/// Intensity distribution (absolute, scaled to `flux_lm` where that is given), emitter and spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Luminaire {
    distribution: Arc<IntensityDistribution>,
    /// Bilinear between its directions, which are the distribution's own and for a smooth interpolation more.
    grid: Arc<IntensityDistribution>,
    interpolation: Interpolation,
    emitter: Emitter,
    /// The emitter of the file, where `emitter` was put in its place.
    stated_emitter: Emitter,
    spectral: Spectral,
    lookup: Lookup,
    mean_cosine: f64,
    correction: Option<Correction>,
    pub(crate) memory: Memory,
}

impl Luminaire {
    /// A luminaire from its parts, its light linear between the directions of `distribution`.
    pub fn new(distribution: IntensityDistribution, emitter: Emitter, spectral: Spectral) -> Self {
        Self::interpolated(distribution, Interpolation::Linear, emitter, spectral)
    }

    /// A luminaire from its parts, of whose directions no uncertainty is known.
    pub fn interpolated(
        distribution: IntensityDistribution,
        interpolation: Interpolation,
        emitter: Emitter,
        spectral: Spectral,
    ) -> Self {
        let grid = interpolation.grid_of(&distribution, &not_known);
        Self::on_grid(distribution, grid, interpolation, emitter, spectral)
    }

    /// A luminaire whose light is bilinear on `grid`, which has the directions of `distribution` and stands for this
    /// interpolation of it.
    pub(crate) fn on_grid(
        distribution: IntensityDistribution,
        grid: IntensityDistribution,
        interpolation: Interpolation,
        emitter: Emitter,
        spectral: Spectral,
    ) -> Self {
        let lookup = Lookup::new(&distribution, &grid);
        Self {
            mean_cosine: mean_cosine(&grid),
            distribution: Arc::new(distribution),
            grid: Arc::new(grid),
            interpolation,
            stated_emitter: emitter.clone(),
            emitter,
            spectral,
            lookup,
            correction: None,
            memory: Memory::default(),
        }
    }

    /// The same luminaire with another grid, which has all directions of its distribution then.
    pub(crate) fn with_grid(&self, grid: IntensityDistribution) -> Self {
        let (emitter, spectral) = (self.emitter.clone(), self.spectral.clone());
        Self::on_grid(grid.clone(), grid, self.interpolation, emitter, spectral)
    }

    /// The same light from another emitter, its far field multiplied by `factor` in each direction.
    pub(crate) fn with_emitter(&self, emitter: Emitter, factor: Option<IntensityDistribution>) -> Self {
        Self {
            emitter,
            correction: factor.map(Correction::new),
            memory: self.memory.of_distribution(),
            ..self.clone()
        }
    }

    /// The intensity distribution as the model's files give it: nothing refitted, no effects, no direction added.
    pub fn distribution(&self) -> &IntensityDistribution {
        &self.distribution
    }

    /// The grid whose bilinear interpolant is the light: the distribution's own, or a finer one where the
    /// interpolation is smooth. Of a luminaire whose emitter was exchanged it lacks the factor.
    pub fn grid(&self) -> &IntensityDistribution {
        &self.grid
    }

    /// Whether the light has no edges at the directions of the file.
    pub(crate) fn is_smooth(&self) -> bool {
        self.interpolation == Interpolation::Smooth
    }

    /// Geometric mean of cos γ over the luminous flux, of directions beyond 85° as if they were there: where a wider or
    /// a narrower beam of the same flux has the same intensity.
    pub(crate) fn mean_cosine(&self) -> f64 {
        self.mean_cosine
    }

    /// The luminous shape as the model's file gives it.
    pub fn emitter(&self) -> &Emitter {
        &self.emitter
    }

    /// The luminous shape before [`with_emitter`](Self::with_emitter) put another in its place.
    pub(crate) fn stated_emitter(&self) -> &Emitter {
        &self.stated_emitter
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

    /// Intensity in cd towards (C, γ), γ ≥ 0; bilinear on the grid, the mean over C at the poles.
    pub(crate) fn intensity_cd(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        self.lookup.at(&self.grid, c_deg, gamma_deg) * self.correction_at(c_deg, gamma_deg)
    }

    /// Intensities in cd as [`intensity_cd`](Self::intensity_cd) gives them at C, C + 360°/n, … for all `n` of `values`.
    pub(crate) fn intensities_around_cd(&self, c_deg: f64, gamma_deg: f64, values: &mut [f64]) {
        self.lookup.around(&self.grid, c_deg, gamma_deg, values);
        if let Some(correction) = &self.correction {
            let mut factors = vec![1.0; values.len()];
            correction
                .lookup
                .around(&correction.factor, c_deg, gamma_deg, &mut factors);
            for (value, factor) in values.iter_mut().zip(factors) {
                *value *= factor;
            }
        }
    }

    /// The factor of [`with_emitter`](Self::with_emitter); 1 where there is none.
    pub(crate) fn correction_at(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        self.correction
            .as_ref()
            .map_or(1.0, |correction| correction.at(c_deg, gamma_deg))
    }

    pub(crate) fn is_corrected(&self) -> bool {
        self.correction.is_some()
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

/// A factor on the light of each direction, bilinear on a grid of its own.
#[derive(Debug, Clone, PartialEq)]
struct Correction {
    factor: Arc<IntensityDistribution>,
    lookup: Lookup,
}

impl Correction {
    fn new(factor: IntensityDistribution) -> Self {
        Self {
            lookup: Lookup::new(&factor, &factor),
            factor: Arc::new(factor),
        }
    }

    fn at(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        self.lookup.at(&self.factor, c_deg, gamma_deg)
    }
}

/// Steps of an equidistant file, so that the cell of its grid is found without a search.
#[derive(Debug, Clone, PartialEq)]
struct Lookup {
    gamma: Option<EvenGamma>,
    /// Step of planes that divide the whole circle evenly from 0.
    c_step_deg: Option<f64>,
    pole_cd: [f64; 2],
    /// Intensities of the grid around the axis, one γ after the other, `[ig * nc + ic]`.
    by_gamma_cd: Arc<[f64]>,
}

/// γ of the file evenly apart, each step cut into equal parts by the grid.
#[derive(Debug, Clone, PartialEq)]
struct EvenGamma {
    per_step: f64,
    /// Place in the grid of each γ of the file.
    places: Vec<usize>,
}

impl EvenGamma {
    fn of(file: &[f64], grid: &[f64]) -> Option<Self> {
        let step = (file[file.len() - 1] - file[0]) / (file.len() - 1) as f64;
        let even = |(i, gamma): (usize, &f64)| (gamma - file[0] - step * i as f64).abs() < 1e-9;
        file.iter().enumerate().all(even).then(|| Self {
            per_step: 1.0 / step,
            places: file.iter().map(|gamma| grid.partition_point(|at| at < gamma)).collect(),
        })
    }

    /// The grid's cell at `from_first_deg` degrees from its first γ, and the share of the way through it.
    fn cell(&self, from_first_deg: f64) -> (usize, f64) {
        let steps = from_first_deg * self.per_step;
        let step = (steps as usize).min(self.places.len() - 2);
        let (first, next) = (self.places[step], self.places[step + 1]);
        let place = (steps - step as f64) * (next - first) as f64;
        let part = (place as usize).min(next - first - 1);
        (first + part, place - part as f64)
    }
}

impl Lookup {
    fn new(file: &IntensityDistribution, grid: &IntensityDistribution) -> Self {
        let (planes, rows) = (grid.c_deg().len(), grid.gamma_deg().len());
        let c_step = 360.0 / planes as f64;
        let around = grid
            .c_deg()
            .iter()
            .enumerate()
            .all(|(i, c)| (c - c_step * i as f64).abs() < 1e-9);
        Self {
            gamma: EvenGamma::of(file.gamma_deg(), grid.gamma_deg()),
            c_step_deg: around.then_some(c_step),
            pole_cd: [grid.pole_cd(0.0), grid.pole_cd(180.0)],
            by_gamma_cd: (0..rows * planes)
                .map(|i| grid.intensity_cd()[i % planes * rows + i / planes])
                .collect(),
        }
    }

    fn at(&self, grid: &IntensityDistribution, c_deg: f64, gamma_deg: f64) -> f64 {
        let mut value = [0.0];
        self.around(grid, c_deg, gamma_deg, &mut value);
        value[0]
    }

    /// The interpolant at γ and at C, C + 360°/n, … for all `n` of `values`.
    fn around(&self, grid: &IntensityDistribution, c_deg: f64, gamma_deg: f64, values: &mut [f64]) {
        let pole = (gamma_deg < 1e-9)
            .then_some(0)
            .or((gamma_deg > 180.0 - 1e-9).then_some(1));
        if let Some(pole) = pole.filter(|_| !grid.is_rotational()) {
            return values.fill(self.pole_cd[pole]);
        }
        let step_deg = 360.0 / values.len() as f64;
        let (Some(even), Some(c_step)) = (&self.gamma, self.c_step_deg) else {
            for (k, value) in values.iter_mut().enumerate() {
                *value = grid.intensity_cd_at(c_deg + step_deg * k as f64, gamma_deg);
            }
            return;
        };
        let gamma = grid.gamma_deg();
        if gamma_deg < gamma[0] || gamma_deg > gamma[gamma.len() - 1] {
            return values.fill(0.0);
        }
        let (cell, v) = even.cell(gamma_deg - gamma[0]);
        let planes = grid.c_deg().len();
        let (low, high) = self.by_gamma_cd[cell * planes..(cell + 2) * planes].split_at(planes);
        let along = |plane: usize| low[plane] + v * (high[plane] - low[plane]);
        if grid.is_rotational() {
            return values.fill(along(0));
        }
        let mut turn = c_deg.rem_euclid(360.0) / c_step;
        let by = step_deg / c_step;
        for value in values {
            let before = turn as usize;
            let (before, turned) = if before < planes {
                (before, turn)
            } else {
                (before - planes, turn - planes as f64)
            };
            let first = along(before);
            let next = if before + 1 < planes { before + 1 } else { 0 };
            *value = first + (turned - before as f64) * (along(next) - first);
            turn = turned + by;
        }
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
        for how in [Interpolation::Linear, Interpolation::Smooth] {
            let luminaire = Luminaire::interpolated(distribution.clone(), how, Emitter::Point {}, Spectral::None);
            let grid = how.grid_of(&distribution, &not_known);
            for i in 0..1900 {
                let gamma = i as f64 * 0.0501;
                let (quick, slow) = (luminaire.intensity_cd(0.0, gamma), grid.intensity_cd_at(0.0, gamma));
                assert!((quick - slow).abs() < 1e-9, "{how:?} {gamma}: {quick} {slow}");
            }
        }
    }

    #[test]
    fn the_quick_lookup_around_c_is_the_interpolant() {
        let gamma: Vec<f64> = (0..=36).map(|i| 5.0 * i as f64).collect();
        let c: Vec<f64> = (0..24).map(|k| 15.0 * k as f64).collect();
        let intensity: Vec<f64> = (0..24 * 37).map(|i| f64::from(i * 7919 % 1000)).collect();
        let distribution = IntensityDistribution::new(c, gamma, intensity).unwrap();
        for how in [Interpolation::Linear, Interpolation::Smooth] {
            let luminaire = Luminaire::interpolated(distribution.clone(), how, Emitter::Point {}, Spectral::None);
            let grid = how.grid_of(&distribution, &not_known);
            for i in 0..4000 {
                let (c, gamma) = (i as f64 * 0.37 - 360.0, 0.01 + i as f64 * 0.0449);
                let (quick, slow) = (luminaire.intensity_cd(c, gamma), grid.intensity_cd_at(c, gamma));
                assert!((quick - slow).abs() < 1e-6, "{how:?} {c} {gamma}: {quick} {slow}");
            }
        }
    }
}
