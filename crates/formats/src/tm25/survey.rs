//! What a ray file holds, in one pass.

use std::io::Read;

use glam::DVec3;

use super::error::Tm25Error;
use super::reader::{Ray, Reader};

/// Rays with one kind of damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// How many.
    pub rays: u64,
    /// The first one, from 0.
    pub first: u64,
}

impl Damage {
    fn add(&mut self, index: u64) {
        if self.rays == 0 {
            self.first = index;
        }
        self.rays += 1;
    }
}

/// Facts of the rays of a file. Sums and means are over sound rays, weighted by flux (luminous where there is one).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// Rays that there are.
    pub rays: u64,
    /// Sum of the luminous fluxes, lm.
    pub luminous_lm: Option<f64>,
    /// Sum of the radiant fluxes, W.
    pub radiant_w: Option<f64>,
    /// Smallest and largest place, mm; none without a sound ray.
    pub bounds_mm: Option<[DVec3; 2]>,
    /// Mean place, mm.
    pub centroid_mm: Option<DVec3>,
    /// Sum of the directions over the flux: its length is 1 for one direction, 0 for all alike.
    pub mean_direction: Option<DVec3>,
    /// Share of the flux in each 10° of γ about +z.
    pub zones: [f64; 18],
    /// γ within which half of the flux leaves, by bins of 0.1°.
    pub half_flux_gamma_deg: Option<f64>,
    /// Shortest and longest wavelength, nm.
    pub wavelength_nm: Option<[f64; 2]>,
    /// Numbers that are none in place, direction or flux.
    pub not_finite: Damage,
    /// Direction (0, 0, 0).
    pub no_direction: Damage,
    /// Direction whose length differs from 1 by more than 1e-3.
    pub not_unit: Damage,
    /// Flux below zero.
    pub negative: Damage,
    /// A wavelength that is not above zero.
    pub no_wavelength: Damage,
}

const FINE: usize = 1800;

impl Survey {
    /// Reads all rays.
    ///
    /// # Errors
    /// [`Tm25Error::Io`].
    pub fn of<R: Read>(reader: &mut Reader<R>) -> Result<Self, Tm25Error> {
        let mut survey = Self::default();
        let columns = reader.header().columns;
        let (mut flux, mut luminous, mut radiant) = (0.0, 0.0, 0.0);
        let (mut place, mut direction) = (DVec3::ZERO, DVec3::ZERO);
        let mut fine = vec![0.0; FINE];
        while let Some(ray) = reader.next_ray()? {
            let index = survey.rays;
            survey.rays += 1;
            survey.damage(&ray, index);
            if !ray.is_sound() {
                continue;
            }
            let weight = ray.flux();
            let toward = ray.direction.normalize();
            flux += weight;
            luminous += ray.luminous_lm.unwrap_or(0.0);
            radiant += ray.radiant_w.unwrap_or(0.0);
            place += weight * ray.origin_mm;
            direction += weight * toward;
            let [low, high] = survey.bounds_mm.unwrap_or([ray.origin_mm; 2]);
            survey.bounds_mm = Some([low.min(ray.origin_mm), high.max(ray.origin_mm)]);
            let gamma_deg = toward.x.hypot(toward.y).atan2(toward.z).to_degrees();
            fine[((gamma_deg * 10.0) as usize).min(FINE - 1)] += weight;
        }
        survey.luminous_lm = columns.luminous.then_some(luminous);
        survey.radiant_w = columns.radiant.then_some(radiant);
        if flux > 0.0 {
            survey.centroid_mm = Some(place / flux);
            survey.mean_direction = Some(direction / flux);
            let mut sum = 0.0;
            for (bin, share) in fine.iter().enumerate() {
                survey.zones[bin / (FINE / 18)] += share / flux;
                if sum < 0.5 * flux && sum + share >= 0.5 * flux {
                    survey.half_flux_gamma_deg = Some((bin as f64 + (0.5 * flux - sum) / share) / 10.0);
                }
                sum += share;
            }
        }
        Ok(survey)
    }

    fn damage(&mut self, ray: &Ray, index: u64) {
        let fluxes = [ray.radiant_w, ray.luminous_lm];
        let finite = ray.origin_mm.is_finite()
            && ray.direction.is_finite()
            && fluxes.iter().flatten().all(|flux| flux.is_finite());
        if !finite {
            self.not_finite.add(index);
        }
        if ray.direction == DVec3::ZERO {
            self.no_direction.add(index);
        } else if (ray.direction.length() - 1.0).abs() > 1e-3 {
            self.not_unit.add(index);
        }
        if fluxes.iter().flatten().any(|flux| *flux < 0.0) {
            self.negative.add(index);
        }
        if let Some(nm) = ray.wavelength_nm {
            if nm > 0.0 && nm.is_finite() {
                let [low, high] = self.wavelength_nm.unwrap_or([nm; 2]);
                self.wavelength_nm = Some([low.min(nm), high.max(nm)]);
            } else {
                self.no_wavelength.add(index);
            }
        }
    }
}
