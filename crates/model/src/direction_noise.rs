//! What the noise of the distribution's own directions does to predictions: one reading made each direction, and
//! whoever looks there again meets the same error again.

use std::collections::BTreeMap;

use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, ReadingCoordinates};

use crate::model::Model;
use crate::prepared::PreparedModel;

/// What one direction of the distribution, wrong by one standard uncertainty, does to predictions. Directions are
/// independent of each other.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionError {
    /// Its number in the distribution, `[ic * ng + ig]`; the first half-plane's at a pole.
    pub direction: usize,
    /// Numbers of the predictions that it changes, each with how much, in its own unit.
    pub errors: Vec<(usize, f64)>,
}

/// Shares below this of a direction's uncertainty do not matter.
const NEGLIGIBLE: f64 = 1e-3;

impl Model {
    /// Errors of the readings that come from the noise of single directions of the distribution, where the model states
    /// it (`luminaire.u.direction_rel`, `direction_cd`); empty where it does not.
    pub fn direction_errors_of_readings(&self, readings: &[ReadingCoordinates]) -> Vec<DirectionError> {
        self.direction_errors(|prepared, u_cd| {
            let places = self.detector_places(readings);
            let lamp: Vec<f64> = readings.iter().map(|at| self.lamp_factor(at.lamp_age_s())).collect();
            let mut errors = Errors::default();
            for (number, ((at, (point_mm, facing)), lamp)) in readings.iter().zip(places).zip(lamp).enumerate() {
                if at.kind == ReadingKind::Lit {
                    prepared.shares(point_mm, facing, |direction, lx_per_cd| {
                        errors.add(direction, number, lx_per_cd * lamp * u_cd(direction));
                    });
                }
            }
            errors
        })
    }

    /// The same of the cells of maps, in their unit.
    pub fn direction_errors_of_maps(&self, maps: &MapSet) -> Vec<DirectionError> {
        self.direction_errors(|prepared, u_cd| {
            let mut errors = Errors::default();
            for (number, place) in self.cell_places(maps).into_iter().enumerate() {
                if let Some((point_mm, facing, unit_per_lx)) = place {
                    prepared.shares(point_mm, facing, |direction, lx_per_cd| {
                        errors.add(direction, number, lx_per_cd * unit_per_lx * u_cd(direction));
                    });
                }
            }
            errors
        })
    }

    fn direction_errors(
        &self,
        collect: impl FnOnce(&PreparedModel<'_>, &dyn Fn(usize) -> f64) -> Errors,
    ) -> Vec<DirectionError> {
        let Some(u) = self.uncertainty().filter(|u| u.of_direction_cd(1.0) > 0.0) else {
            return Vec::new();
        };
        let distribution = self.luminaire().distribution();
        let (planes, gammas) = (distribution.c_deg().len(), distribution.gamma_deg());
        let u_cd = |direction: usize| {
            let gamma = gammas[direction % gammas.len()];
            // At a pole every half-plane had a reading of its own.
            let readings = if gamma == 0.0 || gamma == 180.0 {
                planes as f64
            } else {
                1.0
            };
            u.of_direction_cd(distribution.intensity_cd()[direction]) / readings.sqrt()
        };
        collect(&PreparedModel::new(self), &u_cd).into_vec()
    }
}

/// Errors by direction, then by prediction.
#[derive(Default)]
struct Errors(BTreeMap<usize, BTreeMap<usize, f64>>);

impl Errors {
    fn add(&mut self, direction: usize, number: usize, error: f64) {
        *self.0.entry(direction).or_default().entry(number).or_default() += error;
    }

    fn into_vec(self) -> Vec<DirectionError> {
        let strong = |(direction, errors): (usize, BTreeMap<usize, f64>)| {
            let most = errors.values().fold(0.0_f64, |most, error| most.max(error.abs()));
            let errors = errors
                .into_iter()
                .filter(|(_, error)| error.abs() > NEGLIGIBLE * most)
                .collect();
            DirectionError { direction, errors }
        };
        self.0.into_iter().map(strong).collect()
    }
}
