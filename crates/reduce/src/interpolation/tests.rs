//! Distributions of closed form on coarse grids against the same ones on a fine grid.

use super::*;

/// Intensity over (C, γ) in degrees.
type Shape = Box<dyn Fn(f64, f64) -> f64>;

/// cosⁿ about an axis tilted by `tilt_deg` towards C `azimuth_deg`.
fn lobe(exponent: f64, tilt_deg: f64, azimuth_deg: f64) -> Shape {
    let direction = |c: f64, gamma: f64| {
        let ((sin_c, cos_c), (sin, cos)) = (c.to_radians().sin_cos(), gamma.to_radians().sin_cos());
        [sin * cos_c, sin * sin_c, cos]
    };
    let axis = direction(azimuth_deg, tilt_deg);
    Box::new(move |c, gamma| {
        let cos: f64 = direction(c, gamma).iter().zip(axis).map(|(a, b)| a * b).sum();
        cos.max(0.0).powf(exponent)
    })
}

/// cosⁿ γ·(1 + e·sin²γ·cos mC).
fn folded(exponent: f64, ellipticity: f64, fold: f64) -> Shape {
    Box::new(move |c, gamma| {
        let (sin, cos) = gamma.to_radians().sin_cos();
        cos.max(0.0).powf(exponent) * (1.0 + ellipticity * sin * sin * (fold * c.to_radians()).cos())
    })
}

fn batwing(gamma_deg: f64, width_deg: f64) -> Shape {
    Box::new(move |_, gamma| (-((gamma - gamma_deg) / width_deg).powi(2)).exp())
}

fn cut_off(gamma_deg: f64, width_deg: f64) -> Shape {
    Box::new(move |_, gamma| 1.0 / (1.0 + ((gamma - gamma_deg) / width_deg).exp()))
}

fn shapes() -> Vec<Shape> {
    let mut shapes = Vec::new();
    for exponent in [1.0, 2.0, 5.3, 12.0, 40.0, 120.0] {
        shapes.push(lobe(exponent, 0.0, 0.0));
        shapes.push(lobe(exponent, 25.0, 37.0));
        for fold in [1.0, 2.0, 3.0, 4.0] {
            shapes.push(folded(exponent, 0.4, fold));
        }
    }
    for (gamma, width) in [(20.0, 12.0), (35.0, 15.0), (55.0, 20.0), (65.0, 9.0), (45.6, 14.4)] {
        shapes.push(batwing(gamma, width));
    }
    for (gamma, width) in [(30.0, 2.0), (45.0, 5.0), (62.0, 3.0), (88.0, 8.0)] {
        shapes.push(cut_off(gamma, width));
    }
    let two = (lobe(8.0, 30.0, 10.0), lobe(3.0, 100.0, 200.0));
    shapes.push(Box::new(move |c, gamma| two.0(c, gamma) + 0.6 * two.1(c, gamma)));
    shapes
}

fn on_grid(shape: &Shape, c_step: f64, gamma_step: f64) -> IntensityDistribution {
    let every = |step: f64, last: f64| -> Vec<f64> {
        (0..=(last / step).round() as u32)
            .map(|i| f64::from(i) * step)
            .collect()
    };
    let (c, gamma) = (every(c_step, 360.0 - c_step), every(gamma_step, 180.0));
    let intensity = c
        .iter()
        .flat_map(|&c| gamma.iter().map(move |&gamma| (c, gamma)))
        .map(|(c, gamma)| shape(c, gamma))
        .collect();
    IntensityDistribution::new(c, gamma, intensity).unwrap()
}

#[test]
fn the_flux_of_known_distributions_lies_within_two_u_or_the_grid_is_too_coarse() {
    let flux = |distribution: &IntensityDistribution| distribution.flux_lm();
    let shapes = shapes();
    let truth: Vec<f64> = shapes.iter().map(|shape| flux(&on_grid(shape, 5.0, 0.5))).collect();
    for (c_step, gamma_step, least_resolved) in [
        (15.0, 2.0, 44),
        (15.0, 5.0, 44),
        (15.0, 15.0, 26),
        (30.0, 10.0, 31),
        (45.0, 15.0, 21),
        (30.0, 30.0, 14),
        (45.0, 45.0, 8),
        (90.0, 5.0, 0),
    ] {
        let (mut resolved, mut within_one) = (0, 0);
        for (number, (shape, truth)) in shapes.iter().zip(&truth).enumerate() {
            let grid = on_grid(shape, c_step, gamma_step);
            if !unresolved(&grid).is_empty() {
                continue;
            }
            let u = u_of(&grid, Kind::Integral, flux).unwrap() + 1e-5 * truth;
            let off = (flux(&grid) - truth).abs();
            assert!(
                off < 2.0 * u,
                "{c_step}°/{gamma_step}°, shape {number}: {off} of {truth}, u = {u}"
            );
            assert!(
                u < 0.35 * truth,
                "{c_step}°/{gamma_step}°, shape {number}: u = {u} of {truth}"
            );
            resolved += 1;
            within_one += usize::from(off < u);
        }
        assert!(resolved >= least_resolved, "{c_step}°/{gamma_step}°: {resolved}");
        assert!(
            20 * within_one >= 13 * resolved,
            "{c_step}°/{gamma_step}°: {within_one} of {resolved}"
        );
    }
}

#[test]
fn what_no_direction_hits_is_not_called_known() {
    // A lobe of ± 6° between the directions, and a square luminaire in four half-planes.
    assert_eq!(unresolved(&on_grid(&lobe(120.0, 20.0, 20.0), 15.0, 15.0)).len(), 2);
    assert_eq!(unresolved(&on_grid(&folded(2.0, 0.4, 4.0), 90.0, 5.0)).len(), 1);
    assert!(unresolved(&on_grid(&folded(2.0, 0.2, 4.0), 45.0, 5.0)).is_empty());
}

#[test]
fn the_largest_intensity_between_directions_is_allowed_for() {
    for exponent in [1.0, 5.3, 12.0, 40.0] {
        for tilt in [0.0, 3.0, 7.5, 20.0, 38.0] {
            for (c_step, gamma_step) in [(15.0, 2.0), (15.0, 5.0), (15.0, 15.0), (30.0, 10.0)] {
                let grid = on_grid(&lobe(exponent, tilt, 52.0), c_step, gamma_step);
                if !unresolved(&grid).is_empty() {
                    continue;
                }
                let off = 1.0 - grid.peak().intensity_cd;
                let u = above_the_largest_cd(&grid);
                assert!(
                    off <= 2.0 * u + 1e-9,
                    "n {exponent}, {tilt}°, {c_step}°/{gamma_step}°: {off}, u = {u}"
                );
            }
        }
    }
}
