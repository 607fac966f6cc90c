//! Direct simulation: rays from the emitter, counted by pixel.
//!
//! Three samplings of one law. *Traced*: each of the N rays is emitted; its first number tells whether it leaves
//! through a cell of the distribution from which the sensor can be reached, and only then is it followed. *Thinned*:
//! the number of rays that leave through those cells is drawn from its binomial law, and only they are emitted.
//! *Expected*: the counts of the pixels are drawn from their Poisson law on the inverse result. Results depend on the
//! seed alone.

use std::sync::atomic::AtomicU64;

use glam::DVec3;
use rayon::prelude::*;
use zerocopy::{FromBytes, IntoBytes};

use crate::array::{Array, RUN};
use crate::batch::{LANES, Tracer, words};
use crate::emission::{Emission, Ray, first_number};
use crate::random::{Purpose, Random, unit53};
use crate::sensor::Sensor;
use crate::source::LightSource;

/// Rays of one piece of work.
const CHUNK: u64 = 1 << 16;

/// Block of the words that hold the low bits of the first numbers of traced rays. Of the high bits four rays share one
/// block of four words: nearly all rays end there, and the low bits of the others are drawn when they are asked for.
const LOW_WORDS: u32 = 5;

/// Which of the three equal laws makes the counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// Every ray is emitted.
    Traced,
    /// Only the rays of the cone are emitted, their number drawn.
    Thinned,
    /// Poisson counts on the inverse result.
    Expected,
}

impl Sampling {
    /// The word of the command line and of result files.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Traced => "traced",
            Self::Thinned => "thinned",
            Self::Expected => "expected",
        }
    }
}

/// Why rays cannot be traced.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DirectError {
    /// No ray.
    #[error("a direct simulation needs at least one ray")]
    NoRays,
    /// The distribution holds no positive flux.
    #[error("the distribution emits no light: its flux is {flux_lm} lm")]
    Dark {
        /// What it emits.
        flux_lm: f64,
    },
    /// More rays than can be followed in a day.
    #[error("{sampled:.1e} rays would have to be followed one by one: more than {limit:.0e}")]
    TooMany {
        /// Rays that the sampling would follow.
        sampled: f64,
        /// The most.
        limit: f64,
    },
}

/// The most rays that traced and thinned follow one by one.
const MOST_RAYS: f64 = 2e13;

/// Rays counted by pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Counts {
    /// Rays of each pixel, `[iy * nx + ix]`.
    pub count: Array<u64>,
    /// Rays over the whole sphere, N.
    pub rays: u64,
    /// Flux of the emitter, lm.
    pub flux_lm: f64,
    /// Area of a pixel, m².
    pub pixel_area_m2: f64,
}

impl Counts {
    /// Illuminance of one ray in one pixel, lx: Φ/(N·A).
    pub fn lux_per_ray(&self) -> f64 {
        self.flux_lm / (self.rays as f64 * self.pixel_area_m2)
    }

    /// Rays on the sensor.
    pub fn on_sensor(&self) -> u64 {
        self.count
            .par_chunks(RUN)
            .map(|counts| counts.iter().sum::<u64>())
            .sum()
    }

    /// Pixels that no ray reached.
    pub fn empty(&self) -> usize {
        let empty = |counts: &[u64]| counts.iter().filter(|count| **count == 0).count();
        self.count.par_chunks(RUN).map(empty).sum()
    }

    /// The map, lx.
    pub fn illuminance_lx(&self) -> Array<f64> {
        let unit = self.lux_per_ray();
        let mut map = Array::zeros(self.count.len());
        let runs = map.par_chunks_mut(RUN).zip(self.count.par_chunks(RUN));
        runs.for_each(|(map, counts)| {
            for (value, count) in map.iter_mut().zip(counts) {
                *value = *count as f64 * unit;
            }
        });
        map
    }
}

