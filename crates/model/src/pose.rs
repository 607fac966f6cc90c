//! The pose of a flat sensor before the luminaire, in the luminaire frame.

use glam::{DMat3, DVec2, DVec3};

/// Where a sensor stands: R = Rx(tilt_x)·Ry(tilt_y)·Rz(rot_z) (Rz acts first), then a shift by
/// (offset_x, offset_y, distance).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPose {
    /// From the light centre to the sensor's centre along γ = 0.
    pub distance_mm: f64,
    /// Rotation about x, applied last.
    pub tilt_x_deg: f64,
    /// Rotation about y, applied second.
    pub tilt_y_deg: f64,
    /// Rotation about z, applied first.
    pub rot_z_deg: f64,
    /// Shift of the centre in x and y.
    pub offset_mm: DVec2,
    /// A further rotation in the sensor's own axes, before all others: by the first angle, lifting the side at the
    /// second (azimuth in the sensor's plane) towards the lamp. Zero unless an effect tilts the sensor in its mount.
    pub mount_tilt_deg: [f64; 2],
}

impl SensorPose {
    /// A sensor square on the optical axis at `distance_mm`.
    pub const fn facing(distance_mm: f64) -> Self {
        Self {
            distance_mm,
            tilt_x_deg: 0.0,
            tilt_y_deg: 0.0,
            rot_z_deg: 0.0,
            offset_mm: DVec2::ZERO,
            mount_tilt_deg: [0.0; 2],
        }
    }

    /// R, the rotation from the sensor's axes to the luminaire's.
    pub fn rotation(&self) -> DMat3 {
        let rotation = DMat3::from_rotation_x(self.tilt_x_deg.to_radians())
            * DMat3::from_rotation_y(self.tilt_y_deg.to_radians())
            * DMat3::from_rotation_z(self.rot_z_deg.to_radians());
        let [angle, azimuth] = self.mount_tilt_deg;
        if angle == 0.0 {
            return rotation;
        }
        let (sin, cos) = azimuth.to_radians().sin_cos();
        rotation * DMat3::from_axis_angle(DVec3::new(-sin, cos, 0.0), angle.to_radians())
    }

    /// The centre of the sensor.
    pub fn centre_mm(&self) -> DVec3 {
        self.offset_mm.extend(self.distance_mm)
    }

    /// The point of the sensor at (x, y) from its centre, in the luminaire frame.
    pub fn lamp_from_sensor(&self, sensor_mm: DVec2) -> DVec3 {
        self.rotation() * sensor_mm.extend(0.0) + self.centre_mm()
    }

    /// The outward normal of the light-sensitive side, R·(0, 0, −1).
    pub fn normal(&self) -> DVec3 {
        self.rotation() * DVec3::NEG_Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_act_in_the_stated_order() {
        let pose = SensorPose {
            tilt_x_deg: 90.0,
            rot_z_deg: 90.0,
            ..SensorPose::facing(500.0)
        };
        // Rz turns x to y, Rx turns y to z.
        let point = pose.lamp_from_sensor(DVec2::new(10.0, 0.0));
        assert!((point - DVec3::new(0.0, 0.0, 510.0)).length() < 1e-12, "{point}");
        // (0,0,−1) is left alone by Rz, and Rx(90°) takes −z to +y.
        assert!((pose.normal() - DVec3::Y).length() < 1e-12);
    }

    #[test]
    fn tilts_compose_as_written_matrices() {
        let pose = SensorPose {
            tilt_x_deg: 25.0,
            tilt_y_deg: -35.0,
            rot_z_deg: 70.0,
            offset_mm: DVec2::new(3.0, -4.0),
            ..SensorPose::facing(300.0)
        };
        let (a, b, c) = (25f64.to_radians(), (-35f64).to_radians(), 70f64.to_radians());
        let z = |p: DVec3| DVec3::new(c.cos() * p.x - c.sin() * p.y, c.sin() * p.x + c.cos() * p.y, p.z);
        let y = |p: DVec3| DVec3::new(b.cos() * p.x + b.sin() * p.z, p.y, -b.sin() * p.x + b.cos() * p.z);
        let x = |p: DVec3| DVec3::new(p.x, a.cos() * p.y - a.sin() * p.z, a.sin() * p.y + a.cos() * p.z);
        let local = DVec3::new(7.0, 11.0, 0.0);
        let expected = x(y(z(local))) + DVec3::new(3.0, -4.0, 300.0);
        assert!((pose.lamp_from_sensor(DVec2::new(7.0, 11.0)) - expected).length() < 1e-12);
    }
}
