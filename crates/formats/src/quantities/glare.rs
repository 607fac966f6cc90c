//! The UGR table of CIE 117 and CIE 190: standard rooms, luminaires spaced a quarter of the mounting height.
//!
//! Lengths are in units of H, the height of the luminaires above the eye. The room between the luminaires and the eye
//! is solved for its inter-reflected light with three surfaces (ceiling, walls, floor cavity); the direct light on the
//! floor follows from the direct shares. The position index is Guth's formula within the range of the published table.
//!
//! Compared with what we did not write (`tests/peers/glare.py`): the uncorrected table that CIE 190 gives for its
//! worked example at spacing 1 H is met within 0.3, Relux on eleven luminaires within 0.4, DIALux on the same within
//! 1.0.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::luminous_body::{Body, extents_mm};
use super::utilisation::direct_shares;
use crate::distribution::Distribution;
use crate::eulumdat::document::ROOM_INDICES;

/// X (across the line of sight) and Y (along it) in H.
const ROOMS: [[f64; 2]; 19] = [
    [2.0, 2.0],
    [2.0, 3.0],
    [2.0, 4.0],
    [2.0, 6.0],
    [2.0, 8.0],
    [2.0, 12.0],
    [4.0, 2.0],
    [4.0, 3.0],
    [4.0, 4.0],
    [4.0, 6.0],
    [4.0, 8.0],
    [4.0, 12.0],
    [8.0, 4.0],
    [8.0, 6.0],
    [8.0, 8.0],
    [8.0, 12.0],
    [12.0, 4.0],
    [12.0, 6.0],
    [12.0, 8.0],
];

/// Ceiling, walls, floor cavity in %.
const REFLECTANCES: [[f64; 3]; 5] = [
    [70.0, 50.0, 20.0],
    [70.0, 30.0, 20.0],
    [50.0, 50.0, 20.0],
    [50.0, 30.0, 20.0],
    [30.0, 30.0, 20.0],
];

/// CIE 117, 4.5: luminaires seen flatter than this do not count.
const LARGEST_GAMMA_DEG: f64 = 85.0;

/// Spacing over H.
const SPACING: f64 = 0.25;

/// A luminous opening longer along C0 than along C90 by more than this is one that lies along C0.
const LONGER: f64 = 1.1;

/// UGR of the standard rooms for the luminaire's own flux. Crosswise and endwise are those of the luminaire (CIE 117):
/// it lies along C90–C270, as in EULUMDAT, unless its opening is longer along C0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GlareTable {
    /// Spacing of the luminaires over their height above the eye.
    pub spacing_over_height: f64,
    /// Reflectances of ceiling, walls and floor cavity: a column each.
    pub reflectance_percent: [[f64; 3]; 5],
    /// Sides of the rooms across and along the line of sight in H, the height of the luminaires above the eye: a row
    /// each.
    pub room_h: [[f64; 2]; 19],
    /// Seen across the luminaire, by room and reflectances.
    pub crosswise: Vec<Vec<Option<f64>>>,
    /// Seen along it.
    pub endwise: Vec<Vec<Option<f64>>>,
}

/// The table; none without a luminous area or without downward light.
pub(super) fn table(distribution: &Distribution) -> Option<GlareTable> {
    let source = Source::new(distribution)?;
    let [x, y] = extents_mm(&distribution.luminaire);
    let lies_along_c0 = x > LONGER * y;
    let view = |endwise: bool| -> Vec<Vec<Option<f64>>> {
        let along_c90 = endwise != lies_along_c0;
        ROOMS.iter().map(|&room| source.row(room, along_c90)).collect()
    };
    Some(GlareTable {
        spacing_over_height: SPACING,
        reflectance_percent: REFLECTANCES,
        room_h: ROOMS,
        crosswise: view(false),
        endwise: view(true),
    })
}

struct Source<'d> {
    distribution: &'d Distribution,
    body: Body,
    down_lm: f64,
    up_lm: f64,
    ratios: [f64; 10],
}

impl<'d> Source<'d> {
    fn new(distribution: &'d Distribution) -> Option<Self> {
        let grid = &distribution.intensity;
        Some(Self {
            distribution,
            body: Body::of(&distribution.luminaire)?,
            down_lm: grid.flux_between_lm(0.0, 90.0),
            up_lm: grid.flux_between_lm(90.0, 180.0),
            ratios: direct_shares(grid)?,
        })
    }

