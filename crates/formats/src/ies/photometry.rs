//! The three coordinate systems of LM-63, and the direction that a pair of angles means in A and B.

use glam::DVec3;

/// A photometric type: how vertical and horizontal angles turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometry {
    /// H turns about the vertical axis, V is the elevation: automotive lamps.
    A,
    /// V turns about the horizontal axis, H is the elevation: floodlights.
    B,
    /// C half-planes and γ.
    C,
}

impl Photometry {
    /// By its letter.
    pub fn of(letter: &str) -> Option<Self> {
        match letter {
            "A" | "a" => Some(Self::A),
            "B" | "b" => Some(Self::B),
            "C" | "c" => Some(Self::C),
            _ => None,
        }
    }

    /// Its letter.
    pub const fn letter(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
        }
    }

    /// Its number in the file.
    pub const fn code(self) -> &'static str {
        match self {
            Self::A => "3",
            Self::B => "2",
            Self::C => "1",
        }
    }

    /// The unit vector in the frame of C–γ (x towards C0, y towards C90, z along γ = 0), angles in degrees. In type C
    /// the vertical angle is γ and the horizontal one C.
    pub fn direction(self, vertical_deg: f64, horizontal_deg: f64) -> DVec3 {
        let (sin_v, cos_v) = vertical_deg.to_radians().sin_cos();
        let (sin_h, cos_h) = horizontal_deg.to_radians().sin_cos();
        match self {
            Self::A => DVec3::new(cos_v * sin_h, sin_v, cos_v * cos_h),
            Self::B => DVec3::new(sin_h, cos_h * sin_v, cos_h * cos_v),
            Self::C => isolux_photometry::direction(horizontal_deg, vertical_deg),
        }
    }
}
