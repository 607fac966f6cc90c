//! Light around a circle of equal γ: a spline through half-planes, and what it misses between them of a circle that
//! was read all round.

/// Width of the mean of a circle's readings about each place, degrees: less noise, and every defect that is wider
/// stays.
pub(crate) const MEAN_DEG: f64 = 7.5;
/// Steps in which a circle is kept, degrees.
pub(crate) const STEP_DEG: f64 = 2.5;

/// What a spline through half-planes misses anywhere, in what it misses of rings: up to so many times on sixteen
/// luminaires with three or four rings each.
pub const BEYOND_RINGS: f64 = 2.1;

/// A periodic cubic spline over C.
#[derive(Debug, Clone, PartialEq)]
pub struct AroundSpline {
    c_deg: Vec<f64>,
    value: Vec<f64>,
    /// Second derivatives at the half-planes, per square degree.
    bend: Vec<f64>,
}

impl AroundSpline {
    /// Through `value` at half-planes `c_deg`, rising in [0, 360). Of fewer than three it is a straight line from one
    /// to the next.
    ///
    /// # Panics
    /// Where there are none, or not as many values.
    pub fn through(c_deg: &[f64], value: &[f64]) -> Self {
        assert!(
            !c_deg.is_empty() && c_deg.len() == value.len(),
            "one value a half-plane"
        );
        let count = c_deg.len();
        let bend = if count < 3 {
            vec![0.0; count]
        } else {
            bends(c_deg, value)
        };
        Self {
            c_deg: c_deg.to_vec(),
            value: value.to_vec(),
            bend,
        }
    }

    /// At any C.
    pub fn at(&self, c_deg: f64) -> f64 {
        let count = self.c_deg.len();
        let c_deg = c_deg.rem_euclid(360.0);
        let behind = self.c_deg.partition_point(|c| *c <= c_deg) % count;
        let before = (behind + count - 1) % count;
        let width = width_deg(self.c_deg[before], self.c_deg[behind]);
        let share = (c_deg - self.c_deg[before]).rem_euclid(360.0) / width;
        let (a, b) = (1.0 - share, share);
        let cubic = |share: f64| (share.powi(3) - share) * width * width / 6.0;
        a * self.value[before] + b * self.value[behind] + cubic(a) * self.bend[before] + cubic(b) * self.bend[behind]
    }
}

/// From one half-plane to the next, degrees; the whole circle from one to itself.
fn width_deg(from_deg: f64, to_deg: f64) -> f64 {
    let width = (to_deg - from_deg).rem_euclid(360.0);
    if width == 0.0 { 360.0 } else { width }
}

/// Second derivatives of the periodic spline: its cyclic tridiagonal system, by the formula of Sherman and Morrison.
fn bends(c_deg: &[f64], value: &[f64]) -> Vec<f64> {
    let count = c_deg.len();
    let next = |k: usize| (k + 1) % count;
    let width: Vec<f64> = (0..count).map(|k| width_deg(c_deg[k], c_deg[next(k)])).collect();
    let slope: Vec<f64> = (0..count).map(|k| (value[next(k)] - value[k]) / width[k]).collect();
    let last = count - 1;
    let before = |k: usize| if k == 0 { last } else { k - 1 };
    let mut diagonal: Vec<f64> = (0..count).map(|k| (width[before(k)] + width[k]) / 3.0).collect();
    let right: Vec<f64> = (0..count).map(|k| slope[k] - slope[before(k)]).collect();
    let corner = width[last] / 6.0;
    let gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[last] -= corner * corner / gamma;
    let between: Vec<f64> = width[..last].iter().map(|width| width / 6.0).collect();
    let mut of_corners = vec![0.0; count];
    (of_corners[0], of_corners[last]) = (gamma, corner);
    let plain = tridiagonal(&diagonal, &between, &right);
    let turned = tridiagonal(&diagonal, &between, &of_corners);
    let of_ends = |x: &[f64]| x[0] + corner / gamma * x[last];
    let factor = of_ends(&plain) / (1.0 + of_ends(&turned));
    plain.iter().zip(&turned).map(|(x, z)| x - factor * z).collect()
}

