//! What a spline over C leaves open between the half-planes that it goes through: by rings, which were read all round,
//! and by half-planes that are left out in turn.

use crate::around::{AroundSpline, BEYOND_RINGS};

/// What a spline misses in a gap, in what it misses of a half-plane that is left out: the gap is then twice as wide.
pub const OF_LEFT_OUT: f64 = 0.25;

/// Half-planes that were read, without the poles.
#[derive(Debug, Clone, Copy)]
pub struct ReadHalfPlanes<'a> {
    /// Half-planes in [0, 360), rising, degrees; three or more.
    pub c_deg: &'a [f64],
    /// γ, rising, degrees.
    pub gamma_deg: &'a [f64],
    /// The light by γ and half-plane, in any unit.
    pub light: &'a [Vec<f64>],
}

/// The most that a spline through half-planes misses of a ring.
#[derive(Debug, Clone, PartialEq)]
pub struct MissedOfRing {
    /// γ of the ring, degrees.
    pub gamma_deg: f64,
    /// From each half-plane to the next, in the unit of their light.
    pub largest: Vec<f64>,
}

/// Standard uncertainty anywhere by what is missed of rings.
pub fn u_beyond_rings(missed: f64) -> f64 {
    0.5 * BEYOND_RINGS * missed
}

/// Of the light of all half-planes `c_deg` at one γ: the spline through the others at each of them, less its light.
///
/// # Panics
/// Where there is one half-plane alone, or not as many values.
pub fn left_out(c_deg: &[f64], light: &[f64]) -> Vec<f64> {
    let without = |out: usize, values: &[f64]| -> Vec<f64> { [&values[..out], &values[out + 1..]].concat() };
    (0..c_deg.len())
        .map(|out| AroundSpline::through(&without(out, c_deg), &without(out, light)).at(c_deg[out]) - light[out])
        .collect()
}

/// Standard uncertainty of the spline by γ and gap, from each half-plane to the next, in the unit of their light: what
/// is missed of `rings`, rising in γ, from one to the next, or of the half-planes beside the gap that are left out,
/// where that is more. It is nowhere more than the largest light of the γ: where there is no light none is missed.
pub fn u_between(read: &ReadHalfPlanes<'_>, rings: &[MissedOfRing]) -> Vec<Vec<f64>> {
    let gaps = read.c_deg.len();
    let of_rings = |gamma_deg: f64, gap: usize| -> f64 {
        let next = rings.partition_point(|ring| ring.gamma_deg < gamma_deg);
        match (next.checked_sub(1).map(|before| &rings[before]), rings.get(next)) {
            (Some(a), Some(b)) => {
                let share = (gamma_deg - a.gamma_deg) / (b.gamma_deg - a.gamma_deg);
                a.largest[gap] + (b.largest[gap] - a.largest[gap]) * share
            }
            (Some(one), None) | (None, Some(one)) => one.largest[gap],
            (None, None) => 0.0,
        }
    };
    let of_row = |(gamma, light): (&f64, &Vec<f64>)| -> Vec<f64> {
        let brightest = light.iter().copied().fold(0.0, f64::max);
        let left_out = left_out(read.c_deg, light);
        let of_gap = |gap: usize| {
            let beside = left_out[gap].abs().max(left_out[(gap + 1) % gaps].abs());
            u_beyond_rings(of_rings(*gamma, gap))
                .max(OF_LEFT_OUT * beside)
                .min(brightest)
        };
        (0..gaps).map(of_gap).collect()
    };
    read.gamma_deg.iter().zip(read.light).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_missed_as_the_gaps_beside_it_or_the_rings_more_than_that() {
        let c_deg: Vec<f64> = (0..8).map(|k| 45.0 * f64::from(k)).collect();
        // Light of 100 with one half-plane at C 90° that is brighter, and none at γ 80°.
        let of_plane = |c: &f64| if *c == 90.0 { 120.0 } else { 100.0 };
        let row: Vec<f64> = c_deg.iter().map(of_plane).collect();
        let light = [row.clone(), vec![0.0; 8]];
        let read = ReadHalfPlanes {
            c_deg: &c_deg,
            gamma_deg: &[30.0, 80.0],
            light: &light,
        };
        let missed = left_out(&c_deg, &row);
        assert!((missed[2] + 20.0).abs() < 1e-9, "{missed:?}");
        let quiet = u_between(&read, &[]);
        assert!((quiet[0][1] - 5.0).abs() < 1e-9 && quiet[0][1] == quiet[0][2]);
        assert!(quiet[0][5] < 1.0, "{quiet:?}");
        let mut largest = vec![0.0; 8];
        largest[5] = 10.0;
        let rings = [MissedOfRing {
            gamma_deg: 40.0,
            largest,
        }];
        let seen = u_between(&read, &rings);
        assert!((seen[0][5] - u_beyond_rings(10.0)).abs() < 1e-9);
        assert_eq!(seen[0][1], quiet[0][1]);
        assert_eq!(seen[1], vec![0.0; 8], "in the dark");
    }
}
