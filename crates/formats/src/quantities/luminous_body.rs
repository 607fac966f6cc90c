//! The luminous opening as a body: its extents, its sides, where it is round, and how large it is from everywhere.

use crate::luminaire::{Luminaire, face};

/// Where the luminous opening is round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rounding {
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

/// What shines of a luminaire.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    /// Luminous area in m², seen along γ = 0.
    area_m2: f64,
    /// Luminous sides in m², seen from C0, C90, C180, C270.
    side_m2: [f64; 4],
    rounding: Rounding,
}

impl Body {
    /// None where the file states no luminous area.
    pub fn of(luminaire: &Luminaire) -> Option<Self> {
        let area_m2 = luminaire.luminous_area_mm2()? * 1e-6;
        let (side_m2, rounding) = sides(luminaire)?;
        Some(Self {
            area_m2,
            side_m2,
            rounding,
        })
    }

    /// Seen by an eye towards C, γ. A body of which every section is an ellipse has the root of the sum of the squares
    /// of its three faces' shares (exact for ellipsoids); where it is round in one plane this holds for the two faces
    /// around that plane's axis.
    pub fn projected_m2(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let (sin_g, cos_g) = gamma_deg.to_radians().sin_cos();
        let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
        let [c0, c90, c180, c270] = self.side_m2;
        let [x, y] = [(cos_c, c0, c180), (sin_c, c90, c270)].map(|(part, ahead, behind)| {
            let share = if self.rounding == Rounding::Cylinder {
                part * part
            } else {
                part.abs()
            };
            share * if part > 0.0 { ahead } else { behind }
        });
        let (x, y, z) = (x * sin_g, y * sin_g, self.area_m2 * cos_g.abs());
        match self.rounding {
            Rounding::None | Rounding::Cylinder => z + (x + y),
            Rounding::Upright => z + x.hypot(y),
            Rounding::AlongC90 => y + x.hypot(z),
            Rounding::AlongC0 => x + y.hypot(z),
            Rounding::Ellipsoid => x.hypot(y).hypot(z),
        }
    }
}

/// Luminous sides in m² seen from C0, C90, C180 and C270, and where they are round.
fn sides(luminaire: &Luminaire) -> Option<([f64; 4], Rounding)> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_body_is_as_large_as_its_shadow() {
        let seen = |body_mm: [f64; 3], c_deg: f64, gamma_deg: f64| {
            let mut luminaire = Luminaire::default();
            luminaire.set_luminous_body(body_mm);
            Body::of(&luminaire).unwrap().projected_m2(c_deg, gamma_deg)
        };
        let close = |found: f64, exact: f64| assert!((found / exact - 1.0).abs() < 1e-12, "{found} for {exact}");
        for (c, gamma) in [(0.0, 0.0), (0.0, 60.0), (90.0, 30.0), (37.0, 71.0), (200.0, 85.0)] {
            let (sin_g, cos_g) = f64::to_radians(gamma).sin_cos();
            let (sin_c, cos_c) = f64::to_radians(c).sin_cos();
            let [ux, uy] = [(sin_g * cos_c).abs(), (sin_g * sin_c).abs()];
            // A sphere of 200 mm: the same disc from everywhere.
            close(seen([-200.0; 3], c, gamma), PI * 0.01);
            // An upright cylinder: its disc from below, its diameter times its height from the side.
            close(
                seen([-200.0, -200.0, 100.0], c, gamma),
                PI * 0.01 * cos_g + 0.02 * sin_g,
            );
            // A lying tube of 1.2 m × 40 mm: its length times its diameter around the axis, and its end along it.
            let tube = |along: f64| 0.048 * (1.0 - along * along).sqrt() + PI * 0.0004 * along;
            close(seen([1200.0, -40.0, -40.0], c, gamma), tube(ux));
            close(seen([-40.0, 1200.0, -40.0], c, gamma), tube(uy));
            // A box: its three faces.
            let faces = 0.08 * cos_g + 0.02 * uy + 0.04 * ux;
            close(seen([200.0, 400.0, 100.0], c, gamma), faces);
        }
    }
}
