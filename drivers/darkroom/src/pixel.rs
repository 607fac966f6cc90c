//! What does not change from one exposure of the spectroradiometer to the next.

/// A pixel of its detector.
#[derive(Debug, Clone)]
pub(crate) struct Pixel {
    /// Optically black.
    pub is_black: bool,
    /// Wavelength that the instrument states, nm.
    pub stated_nm: f64,
    /// As far as the next one, nm.
    pub width_nm: f64,
    /// Relative to the largest.
    pub responsivity: f64,
    /// Light on it of what is not the phosphor's, and of the phosphor with 1 of it, in the unit of their relative
    /// power.
    pub spread_parts: [f64; 2],
    /// Its dark current over that of the detector.
    pub dark_rel: f64,
}
