//! What the sweeps of a scan say while it goes on.

use isolux_record::{Reading, Role, Run};

use crate::error::ReduceError;
use crate::samples::{Corrected, Sample, samples};
use crate::sweeps::as_readings;

/// The directions of a block that its sweeps so far give, by half-plane and γ, with the uncertainties that a reduction
/// gives them; the intensities are E·d², not corrected.
///
/// # Errors
/// [`ReduceError::Sweeps`] before a half-plane was swept both ways; else as [`reduce`](crate::reduce()).
pub fn in_motion_so_far(run: &Run, block: &str) -> Result<Vec<Sample>, ReduceError> {
    let at_rest = as_readings(run)?;
    let of_block = |row: &&Reading| row.block == block && row.role == Role::Point;
    let rows: Vec<&Reading> = at_rest.run.readings.rows.iter().filter(of_block).collect();
    samples(&rows, &at_rest.in_motion.of_curves, |row, lux| {
        let cd_per_lx = (row.distance_mm * 1e-3).powi(2);
        Corrected {
            intensity_cd: lux * cd_per_lx,
            cd_per_lx,
            c_deg: row.c_deg,
            gamma_deg: row.gamma_deg,
        }
    })
}
