//! The luminous flux of a part of the sphere, and its share of the whole.

use isolux_photometry::Sector;

use crate::budget;
use crate::error::ReduceError;
use crate::interpolation::{self, Kind};
use crate::{Quantity, Reduction};

/// Luminous flux of `sector` in lm; what the flux of the whole lacks is lacking in it.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn sector_flux(reduction: &Reduction, sector: &Sector) -> Result<Quantity, ReduceError> {
    let grid = &reduction.grid;
    let flux = budget::weighted_sum(grid, &grid.sector_weights_sr(sector), &reduction.common, "lm");
    let between = interpolation::u_of(&grid.distribution, Kind::Integral, |light| light.sector_flux_lm(sector))?;
    let whole = &reduction.flux;
    let over_c = whole.parts.get(OVER_C).map(|part| part / whole.value * flux.value);
    let flux = over_c.into_iter().fold(flux, |flux, part| flux.with_part(OVER_C, part));
    let missing = whole.missing.iter().cloned();
    Ok(flux.with_part("interpolation", between).lacking(missing))
}

/// Share of the luminous flux that lies in `sector`, in %. What is a factor of every intensity is no part of it.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn flux_share(reduction: &Reduction, sector: &Sector) -> Result<Quantity, ReduceError> {
    let grid = &reduction.grid;
    let of_sector = grid.sector_weights_sr(sector);
    let of_sphere = grid.flux_weights_sr();
    let sum = |weights: &[f64]| -> f64 {
        let pairs = weights.iter().zip(grid.distribution.intensity_cd());
        pairs.map(|(sr, cd)| sr * cd).sum()
    };
    let flux_lm = sum(&of_sphere);
    let share = sum(&of_sector) / flux_lm;
    // d(Φ_s/Φ) = Σ (w_s − share·w)·dI / Φ.
    let pairs = of_sector.iter().zip(&of_sphere);
    let slopes: Vec<f64> = pairs
        .map(|(part, whole)| 100.0 * (part - share * whole) / flux_lm)
        .collect();
    let moved = budget::weighted_sum(grid, &slopes, &reduction.common, "%");
    let between = interpolation::u_of(&grid.distribution, Kind::Integral, |light| {
        100.0 * light.sector_flux_lm(sector) / light.flux_lm()
    })?;
    let missing = reduction.flux.missing.iter().cloned();
    Ok(Quantity::new(100.0 * share, "%", moved.parts)
        .with_part("interpolation", between)
        .lacking(missing))
}

/// The part that half-planes chosen by the scan leave in a flux.
const OVER_C: &str = "interpolation_over_c";
