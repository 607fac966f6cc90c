//! What else may stand in the path: windows, filters, vapour, a thin lens, a Lambertian target. Closed forms, each
//! tested against its limits and for the balance of energy.

use std::f64::consts::PI;

/// Fresnel reflectances (s, p) of a plane boundary for light from index `n1` at the cosine of incidence into `n2`; (1,
/// 1) beyond the critical angle.
pub fn fresnel(n1: f64, n2: f64, cos_incidence: f64) -> (f64, f64) {
    let sine = n1 / n2 * (1.0 - cos_incidence * cos_incidence).max(0.0).sqrt();
    if sine >= 1.0 {
        return (1.0, 1.0);
    }
    let cos_inside = (1.0 - sine * sine).sqrt();
    let s = (n1 * cos_incidence - n2 * cos_inside) / (n1 * cos_incidence + n2 * cos_inside);
    let p = (n2 * cos_incidence - n1 * cos_inside) / (n2 * cos_incidence + n1 * cos_inside);
    (s * s, p * p)
}

/// What a plane-parallel plate does to unpolarised light: shares reflected, transmitted, absorbed; sum 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Reflected.
    pub reflected: f64,
    /// Transmitted.
    pub transmitted: f64,
    /// Absorbed.
    pub absorbed: f64,
}

/// A plate of index `n` in air with the internal transmittance `internal` along the normal; all reflections between its
/// faces add without interference: T = (1 − R)²τ/(1 − R²τ²).
pub fn plate(n: f64, internal: f64, cos_incidence: f64) -> Shares {
    let sine = (1.0 - cos_incidence * cos_incidence).max(0.0).sqrt() / n;
    let tau = internal.powf(1.0 / (1.0 - sine * sine).sqrt());
    let (s, p) = fresnel(1.0, n, cos_incidence);
    let of = |r: f64| {
        let transmitted = (1.0 - r).powi(2) * tau / (1.0 - r * r * tau * tau);
        let reflected = r * (1.0 + tau * transmitted);
        let absorbed = (1.0 - r) * (1.0 - tau) / (1.0 - r * tau);
        [reflected, transmitted, absorbed]
    };
    let (s, p) = (of(s), of(p));
    Shares {
        reflected: 0.5 * (s[0] + p[0]),
        transmitted: 0.5 * (s[1] + p[1]),
        absorbed: 0.5 * (s[2] + p[2]),
    }
}

/// Transmittance of vapour or a filter: 10^(−ε·c·ℓ), ε in l/(mol·cm), c in mol/l, ℓ in cm (Beer–Lambert, decadic).
pub fn beer_lambert(epsilon: f64, concentration_mol_l: f64, path_cm: f64) -> f64 {
    10.0_f64.powf(-epsilon * concentration_mol_l * path_cm)
}

/// Illuminance in the image of a thin lens without vignetting: E = π·L·τ·cos⁴θ / (4·N²·(1 + |m|)²).
pub fn thin_lens(luminance: f64, transmittance: f64, f_number: f64, magnification: f64, field_angle_rad: f64) -> f64 {
    PI * luminance * transmittance * field_angle_rad.cos().powi(4)
        / (4.0 * f_number * f_number * (1.0 + magnification.abs()).powi(2))
}

/// Share of the lens's pupil that a second aperture of equal radius, displaced by `shift` radii, lets through:
/// mechanical vignetting, the overlap of two circles.
pub fn overlap(shift: f64) -> f64 {
    let x = (0.5 * shift.abs()).min(1.0);
    2.0 / PI * (x.acos() - x * (1.0 - x * x).sqrt())
}

/// Luminance of a Lambertian target of reflectance `rho` under `illuminance`: L = ρE/π.
pub fn lambertian(rho: f64, illuminance: f64) -> f64 {
    rho * illuminance / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Random};

    #[test]
    fn fresnel_against_its_known_values() {
        let (s, p) = fresnel(1.0, 1.5, 1.0);
        assert!((s - 0.04).abs() < 1e-15 && (p - 0.04).abs() < 1e-15);
        // Brewster's angle: no p reflection; s is ((n² − 1)/(n² + 1))².
        let (s, p) = fresnel(1.0, 1.5, (1.5_f64.atan()).cos());
        assert!(p < 1e-30 && (s - (1.25_f64 / 3.25).powi(2)).abs() < 1e-15);
        assert_eq!(fresnel(1.5, 1.0, 0.5), (1.0, 1.0));
        let (s, p) = fresnel(1.0, 1.5, 1e-12);
        assert!(s > 1.0 - 1e-10 && p > 1.0 - 1e-10);
    }

    #[test]
    fn a_plate_loses_no_energy_and_clear_glass_absorbs_none() {
        for k in 0..90 {
            let cos = f64::from(k).to_radians().cos();
            let clear = plate(1.52, 1.0, cos);
            assert!(clear.absorbed.abs() < 1e-12, "{k}°: {clear:?}");
            let grey = plate(1.52, 0.9, cos);
            assert!((grey.reflected + grey.transmitted + grey.absorbed - 1.0).abs() < 1e-12 && grey.absorbed > 0.0);
        }
        // Two faces at normal incidence: 2n/(n² + 1).
        assert!((plate(1.52, 1.0, 1.0).transmitted - 2.0 * 1.52 / (1.52 * 1.52 + 1.0)).abs() < 1e-12);
    }

    #[test]
    fn a_plate_agrees_with_photons_that_bounce() {
        let (n, internal, cos) = (1.7, 0.8_f64, 0.6);
        let (s, p) = fresnel(1.0, n, cos);
        let sine = (1.0_f64 - cos * cos).sqrt() / n;
        let tau = internal.powf(1.0 / (1.0 - sine * sine).sqrt());
        let random = Random::new(3, Purpose::Trial);
        let (mut through, photons) = (0.0, 200_000_u64);
        for index in 0..photons {
            let mut numbers = random.sequence(index);
            let r = if index % 2 == 0 { s } else { p };
            if numbers.uniform() < r {
                continue;
            }
            loop {
                if numbers.uniform() >= tau {
                    break;
                }
                if numbers.uniform() >= r {
                    // Out through the face it has come to: the far one every other time.
                    through += 1.0;
                    break;
                }
                if numbers.uniform() >= tau || numbers.uniform() >= r {
                    break;
                }
            }
        }
        let (found, expected) = (through / photons as f64, plate(n, internal, cos).transmitted);
        assert!(
            (found - expected).abs() < 4.5 * (expected / photons as f64).sqrt(),
            "{found} {expected}"
        );
    }

    #[test]
    fn lens_and_vapour_in_their_limits() {
        assert!((thin_lens(1000.0, 1.0, 2.0, 0.0, 0.0) - PI * 1000.0 / 16.0).abs() < 1e-9);
        assert!(
            (thin_lens(1.0, 1.0, 1.0, 0.0, 0.5) / thin_lens(1.0, 1.0, 1.0, 0.0, 0.0) - 0.5_f64.cos().powi(4)).abs()
                < 1e-15
        );
        assert!((overlap(0.0) - 1.0).abs() < 1e-15 && overlap(2.0).abs() < 1e-15 && overlap(1.0) < 0.5);
        assert!((beer_lambert(100.0, 0.01, 1.0) - 0.1).abs() < 1e-15);
        assert!((lambertian(0.5, PI) - 0.5).abs() < 1e-15);
    }
}
