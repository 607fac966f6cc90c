//! How the luminaire stands on the bench.

use glam::DVec3;

/// How the luminaire hangs on a bench that turns it: the optical axis points to (cos γ, sin γ, 0) of the bench, the
/// half-plane C contains +X, and C + 90° points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Attitude {
    /// Luminaire axes x, y, z as seen from the bench.
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl Attitude {
    pub fn new(c_deg: f64, gamma_deg: f64, nonperp_deg: f64) -> Self {
        let (sin, cos) = gamma_deg.to_radians().sin_cos();
        let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
        let (lean, upright) = nonperp_deg.to_radians().sin_cos();
        // At C = 0: x towards the detector's side, y up, z the optical axis; then the axis leans out of the horizontal.
        let toward = DVec3::new(sin, -cos, 0.0);
        let level = DVec3::new(cos, sin, 0.0);
        let axis = upright * level + lean * DVec3::Z;
        let up = upright * DVec3::Z - lean * level;
        Self {
            x: cos_c * toward - sin_c * up,
            y: sin_c * toward + cos_c * up,
            z: axis,
        }
    }

    /// A direction of the bench in the luminaire's frame.
    pub fn luminaire_from_room(&self, room: DVec3) -> DVec3 {
        DVec3::new(room.dot(self.x), room.dot(self.y), room.dot(self.z))
    }
}
