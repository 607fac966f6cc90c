//! What a plan will give, before it is carried out: a plan that no reduction takes is refused before the scan, not
//! after it.

use isolux_photometry::IntensityDistribution;
use isolux_record::{Plan, Station};

use crate::blocks;
use crate::error::ReduceError;
use crate::grid::Grid;
use crate::samples::{Sample, unsigned};

/// The distribution that `plan` on `station` gives of a lamp with 1 cd in every direction.
///
/// # Errors
/// What [`crate::reduce`] would say of such a run: no lit readings of the lux meter, no grid, half-planes that do not
/// go round.
pub fn check_feasibility(plan: &Plan, station: &Station) -> Result<IntensityDistribution, ReduceError> {
    let directions = blocks::planned(plan, station.bench().distance_mm)?;
    let full_circle = directions.iter().any(|(c, _)| *c == 0.0);
    let mut samples: Vec<Sample> = directions
        .iter()
        .map(|&(c, gamma)| {
            let (c_deg, gamma_deg) = unsigned(c, gamma);
            Sample {
                c_deg,
                gamma_deg,
                closing: full_circle && c == 360.0 && gamma >= 0.0,
                true_c_deg: c_deg,
                true_gamma_deg: gamma_deg,
                intensity_cd: 1.0,
                u_noise_cd: 0.0,
                u_curve_cd: None,
                u_digit_cd: 0.0,
                display: None,
                lamp_s: None,
            }
        })
        .collect();
    samples.sort_by(|a, b| {
        a.closing
            .cmp(&b.closing)
            .then(a.c_deg.total_cmp(&b.c_deg))
            .then(a.gamma_deg.total_cmp(&b.gamma_deg))
    });
    // A direction that two blocks or both signs of γ ask for is one node.
    samples.dedup_by(|a, b| (a.closing, a.c_deg, a.gamma_deg) == (b.closing, b.c_deg, b.gamma_deg));
    Ok(Grid::new(&samples)?.distribution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use camino::Utf8Path;

    fn checked(block: &str) -> Result<IntensityDistribution, ReduceError> {
        let station = Station::parse(Utf8Path::new("station.toml"), isolux_any_record::STATION).unwrap();
        let plan = format!("format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\n{block}\n");
        check_feasibility(&Plan::parse(Utf8Path::new("plan.toml"), &plan).unwrap(), &station)
    }

    #[test]
    fn a_plan_that_closes_gives_its_grid() {
        let grid = checked("c_range = [0.0, 360.0, 30.0]\ngamma_range = [0.0, 90.0, 5.0]").unwrap();
        assert_eq!((grid.c_deg().len(), grid.gamma_deg().len()), (12, 19));
        assert!(
            (grid.flux_lm() - std::f64::consts::TAU).abs() < 1e-2,
            "1 cd over a hemisphere"
        );
        let grid = checked("c_deg = [0.0, 90.0]\ngamma_range = [-90.0, 90.0, 10.0]").unwrap();
        assert_eq!(grid.c_deg(), [0.0, 90.0, 180.0, 270.0]);
    }

    #[test]
    fn a_plan_that_no_reduction_takes_is_refused() {
        let open = checked("c_deg = [0.0, 30.0, 60.0]\ngamma_range = [0.0, 90.0, 5.0]");
        assert!(matches!(open, Err(ReduceError::NotRound(_))), "{open:?}");
        let dark = checked("instrument = \"spectroradiometer\"\nc_deg = 0.0\ngamma_deg = 0.0");
        assert!(matches!(dark, Err(ReduceError::NoLight)), "{dark:?}");
        let one = checked("c_deg = 0.0\ngamma_deg = 0.0");
        assert!(matches!(one, Err(ReduceError::NoLight)), "{one:?}");
    }
}
