//! What counting rays does to a result.

use rayon::prelude::*;

use crate::array::{Array, RUN};
use crate::direct::Counts;
use crate::noise::{self, Interval};
use crate::setup::Setup;

/// What counting rays does to the result.
pub(super) struct Rays {
    pub value: f64,
    pub relative_of_mean: f64,
    pub relative_per_pixel: f64,
    pub maximum: Interval,
    pub max_noise_free: f64,
    pub uniformity: f64,
    pub needed: f64,
}

impl Rays {
    /// `noise_free`: the map without noise.
    pub fn of(counts: &Counts, setup: &Setup, mut noise_free: Array<f64>) -> Self {
        let per_unit = setup.per_unit();
        let pixels = setup.sensor.pixels();
        let value = counts.lux_per_ray() * setup.lamp * per_unit;
        let background = setup.background_lx * per_unit;
        let light = noise::moments(&noise_free);
        noise_free.par_chunks_mut(RUN).for_each(|lights| {
            for light in lights {
                *light = ((*light - background) / value).max(0.0);
            }
        });
        let expected = noise_free;
        let law = noise::largest_count(&expected);
        let scaled = |count: f64| count * value + background;
        // Where no ray arrived, the upper limit of three rays at 95 % stands in for the mean.
        let caught = counts.on_sensor() as f64;
        let known = if caught > 0.0 { caught } else { noise::upper_limit_95(0) };
        let share = light.map_or(0.0, |light| (light.mean - background) / value * pixels as f64) / counts.rays as f64;
        Self {
            value,
            relative_of_mean: if caught > 0.0 { caught.sqrt().recip() } else { known },
            relative_per_pixel: (known / pixels as f64).sqrt().recip(),
            maximum: Interval {
                median: scaled(law.median),
                lo95: scaled(law.lo95),
                hi95: scaled(law.hi95),
            },
            max_noise_free: light.map_or(0.0, |light| light.max),
            uniformity: light
                .filter(|light| light.mean != 0.0)
                .map_or(0.0, |light| light.min / light.mean),
            needed: noise::rays_needed(0.01, share, pixels),
        }
    }
}
