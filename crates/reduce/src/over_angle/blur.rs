//! The size of the lamp: near by, a spectroradiometer sees every part of it under an angle of its own, and reads the
//! mixture.

use isolux_photometry::{HalfPlanes, IntensityDistribution, angles_deg, direction};
use isolux_spectrum::Spectrum;

use super::mix;

/// What would be read of a lamp that has, in each direction, the spectra that were read: they are mixed once more as
/// the disc of the lamp mixed them. Over a disc that is seen under the half angle a, the mean of a function is its
/// value plus a²/8 of its Laplacian; the function is the light, intensity times spectrum of one lumen.
pub fn blurred(
    half_planes: &HalfPlanes,
    directions_deg: &[(f64, f64)],
    per_lumen: &[Spectrum],
    distribution: &IntensityDistribution,
    half_angle_deg: f64,
    step_deg: f64,
) -> Vec<Spectrum> {
    // Second differences over less than a step of the spectra would see the bends of their interpolation.
    let h_deg = step_deg.max(half_angle_deg / 2f64.sqrt());
    // mean of four at the distance h = value + h²/4 of the Laplacian
    let share = 0.5 * (half_angle_deg / h_deg).powi(2);
    let of = |(index, &(c_deg, gamma_deg)): (usize, &(f64, f64))| {
        let towards = direction(c_deg, gamma_deg);
        let (sin, cos) = c_deg.to_radians().sin_cos();
        let across = glam::DVec3::new(-sin, cos, 0.0);
        let along = across.cross(towards);
        let (sin_h, cos_h) = h_deg.to_radians().sin_cos();
        let own_cd = distribution.intensity_cd_at(c_deg, gamma_deg).max(0.0);
        let mut parts = vec![(per_lumen[index].clone(), (1.0 - share) * own_cd)];
        for side in [along, -along, across, -across] {
            let (c, gamma) = angles_deg(cos_h * towards + sin_h * side);
            let c = c.rem_euclid(360.0);
            let intensity_cd = distribution.intensity_cd_at(c, gamma).max(0.0);
            if let Some(there) = mix(half_planes, per_lumen, c, gamma) {
                parts.push((there, 0.25 * share * intensity_cd));
            }
        }
        let whole: f64 = parts.iter().map(|(_, weight)| weight).sum();
        let mut value = vec![0.0; per_lumen[index].value().len()];
        for (spectrum, weight) in &parts {
            value
                .iter_mut()
                .zip(spectrum.value())
                .for_each(|(sum, part)| *sum += weight / whole * part);
        }
        // In the dark there is nothing to mix.
        Spectrum::new(per_lumen[index].wavelength_nm().to_vec(), value).unwrap_or_else(|_| per_lumen[index].clone())
    };
    directions_deg.iter().enumerate().map(of).collect()
}
