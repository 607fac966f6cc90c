//! The luminous opening as a body: its extents, its sides, and where it is round.

use crate::luminaire::{Luminaire, face};

/// Where the luminous opening is round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rounding {
    /// Nowhere: a box.
    None,
    /// An upright cylinder with a circle as its outline, as wide from everywhere.
    Cylinder,
    /// An upright cylinder with an ellipse as its outline.
    Upright,
    /// A cylinder that lies along C0–C180.
    AlongC0,
    /// A cylinder that lies along C90–C270.
    AlongC90,
    /// An ellipsoid or a sphere.
    Ellipsoid,
}

/// Extents of the luminous opening along C0 and C90, 0 where they are not stated.
pub(super) fn extents_mm(luminaire: &Luminaire) -> [f64; 2] {
    match (luminaire.luminous_body_mm, luminaire.luminous_width_mm) {
        (Some([x, y, _]), _) => [x.abs(), y.abs()],
        // Round.
        (None, Some(0.0)) => [0.0; 2],
        (None, width) => [width, luminaire.luminous_length_mm].map(Option::unwrap_or_default),
    }
}

/// Luminous sides in m² seen from C0, C90, C180 and C270, and where they are round.
pub(super) fn sides(luminaire: &Luminaire) -> Option<([f64; 4], Rounding)> {
    if let Some(body_mm) = luminaire.luminous_body_mm {
        let [x, y, z] = body_mm.map(|extent| extent * 1e-3);
        let (from_c0, from_c90) = (face(y, z), face(x, z));
        let rounding = match (x < 0.0, y < 0.0, z < 0.0) {
            (true, true, true) => Rounding::Ellipsoid,
            (true, true, false) if x == y => Rounding::Cylinder,
            (true, true, false) => Rounding::Upright,
            (true, false, true) => Rounding::AlongC90,
            (false, true, true) => Rounding::AlongC0,
            _ => Rounding::None,
        };
        return Some(([from_c0, from_c90, from_c0, from_c90], rounding));
    }
    let (length, width) = (
        luminaire.luminous_length_mm? * 1e-3,
        luminaire.luminous_width_mm? * 1e-3,
    );
    let height = luminaire
        .luminous_height_mm
        .map(|height| height.unwrap_or(0.0).max(0.0) * 1e-3);
    let (breadth, rounding) = if width == 0.0 {
        (length, Rounding::Cylinder)
    } else {
        (width, Rounding::None)
    };
    // The side seen from C0 is as long as the luminaire, which lies along C90 to C270.
    let side_m2 = [
        length * height[0],
        breadth * height[1],
        length * height[2],
        breadth * height[3],
    ];
    Some((side_m2, rounding))
}