/// Traces all `rays`.
///
/// # Errors
/// [`DirectError`] for no rays, no light, too many rays.
pub fn traced(source: &LightSource, sensor: &Sensor, rays: u64, seed: u64) -> Result<Counts, DirectError> {
    let emission = prepared(source, sensor, rays)?;
    follow(rays as f64)?;
    let random = Random::new(seed, Purpose::Ray);
    let cone = emission.cone();
    let highest = (cone * 4_294_967_296.0).min(4_294_967_295.0) as u32;
    let mut count = Array::zeros(sensor.pixels());
    let tracer = Tracer::new(
        &emission,
        sensor,
        counters(&mut count),
        random,
        source.extinction_per_mm(),
    );
    (0..rays.div_ceil(CHUNK))
        .into_par_iter()
        .for_each_init(Vec::new, |pending, chunk| {
            if source.is_stopped() {
                return;
            }
            let (mut first, to) = (chunk * CHUNK, ((chunk + 1) * CHUNK).min(rays));
            pending.clear();
            let mut words = [[0_u32; LANES]; 4];
            while first < to {
                if leaves(random.key(), first / 4, random.purpose(), highest, &mut words) {
                    for lane in 0..LANES {
                        for (word, lanes) in words.iter().enumerate() {
                            if lanes[lane] > highest {
                                continue;
                            }
                            let index = first + (4 * lane + word) as u64;
                            let u = unit53(lanes[lane], random.words(index / 4, LOW_WORDS)[word]);
                            if u < cone && index < to {
                                pending.push((u, index));
                            }
                        }
                    }
                }
                first += 4 * LANES as u64;
            }
            tracer.follow(pending, 1);
        });
    Ok(counted(count, &emission, sensor, rays))
}

/// Draws how many of `rays` leave through the cone and traces those.
///
/// # Errors
/// [`DirectError`] for no rays, no light, too many rays in the cone.
pub fn thinned(source: &LightSource, sensor: &Sensor, rays: u64, seed: u64) -> Result<Counts, DirectError> {
    let emission = prepared(source, sensor, rays)?;
    let cone = emission.cone();
    let inside = Random::new(seed, Purpose::Cone)
        .sequence(0)
        .binomial(rays, cone.min(1.0));
    follow(inside as f64)?;
    let random = Random::new(seed, Purpose::Ray);
    let mut count = Array::zeros(sensor.pixels());
    let tracer = Tracer::new(
        &emission,
        sensor,
        counters(&mut count),
        random,
        source.extinction_per_mm(),
    );
    // How many leave through each cell: the multinomial law, one binomial after the other.
    let mut pieces = Vec::new();
    let (mut first, mut left) = (0, inside);
    for (number, (cell, share)) in emission.shares().enumerate() {
        let in_cell = Random::new(seed, Purpose::Cone)
            .sequence(1 + number as u64)
            .binomial(left, share);
        left -= in_cell;
        for from in (0..in_cell).step_by(CHUNK as usize) {
            pieces.push((cell, first + from, CHUNK.min(in_cell - from)));
        }
        first += in_cell;
    }
    // Block 3: a thinned ray shares no number with the traced ray of the same index.
    pieces.into_par_iter().for_each(|(cell, first, rays)| {
        if !source.is_stopped() {
            tracer.follow_cell(cell, first, rays, 3);
        }
    });
    Ok(counted(count, &emission, sensor, rays))
}

/// Draws the counts from their Poisson law on a noise-free map in lx (the result of [`crate::inverse`]).
///
/// # Errors
/// [`DirectError`] for no rays and no light.
pub fn expected(
    source: &LightSource,
    sensor: &Sensor,
    illuminance_lx: &[f64],
    rays: u64,
    seed: u64,
) -> Result<Counts, DirectError> {
    let emission = prepared(source, sensor, rays)?;
    let random = Random::new(seed, Purpose::Pixel);
    let per_lux = sensor.pixel_area_m2() * rays as f64 / emission.flux_lm();
    let mut count = Array::zeros(illuminance_lx.len());
    let runs = count.par_chunks_mut(RUN).zip(illuminance_lx.par_chunks(RUN));
    runs.enumerate().for_each(|(run, (counts, lux))| {
        for (group, (counts, lux)) in counts.chunks_mut(LANES).zip(lux.chunks(LANES)).enumerate() {
            let first = (run * RUN + group * LANES) as u64;
            let index = std::array::from_fn(|lane| first + lane as u64);
            let words = words(random.key(), &index, 0, random.purpose());
            for (lane, (count, lux)) in counts.iter_mut().zip(lux).enumerate() {
                let mut sequence = random.begun(index[lane], words.map(|lanes| lanes[lane]));
                *count = sequence.poisson(lux * per_lux);
            }
        }
    });
    Ok(Counts {
        count,
        rays,
        flux_lm: emission.flux_lm(),
        pixel_area_m2: sensor.pixel_area_m2(),
    })
}

/// A ray that reached the sensor: for pictures and ray files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The ray.
    pub ray: Ray,
    /// Where it ends, mm.
    pub end: DVec3,
    /// Pixel along x and y.
    pub pixel: [usize; 2],
}

