//! The grid of a plan for one luminaire: half-planes by its symmetry, steps by its beam and by what is lost between them.

use std::fmt;

use isolux_photometry::{IntensityDistribution, Symmetry};

/// What may be lost between the directions of a plan, in shares of the peak.
const MOST_LOST: f64 = 0.01;
/// Readings of a distribution that a day has time for.
const MOST_POINTS: usize = 4000;
/// Steps of γ in a beam, at least, from one half of the peak to the other.
const STEPS_IN_BEAM: f64 = 10.0;
/// Steps of C, at least, over a lobe from one half of its largest intensity to the other.
const STEPS_IN_LOBE: f64 = 2.0;
/// A lobe over C is one that falls to half, at a γ that has this share of the peak.
const LOBE_SHARE: f64 = 0.1;
/// Differences below this share of the peak are none.
const SAME: f64 = 1e-3;

const WHOLE: [f64; 2] = [0.0, 360.0];
/// No wider: the reduction states no uncertainty over a wider gap between half-planes.
const STEPS_C_DEG: [f64; 8] = [45.0, 30.0, 22.5, 15.0, 10.0, 7.5, 5.0, 2.5];
const STEPS_GAMMA_DEG: [f64; 5] = [5.0, 2.5, 2.0, 1.0, 0.5];

/// Half-planes and γ of a distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    symmetry: Symmetry,
    /// First half-plane, last one and step, degrees; a whole turn has its first half-plane twice.
    c_range: [f64; 3],
    gamma_step_deg: f64,
    /// Largest error of the file's directions interpolated in this grid, in shares of the peak.
    lost: f64,
}

impl Grid {
    /// The grid with the fewest readings that loses at most 1 % of the peak between its directions, all round the lamp:
    /// a symmetry that a scan takes for granted leaves its results without uncertainty. Where a day has no time for
    /// it, the part of the circle that the symmetry of the file leaves; where there is none, the grid that loses least.
    pub fn choose(light: &IntensityDistribution) -> Self {
        let peak_cd = light.peak().intensity_cd;
        let symmetry = light.detect_symmetry(SAME * peak_cd);
        let part = match symmetry {
            Symmetry::None | Symmetry::Rotational => WHOLE,
            Symmetry::C0C180 => [0.0, 180.0],
            Symmetry::C90C270 => [90.0, 270.0],
            Symmetry::Quadrant => [0.0, 90.0],
        };
        let narrowest = (0..light.c_deg().len()).filter_map(|plane| Some(light.beam_angle(plane)?.full_angle_deg()));
        let finest = STEPS_GAMMA_DEG[STEPS_GAMMA_DEG.len() - 1];
        let most_gamma = (narrowest.fold(f64::INFINITY, f64::min) / STEPS_IN_BEAM).max(finest);
        let finest_c = STEPS_C_DEG[STEPS_C_DEG.len() - 1];
        let most_c = (narrowest_over_c_deg(light) / STEPS_IN_LOBE).max(finest_c);
        let grids = |[first, last]: [f64; 2], most_c: f64, most_gamma: f64| -> Vec<Self> {
            let steps = STEPS_C_DEG
                .into_iter()
                .flat_map(|step_c| STEPS_GAMMA_DEG.map(|gamma| (step_c, gamma)));
            let fine = steps.filter(|(step_c, gamma)| *step_c <= most_c && *gamma <= most_gamma);
            let grids = fine.map(|(step_c, gamma_step_deg)| Self {
                symmetry,
                c_range: [first, last, step_c],
                gamma_step_deg,
                lost: lost(light, [first, step_c, gamma_step_deg]) / peak_cd,
            });
            grids.filter(|grid| grid.points() <= MOST_POINTS).collect()
        };
        let good = |grids: &[Self]| {
            let good = grids.iter().filter(|grid| grid.lost <= MOST_LOST);
            good.min_by_key(|grid| grid.points()).cloned()
        };
        // The coarsest steps are never more readings than a day has time for: there is always one that loses least.
        let least = || {
            let any = grids(WHOLE, f64::INFINITY, f64::INFINITY);
            any.into_iter().min_by(|a, b| a.lost.total_cmp(&b.lost))
        };
        good(&grids(WHOLE, most_c, most_gamma))
            .or_else(|| good(&grids(part, most_c, most_gamma)))
            .or_else(least)
            .unwrap_or(Self {
                symmetry,
                c_range: [0.0, 360.0, STEPS_C_DEG[0]],
                gamma_step_deg: STEPS_GAMMA_DEG[0],
                lost: 1.0,
            })
    }

