//! The lamp as it is seen from far away, tabulated over the sphere: what lights a floor a metre below need not be
//! added up LED by LED for each of its patches at each reading.

use glam::DVec3;

use crate::illuminator::{Illuminator, Ray};

/// Luminous intensity over the sphere: one table for each hemisphere, on an even grid of u = x/s and v = y/s with s =
/// |x| + |y| + |z|. A table reaches past its own hemisphere, so that no cell lacks a corner.
#[derive(Debug, Clone)]
pub struct FarField {
    intensity_cd: [Vec<f64>; 2],
}

/// Cells from the axis to the horizon: about a degree each.
const CELLS: usize = 64;
/// Nodes along a side of a table.
const SIDE: usize = 2 * CELLS + 1;

impl FarField {
    /// The far field of `lamp`, without losses in the air.
    pub fn new(lamp: &Illuminator) -> Self {
        let node = |k: usize| k as f64 / CELLS as f64 - 1.0;
        let table = |side: f64| {
            let mut intensity_cd = Vec::with_capacity(SIDE * SIDE);
            for row in 0..SIDE {
                for column in 0..SIDE {
                    let (u, v) = (node(column), node(row));
                    let direction = DVec3::new(u, v, side * (1.0 - u.abs() - v.abs())).normalize_or_zero();
                    intensity_cd.push(lamp.far_field_cd(direction));
                }
            }
            intensity_cd
        };
        Self {
            intensity_cd: [table(1.0), table(-1.0)],
        }
    }

    /// Luminous intensity towards the unit vector `direction`, cd.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        let table = &self.intensity_cd[usize::from(direction.z < 0.0)];
        let sum = direction.x.abs() + direction.y.abs() + direction.z.abs();
        let place = |along: f64| {
            let place = (along / sum + 1.0) * CELLS as f64;
            let cell = (place as usize).min(SIDE - 2);
            (cell, place - cell as f64)
        };
        let ((column, right), (row, down)) = (place(direction.x), place(direction.y));
        let at = |row: usize| {
            let (left, next) = (table[row * SIDE + column], table[row * SIDE + column + 1]);
            left + right * (next - left)
        };
        at(row) + down * (at(row + 1) - at(row))
    }

    /// The lamp's light on its way from the light centre to `point_mm` (luminaire frame); the air takes
    /// `absorption_per_mm`.
    pub fn ray_to(&self, point_mm: DVec3, absorption_per_mm: f64) -> Ray {
        let distance_mm = point_mm.length();
        let direction = point_mm / distance_mm;
        Ray {
            direction,
            distance_mm,
            intensity_cd: self.intensity_cd(direction) * (-absorption_per_mm * distance_mm).exp(),
            // The meter that sees the floor weighs light by V(λ): its colour is not asked for.
            phosphor: 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;

    #[test]
    fn the_table_is_the_lamp_in_every_direction() {
        let mut room = Darkroom::default();
        room.lamp.aim_deg = 20.0;
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, room.seed);
        let (far, peak) = (FarField::new(&lamp), lamp.far_field_cd(DVec3::Z));
        for k in 0..5000 {
            let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / 5000.0;
            let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
            let direction = DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
            let (got, expected) = (far.intensity_cd(direction), lamp.far_field_cd(direction));
            assert!(
                (got - expected).abs() < 1e-3 * peak,
                "{direction}: {got} against {expected}"
            );
        }
    }
}