/// The first `wanted` rays of a thinned run that reach the sensor (fewer if the sensor is hard to reach).
///
/// # Errors
/// [`DirectError::Dark`].
pub fn hits(source: &LightSource, sensor: &Sensor, wanted: usize, seed: u64) -> Result<Vec<Hit>, DirectError> {
    let emission = prepared(source, sensor, 1)?;
    let random = Random::new(seed, Purpose::Ray);
    let tries = (wanted as u64).saturating_mul(1000).max(100_000);
    Ok((0..tries)
        .filter_map(|index| {
            let ray = emission.ray(
                first_number(random.words(index, 2)) * emission.cone(),
                random.words(index, 3),
            )?;
            let (end, pixel) = landing(&ray, sensor)?;
            Some(Hit { ray, end, pixel })
        })
        .take(wanted)
        .collect())
}

fn prepared(source: &LightSource, sensor: &Sensor, rays: u64) -> Result<Emission, DirectError> {
    if rays == 0 {
        return Err(DirectError::NoRays);
    }
    let emission = Emission::new(source, sensor);
    if emission.flux_lm() > 0.0 {
        Ok(emission)
    } else {
        Err(DirectError::Dark {
            flux_lm: emission.flux_lm(),
        })
    }
}

fn follow(sampled: f64) -> Result<(), DirectError> {
    if sampled > MOST_RAYS {
        Err(DirectError::TooMany {
            sampled,
            limit: MOST_RAYS,
        })
    } else {
        Ok(())
    }
}

/// The counters of all pixels, for threads that count side by side.
fn counters(count: &mut [u64]) -> &[AtomicU64] {
    <[AtomicU64]>::mut_from_bytes(count.as_mut_bytes())
        .map_err(|_| ())
        .expect("a counter is as large as its number and aligned as it")
}

fn counted(count: Array<u64>, emission: &Emission, sensor: &Sensor, rays: u64) -> Counts {
    Counts {
        count,
        rays,
        flux_lm: emission.flux_lm(),
        pixel_area_m2: sensor.pixel_area_m2(),
    }
}

/// Where a ray meets the sensor's face, and the pixel.
#[inline]
pub fn landing(ray: &Ray, sensor: &Sensor) -> Option<(DVec3, [usize; 2])> {
    let speed = ray.direction.dot(sensor.toward);
    let height = (sensor.corner - ray.origin).dot(sensor.toward);
    if speed <= 0.0 || height <= 0.0 {
        return None;
    }
    let end = ray.origin + ray.direction * (height / speed);
    let local = end - sensor.corner;
    let x = local.dot(sensor.step_x) / sensor.step_x.length_squared();
    let y = local.dot(sensor.step_y) / sensor.step_y.length_squared();
    let inside = x >= 0.0 && y >= 0.0 && x < sensor.nx as f64 && y < sensor.ny as f64;
    inside.then_some((end, [x as usize, y as usize]))
}

/// The first words of four times [`LANES`] rays, ray 4·(first + lane) + word; whether any of them is at most
/// `highest`.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn leaves(key: [u32; 2], first: u64, purpose: u32, highest: u32, words: &mut [[u32; LANES]; 4]) -> bool {
    let mut c0 = [0_u32; LANES];
    let mut c1 = [(first >> 32) as u32; LANES];
    let mut c2 = [0_u32; LANES];
    let mut c3 = [purpose; LANES];
    for (lane, word) in c0.iter_mut().enumerate() {
        // CHUNK and LANES are powers of two, so that no lane carries into the high word.
        *word = (first as u32).wrapping_add(lane as u32);
    }
    let mut key = key;
    for round in 0..10 {
        if round > 0 {
            key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
        }
        for lane in 0..LANES {
            let p0 = u64::from(c0[lane]) * 0xD251_1F53;
            let p1 = u64::from(c2[lane]) * 0xCD9E_8D57;
            c0[lane] = (p1 >> 32) as u32 ^ c1[lane] ^ key[0];
            c1[lane] = p1 as u32;
            c2[lane] = (p0 >> 32) as u32 ^ c3[lane] ^ key[1];
            c3[lane] = p0 as u32;
        }
    }
    *words = [c0, c1, c2, c3];
    let mut least = [u32::MAX; LANES];
    for word in [c0, c1, c2, c3] {
        for lane in 0..LANES {
            least[lane] = least[lane].min(word[lane]);
        }
    }
    least.into_iter().fold(u32::MAX, u32::min) <= highest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_rays_share_a_block_of_the_stream() {
        let random = Random::new(5, Purpose::Ray);
        let mut words = [[0; LANES]; 4];
        let first = (7 << 32) + 64;
        assert!(leaves(random.key(), first, random.purpose(), u32::MAX, &mut words));
        for lane in 0..LANES {
            let block = random.words(first + lane as u64, 0);
            assert_eq!(words.map(|word| word[lane]), block);
        }
        let least = words.iter().flatten().copied().min().unwrap_or(0);
        assert!(!leaves(random.key(), first, random.purpose(), least - 1, &mut words));
    }
}
