//! Shape of the luminous opening from the signs of its three dimensions.

/// Shape codes of LM-63 (1995 and 2002 tables merged: they do not contradict each other).
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
    /// An ellipse or ellipsoid with its axis along the length.
    EllipseAlongLength,
    /// An ellipse or ellipsoid with its axis along the width.
    EllipseAlongWidth,
    /// A line: one dimension alone.
    Line,
    /// No code that is known.
    Unknown,
}

impl Shape {
    /// The shape of an opening of `[width, length, height]`, in whatever unit.
    pub fn of([width, length, height]: [f64; 3]) -> Self {
        let sign = |value: f64| i8::from(value > 0.0) - i8::from(value < 0.0);
        match (sign(width), sign(length), sign(height)) {
            (0, 0, 0) => Self::Point,
            (1, 1, 0 | 1) => Self::Rectangular,
            (-1, 0, 0) => Self::Circular,
            (-1, -1, 0) if width == length => Self::Circular,
            (-1, -1, 0 | 1) if width != length => Self::Elliptical,
            (-1, 0 | -1, 1) => Self::VerticalCylinder,
            (-1, 0 | -1, -1) | (0, 0, -1) => Self::Sphere,
            (0, 1, -1) => Self::HorizontalCylinderAlongLength,
            (1, 0, -1) => Self::HorizontalCylinderAlongWidth,
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
            Self::Line => "line",
            Self::Unknown => "unknown",
        }
    }

    /// Whether its outline seen along γ = 0 is a circle.
    pub const fn is_round(self) -> bool {
        matches!(self, Self::Circular | Self::Sphere | Self::VerticalCylinder)
    }

    /// Whether its outline seen along γ = 0 is an ellipse.
    pub const fn is_elliptic(self) -> bool {
        matches!(
            self,
            Self::Elliptical | Self::EllipseAlongLength | Self::EllipseAlongWidth
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_of_both_editions() {
        assert_eq!(Shape::of([0.0, 0.0, 0.0]), Shape::Point);
        assert_eq!(Shape::of([-0.1, 0.0, 0.0]), Shape::Circular);
        assert_eq!(Shape::of([-0.3, -0.3, 0.0]), Shape::Circular);
        assert_eq!(Shape::of([-0.3, -0.3, 0.2]), Shape::VerticalCylinder);
        assert_eq!(Shape::of([-0.12, 0.0, -0.12]), Shape::Sphere);
        assert_eq!(Shape::of([0.0, 0.12, -0.34]), Shape::HorizontalCylinderAlongLength);
        assert_eq!(Shape::of([0.5, 0.5, 0.2]), Shape::Rectangular);
    }
}
