//! Where the luminaire on the goniophotometer really points: a chain of rotations with the errors of each joint in it.
//!
//! Bench frame: origin at the intersection of the axes, X towards the detector, Z up. At (C, γ) = (0, 0) the
//! luminaire's z lies along X, its x along −Y and its y along Z: seen from behind, C runs counter-clockwise. The C
//! axis turns the luminaire about X, then the γ axis turns both about Z.

use glam::{DMat3, DVec3};

use crate::injected_effects::InjectedEffects;

/// Pose of the luminaire on the bench, with every error of the bench in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounted {
    /// Luminaire frame → bench frame (a reflection is part of it, see the module).
    rotation: DMat3,
    /// Light centre in the bench frame, mm.
    centre_mm: DVec3,
}

impl Mounted {
    /// The luminaire at the read-back position (C, γ), reached with `travel` (sign of the last γ motion, or a share
    /// of it while play is being taken up).
    pub fn at(c_deg: f64, gamma_deg: f64, travel: f64, injected_effects: &InjectedEffects) -> Self {
        let gamma_deg = gamma_deg
            + injected_effects.gamma_zero.offset_deg
            + injected_effects.gamma_sag.amplitude_deg * gamma_deg.to_radians().cos()
            + 0.5 * injected_effects.backlash.width_deg * travel;
        let c_deg = c_deg + injected_effects.c_zero.offset_deg;
        let at_rest = DMat3::from_cols(-DVec3::Y, DVec3::Z, DVec3::X);
        let stage = DMat3::from_rotation_z(gamma_deg.to_radians())
            * DMat3::from_rotation_y(-injected_effects.axis_nonperp.angle_deg.to_radians())
            * DMat3::from_rotation_x(c_deg.to_radians())
            * at_rest;
        let (tilt, azimuth) = InjectedEffects::polar(
            injected_effects.luminaire_tilt.angle_deg,
            injected_effects.luminaire_tilt.azimuth_deg,
        );
        let (offset, towards) = (
            injected_effects.lateral_centre.offset_mm,
            injected_effects.lateral_centre.azimuth_deg.to_radians(),
        );
        let centre = DVec3::new(
            offset * towards.cos(),
            offset * towards.sin(),
            injected_effects.axial_centre.offset_mm,
        );
        Self {
            rotation: stage * lean(tilt, azimuth + std::f64::consts::PI),
            centre_mm: stage * centre,
        }
    }

    /// A point of the bench frame (mm) in the luminaire frame (mm).
    pub fn to_luminaire(&self, point_mm: DVec3) -> DVec3 {
        self.rotation.transpose() * (point_mm - self.centre_mm)
    }

    /// A direction of the bench frame in the luminaire frame.
    pub fn direction_to_luminaire(&self, direction: DVec3) -> DVec3 {
        self.rotation.transpose() * direction
    }
}

/// Turns z by `angle` towards `azimuth` (rad, from x to y).
pub fn lean(angle: f64, azimuth: f64) -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(-azimuth.sin(), azimuth.cos(), 0.0), angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (C, γ) in degrees of the far detector as the luminaire sees it.
    fn seen(c: f64, gamma: f64, travel: f64, injected_effects: &InjectedEffects) -> (f64, f64) {
        let d = Mounted::at(c, gamma, travel, injected_effects).direction_to_luminaire(DVec3::X);
        (
            d.y.atan2(d.x).to_degrees().rem_euclid(360.0),
            d.z.clamp(-1.0, 1.0).acos().to_degrees(),
        )
    }

    fn close(a: (f64, f64), b: (f64, f64)) {
        assert!(
            (a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-6,
            "{a:?} is not {b:?}"
        );
    }

    #[test]
    fn the_detector_is_seen_at_c_gamma() {
        let none = InjectedEffects::default();
        for (c, gamma) in [(0.0, 30.0), (90.0, 30.0), (215.0, 120.0), (359.0, 1.0)] {
            close(seen(c, gamma, 1.0, &none), (c, gamma));
        }
        close(seen(20.0, -35.0, 1.0, &none), (200.0, 35.0));
        // contracts.md: at (C, γ) the optical axis points to (cos γ, sin γ, 0), and the direction C + 90° points
        // up.
        let mounted = Mounted::at(40.0, 25.0, 0.0, &none);
        let axis = mounted.rotation * DVec3::Z;
        let gamma = 25.0f64.to_radians();
        assert!((axis - DVec3::new(gamma.cos(), gamma.sin(), 0.0)).length() < 1e-12);
        let c90 = 130.0f64.to_radians();
        assert!((mounted.rotation * DVec3::new(c90.cos(), c90.sin(), 0.0) - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn errors_of_the_axes_shift_what_is_seen() {
        let mut injected_effects = InjectedEffects::default();
        injected_effects.gamma_zero.offset_deg = 0.3;
        injected_effects.c_zero.offset_deg = -2.0;
        close(seen(40.0, 30.0, 1.0, &injected_effects), (38.0, 30.3));
        let mut injected_effects = InjectedEffects::default();
        injected_effects.gamma_sag.amplitude_deg = 0.2;
        injected_effects.backlash.width_deg = 0.4;
        close(seen(40.0, 60.0, -1.0, &injected_effects), (40.0, 59.9));
        let mut injected_effects = InjectedEffects::default();
        injected_effects.axis_nonperp.angle_deg = 2.0;
        let (_, gamma) = seen(0.0, 60.0, 0.0, &injected_effects);
        let expected = (60.0f64.to_radians().cos() * 2.0f64.to_radians().cos())
            .acos()
            .to_degrees();
        assert!((gamma - expected).abs() < 1e-9);
    }

    #[test]
    fn a_tilt_is_largest_in_its_half_plane() {
        let mut injected_effects = InjectedEffects::default();
        injected_effects.luminaire_tilt.angle_deg = 0.5;
        injected_effects.luminaire_tilt.azimuth_deg = 60.0;
        close(seen(60.0, 30.0, 1.0, &injected_effects), (60.0, 30.5));
        close(seen(240.0, 30.0, 1.0, &injected_effects), (240.0, 29.5));
    }

    #[test]
    fn an_offset_centre_moves_with_the_luminaire() {
        let mut injected_effects = InjectedEffects::default();
        injected_effects.axial_centre.offset_mm = 20.0;
        let to_detector = Mounted::at(0.0, 0.0, 0.0, &injected_effects).to_luminaire(DVec3::X * 1000.0);
        assert!((to_detector - DVec3::Z * 980.0).length() < 1e-9);
        let mut injected_effects = InjectedEffects::default();
        injected_effects.lateral_centre.offset_mm = 10.0;
        injected_effects.lateral_centre.azimuth_deg = 30.0;
        // At γ = 90° in the half-plane of the offset, the centre stands 10 mm nearer to the detector.
        let to_detector = Mounted::at(30.0, 90.0, 0.0, &injected_effects).to_luminaire(DVec3::X * 1000.0);
        assert!((to_detector.length() - 990.0).abs() < 1e-9);
    }
}
