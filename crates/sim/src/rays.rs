//! Rays from the emitter to the sensor as a file, for pictures and other programs.

use glam::DVec3;
use isolux_formats::tm25;
use isolux_model::{Scene, Spectral};
use serde::Serialize;

use crate::direct::{self, DirectError, Hit};
use crate::random::{Purpose, Random};
use crate::simulation::Simulation;

/// `isolux-rays/1`: rays that reach the sensor, in the luminaire frame.
#[derive(Debug, Clone, Serialize)]
pub struct RayFile {
    format: &'static str,
    unit: &'static str,
    seed: u64,
    rays: Vec<RayRow>,
}

/// One ray.
#[derive(Debug, Clone, Serialize)]
pub struct RayRow {
    /// Where it leaves, mm.
    pub origin_mm: [f64; 3],
    /// Where it meets the sensor, mm.
    pub end_mm: [f64; 3],
    /// Pixel along x and y.
    pub pixel: [usize; 2],
    /// Drawn from the spectrum by energy; null without one.
    pub wavelength_nm: Option<f64>,
}

/// `wanted` rays of a thinned run, with wavelengths drawn from the model's spectrum.
///
/// # Errors
/// Exit 2 when the source is dark.
pub fn rows(scene: &Scene, simulation: &Simulation, wanted: usize, seed: u64) -> Result<Vec<RayRow>, DirectError> {
    let hits = direct::hits(&simulation.setup.source, &simulation.setup.sensor, wanted, seed)?;
    let drawn = wavelengths(scene, hits.len(), seed);
    Ok(hits
        .iter()
        .enumerate()
        .map(|(index, hit)| row(hit, drawn.as_ref().map(|drawn| drawn[index])))
        .collect())
}

/// The rays as `isolux-rays/1`.
///
/// # Errors
/// As [`rows`].
pub fn file(scene: &Scene, simulation: &Simulation, wanted: usize) -> Result<RayFile, DirectError> {
    let seed = simulation.facts.seed.unwrap_or(1);
    Ok(RayFile {
        format: "isolux-rays/1",
        unit: "mm",
        seed,
        rays: rows(scene, simulation, wanted, seed)?,
    })
}

/// The same rays as IES TM-25: each carries the same share of what falls on the sensor, in W with a wavelength, else in
/// lm. `name` is that of the luminaire.
///
/// # Errors
/// As [`rows`].
pub fn tm25(scene: &Scene, simulation: &Simulation, wanted: usize, name: &str) -> Result<Vec<u8>, DirectError> {
    let rows = rows(scene, simulation, wanted, simulation.facts.seed.unwrap_or(1))?;
    // All rays together carry what falls on the sensor.
    let area_m2 = simulation.setup.sensor.pixel_area_m2() * simulation.setup.sensor.pixels() as f64;
    let ler = simulation.facts.ler_lm_per_w.unwrap_or(1.0);
    let flux_lm = simulation.facts.mean * ler * area_m2;
    let each = flux_lm / rows.len().max(1) as f64;
    // A ray with a wavelength carries watts: wavelengths are drawn by energy, so that all carry the same.
    let each_w = scene.model.ler_lm_per_w().map(|ler| each / ler);
    let rays = rows
        .iter()
        .map(|row| {
            let origin_mm = DVec3::from_array(row.origin_mm);
            let direction = (DVec3::from_array(row.end_mm) - origin_mm).normalize_or(DVec3::Z);
            let wavelength_nm = row.wavelength_nm.filter(|_| each_w.is_some());
            tm25::Ray {
                origin_mm,
                direction,
                radiant_w: each_w.filter(|_| wavelength_nm.is_some()),
                luminous_lm: if wavelength_nm.is_none() { Some(each) } else { None },
                wavelength_nm,
            }
        })
        .collect();
    let set = tm25::RaySet {
        rays,
        luminous_flux_lm: Some(flux_lm),
        radiant_flux_w: scene.model.ler_lm_per_w().map(|ler| flux_lm / ler),
    };
    // A fixed time: the same run gives the same bytes.
    Ok(tm25::write(&set, "2013-09-04T08:30:29+01:00", name))
}

fn row(hit: &Hit, wavelength_nm: Option<f64>) -> RayRow {
    RayRow {
        origin_mm: hit.ray.origin.to_array(),
        end_mm: hit.end.to_array(),
        pixel: hit.pixel,
        wavelength_nm,
    }
}

/// Wavelengths by inversion of the running sum of the spectrum at 1 nm.
fn wavelengths(scene: &Scene, count: usize, seed: u64) -> Option<Vec<f64>> {
    let Spectral::Spectrum(spectrum) = scene.model.luminaire().spectral() else {
        return None;
    };
    let mut running = 0.0;
    let sums: Vec<f64> = spectrum
        .per_nm()
        .into_iter()
        .map(|value| {
            running += value.max(0.0);
            running
        })
        .collect();
    if running <= 0.0 {
        return None;
    }
    let random = Random::new(seed, Purpose::Trial);
    let draw = |index: usize| {
        let mut sequence = random.sequence(index as u64);
        let aim = sequence.uniform() * running;
        let bin = sums.partition_point(|sum| *sum <= aim).min(sums.len() - 1);
        360.0 + bin as f64 + sequence.uniform() - 0.5
    };
    Some((0..count).map(draw).collect())
}
