//! Half-planes between those that a scan chose: a periodic spline over C, and what rings and left-out half-planes show
//! that it misses.
//!
//! A ring was read all round, so that a spline through its own light at the half-planes can be compared with it in
//! every gap. That is what interpolation misses at the γ of the rings; anywhere it may be [`BEYOND_RINGS`] times as
//! much, which is taken as U (k = 2). Between rings it is taken from one to the next, and nowhere above the largest
//! light of a γ. A half-plane that is left out is missed by as much as a gap twice as wide; a quarter of that is a
//! standard uncertainty of the gaps beside it, where it is larger.

use isolux_photometry::{AroundSpline, MissedOfRing, ReadHalfPlanes, Ring, bands, u_between, u_beyond_rings};
use isolux_record::plan::Block;

use crate::grid::is_pole;
use crate::samples::Sample;

/// What a scan that chose its half-planes knows of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfPlanes {
    /// Half-planes of the plan, in [0, 360), rising.
    pub planned_c_deg: Vec<f64>,
    /// Rings, in lx.
    pub rings: Vec<Ring>,
}

/// What was interpolated, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Between {
    /// Half-planes that were read, in [0, 360), rising.
    pub read_c_deg: Vec<f64>,
    /// Half-planes of the result.
    pub count: usize,
    /// γ of the rings.
    pub rings_gamma_deg: Vec<f64>,
    /// Largest standard uncertainty of the interpolation, in shares of the largest intensity.
    pub u_map_rel: f64,
    /// Standard uncertainty of the flux by it, relative.
    pub u_flux_rel: f64,
}

/// The half-planes that were read, with every γ but the poles.
struct Read {
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    /// By γ and half-plane.
    samples: Vec<Vec<Sample>>,
}

impl HalfPlanes {
    /// Of a block that was read to its end.
    pub fn of(block: &Block, rings: impl Iterator<Item = Ring>) -> Self {
        let planned_c_deg = block.half_planes_deg(&block.c_deg);
        let mut rings: Vec<Ring> = rings.collect();
        rings.sort_by(|a, b| a.gamma_deg.total_cmp(&b.gamma_deg));
        Self { planned_c_deg, rings }
    }

    /// Adds the half-planes that were not read to the samples of the others, which stand by C and γ rising; none where
    /// there is nothing to add.
    pub fn fill(&self, samples: &mut Vec<Sample>) -> Option<Between> {
        let read = Read::of(samples);
        let is_read = |c: &f64| read.c_deg.iter().any(|there| (there - c).abs() < 1e-6);
        let absent: Vec<f64> = self.planned_c_deg.iter().copied().filter(|c| !is_read(c)).collect();
        // Without a ring nothing says how far a spline is off: the result has the half-planes that were read.
        if absent.is_empty() || self.rings.is_empty() || read.c_deg.len() < 3 || read.gamma_deg.is_empty() {
            return None;
        }
        let missed = self.missed(&read);
        let mut u_largest: f64 = 0.0;
        for c_deg in absent {
            let gap = read.gap(c_deg);
            let weights = read.weights(c_deg);
            for (column, row) in read.samples.iter().enumerate() {
                let u_between = missed.u_cd[column][gap];
                u_largest = u_largest.max(u_between);
                samples.push(interpolated(c_deg, row, &weights, u_between));
            }
        }
        samples.sort_by(|a, b| {
            let by_place = a.c_deg.total_cmp(&b.c_deg).then(a.gamma_deg.total_cmp(&b.gamma_deg));
            a.closing.cmp(&b.closing).then(by_place)
        });
        let largest = samples
            .iter()
            .map(|sample| sample.intensity_cd)
            .fold(f64::MIN_POSITIVE, f64::max);
        Some(Between {
            count: self.planned_c_deg.len(),
            read_c_deg: read.c_deg,
            rings_gamma_deg: self.rings.iter().map(|ring| ring.gamma_deg).collect(),
            u_map_rel: u_largest / largest,
            u_flux_rel: missed.u_flux_rel,
        })
    }

