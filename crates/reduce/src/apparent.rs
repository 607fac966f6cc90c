//! The axis as it appears from the other distances of the run.

use isolux_record::{Quality, Reading, ReadingKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::background::{Background, Level, Subtract};

/// Intensity on the axis as it appears from a distance: equal at all of them where the inverse square law holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Apparent {
    /// Distance.
    pub distance_mm: f64,
    /// E·d².
    pub intensity_cd: f64,
    /// Its standard uncertainty without the common parts.
    pub u_cd: f64,
}

/// The distances other than `main_mm` at which the axis was read, rising; `factor` corrects the meter's
/// response there, by the distance.
pub fn other_distances(
    all: &[Reading],
    main_mm: f64,
    subtract: Subtract,
    factor: impl Fn(f64) -> f64,
) -> Vec<Apparent> {
    let mut on_axis: Vec<&Reading> = all
        .iter()
        .filter(|row| row.kind == ReadingKind::Lit && row.distance_mm != main_mm && row.gamma_target_deg == 0.0)
        .filter(|row| row.quality == Quality::Ok)
        .collect();
    on_axis.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
    on_axis
        .chunk_by(|a, b| a.distance_mm == b.distance_mm)
        .filter_map(|group| {
            let distance_mm = group[0].distance_mm;
            let background = Background::of(all, distance_mm);
            let level = Level::of(group.iter().copied())?;
            let per_lx = factor(distance_mm) * (distance_mm * 1e-3).powi(2);
            let (noise, digit) = background.u_lx(0.0, subtract);
            Some(Apparent {
                distance_mm,
                intensity_cd: (level.mean_lx - background.subtracted_lx(0.0, subtract)) * per_lx,
                u_cd: level.u_lx().hypot(noise).hypot(digit) * per_lx,
            })
        })
        .collect()
}