    fn planes(&self) -> usize {
        ((self.c_range[1] - self.c_range[0]) / self.c_range[2]).round() as usize + 1
    }

    fn gammas(&self) -> usize {
        (180.0 / self.gamma_step_deg).round() as usize + 1
    }

    fn points(&self) -> usize {
        self.planes() * self.gammas()
    }
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let symmetry = match self.symmetry {
            Symmetry::None => "no symmetry in the file",
            Symmetry::Rotational => "the file is rotationally symmetric",
            Symmetry::C0C180 => "the file is symmetric about C 0°–180°",
            Symmetry::C90C270 => "the file is symmetric about C 90°–270°",
            Symmetry::Quadrant => "the file is symmetric about both principal planes",
        };
        let [first, last, step] = self.c_range;
        write!(
            f,
            "plan: {} half-planes, C {first}° to {last}° by {step}°, × {} γ by {}°: {symmetry}; between them at most {:.1} % of the peak is lost",
            self.planes(),
            self.gammas(),
            self.gamma_step_deg,
            100.0 * self.lost
        )
    }
}

/// Width over C between the halves of the narrowest lobe around its largest intensity, degrees; infinite without lobes.
fn narrowest_over_c_deg(light: &IntensityDistribution) -> f64 {
    let mut narrowest = f64::INFINITY;
    let peak_cd = light.peak().intensity_cd;
    for gamma_deg in light.gamma_deg() {
        if matches!(*gamma_deg, 0.0 | 180.0) {
            continue;
        }
        let at = |c_deg: f64| light.intensity_cd_at(c_deg, *gamma_deg);
        let values = light.c_deg().iter().map(|c_deg| (*c_deg, at(*c_deg)));
        let Some((middle, most)) = values.max_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        if most < LOBE_SHARE * peak_cd {
            continue;
        }
        let reach = |way: f64| {
            (1..=180)
                .map(|k| way * f64::from(k))
                .find(|off| at(middle + off) < 0.5 * most)
        };
        if let (Some(left), Some(right)) = (reach(-1.0), reach(1.0)) {
            narrowest = narrowest.min(right - left);
        }
    }
    narrowest
}

/// Largest error at the directions of `light` when it is read at C = first, first + step, … all round and γ = 0, step, …
/// and interpolated between, cd.
fn lost(light: &IntensityDistribution, [first, step_c, step_gamma]: [f64; 3]) -> f64 {
    let count = |range: f64, step: f64| (range / step).round() as usize;
    let c_deg: Vec<f64> = (0..count(360.0, step_c))
        .map(|k| (first + k as f64 * step_c).rem_euclid(360.0))
        .collect();
    let mut c_deg = c_deg;
    c_deg.sort_by(f64::total_cmp);
    let gamma_deg: Vec<f64> = (0..=count(180.0, step_gamma)).map(|k| k as f64 * step_gamma).collect();
    let read = |c: &f64| -> Vec<f64> {
        gamma_deg
            .iter()
            .map(|gamma| light.intensity_cd_at(*c, *gamma))
            .collect()
    };
    let intensity_cd = c_deg.iter().flat_map(read).collect();
    let Ok(coarse) = IntensityDistribution::new(c_deg, gamma_deg, intensity_cd) else {
        return f64::INFINITY;
    };
    let mut worst = 0.0f64;
    for (plane, c_deg) in light.c_deg().iter().enumerate() {
        for (gamma_deg, intensity_cd) in light.gamma_deg().iter().zip(light.row(plane)) {
            worst = worst.max((coarse.intensity_cd_at(*c_deg, *gamma_deg) - intensity_cd).abs());
        }
    }
    worst
}

