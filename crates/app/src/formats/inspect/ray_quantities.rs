//! What follows from the rays of a TM-25 file.

use glam::DVec3;
use isolux_formats::tm25::{Header, Spectral, Survey};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The quantities of a ray file, in the frame of its header.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RayQuantities {
    /// Rays that are there.
    pub rays: u64,
    /// Rays by the header.
    pub rays_stated: u64,
    /// Luminous flux that they carry.
    pub luminous_flux_lm: Option<f64>,
    /// Radiant flux that they carry.
    pub radiant_flux_w: Option<f64>,
    /// The same by the header.
    pub luminous_flux_stated_lm: Option<f64>,
    /// The same by the header.
    pub radiant_flux_stated_w: Option<f64>,
    /// What is known of each ray.
    pub columns: Vec<String>,
    /// How spectra are given, in a word.
    pub spectral: String,
    /// Shortest and longest wavelength.
    pub wavelength_nm: Option<[f64; 2]>,
    /// Spectra in the header.
    pub spectra: usize,
    /// Smallest coordinates of the places where rays begin.
    pub bounds_min_mm: Option<[f64; 3]>,
    /// The largest.
    pub bounds_max_mm: Option<[f64; 3]>,
    /// Their mean, weighted by flux.
    pub centroid_mm: Option<[f64; 3]>,
    /// Mean direction, weighted by flux; its length is 1 where all rays are parallel.
    pub mean_direction: Option<[f64; 3]>,
    /// C of it.
    pub mean_direction_c_deg: Option<f64>,
    /// γ of it.
    pub mean_direction_gamma_deg: Option<f64>,
    /// γ within which half the flux lies.
    pub half_flux_gamma_deg: Option<f64>,
    /// Share of the flux in zones of 10° of γ.
    pub zonal_flux_share: [f64; 18],
    /// When the file was made, as it says.
    pub created: String,
    /// Whether the rays were measured, not simulated.
    pub measured: bool,
    /// The light source, as the header names it.
    pub light_source: String,
    /// Its manufacturer.
    pub manufacturer: String,
    /// Who made the file.
    pub file_by: String,
}

impl RayQuantities {
    /// Of a ray file with this header and these rays.
    pub(super) fn of(header: &Header, survey: &Survey) -> Self {
        let point = |at: Option<DVec3>| at.map(|at| at.to_array());
        let bounds = |k: usize| point(survey.bounds_mm.map(|bounds| bounds[k]));
        let angles = survey.mean_direction.filter(|mean| mean.length() > 1e-9).map(|mean| {
            let c_deg = mean.y.atan2(mean.x).to_degrees().rem_euclid(360.0);
            (c_deg, mean.x.hypot(mean.y).atan2(mean.z).to_degrees())
        });
        let columns = &header.columns;
        let mut names = vec!["place", "direction"];
        for (present, name) in [
            (columns.radiant, "radiant flux"),
            (columns.wavelength, "wavelength"),
            (columns.luminous, "luminous flux"),
            (columns.stokes, "polarisation"),
            (columns.tristimulus, "tristimulus"),
            (columns.spectrum, "spectrum index"),
        ] {
            names.extend(present.then_some(name));
        }
        let names = names.into_iter().map(str::to_owned).chain(header.names.iter().cloned());
        let names = names.collect();
        let single = match header.spectral {
            Spectral::Single(nm) => Some([nm; 2]),
            _ => None,
        };
        let range = single.or(survey.wavelength_nm).or_else(|| {
            let points = header.tables.iter().flat_map(|table| &table.wavelength_nm).copied();
            let [low, high] = [f64::min, f64::max].map(|pick| points.clone().reduce(pick));
            Some([low?, high?])
        });
        let [light_source, manufacturer, _, file_by, ..] = header.texts.clone();
        Self {
            rays: survey.rays,
            rays_stated: header.rays,
            luminous_flux_lm: survey.luminous_lm,
            radiant_flux_w: survey.radiant_w,
            luminous_flux_stated_lm: header.luminous_flux_lm,
            radiant_flux_stated_w: header.radiant_flux_w,
            columns: names,
            spectral: header.spectral.word().to_owned(),
            wavelength_nm: range,
            spectra: header.tables.len(),
            bounds_min_mm: bounds(0),
            bounds_max_mm: bounds(1),
            centroid_mm: point(survey.centroid_mm),
            mean_direction: point(survey.mean_direction),
            mean_direction_c_deg: angles.map(|angles| angles.0),
            mean_direction_gamma_deg: angles.map(|angles| angles.1),
            half_flux_gamma_deg: survey.half_flux_gamma_deg,
            zonal_flux_share: survey.zones,
            created: header.created.clone(),
            measured: header.method == 1,
            light_source,
            manufacturer,
            file_by,
        }
    }
}