    fn missed(&self, read: &Read) -> MissedOf {
        let gaps = read.c_deg.len();
        // Rings in candela: by what the half-planes have at their γ.
        let of_rings = self.rings.iter().map(|ring| {
            let light: f64 = (0..gaps).map(|plane| read.at(plane, ring.gamma_deg)).sum();
            let own: f64 = read.c_deg.iter().map(|c| ring.at(*c)).sum();
            let cd_per_lx = if own > 0.0 { light / own } else { 0.0 };
            let missed = ring.missed(&read.c_deg);
            let largest = missed.iter().map(|gap| cd_per_lx * gap.largest).collect();
            let mean: Vec<f64> = missed.iter().map(|gap| cd_per_lx * gap.mean).collect();
            let gamma_deg = ring.gamma_deg;
            (MissedOfRing { gamma_deg, largest }, (gamma_deg, mean))
        });
        let (largest, mean): (Vec<MissedOfRing>, Vec<(f64, Vec<f64>)>) = of_rings.unzip();
        let cd = |row: &Vec<Sample>| row.iter().map(|sample| sample.intensity_cd).collect();
        let light: Vec<Vec<f64>> = read.samples.iter().map(cd).collect();
        let half_planes = ReadHalfPlanes {
            c_deg: &read.c_deg,
            gamma_deg: &read.gamma_deg,
            light: &light,
        };
        MissedOf {
            u_cd: u_between(&half_planes, &largest),
            u_flux_rel: u_beyond_rings(flux_rel(read, &mean)),
        }
    }
}

/// What interpolation misses.
struct MissedOf {
    /// Standard uncertainty by γ and gap, cd.
    u_cd: Vec<Vec<f64>>,
    u_flux_rel: f64,
}

/// What the means over the gaps make of the flux: root of the sum of their squares, for each gap errs on its own.
fn flux_rel(read: &Read, of_rings: &[(f64, Vec<f64>)]) -> f64 {
    let gamma_deg: Vec<f64> = of_rings.iter().map(|ring| ring.0).collect();
    let bands = bands(&gamma_deg);
    let gaps = read.c_deg.len();
    let mean = |gamma: f64| (0..gaps).map(|plane| read.at(plane, gamma)).sum::<f64>() / gaps as f64;
    let flux: f64 = of_rings
        .iter()
        .zip(&bands)
        .map(|(ring, band)| band * mean(ring.0))
        .sum();
    let of_gap = |gap: usize| {
        let sum: f64 = of_rings.iter().zip(&bands).map(|(ring, band)| band * ring.1[gap]).sum();
        sum * read.width_deg(gap) / 360.0
    };
    let squares: f64 = (0..gaps).map(|gap| of_gap(gap).powi(2)).sum();
    if flux > 0.0 { squares.sqrt() / flux } else { 0.0 }
}

impl Read {
    fn of(samples: &[Sample]) -> Self {
        let mut c_deg: Vec<f64> = Vec::new();
        let mut planes: Vec<&[Sample]> = Vec::new();
        for plane in samples.chunk_by(|a, b| (a.closing, a.c_deg) == (b.closing, b.c_deg)) {
            if !plane[0].closing {
                c_deg.push(plane[0].c_deg);
                planes.push(plane);
            }
        }
        let without_poles = |plane: &[Sample]| -> Vec<Sample> {
            plane
                .iter()
                .filter(|sample| !is_pole(sample.gamma_deg))
                .copied()
                .collect()
        };
        let planes: Vec<Vec<Sample>> = planes.into_iter().map(without_poles).collect();
        let gamma_deg: Vec<f64> = planes
            .first()
            .map_or_else(Vec::new, |plane| plane.iter().map(|sample| sample.gamma_deg).collect());
        let same = |plane: &Vec<Sample>| {
            plane.len() == gamma_deg.len()
                && plane
                    .iter()
                    .zip(&gamma_deg)
                    .all(|(sample, gamma)| sample.gamma_deg == *gamma)
        };
        // Half-planes that do not make one grid are refused where the grid is made.
        if !planes.iter().all(same) {
            return Self {
                c_deg: Vec::new(),
                gamma_deg: Vec::new(),
                samples: Vec::new(),
            };
        }
        let samples = (0..gamma_deg.len()).map(|column| planes.iter().map(|plane| plane[column]).collect());
        Self {
            samples: samples.collect(),
            c_deg,
            gamma_deg,
        }
    }

