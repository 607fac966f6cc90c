//! An EULUMDAT file as a document: every field of the header, and the planes as stored.

use isolux_photometry::Symmetry;

/// The document: header as read, stored planes in cd/klm.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// Lines 1–26f and the direct ratios.
    pub header: Header,
    /// Symmetry indicator, line 3.
    pub isym: u8,
    /// The Mc angles of C that the file lists.
    pub c_deg: Vec<f64>,
    /// The Ng angles of γ.
    pub gamma_deg: Vec<f64>,
    /// Stored planes one after the other, Ng values each, in cd/klm.
    pub intensity_cd_klm: Vec<f64>,
}

/// Everything but the light. A number that is blank or cannot be read is `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Header {
    /// Line 1.
    pub company: String,
    /// Line 2: 1 point source with symmetry about the vertical axis, 2 linear, 3 point source with any other symmetry.
    pub type_indicator: Option<f64>,
    /// Line 5: distance between C planes as stated.
    pub c_step_deg: Option<f64>,
    /// Line 7: distance between γ as stated.
    pub gamma_step_deg: Option<f64>,
    /// Line 8.
    pub report: String,
    /// Line 9.
    pub name: String,
    /// Line 10.
    pub number: String,
    /// Line 11.
    pub file_name: String,
    /// Line 12.
    pub date_user: String,
    /// Line 13, diameter or length in mm.
    pub length_mm: Option<f64>,
    /// Line 14, width in mm, 0 for a round luminaire.
    pub width_mm: Option<f64>,
    /// Line 15.
    pub height_mm: Option<f64>,
    /// Line 16, diameter or length of the luminous area.
    pub luminous_length_mm: Option<f64>,
    /// Line 17, width of the luminous area, 0 for a round one.
    pub luminous_width_mm: Option<f64>,
    /// Lines 18–21, height of the luminous area seen from C0, C90, C180, C270.
    pub luminous_height_mm: [Option<f64>; 4],
    /// Line 22, downward flux fraction in %.
    pub dff_percent: Option<f64>,
    /// Line 23, light output ratio in %.
    pub lorl_percent: Option<f64>,
    /// Line 24, factor on the intensities.
    pub conversion_factor: Option<f64>,
    /// Line 25.
    pub tilt_deg: Option<f64>,
    /// Lines 26a–f, one entry a set.
    pub lamp_sets: Vec<LampSet>,
    /// Ten direct ratios for room indices 0.6 … 5.
    pub direct_ratios: [Option<f64>; 10],
}

impl Header {
    /// Light output ratio and downward flux fraction are both zero: templates have it so, light never.
    pub(crate) fn fractions_unstated(&self) -> bool {
        self.lorl_percent == Some(0.0) && self.dff_percent == Some(0.0)
    }
}

/// Six lines of one set of lamps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LampSet {
    /// 26a, number of lamps; negative for absolute photometry.
    pub count: Option<f64>,
    /// 26b.
    pub lamp: String,
    /// 26c, total flux of the set in lm.
    pub flux_lm: Option<f64>,
    /// 26d.
    pub colour: String,
    /// 26e.
    pub rendering: String,
    /// 26f, power with gear in W.
    pub watts: Option<f64>,
}

/// Room indices k of the ten direct ratios.
pub const ROOM_INDICES: [f64; 10] = [0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0];

/// The symmetry that an indicator stands for.
pub(crate) const fn symmetry(isym: u8) -> Symmetry {
    match isym {
        1 => Symmetry::Rotational,
        2 => Symmetry::C0C180,
        3 => Symmetry::C90C270,
        4 => Symmetry::Quadrant,
        _ => Symmetry::None,
    }
}

/// The indicator for a symmetry.
pub(super) const fn isym(symmetry: Symmetry) -> u8 {
    match symmetry {
        Symmetry::None => 0,
        Symmetry::Rotational => 1,
        Symmetry::C0C180 => 2,
        Symmetry::C90C270 => 3,
        Symmetry::Quadrant => 4,
    }
}

/// Number of planes that a file with `isym` and `mc` angles stores.
pub(crate) const fn stored_planes(isym: u8, mc: usize) -> usize {
    match isym {
        1 => 1,
        2 | 3 => mc / 2 + 1,
        4 => mc / 4 + 1,
        _ => mc,
    }
}
