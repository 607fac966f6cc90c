//! How a table's light changes over the angles of a sensor: what the bound of a pixel's centre is made of, and the list of kinks.

use crate::table::Table;

/// How steep a table is relative to its light, over a range of polar angles.
pub(super) struct Slopes {
    /// 1/rad.
    pub gamma: f64,
    /// The same in the cells at the pole, and elsewhere over sin γ.
    pub tip: f64,
    pub gamma_per_sine: f64,
    /// Slope in C over sin γ, 1/rad.
    pub c_per_sine: f64,
    /// 1/rad².
    pub both: f64,
    /// Line of each kink and its change of slope, 1/rad.
    pub cones: Vec<(usize, f64)>,
    /// Line of each kink and its change of slope over sin γ.
    pub planes: Vec<(usize, f64)>,
}

impl Slopes {
    /// `None` where the light may be zero, or differs at the pole from plane to plane.
    pub fn over(table: &Table, low: f64, high: f64) -> Option<Self> {
        let grid = &table.gamma_rad;
        let n = grid.len();
        if n < 2 || low < grid[0] - 1e-9 || high > grid[n - 1] + 1e-9 {
            return None;
        }
        let first = grid.partition_point(|line| *line <= low).max(1) - 1;
        let last = grid.partition_point(|line| *line < high).min(n - 1);
        let planes = if table.is_rotational() {
            1
        } else {
            table.c_rad.len() - 1
        };
        let at = |ic: usize, ig: usize| table.intensity_cd[ic % planes * n + ig];
        let least = (0..planes)
            .flat_map(|ic| (first..=last).map(move |ig| at(ic, ig)))
            .fold(f64::INFINITY, f64::min);
        if least <= 1e-6 * table.peak_cd() {
            return None;
        }
        let slope = |ic: usize, ig: usize| (at(ic, ig + 1) - at(ic, ig)) / (grid[ig + 1] - grid[ig]);
        // Relative to the dimmest plane of the two lines round a cell.
        let dim = |ig: usize| (0..planes).map(|ic| at(ic, ig)).fold(f64::INFINITY, f64::min);
        let mut out = Self {
            gamma: 0.0,
            tip: 0.0,
            gamma_per_sine: 0.0,
            c_per_sine: 0.0,
            both: 0.0,
            cones: Vec::new(),
            planes: Vec::new(),
        };
        for ig in first..last {
            let per = dim(ig).min(dim(ig + 1)).recip();
            for ic in 0..planes {
                let steep = per * slope(ic, ig).abs();
                out.gamma = out.gamma.max(steep);
                if grid[ig] < 1e-9 {
                    out.tip = out.tip.max(steep);
                } else {
                    let sine = grid[ig].sin().min(grid[ig + 1].sin()).max(1e-300);
                    out.gamma_per_sine = out.gamma_per_sine.max(steep / sine);
                }
            }
        }
        for ig in first.max(1)..=last.min(n - 2) {
            let jump = (0..planes)
                .map(|ic| (slope(ic, ig) - slope(ic, ig - 1)).abs())
                .fold(0.0, f64::max);
            if table.gamma_kinks().contains(&grid[ig]) {
                out.cones.push((ig, jump / dim(ig)));
            }
        }
        if planes > 1 {
            let width = |ic: usize| table.c_rad[ic % planes + 1] - table.c_rad[ic % planes];
            let across = |ic: usize, ig: usize| (at(ic + 1, ig) - at(ic, ig)) / width(ic);
            let mut jumps = vec![0.0_f64; planes];
            for ig in first..=last {
                let sine = grid[ig].sin();
                let per = dim(ig).recip();
                for ic in 0..planes {
                    let here = across(ic, ig);
                    let jump = (here - across(ic + planes - 1, ig)).abs() * per;
                    if sine < 1e-9 {
                        if here.abs() * per > 1e-12 {
                            return None;
                        }
                        continue;
                    }
                    out.c_per_sine = out.c_per_sine.max(here.abs() * per / sine);
                    jumps[ic] = jumps[ic].max(jump / sine);
                    if ig < last {
                        let next = across(ic, ig + 1);
                        out.both = out.both.max((next - here).abs() * per / (grid[ig + 1] - grid[ig]));
                    }
                }
            }
            if first == 0 {
                let sine = grid[1].sin();
                for ic in 0..planes {
                    out.both = out.both.max(across(ic, 1).abs() / (dim(1) * sine));
                }
            }
            out.planes = jumps
                .into_iter()
                .enumerate()
                .filter(|(_, jump)| *jump > 1e-13)
                .collect();
        }
        Some(out)
    }
}
