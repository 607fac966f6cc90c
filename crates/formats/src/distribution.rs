//! A luminous intensity distribution as any photometric file gives it: absolute, full circle, with its description.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::{Map, Value, json};

use crate::eulumdat::document::Document;
pub use crate::luminaire::Luminaire;

/// What was read from a photometric file.
#[derive(Debug, Clone)]
pub struct Distribution {
    /// Absolute candela over the full circle.
    pub intensity: IntensityDistribution,
    /// The symmetry that the file claims.
    pub symmetry: Symmetry,
    /// Flux of the lamps in lm that the file states, for all lamps of the set together.
    pub lamp_flux_lm: Option<f64>,
    /// Absolute photometry: the intensities are those of the luminaire, no lamp was measured bare.
    pub absolute: bool,
    /// The file's own coordinates, where they are not C-γ.
    pub native: Option<Native>,
    /// The description that formats share.
    pub luminaire: Luminaire,
    /// Every field that was read, decoded, and `encoding`.
    pub header: Map<String, Value>,
    /// The document as it stood, where it was EULUMDAT in the format's own order of planes.
    pub eulumdat: Option<Box<Document>>,
}

/// A distribution in the coordinates of its file (photometry of type A or B).
#[derive(Debug, Clone, PartialEq)]
pub struct Native {
    /// `"A"` or `"B"`.
    pub photometry_type: &'static str,
    /// Vertical angles in degrees.
    pub vertical_deg: Vec<f64>,
    /// Horizontal angles in degrees.
    pub horizontal_deg: Vec<f64>,
    /// Candela, one row a horizontal angle.
    pub intensity_cd: Vec<Vec<f64>>,
    /// Which of the file's directions becomes C0.
    pub c0_axis: &'static str,
}

impl Distribution {
    /// Absolute photometry without a description.
    pub fn absolute(intensity: IntensityDistribution) -> Self {
        Self {
            symmetry: intensity.detect_symmetry(0.0),
            intensity,
            lamp_flux_lm: None,
            absolute: true,
            native: None,
            luminaire: Luminaire::default(),
            header: Map::new(),
            eulumdat: None,
        }
    }

    /// The document of format `isolux-distribution/1`.
    pub fn to_json(&self) -> Value {
        let grid = &self.intensity;
        let rows: Vec<&[f64]> = (0..grid.c_deg().len()).map(|plane| grid.row(plane)).collect();
        let mut document = json!({
            "format": "isolux-distribution/1",
            "c_deg": grid.c_deg(),
            "gamma_deg": grid.gamma_deg(),
            "intensity_cd": rows,
            "lamp_flux_lm": self.lamp_flux_lm,
            "absolute": self.absolute,
            "symmetry": symmetry_name(self.symmetry),
            "resampled": self.native.is_some(),
            "header": self.header,
        });
        if let Some(native) = &self.native {
            document["native"] = json!({
                "photometry_type": native.photometry_type,
                "vertical_deg": native.vertical_deg,
                "horizontal_deg": native.horizontal_deg,
                "intensity_cd": native.intensity_cd,
                "c0_axis": native.c0_axis,
            });
        }
        document
    }
}

/// The name of a symmetry in `isolux-distribution/1`.
pub const fn symmetry_name(symmetry: Symmetry) -> &'static str {
    match symmetry {
        Symmetry::None => "none",
        Symmetry::Rotational => "rotational",
        Symmetry::C0C180 => "c0_c180",
        Symmetry::C90C270 => "c90_c270",
        Symmetry::Quadrant => "quadrant",
    }
}
