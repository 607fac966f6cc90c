//! Shape of the luminous opening from the signs of its three dimensions, and which way they lie.
//!
//! Length runs along photometric horizontal, height along photometric zero, width across both. Photometric horizontal
//! is H = 0 with V = 90° in types B and C and V = 0 in type A; photometric zero is V = 0 in types B and C and V = −90°
//! in type A (LM-63-2002, definitions). Signs after the published description of Radiance's `ies2rad`, which has them
//! by edition.

use super::edition::Edition;
use super::photometry::Photometry;

/// Shape codes of LM-63, all editions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// All zero.
    Point,
    /// Width and length positive.
    Rectangular,
    /// Width (and length) negative: a diameter.
    Circular,
    /// Width and length negative and different.
    Elliptical,
    /// Width and height negative.
    Sphere,
    /// A circle with luminous sides.
    VerticalCylinder,
    /// A tube along the length.
    HorizontalCylinderAlongLength,
    /// A tube along the width.
    HorizontalCylinderAlongWidth,
    /// An ellipse or ellipsoid with its axis along the length (until 1995).
    EllipseAlongLength,
    /// An ellipse or ellipsoid with its axis along the width (until 1995).
    EllipseAlongWidth,
    /// All negative and not equal.
    Ellipsoid,
    /// An upright circle or ellipse that faces photometric horizontal (since 2002).
    VerticalCircle,
    /// A line: one dimension alone.
    Line,
    /// No code that is known.
    Unknown,
}

impl Shape {
    /// The shape of an opening of `[width, length, height]`, in whatever unit. Two codes changed their meaning in 2002.
    pub fn of([width, length, height]: [f64; 3], edition: Edition) -> Self {
        let sign = |value: f64| i8::from(value > 0.0) - i8::from(value < 0.0);
        let since_2002 = edition >= Edition::E2002;
        match (sign(width), sign(length), sign(height)) {
            (0, 0, 0) => Self::Point,
            (1, 1, 0 | 1) => Self::Rectangular,
            (-1, 0, 0) => Self::Circular,
            (-1, -1, 0) if width == length => Self::Circular,
            (-1, -1, 0 | 1) if width != length => Self::Elliptical,
            (-1, 0 | -1, 1) => Self::VerticalCylinder,
            (-1, -1, -1) if width != length || width != height => Self::Ellipsoid,
            (-1, 0, -1) if since_2002 => Self::VerticalCircle,
            (-1, 0 | -1, -1) | (0, 0, -1) => Self::Sphere,
            (0, 1, -1) => Self::HorizontalCylinderAlongLength,
            (1, 0, -1) => Self::HorizontalCylinderAlongWidth,
            (-1, 1, -1) if since_2002 => Self::HorizontalCylinderAlongLength,
            (1, -1, -1) if since_2002 => Self::HorizontalCylinderAlongWidth,
            (-1, 1, _) => Self::EllipseAlongLength,
            (1, -1, _) => Self::EllipseAlongWidth,
            (1, 0, 0 | 1) | (0, 1, 0 | 1) | (0, 0, 1) => Self::Line,
            _ => Self::Unknown,
        }
    }

    /// Its name in the JSON documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Rectangular => "rectangular",
            Self::Circular => "circular",
            Self::Elliptical => "elliptical",
            Self::Sphere => "sphere",
            Self::VerticalCylinder => "vertical_cylinder",
            Self::HorizontalCylinderAlongLength => "horizontal_cylinder_along_length",
            Self::HorizontalCylinderAlongWidth => "horizontal_cylinder_along_width",
            Self::EllipseAlongLength => "ellipse_along_length",
            Self::EllipseAlongWidth => "ellipse_along_width",
            Self::Ellipsoid => "ellipsoid",
            Self::VerticalCircle => "vertical_circle",
            Self::Line => "line",
            Self::Unknown => "unknown",
        }
    }
}

/// The same opening in the codes of 2002, where two negative dimensions mean that it is round in their plane.
fn since_2002([width, length, height]: [f64; 3], edition: Edition) -> [f64; 3] {
    let or = |value: f64, other: f64| if value == 0.0 { other } else { value };
    match Shape::of([width, length, height], edition) {
        Shape::Circular | Shape::VerticalCylinder => [width, width, height],
        Shape::Sphere => [or(width, height); 3],
        Shape::HorizontalCylinderAlongLength => [or(width, height), length, height],
        Shape::HorizontalCylinderAlongWidth => [width, or(length, height), height],
        Shape::EllipseAlongLength | Shape::EllipseAlongWidth => [-width.abs(), -length.abs(), height],
        _ => [width, length, height],
    }
}