    /// One value a set of reflectances, for a room of X × Y.
    fn row(&self, [x, y]: [f64; 2], along_c90: bool) -> Vec<Option<f64>> {
        let glare = self.glare(x, y, along_c90);
        REFLECTANCES
            .iter()
            .map(|reflectance| {
                let background = self.background(x, y, reflectance.map(|percent| percent / 100.0));
                let ugr = 8.0 * (0.25 / background * glare).log10();
                ugr.is_finite().then(|| (ugr * 10.0).round() / 10.0)
            })
            .collect()
    }

    /// Σ L²·ω/p² over the luminaires ahead, times H² in m (it cancels against the background's 1/H²).
    fn glare(&self, x: f64, y: f64, along_c90: bool) -> f64 {
        let mut sum = 0.0;
        let (across, along) = ((x / SPACING).round() as usize, (y / SPACING).round() as usize);
        for i in 0..across {
            let t = (i as f64 + 0.5) * SPACING - x / 2.0;
            for j in 0..along {
                let r = (j as f64 + 0.5) * SPACING;
                let distance = (t * t + r * r + 1.0).sqrt();
                let gamma = (1.0 / distance).acos().to_degrees();
                if !in_view(t, r) || gamma > LARGEST_GAMMA_DEG {
                    continue;
                }
                // From the luminaire to the eye: back along the line of sight and sideways.
                let (view, side) = (-r, -t);
                let c = if along_c90 { view.atan2(-side) } else { side.atan2(view) };
                let c = c.to_degrees().rem_euclid(360.0);
                let intensity = self.distribution.intensity.intensity_cd_at(c, gamma);
                let projected = self.body.projected_m2(c, gamma);
                if intensity > 0.0 && projected > 0.0 {
                    let p = position_index(t, r);
                    sum += intensity * intensity / (projected * distance * distance * p * p);
                }
            }
        }
        sum
    }

    /// Background luminance in cd/m², times H²: indirect illuminance of the walls over π.
    fn background(&self, x: f64, y: f64, [ceiling, walls, floor]: [f64; 3]) -> f64 {
        let luminaires = (x / SPACING).round() * (y / SPACING).round();
        let room_index = x * y / (x + y);
        let direct = interpolate(&ROOM_INDICES, &self.ratios, room_index).clamp(0.0, 1.0);
        // Flux that first falls on ceiling, walls and floor.
        let first = [self.up_lm, self.down_lm * (1.0 - direct), self.down_lm * direct].map(|flux| flux * luminaires);
        let (plane, wall) = (x * y, 2.0 * (x + y));
        let between = parallel_factor(x, y);
        let to_wall = 1.0 - between;
        let from_wall = to_wall * plane / wall;
        let exchange = [
            [0.0, to_wall, between],
            [from_wall, 1.0 - 2.0 * from_wall, from_wall],
            [between, to_wall, 0.0],
        ];
        let reflectance = [ceiling, walls, floor];
        // Flux that leaves each surface after every reflection: b = ρ·(first + Fᵀ·b), summed until it is still.
        let mut leaving = [0.0; 3];
        for _ in 0..200 {
            leaving = std::array::from_fn(|to| {
                let arriving: f64 = (0..3).map(|from| leaving[from] * exchange[from][to]).sum();
                reflectance[to] * (first[to] + arriving)
            });
        }
        let indirect: f64 = (0..3).map(|from| leaving[from] * exchange[from][1]).sum();
        indirect / wall / PI
    }
}

/// Whether CIE 117's table of position indices has a value there: T/R up to 3, H/R up to 1.9 (1.8 below T/R = 0.9, 1.7
/// below 0.4). What stands farther to the side or higher up is out of sight.
fn in_view(t: f64, r: f64) -> bool {
    let sideways = t.abs() / r;
    let highest = match sideways {
        sideways if sideways < 0.4 => 1.7,
        sideways if sideways < 0.9 => 1.8,
        _ => 1.9,
    };
    sideways <= 3.0 && 1.0 / r <= highest
}

/// Guth's position index for a source at T = `t` sideways, R = `r` ahead and H = 1 up.
fn position_index(t: f64, r: f64) -> f64 {
    let sigma = (t * t + 1.0).sqrt().atan2(r).to_degrees();
    let tau = t.abs().atan2(1.0).to_degrees();
    let linear = (35.2 - 0.31889 * tau - 1.22 * (-2.0 * tau / 9.0).exp()) * 1e-3 * sigma;
    let square = (21.0 + 0.26667 * tau - 0.002963 * tau * tau) * 1e-5 * sigma * sigma;
    (linear + square).exp()
}

