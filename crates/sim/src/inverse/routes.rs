//! Which routes a solution may take.

/// The routes that the inverse solver chooses from, quickest first. What one of them does not compute, the next in turn
/// does: every set gives the same light within the stated bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Routes {
    /// One polynomial over a tile of pixels.
    pub polynomials: bool,
    /// One product rule for all pixels of a tile.
    pub common_rules: bool,
    /// Product rules over pixel and emitter.
    pub product_rules: bool,
    /// A few points in place of an emitter that is small against the pixel.
    pub few_points: bool,
    /// Flat emitters along their outline.
    pub outlines: bool,
    /// Four points of the pixel in place of an adaptive rule over it, for outlines.
    pub four_points: bool,
    /// Leaves of even turn, where the places of the chords themselves do not serve.
    pub leaves: bool,
}

impl Routes {
    /// Every one.
    pub const ALL: Self = Self {
        polynomials: true,
        common_rules: true,
        product_rules: true,
        few_points: true,
        outlines: true,
        four_points: true,
        leaves: true,
    };

    /// Chords of pixel and emitter alone, or lines across the pixel for points.
    pub const CHORDS: Self = Self {
        polynomials: false,
        common_rules: false,
        product_rules: false,
        few_points: false,
        outlines: false,
        four_points: false,
        leaves: true,
    };

    /// Flat emitters along their outline wherever that applies, else chords.
    pub const OUTLINES: Self = Self {
        outlines: true,
        ..Self::CHORDS
    };
}