/// Extents along C0, C90 and γ = 0 of an opening of `[width, length, height]`, signed by the codes of 2002.
pub(super) fn body(opening: [f64; 3], edition: Edition, photometry: Photometry) -> [f64; 3] {
    let [width, length, height] = since_2002(opening, edition);
    match photometry {
        Photometry::A => [width, height, length],
        Photometry::B => [width, length, height],
        Photometry::C => [length, width, height],
    }
}

/// Width, length and height of a body in the frame of C–γ: what [`body`] turns back.
pub(super) fn opening([x, y, z]: [f64; 3], photometry: Photometry) -> [f64; 3] {
    match photometry {
        Photometry::A => [x, z, y],
        Photometry::B => [x, y, z],
        Photometry::C => [y, x, z],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_of_all_editions() {
        let both = [
            ([0.0, 0.0, 0.0], Shape::Point),
            ([0.5, 0.5, 0.2], Shape::Rectangular),
            ([-0.1, 0.0, 0.0], Shape::Circular),
            ([-0.3, -0.3, 0.0], Shape::Circular),
            ([-0.3, -0.4, 0.0], Shape::Elliptical),
            ([-0.3, -0.3, 0.2], Shape::VerticalCylinder),
            ([-0.12, -0.12, -0.12], Shape::Sphere),
            ([-0.1, -0.2, -0.3], Shape::Ellipsoid),
            ([0.0, 0.12, -0.34], Shape::HorizontalCylinderAlongLength),
            ([0.0, 1.2, 0.0], Shape::Line),
        ];
        for (opening, shape) in both {
            assert_eq!(Shape::of(opening, Edition::E1995), shape, "{opening:?}");
            assert_eq!(Shape::of(opening, Edition::E2002), shape, "{opening:?}");
        }
        for (opening, before, since) in [
            ([-0.12, 0.0, -0.12], Shape::Sphere, Shape::VerticalCircle),
            (
                [-0.04, 1.2, -0.04],
                Shape::EllipseAlongLength,
                Shape::HorizontalCylinderAlongLength,
            ),
            (
                [1.2, -0.04, -0.04],
                Shape::EllipseAlongWidth,
                Shape::HorizontalCylinderAlongWidth,
            ),
        ] {
            assert_eq!(Shape::of(opening, Edition::E1995), before, "{opening:?}");
            assert_eq!(Shape::of(opening, Edition::E2019), since, "{opening:?}");
        }
    }

    #[test]
    fn length_lies_along_photometric_horizontal() {
        // The direction of H = 0, V = 90° (types B and C) and V = 0 (type A) is the axis that the length is laid along.
        for (photometry, vertical_deg) in [(Photometry::A, 0.0), (Photometry::B, 90.0), (Photometry::C, 90.0)] {
            let axis = photometry.direction(vertical_deg, 0.0).to_array();
            let of = |opening| body(opening, Edition::E2002, photometry);
            let long = of([0.1, 1.2, 0.05]);
            let along = axis.iter().position(|part| part.abs() > 0.5).unwrap();
            assert_eq!(long[along], 1.2, "type {}", photometry.letter());
            assert_eq!(opening(long, photometry), [0.1, 1.2, 0.05]);
        }
    }

    #[test]
    fn the_codes_of_1995_in_those_of_2002() {
        let of = |opening| since_2002(opening, Edition::E1995);
        assert_eq!(of([-0.2, 0.0, 0.0]), [-0.2, -0.2, 0.0]);
        assert_eq!(of([-0.2, 0.0, -0.2]), [-0.2, -0.2, -0.2]);
        assert_eq!(of([0.0, 1.2, -0.04]), [-0.04, 1.2, -0.04]);
        assert_eq!(of([1.2, 0.0, -0.04]), [1.2, -0.04, -0.04]);
        assert_eq!(of([-0.2, 0.4, 0.0]), [-0.2, -0.4, 0.0]);
        assert_eq!(of([0.0, 1.2, 0.0]), [0.0, 1.2, 0.0]);
    }
}
