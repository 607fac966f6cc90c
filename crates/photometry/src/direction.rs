//! (C, γ) and the unit vector that they stand for, in the frame of the crate.

use glam::DVec3;

/// d(C, γ) = (sin γ cos C, sin γ sin C, cos γ).
pub fn direction(c_deg: f64, gamma_deg: f64) -> DVec3 {
    let ((sin_c, cos_c), (sin, cos)) = (c_deg.to_radians().sin_cos(), gamma_deg.to_radians().sin_cos());
    DVec3::new(sin * cos_c, sin * sin_c, cos)
}

/// C in −180…180 and γ in 0…180 of a direction of any length.
pub fn angles_deg(direction: DVec3) -> (f64, f64) {
    (direction.y.atan2(direction.x).to_degrees(), polar_deg(direction))
}

/// γ alone.
pub fn polar_deg(direction: DVec3) -> f64 {
    direction.truncate().length().atan2(direction.z).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_has_the_angles_that_made_it() {
        for (c, gamma, [x, y, z]) in [
            (0.0, 90.0, [1.0, 0.0, 0.0]),
            (90.0, 90.0, [0.0, 1.0, 0.0]),
            (-135.0, 180.0, [0.0, 0.0, -1.0]),
        ] {
            let made = direction(c, gamma);
            assert!((made - DVec3::new(x, y, z)).length() < 1e-15, "{made}");
        }
        let (c, gamma) = angles_deg(7.0 * direction(-130.0, 71.0));
        assert!((c + 130.0).abs() < 1e-12 && (gamma - 71.0).abs() < 1e-12, "{c} {gamma}");
    }
}
