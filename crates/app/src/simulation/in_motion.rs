//! The light of a scan in motion while it goes on: by the half-planes that were swept, and splines between them.

use isolux_photometry::IntensityDistribution;
use isolux_record::Run;
use isolux_record::plan::Block;
use isolux_reduce::{Sample, in_motion_so_far};
use isolux_scan::{Chosen, Known};

use crate::Failure;
use crate::simulation::light_so_far::LightSoFar;

/// The block that is swept: that of the last sweep.
pub(crate) fn block(record: &Run) -> Option<&Block> {
    let name = &record.sweeps.last()?.of.block;
    let mut blocks = record.header.plan.blocks().iter();
    blocks.find(|block| block.name == *name)
}

/// The light by all sweeps so far; none where nothing says what is uncertain between the half-planes.
pub(crate) fn light_so_far(record: &Run) -> Result<Option<LightSoFar>, Failure> {
    let Some(block) = block(record) else {
        return Ok(None);
    };
    let sweeps = record.sweeps.iter().filter(|sweep| sweep.of.block == block.name);
    let Some(known) = Chosen::of(block, sweeps).known(block) else {
        return Ok(None);
    };
    let samples = in_motion_so_far(record, &block.name).map_err(Failure::bad_input)?;
    light(record, block, &known, u_of_strongest_rel(&samples)).map(Some)
}

/// Standard uncertainty of the strongest direction that was swept, relative.
pub(crate) fn u_of_strongest_rel(samples: &[Sample]) -> f64 {
    let strongest = samples.iter().max_by(|a, b| a.intensity_cd.total_cmp(&b.intensity_cd));
    strongest.map_or(0.0, |sample| sample.u_own_cd() / sample.intensity_cd)
}

/// The light by what is known; the other one is as much more between the half-planes as a spline may miss, as if it
/// erred alike everywhere.
pub(crate) fn light(record: &Run, block: &Block, known: &Known, u_reading_rel: f64) -> Result<LightSoFar, Failure> {
    let planned = block.half_planes_deg(&block.c_deg);
    let distance_mm = record.sweeps.last().map_or(0.0, |sweep| sweep.of.distance_mm);
    let cd_per_lx = (distance_mm * 1e-3).powi(2);
    let cells: Vec<(f64, f64)> = planned.iter().flat_map(|c| known.at(*c)).collect();
    let distribution = |u: f64| {
        let cd = cells.iter().map(|(lux, u_lx)| cd_per_lx * (lux + u * u_lx)).collect();
        IntensityDistribution::new(planned.clone(), known.gamma_deg.clone(), cd).map_err(Failure::bad_input)
    };
    Ok(LightSoFar {
        best: distribution(0.0)?,
        other: Some(distribution(1.0)?),
        divisor: 1.0,
        u_reading_rel,
        half_planes: [known.read_c_deg.len(), planned.len()],
    })
}