/// Solution of the symmetric tridiagonal system with this diagonal and these elements beside it.
fn tridiagonal(diagonal: &[f64], beside: &[f64], right: &[f64]) -> Vec<f64> {
    let count = diagonal.len();
    let (mut pivot, mut solution) = (diagonal.to_vec(), right.to_vec());
    for k in 1..count {
        let factor = beside[k - 1] / pivot[k - 1];
        pivot[k] -= factor * beside[k - 1];
        solution[k] -= factor * solution[k - 1];
    }
    solution[count - 1] /= pivot[count - 1];
    for k in (0..count - 1).rev() {
        solution[k] = (solution[k] - beside[k] * solution[k + 1]) / pivot[k];
    }
    solution
}

/// The light of one circle of equal γ, read all round.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// γ, degrees.
    pub gamma_deg: f64,
    /// Every [`STEP_DEG`] from C 0°, the mean of the readings around.
    value: Vec<f64>,
}

/// What a spline through half-planes misses of a circle between two of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Missed {
    /// The largest error, without its sign.
    pub largest: f64,
    /// The mean of the error over the way between them.
    pub mean: f64,
}

impl Ring {
    /// Of readings (C in degrees, light); none where a stretch of the circle has none.
    pub fn of(gamma_deg: f64, readings: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let count = (360.0 / STEP_DEG) as usize;
        let reach = (0.5 * MEAN_DEG / STEP_DEG) as usize;
        let mut cells = vec![(0.0, 0.0); count];
        for (c_deg, value) in readings {
            let cell = (c_deg / STEP_DEG).round().rem_euclid(count as f64) as usize % count;
            cells[cell].0 += value;
            cells[cell].1 += 1.0;
        }
        let mean = |k: usize| {
            let around = (0..=2 * reach).map(|by| cells[(k + by + count - reach) % count]);
            let (sum, number) = around.fold((0.0, 0.0), |all, cell| (all.0 + cell.0, all.1 + cell.1));
            (number > 0.0).then(|| sum / number)
        };
        let value: Option<Vec<f64>> = (0..count).map(mean).collect();
        Some(Self {
            gamma_deg,
            value: value?,
        })
    }

    /// The light at C, straight from one step to the next.
    pub fn at(&self, c_deg: f64) -> f64 {
        let count = self.value.len();
        let place = c_deg.rem_euclid(360.0) / STEP_DEG;
        let (cell, share) = (place as usize % count, place.fract());
        (1.0 - share) * self.value[cell] + share * self.value[(cell + 1) % count]
    }

    /// The mean of all.
    pub fn mean(&self) -> f64 {
        self.value.iter().sum::<f64>() / self.value.len() as f64
    }