/// Text of the plan for the luminaire of the file `name`, at `distance_mm`: that of the day with this grid.
pub fn text(name: &str, grid: &Grid, distance_mm: f64) -> String {
    let range = |[from, to, step]: [f64; 3]| format!("[{from}, {to}, {step}]");
    let name = name.replace(['"', '\\', ','], "_");
    let mut text = String::new();
    for line in super::super::PLAN.lines() {
        let key = line.split([' ', '=']).next().unwrap_or("");
        let comment = line.find('#').map_or("", |at| &line[at..]);
        let set = |value: String| format!("{:<31} {comment}", format!("{key} = {value}"));
        text += match key {
            "name" if line.contains("×") => format!("name = {name:?}"),
            "c_range" => set(range(grid.c_range)),
            "gamma_range" if line.contains("180, 2]") => set(range([0.0, 180.0, grid.gamma_step_deg])),
            "reference_every" => {
                set(grid.gammas().to_string()).replace("91 points", &format!("{} points", grid.gammas()))
            }
            "distance_mm" => set(format!("{distance_mm:.1}")),
            "#" if line.starts_with("# The distribution:") => format!("# {grid}."),
            _ => line.to_owned(),
        }
        .trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(c: &[f64], step: f64, of: impl Fn(f64, f64) -> f64) -> IntensityDistribution {
        let gamma: Vec<f64> = (0..=(180.0 / step) as usize).map(|k| k as f64 * step).collect();
        let values = c
            .iter()
            .flat_map(|c| gamma.iter().map(|gamma| of(*c, *gamma)).collect::<Vec<_>>())
            .collect();
        IntensityDistribution::new(c.to_vec(), gamma.clone(), values).unwrap()
    }

    fn every(step: f64) -> Vec<f64> {
        (0..(360.0 / step) as usize).map(|k| k as f64 * step).collect()
    }

    fn lobe(gamma: f64, fwhm: f64) -> f64 {
        1000.0 * 0.5f64.powf((2.0 * gamma / fwhm).powi(2))
    }

    #[test]
    fn a_narrow_beam_takes_fine_gamma_and_symmetry_saves_half_planes() {
        let spot = Grid::choose(&light(&[0.0], 1.0, |_, gamma| lobe(gamma, 12.0)));
        assert_eq!(
            (spot.symmetry, spot.c_range, spot.gamma_step_deg),
            (Symmetry::Rotational, [0.0, 360.0, 45.0], 1.0)
        );
        let wide = Grid::choose(&light(&[0.0], 1.0, |_, gamma| lobe(gamma, 100.0)));
        assert_eq!(wide.gamma_step_deg, 5.0);
        let oval = |c: f64, gamma: f64| lobe(gamma, 60.0 + 20.0 * (2.0 * c.to_radians()).cos());
        let quadrant = Grid::choose(&light(&every(5.0), 2.5, oval));
        assert_eq!((quadrant.symmetry, quadrant.c_range[1]), (Symmetry::Quadrant, 360.0));
        assert!(quadrant.lost <= MOST_LOST && quadrant.c_range[2] > 5.0, "{quadrant}");
        let leaning =
            |c: f64, gamma: f64| oval(c, gamma) * (1.0 + 0.3 * (gamma / 90.0) * (c - 30.0).to_radians().cos());
        let none = Grid::choose(&light(&every(5.0), 2.5, leaning));
        assert_eq!((none.symmetry, none.c_range[1]), (Symmetry::None, 360.0));
        assert!(none.lost <= MOST_LOST, "{none}");
    }

    #[test]
    fn a_lamp_that_no_day_has_time_for_gets_the_grid_that_loses_least() {
        // Without symmetry: no part of the circle serves in place of the whole.
        let leaning = |c: f64| 1.0 + 0.2 * (c - 37.0).to_radians().cos();
        let spikes = |c: f64, gamma: f64| lobe(gamma, 40.0) * leaning(c) * if c % 10.0 == 0.0 { 1.0 } else { 0.5 };
        let grid = Grid::choose(&light(&every(2.5), 0.5, spikes));
        assert!(grid.points() <= MOST_POINTS && grid.lost > 0.1, "{grid}");
        assert!(grid.to_string().contains("% of the peak is lost"));
    }
}
