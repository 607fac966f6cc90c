//! Whether the detector is in the far field of a luminaire.

use serde::Serialize;

/// Distance ÷ extent from which on I = E·d² holds for a Lambertian distribution, a broad beam and a narrow one.
const LAMBERTIAN: f64 = 5.0;
const BROAD: f64 = 10.0;
const NARROW: f64 = 15.0;

/// Distance against the largest extent D of the luminous area, as EN 13032-4 asks of far-field photometry: at least 5 D
/// for a Lambertian distribution, 10 D for a broad one, 15 D for a narrow one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "class", content = "distance_over_extent")]
pub enum DistanceClass {
    /// The station does not give `lamp.diameter_mm`.
    Unknown,
    /// Below 5 D: near field.
    NearField(f64),
    /// 5 D to 10 D: far field of a Lambertian luminaire alone.
    Lambertian(f64),
    /// 10 D to 15 D: far field of a broad beam.
    Broad(f64),
    /// 15 D and more: far field of a narrow beam too.
    Narrow(f64),
}

/// Half the angle in degrees under which a luminous area of `extent_mm` is seen from `distance_mm`: what a detector
/// there mixes.
pub fn seen_under_deg(extent_mm: f64, distance_mm: f64) -> f64 {
    (0.5 * extent_mm / distance_mm).atan().to_degrees()
}

/// Distance in mm from which on a luminous area of `extent_mm` is seen under no more than a step of `step_deg`, so that
/// directions so far apart do not mix; in tens of millimetres.
pub fn apart_from_mm(extent_mm: f64, step_deg: f64) -> f64 {
    (0.5 * extent_mm / (0.5 * step_deg).to_radians().tan() / 10.0).ceil() * 10.0
}

impl DistanceClass {
    /// The class of `distance_mm` for a luminous area of largest extent `extent_mm`.
    pub fn of(distance_mm: f64, extent_mm: Option<f64>) -> Self {
        let Some(extent_mm) = extent_mm else {
            return Self::Unknown;
        };
        let ratio = distance_mm / extent_mm;
        match ratio {
            _ if ratio < LAMBERTIAN => Self::NearField(ratio),
            _ if ratio < BROAD => Self::Lambertian(ratio),
            _ if ratio < NARROW => Self::Broad(ratio),
            _ => Self::Narrow(ratio),
        }
    }

    /// Distance ÷ extent that a beam of this full width asks for: the narrowest of a distribution, none where it has no
    /// beam.
    pub const fn wanted(beam_deg: Option<f64>) -> f64 {
        match beam_deg {
            Some(beam) if beam < 60.0 => NARROW,
            Some(beam) if beam < 90.0 => BROAD,
            _ => LAMBERTIAN,
        }
    }

    /// Distance ÷ extent.
    pub const fn ratio(self) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::NearField(ratio) | Self::Lambertian(ratio) | Self::Broad(ratio) | Self::Narrow(ratio) => Some(ratio),
        }
    }
}

impl std::fmt::Display for DistanceClass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown => f.write_str("not known: the station gives no lamp.diameter_mm"),
            Self::NearField(ratio) => write!(f, "{ratio:.1} D: near field, I = E·d² does not hold"),
            Self::Lambertian(ratio) => write!(f, "{ratio:.1} D: far field of a Lambertian luminaire alone (≥ 5 D)"),
            Self::Broad(ratio) => write!(f, "{ratio:.1} D: far field of a broad beam (≥ 10 D)"),
            Self::Narrow(ratio) => write!(f, "{ratio:.1} D: far field of any beam (≥ 15 D)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_asks_for_a_distance_that_is_far_field_for_it() {
        assert!(matches!(
            DistanceClass::of(340.0, Some(70.0)),
            DistanceClass::NearField(_)
        ));
        assert_eq!(DistanceClass::of(1000.0, None).ratio(), None);
        for (beam_deg, least) in [(Some(30.0), 15.0), (Some(75.0), 10.0), (Some(110.0), 5.0), (None, 5.0)] {
            assert_eq!(DistanceClass::wanted(beam_deg), least);
            assert_eq!(DistanceClass::of(least * 70.0, Some(70.0)).ratio(), Some(least));
        }
        let classes = [5.0, 10.0, 15.0].map(|ratio| DistanceClass::of(ratio, Some(1.0)));
        assert_eq!(
            classes,
            [
                DistanceClass::Lambertian(5.0),
                DistanceClass::Broad(10.0),
                DistanceClass::Narrow(15.0)
            ]
        );
    }
}