/// View factor between the two opposite x × y faces of a box of height 1.
fn parallel_factor(x: f64, y: f64) -> f64 {
    let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let logarithm = (a * a * b * b / (1.0 + x * x + y * y)).sqrt().ln();
    2.0 / (PI * x * y) * (logarithm + x * b * (x / b).atan() + y * a * (y / a).atan() - x * x.atan() - y * y.atan())
}

fn interpolate(grid: &[f64; 10], values: &[f64; 10], x: f64) -> f64 {
    let at = grid.partition_point(|&k| k <= x).clamp(1, 9) - 1;
    let fraction = ((x - grid[at]) / (grid[at + 1] - grid[at])).clamp(0.0, 1.0);
    values[at] * (1.0 - fraction) + values[at + 1] * fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::luminaire::Luminaire;
    use isolux_photometry::{IntensityDistribution, Symmetry};

    #[test]
    fn view_factor_of_a_cube_and_position_index_ahead() {
        // Opposite faces of a cube: 0.1998 (published tables of view factors).
        assert!((parallel_factor(1.0, 1.0) - 0.199_825).abs() < 1e-5);
        // CIE 117, table of position indices: T/R = 0, H/R = 0.1 … 1.
        for (height_over_r, published) in [(0.1, 1.26), (0.5, 2.86), (1.0, 7.0)] {
            let p = position_index(0.0, 1.0 / height_over_r);
            assert!(
                (p / published - 1.0).abs() < 0.06,
                "H/R {height_over_r}: {p} for {published}"
            );
        }
    }

    /// 4000 lm, I ∝ cosⁿ γ every 5°, luminous opening in mm (width 0: round).
    fn lamp(power: i32, length: f64, width: f64, height: f64) -> Distribution {
        let gamma_deg: Vec<f64> = (0..37).map(|i| f64::from(i) * 5.0).collect();
        let on_axis = 4000.0 * f64::from(power + 1) / (2.0 * PI);
        let candela = gamma_deg
            .iter()
            .map(|gamma| on_axis * gamma.to_radians().cos().max(0.0).powi(power))
            .collect();
        Distribution {
            intensity: IntensityDistribution::new(vec![0.0], gamma_deg, candela).unwrap(),
            symmetry: Symmetry::Rotational,
            lamp_flux_lm: Some(4000.0),
            absolute: true,
            native: None,
            luminaire: Luminaire {
                luminous_length_mm: Some(length),
                luminous_width_mm: Some(width),
                luminous_height_mm: [Some(height); 4],
                ..Luminaire::default()
            },
            header: serde_json::Map::new(),
            eulumdat: None,
        }
    }

    #[test]
    fn tables_are_those_of_another_program() {
        // eulumdat-ugr 1.0.1 (MIT; CIE 190 with the published tables), crosswise and endwise, rooms 2H × 2H, 4H × 8H
        // and 12H × 8H, reflectances 70/50/20 and 30/30/20. Its position indices are the table's, ours Guth's formula:
        // up to 0.3.
        let published = [
            (
                lamp(1, 600.0, 600.0, 0.0),
                [[16.83, 19.14], [21.91, 23.73], [22.77, 24.43]],
            ),
            (
                lamp(20, 600.0, 600.0, 0.0),
                [[-1.17, 0.33], [-2.06, -0.73], [-2.33, -1.01]],
            ),
            (
                lamp(1, 200.0, 0.0, 80.0),
                [[23.35, 25.67], [27.16, 28.98], [27.72, 29.38]],
            ),
            (
                lamp(3, 1200.0, 200.0, 0.0),
                [[16.19, 18.17], [16.66, 18.22], [16.53, 18.01]],
            ),
        ];
        for (which, (lamp, rooms)) in published.iter().enumerate() {
            let table = table(lamp).unwrap();
            for (room, expected) in [0, 10, 18].into_iter().zip(rooms) {
                for view in [&table.crosswise, &table.endwise] {
                    for (column, expected) in [0, 4].into_iter().zip(expected) {
                        let found = view[room][column].unwrap();
                        assert!(
                            (found - expected).abs() < 0.4,
                            "lamp {which}, room {room}: {found} for {expected}"
                        );
                    }
                }
            }
        }
    }
}
