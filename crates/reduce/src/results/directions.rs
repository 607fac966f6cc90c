//! `luminaire.directions.csv`: every direction of the distribution with its uncertainty and where it comes from, which
//! photometric files cannot say.

use std::fmt::Write as _;

use isolux_photometry::Symmetry;

use crate::Reduction;
use crate::budget::of_directions_cd;
use crate::grid::is_pole;
use crate::samples::Sample;
use crate::straight::straight_lines_miss_cd;

/// Columns.
const HEADER: &str = "c_deg,gamma_deg,intensity_cd,read_cd,u_own_cd,u_cd,u_between_cd,origin,missing";

/// The table. Where a part of the uncertainty is not known, `missing` says which and nothing stands for `u_cd`.
pub fn directions(reduction: &Reduction) -> String {
    let grid = &reduction.grid;
    let distribution = &grid.distribution;
    let raw = grid.as_read().intensity_cd();
    let missing = reduction.i_max.missing.join("; ").replace('"', "\"\"");
    let mut text = format!("{HEADER}\n");
    let gammas = distribution.gamma_deg();
    let missed_cd = straight_lines_miss_cd(distribution);
    for (place, u_cd) in of_directions_cd(grid, &reduction.common).into_iter().enumerate() {
        let (c_deg, gamma_deg) = (distribution.c_deg()[place / gammas.len()], gammas[place % gammas.len()]);
        let (intensity_cd, read_cd) = (distribution.intensity_cd()[place], raw[place]);
        let sample = &grid.nodes[grid.sample_of[place]];
        let origin = origin(reduction, sample, c_deg);
        let number = |value: f64, is_known: bool| if is_known { value.to_string() } else { String::new() };
        // Of a scan that is not finished nothing is known of what stands between its half-planes.
        let own = number(sample.u_own_cd(), origin != INTERPOLATED || reduction.partial.is_none());
        let u_cd = number(u_cd, missing.is_empty());
        let between = number(missed_cd[place], reduction.partial.is_none());
        let _ = writeln!(
            text,
            "{c_deg},{gamma_deg},{intensity_cd},{read_cd},{own},{u_cd},{between},{origin},\"{missing}\""
        );
    }
    text
}

/// Between half-planes of a scan that is not finished, or that chose its half-planes.
const INTERPOLATED: &str = "interpolated";

/// How the intensity of a direction in the half-plane C came about.
fn origin(reduction: &Reduction, sample: &Sample, c_deg: f64) -> &'static str {
    let of_pole = is_pole(sample.gamma_deg);
    let partial = reduction.partial.as_ref();
    let mirrored = reduction.grid.assumed != Symmetry::None && sample.c_deg != c_deg;
    match sample.u_curve_cd {
        _ if !of_pole
            && reduction
                .between
                .as_ref()
                .is_some_and(|between| !between.is_read(sample.c_deg)) =>
        {
            INTERPOLATED
        }
        _ if !of_pole && partial.is_some_and(|partial| !partial.holds(sample.c_deg, sample.gamma_deg)) => INTERPOLATED,
        _ if !of_pole && mirrored => "by_symmetry",
        Some(_) => "in_motion",
        None => "at_rest",
    }
}
