//! Why a record does not show what is to be found of a spectroradiometer.

use isolux_record::spectra::SpectrumError;

/// Why a record does not show what is to be found of a spectroradiometer: what was found, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InstrumentError {
    /// The scan is not finished.
    #[error("the scan is not finished; resume it")]
    Unfinished,
    /// No spectra of the procedure.
    #[error("the record has fewer than two spectra of {0}; begin again with this option in another folder")]
    NoSpectra(&'static str),
    /// The run has no spectroradiometer.
    #[error("the record has no spectroradiometer")]
    NoSpectroradiometer,
    /// A pixel was full.
    #[error("{file}: saturated at {wavelength_nm:.1} nm; less light, or a lamp that does not flicker")]
    Saturated {
        /// File of the spectrum in the run.
        file: String,
        /// First such wavelength.
        wavelength_nm: f64,
    },
    /// Nothing of the lamp is seen.
    #[error(
        "no line of {lamp} stands out of the noise; is the lamp on and warm, before the entrance, and the right one?"
    )]
    Dark {
        /// The lamp.
        lamp: String,
    },
    /// A strong line of the list is not there.
    #[error(
        "{lamp} has a strong line at {wavelength_nm:.3} nm, and the spectrum has none within {within_nm} nm of it; \
         name the lamp that shines, or let it warm up"
    )]
    Missing {
        /// The lamp.
        lamp: String,
        /// The line.
        wavelength_nm: f64,
        /// Where it was searched for.
        within_nm: f64,
    },
    /// A line that the list does not have.
    #[error(
        "light at {stated_nm:.1} nm is {share:.0} % of the strongest line, and {lamp} has no line there; keep other \
         light out, or name the lamp that shines",
        share = 100.0 * share_rel
    )]
    Unknown {
        /// The lamp.
        lamp: String,
        /// Where.
        stated_nm: f64,
        /// Its light over that of the strongest line.
        share_rel: f64,
    },
    /// Too few lines alone.
    #[error(
        "{used} lines of {lamp} stand alone at a bandpass of {fwhm_nm:.2} nm ({blended} are blended), {least} are \
         needed; take a lamp with lines farther apart, or a narrower slit"
    )]
    Blended {
        /// The lamp.
        lamp: String,
        /// Lines that could be used.
        used: usize,
        /// Lines that run into each other.
        blended: usize,
        /// How many are needed.
        least: usize,
        /// Bandpass.
        fwhm_nm: f64,
    },
    /// The lines leave out a part of the visible.
    #[error(
        "the lines that can be used reach from {first_nm:.1} nm to {last_nm:.1} nm; colour needs them from \
         {from_nm} nm or below to {to_nm} nm or above"
    )]
    Range {
        /// First line.
        first_nm: f64,
        /// Last line.
        last_nm: f64,
        /// Where they should begin.
        from_nm: f64,
        /// Where they should end.
        to_nm: f64,
    },
    /// A line off a smooth scale.
    #[error(
        "the line at {wavelength_nm:.3} nm is {residual_nm:+.3} nm off a smooth scale through the others; is it in the \
         list with the right wavelength?"
    )]
    Rough {
        /// The line.
        wavelength_nm: f64,
        /// How far it is off.
        residual_nm: f64,
    },
    /// The lamp changed.
    #[error(
        "the light changed by {change:+.1} % from the first spectrum to the last, {limit:.1} % are allowed; let the \
         lamp settle and begin again",
        change = 100.0 * change_rel, limit = 100.0 * limit_rel
    )]
    Unsteady {
        /// Last over first, less 1.
        change_rel: f64,
        /// What is allowed.
        limit_rel: f64,
    },
    /// No filter, or another one.
    #[error(
        "{filter} cuts on at {stated_nm:.0} nm, and the light in the spectrum at {found_nm:.0} nm; put that filter on \
         the entrance, or name the one that is there"
    )]
    OtherFilter {
        /// The filter.
        filter: String,
        /// Its cut-on.
        stated_nm: f64,
        /// Where the light begins.
        found_nm: f64,
    },
    /// Light where the filter is opaque.
    #[error(
        "below {below_nm:.0} nm, where {filter} is opaque, there is {share:.1} % of the strongest light; is the filter \
         before the entrance, with no light beside it?",
        share = 100.0 * share_rel
    )]
    NoFilter {
        /// The filter.
        filter: String,
        /// Where it is opaque.
        below_nm: f64,
        /// Light there over the strongest.
        share_rel: f64,
    },
    /// No pixels where the filter is opaque.
    #[error(
        "the instrument has {pixels} pixels below {below_nm:.0} nm, where {filter} is opaque; {least} are needed: take \
         a filter that cuts on at longer wavelengths"
    )]
    NoPixels {
        /// The filter.
        filter: String,
        /// Where it is opaque.
        below_nm: f64,
        /// Pixels there.
        pixels: usize,
        /// How many are needed.
        least: usize,
    },
    /// A polynomial does not explain the rates.
    #[error(
        "rates at {short_s} s and {long_s} s differ by {difference:+.2} % more than a polynomial of the counts \
         explains, {allowed:.2} % are allowed; was the light steady, and is the integration time what the instrument \
         says?",
        difference = 100.0 * difference_rel, allowed = 100.0 * allowed_rel
    )]
    NotOfCounts {
        /// Integration time of the darker spectrum.
        short_s: f64,
        /// That of the brighter one.
        long_s: f64,
        /// What is left.
        difference_rel: f64,
        /// What noise and drift allow.
        allowed_rel: f64,
    },
    /// All spectra had about the same counts.
    #[error(
        "the spectra have their peaks between {low:.0} % and {high:.0} % of full scale; linearity needs from 15 % or \
         below to 50 % or above: take more light, or another integration time",
        low = 100.0 * low_rel, high = 100.0 * high_rel
    )]
    NoLevels {
        /// Lowest peak.
        low_rel: f64,
        /// Highest peak.
        high_rel: f64,
    },
    /// The instrument's linearity polynomial.
    #[error(transparent)]
    Polynomial(#[from] SpectrumError),
}

impl InstrumentError {
    /// Whether the list or the station is at fault, and not what was measured.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::NoSpectroradiometer)
    }
}
