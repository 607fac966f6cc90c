//! The light of a lamp whose colour depends on the direction, over a sensor.

use isolux_model::ColourOverAngle;
use isolux_photometry::angles_deg;

use super::mesh::Mesh;
use super::{Station, cosine};
use crate::sensor::Sensor;

/// What each of the measured spectra gives for one lumen, and how they mix at every place of a sensor.
///
/// What a spectrum keeps behind plates and vapour depends smoothly on incidence and path: on a mesh it is computed,
/// between it is interpolated. How the spectra mix bends at every measured γ, and is computed for each place.
pub(super) struct Mixture<'a> {
    kept: Vec<Kept>,
    /// None of a lamp of one colour.
    colour: Option<&'a ColourOverAngle>,
}

enum Kept {
    /// Nothing stands in the path.
    Everywhere(f64),
    Over(Mesh),
}

impl<'a> Mixture<'a> {
    /// Of one spectrum, the same in every direction.
    pub fn of_one(mesh: Mesh) -> Self {
        Self {
            kept: vec![Kept::Over(mesh)],
            colour: None,
        }
    }

    /// Of a lamp: `scale` times what a lumen of each spectrum gives behind the parts of `station`, each wavelength in
    /// nm weighted.
    pub fn of_lamp(
        station: &Station,
        colour: &'a ColourOverAngle,
        sensor: &Sensor,
        scale: f64,
        weight: &dyn Fn(f64) -> f64,
    ) -> Self {
        let of = |per_nm: &[f64; super::TABLE]| {
            if station.is_clear() {
                return Kept::Everywhere(scale * station.kept(per_nm, 1.0, 1.0, weight));
            }
            Kept::Over(Mesh::new(sensor, |place| {
                scale * station.kept(per_nm, cosine(sensor, place), place.length(), weight)
            }))
        };
        Self {
            kept: colour.per_lumen().iter().map(of).collect(),
            colour: Some(colour),
        }
    }

    /// The value at (x, y) in pixels.
    pub fn at(&self, sensor: &Sensor, x: f64, y: f64) -> f64 {
        let of = |index: usize| match &self.kept[index] {
            Kept::Everywhere(value) => *value,
            Kept::Over(mesh) => mesh.at(x, y),
        };
        let Some(colour) = self.colour else {
            return of(0);
        };
        let (c_deg, gamma_deg) = angles_deg(sensor.point(x, y));
        let mut sum = 0.0;
        colour.each_weight(c_deg, gamma_deg, |index, weight| {
            if weight != 0.0 {
                sum += weight * of(index);
            }
        });
        sum
    }
}
