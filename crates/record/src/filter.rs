//! `isolux-filter/1`: a long-pass filter, by which the light that a spectroradiometer scatters is seen.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use crate::document::bounds::within;
use crate::document::{DocumentError, Fault, SourceText};

/// Value of `format`.
pub const FORMAT: &str = "isolux-filter/1";

/// A long-pass filter, as its data sheet or a spectrophotometer says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CutOnFilter {
    /// [`FORMAT`].
    pub format: String,
    /// Type and number, as "OG515, 3 mm, no. 2".
    pub designation: String,
    /// Wavelength at which it transmits half of the most.
    pub cut_on_nm: f64,
    /// Below this wavelength it is opaque.
    pub opaque_below_nm: f64,
    /// Bound of its transmittance there.
    pub transmittance_below_max: f64,
}

impl CutOnFilter {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        let source = SourceText { file, text };
        let filter: Self = source.parse(FORMAT)?;
        filter.check().map_err(|fault| source.locate(&fault))?;
        Ok(filter)
    }

    fn check(&self) -> Result<(), Fault> {
        if self.designation.trim().is_empty() || self.designation.chars().any(char::is_control) {
            return Err(Fault::new(
                "designation",
                "is empty or more than one line; write type and number",
            ));
        }
        within("cut_on_nm", self.cut_on_nm, 250.0..=2500.0, " nm")?;
        within(
            "opaque_below_nm",
            self.opaque_below_nm,
            200.0..=self.cut_on_nm - 5.0,
            " nm, 5 nm below cut_on_nm at least",
        )?;
        within(
            "transmittance_below_max",
            self.transmittance_below_max,
            0.0..=1e-2,
            " (a fraction: 1e-5 is usual for coloured glass)",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_filter_can_be_is_refused_with_its_line() {
        let text = "format = \"isolux-filter/1\"\ndesignation = \"OG515\"\ncut_on_nm = 515.0\nopaque_below_nm = 460.0\n\
                    transmittance_below_max = 1e-5\n";
        let file = Utf8Path::new("f.toml");
        assert_eq!(CutOnFilter::parse(file, text).unwrap().cut_on_nm, 515.0);
        for (from, to, expected) in [
            ("460.0", "515.0", "f.toml:4:1: opaque_below_nm: is 515"),
            ("1e-5", "0.5", "f.toml:5:1: transmittance_below_max: is 0.5"),
            ("OG515", "", "f.toml:2:1: designation"),
        ] {
            let error = CutOnFilter::parse(file, &text.replacen(from, to, 1)).unwrap_err();
            assert!(error.to_string().starts_with(expected), "{error}");
        }
    }
}
