//! The sensor: a flat grid of pixels somewhere in the luminaire's frame.

use glam::{DMat3, DVec3};

/// A sensor that cannot be lit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// Zero pixels along a side.
    #[error("the sensor has {nx} × {ny} pixels: each side needs at least one")]
    NoPixels {
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
    },
    /// More pixels than memory can hold.
    #[error("the sensor has {nx} × {ny} pixels: more than {limit} in all would not fit into memory")]
    TooManyPixels {
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
        /// The most that are taken.
        limit: usize,
    },
    /// A side, tilt, shift or distance that is no finite number, or a side that is not positive.
    #[error("{name} = {value:?} is no usable number{need}")]
    Unusable {
        /// Key of the scene file.
        name: &'static str,
        /// What it was.
        value: f64,
        /// What it has to be.
        need: &'static str,
    },
}

/// Pixels that one map may have: 400 million take 1.6 GB as float32.
pub const MAX_PIXELS: usize = 400_000_000;

/// Longest side, distance and shift in mm, 1000 km: beyond it squares of lengths lose what they hold.
pub const MAX_MM: f64 = 1e9;

/// A pose and a grid, as a scene gives them (contract: Frames and angles).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Width and height, mm.
    pub size_mm: [f64; 2],
    /// Pixels along x and y.
    pub pixels: [usize; 2],
    /// z of the sensor's centre, mm.
    pub distance_mm: f64,
    /// Rotation about x, degrees, applied last.
    pub tilt_x_deg: f64,
    /// Rotation about y, degrees.
    pub tilt_y_deg: f64,
    /// Rotation about z, degrees, applied first.
    pub rot_z_deg: f64,
    /// Shift of the centre along x and y, mm.
    pub offset_mm: [f64; 2],
}

/// The sensor in the luminaire's frame: pixel (ix, iy) is the parallelogram corner + (ix + s)·step_x + (iy + t)·step_y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Outer corner of pixel (0, 0), mm.
    pub corner: DVec3,
    /// One pixel along x, mm.
    pub step_x: DVec3,
    /// One pixel along y, mm.
    pub step_y: DVec3,
    /// R·(0, 0, 1), the normal's opposite: light with a positive product reaches the face.
    pub toward: DVec3,
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
}

impl Sensor {
    /// Places the grid: R = Rx(tilt_x)·Ry(tilt_y)·Rz(rot_z), then the shift.
    ///
    /// # Errors
    /// [`SensorError`] for zero or too many pixels and for numbers that are not finite, sides that are not positive.
    pub fn new(pose: &Pose) -> Result<Self, SensorError> {
        for (name, value) in [
            ("distance_mm", pose.distance_mm),
            ("tilt_x_deg", pose.tilt_x_deg),
            ("tilt_y_deg", pose.tilt_y_deg),
            ("rot_z_deg", pose.rot_z_deg),
            ("offset_mm", pose.offset_mm[0]),
            ("offset_mm", pose.offset_mm[1]),
        ] {
            if !value.is_finite() {
                return Err(SensorError::Unusable { name, value, need: "" });
            }
        }
        let rotation = rotation(pose.tilt_x_deg, pose.tilt_y_deg, pose.rot_z_deg);
        let centre = DVec3::new(pose.offset_mm[0], pose.offset_mm[1], pose.distance_mm);
        Self::place(pose.size_mm, pose.pixels, rotation, centre)
    }

    /// A grid of `pixels` over `size_mm`, turned by `rotation` and then shifted so that its middle is at `centre` (mm).
    ///
    /// # Errors
    /// As [`Sensor::new`].
    pub fn place(size_mm: [f64; 2], [nx, ny]: [usize; 2], rotation: DMat3, centre: DVec3) -> Result<Self, SensorError> {
        if nx == 0 || ny == 0 {
            return Err(SensorError::NoPixels { nx, ny });
        }
        if nx.checked_mul(ny).is_none_or(|pixels| pixels > MAX_PIXELS) {
            return Err(SensorError::TooManyPixels {
                nx,
                ny,
                limit: MAX_PIXELS,
            });
        }
        for value in size_mm {
            if !value.is_finite() || value <= 0.0 {
                return Err(SensorError::Unusable {
                    name: "size_mm",
                    value,
                    need: ": a side must be above zero",
                });
            }
        }
        let shift = centre.to_array().map(|length| ("distance_mm and offset_mm", length));
        for (name, value) in size_mm.map(|side| ("size_mm", side)).into_iter().chain(shift) {
            if value.abs() > MAX_MM {
                return Err(SensorError::Unusable {
                    name,
                    value,
                    need: ": a length must be below 1e9 mm (1000 km)",
                });
            }
        }
        let [width, height] = size_mm;
        Ok(Self {
            corner: rotation * DVec3::new(-0.5 * width, -0.5 * height, 0.0) + centre,
            step_x: rotation * DVec3::X * (width / nx as f64),
            step_y: rotation * DVec3::Y * (height / ny as f64),
            toward: rotation * DVec3::Z,
            nx,
            ny,
        })
    }

    /// The point at (x, y) in pixels from the corner; pixel centres at half-integers.
    #[inline]
    pub fn point(&self, x: f64, y: f64) -> DVec3 {
        self.corner + x * self.step_x + y * self.step_y
    }

    /// Smallest z of its corners, mm.
    pub(crate) fn lowest(&self) -> f64 {
        let (nx, ny) = (self.nx as f64, self.ny as f64);
        [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]]
            .map(|[x, y]| self.point(x, y).z)
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    /// Area of one pixel, m².
    pub fn pixel_area_m2(&self) -> f64 {
        self.step_x.cross(self.step_y).length() * 1e-6
    }

    /// Pixels in all.
    pub fn pixels(&self) -> usize {
        self.nx * self.ny
    }

    /// Its middle.
    pub fn centre(&self) -> DVec3 {
        self.point(0.5 * self.nx as f64, 0.5 * self.ny as f64)
    }
}

/// Rx(x)·Ry(y)·Rz(z) in degrees.
pub fn rotation(x_deg: f64, y_deg: f64, z_deg: f64) -> DMat3 {
    DMat3::from_rotation_x(x_deg.to_radians())
        * DMat3::from_rotation_y(y_deg.to_radians())
        * DMat3::from_rotation_z(z_deg.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_beyond_what_squares_can_hold_are_refused() {
        let good = Pose {
            size_mm: [10.0; 2],
            pixels: [2; 2],
            distance_mm: 100.0,
            tilt_x_deg: 0.0,
            tilt_y_deg: 0.0,
            rot_z_deg: 0.0,
            offset_mm: [0.0; 2],
        };
        assert!(Sensor::new(&good).is_ok());
        for bad in [
            Pose {
                size_mm: [1e300, 10.0],
                ..good
            },
            Pose {
                distance_mm: 1e200,
                ..good
            },
            Pose {
                offset_mm: [0.0, -1e10],
                ..good
            },
        ] {
            assert!(
                matches!(Sensor::new(&bad), Err(SensorError::Unusable { .. })),
                "{bad:?}"
            );
        }
    }
}