    /// The gap in which C lies, by the half-plane before it.
    fn gap(&self, c_deg: f64) -> usize {
        (self.c_deg.partition_point(|c| *c <= c_deg) + self.c_deg.len() - 1) % self.c_deg.len()
    }

    fn width_deg(&self, gap: usize) -> f64 {
        (self.c_deg[(gap + 1) % self.c_deg.len()] - self.c_deg[gap]).rem_euclid(360.0)
    }

    /// What each half-plane counts in the spline at C.
    fn weights(&self, c_deg: f64) -> Vec<f64> {
        let unit = |plane: usize| {
            let mut one = vec![0.0; self.c_deg.len()];
            one[plane] = 1.0;
            AroundSpline::through(&self.c_deg, &one).at(c_deg)
        };
        (0..self.c_deg.len()).map(unit).collect()
    }

    /// Intensity of a half-plane at any γ, straight from one direction to the next, cd.
    fn at(&self, plane: usize, gamma_deg: f64) -> f64 {
        let next = self.gamma_deg.partition_point(|gamma| *gamma < gamma_deg);
        let cd = |column: usize| self.samples[column][plane].intensity_cd;
        match (next.checked_sub(1), self.gamma_deg.get(next)) {
            (Some(before), Some(behind)) => {
                let from = self.gamma_deg[before];
                cd(before) + (cd(next) - cd(before)) * (gamma_deg - from) / (behind - from)
            }
            (Some(before), None) => cd(before),
            (None, _) => cd(0),
        }
    }
}

/// A sample of a half-plane that was not read, from those of `row` that were, all of one γ.
fn interpolated(c_deg: f64, row: &[Sample], weights: &[f64], u_between_cd: f64) -> Sample {
    let sum = |of: &dyn Fn(&Sample) -> f64| {
        row.iter()
            .zip(weights)
            .map(|(sample, weight)| weight * of(sample))
            .sum::<f64>()
    };
    let root = |of: &dyn Fn(&Sample) -> f64| {
        let squares = row
            .iter()
            .zip(weights)
            .map(|(sample, weight)| (weight * of(sample)).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let ages: Option<f64> = row.iter().map(|sample| sample.lamp_s).sum();
    Sample {
        c_deg,
        gamma_deg: row[0].gamma_deg,
        closing: false,
        true_c_deg: c_deg,
        true_gamma_deg: row[0].gamma_deg + sum(&|sample| sample.true_gamma_deg - sample.gamma_deg),
        intensity_cd: sum(&|sample| sample.intensity_cd),
        u_noise_cd: root(&|sample| sample.u_noise_cd),
        u_curve_cd: Some(root(&|sample| sample.u_curve_cd.unwrap_or(0.0)).hypot(u_between_cd)),
        u_digit_cd: root(&|sample| sample.u_digit_cd),
        display: None,
        lamp_s: ages.map(|sum| sum / row.len() as f64),
    }
}

impl Between {
    /// Whether a half-plane was read.
    pub fn is_read(&self, c_deg: f64) -> bool {
        self.read_c_deg.iter().any(|read| (read - c_deg).abs() < 1e-6)
    }

    /// The sentence for people.
    pub fn note(&self) -> String {
        let gammas: Vec<String> = self.rings_gamma_deg.iter().map(|gamma| format!("{gamma}°")).collect();
        format!(
            "half-planes were chosen: {} of {} were read, the others are interpolated over C; by rings at γ {} and \
             by half-planes that are left out this is uncertain by at most {:.2} % of the largest intensity (k = 2), \
             and the flux by {:.2} %",
            self.read_c_deg.len(),
            self.count,
            gammas.join(", "),
            200.0 * self.u_map_rel,
            200.0 * self.u_flux_rel
        )
    }
}