    /// The largest.
    pub fn largest(&self) -> f64 {
        self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// What a spline through its own light at half-planes `c_deg`, rising in [0, 360), misses from each of them to the
    /// next.
    pub fn missed(&self, c_deg: &[f64]) -> Vec<Missed> {
        let there: Vec<f64> = c_deg.iter().map(|c| self.at(*c)).collect();
        let spline = AroundSpline::through(c_deg, &there);
        let between = |k: usize| {
            let (from, width) = (c_deg[k], width_deg(c_deg[k], c_deg[(k + 1) % c_deg.len()]));
            let steps = (width / STEP_DEG).ceil().max(1.0) as usize;
            let errors = (0..steps).map(|step| {
                let at = from + width * (step as f64 + 0.5) / steps as f64;
                spline.at(at) - self.at(at)
            });
            let (largest, sum) = errors.fold((0.0_f64, 0.0), |all, error| (all.0.max(error.abs()), all.1 + error));
            Missed {
                largest,
                mean: sum / steps as f64,
            }
        };
        (0..c_deg.len()).map(between).collect()
    }
}

/// What of the sphere each of rings at these γ, rising in degrees, stands for: the band half-way to its neighbours, as
/// the difference of the cosines of its edges.
pub fn bands(gamma_deg: &[f64]) -> Vec<f64> {
    let count = gamma_deg.len();
    let edge_deg = |k: usize| {
        let before = if k > 1 { gamma_deg[k - 2] } else { 0.0 };
        match k {
            0 => 0.0,
            k if k == count => (1.5 * gamma_deg[k - 1] - 0.5 * before).min(180.0),
            k => 0.5 * (gamma_deg[k - 1] + gamma_deg[k]),
        }
    };
    let cos = |k: usize| edge_deg(k).to_radians().cos();
    (0..count).map(|k| cos(k) - cos(k + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(c_deg: f64) -> f64 {
        let c = c_deg.to_radians();
        100.0 + 30.0 * c.cos() + 10.0 * (2.0 * c + 0.4).sin()
    }

    #[test]
    fn a_spline_goes_through_its_half_planes_and_is_smooth_all_round() {
        let c_deg = [0.0, 20.0, 50.0, 90.0, 120.0, 170.0, 200.0, 240.0, 290.0, 330.0];
        let value: Vec<f64> = c_deg.iter().map(|c| wave(*c)).collect();
        let spline = AroundSpline::through(&c_deg, &value);
        for (c, value) in c_deg.iter().zip(&value) {
            assert!((spline.at(*c) - value).abs() < 1e-9 && (spline.at(c + 360.0) - value).abs() < 1e-9);
            let slope = |at: f64| (spline.at(at + 1e-3) - spline.at(at - 1e-3)) / 2e-3;
            let bend = |at: f64| (slope(at + 1e-2) - slope(at - 1e-2)) / 2e-2;
            assert!((bend(c - 0.02) - bend(c + 0.02)).abs() < 2e-3, "{c}");
        }
        for k in 0..720 {
            let c = 0.5 * f64::from(k);
            assert!(
                (spline.at(c) - wave(c)).abs() < 0.6,
                "{c}: {} {}",
                spline.at(c),
                wave(c)
            );
        }
        assert_eq!(AroundSpline::through(&[40.0], &[3.0]).at(250.0), 3.0);
        let two = AroundSpline::through(&[0.0, 180.0], &[1.0, 3.0]);
        assert_eq!((two.at(90.0), two.at(270.0)), (2.0, 2.0));
    }

    #[test]
    fn bands_of_rings_join() {
        let bands = bands(&[20.0, 40.0, 60.0]);
        let cos = |deg: f64| deg.to_radians().cos();
        assert!((bands[0] - (1.0 - cos(30.0))).abs() < 1e-12);
        assert!((bands.iter().sum::<f64>() - (1.0 - cos(70.0))).abs() < 1e-12);
    }

    #[test]
    fn a_dip_between_half_planes_is_missed_there_and_nowhere_else() {
        let dip = |c: f64| 1.0 - 0.05 * (-0.5 * ((c - 110.0) / 8.5).powi(2)).exp();
        let readings = (0..240).map(|k| 1.5 * f64::from(k)).map(|c| (c, wave(c) * dip(c)));
        let ring = Ring::of(30.0, readings).unwrap();
        let c_deg: Vec<f64> = (0..8).map(|k| 45.0 * f64::from(k)).collect();
        let missed = ring.missed(&c_deg);
        assert!(missed[2].largest > 0.03 * wave(110.0), "{missed:?}");
        assert!(missed[2].mean > 0.0, "the spline is above the dip");
        assert!(missed[6].largest < 0.01 * wave(110.0), "{missed:?}");
        let fine: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
        assert!(ring.missed(&fine).iter().all(|gap| gap.largest < 0.02 * wave(110.0)));
        assert!((ring.mean() - 99.7).abs() < 0.3 && ring.largest() < 145.0);
        let half = (0..120).map(|k| (1.5 * f64::from(k), 1.0));
        assert_eq!(Ring::of(30.0, half), None);
    }
}
