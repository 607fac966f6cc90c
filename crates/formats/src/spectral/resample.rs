//! Another spacing, because somebody asked for it: never done on the way.

use isolux_spectrum::{ResampleError, Spectrum};

use super::file::{Series, SpectrumFile};
use crate::finding::Finding;

/// How values between the points are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Sprague's fifth-order polynomial (CIE 167:2005); needs even spacing.
    #[default]
    Sprague,
    /// Straight lines; any spacing.
    Linear,
}

impl Interpolation {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sprague => "sprague",
            Self::Linear => "linear",
        }
    }
}

impl SpectrumFile {
    /// The file at every `step_nm`, and what there is to say of it; the header field `resampled` keeps what was done.
    ///
    /// # Errors
    /// A finding that says why this spacing cannot be had.
    pub fn resampled(&self, step_nm: f64, how: Interpolation) -> Result<(Self, Vec<Finding>), Finding> {
        let refuse = |message: String| Finding::error("convert-resample", message);
        let one = |value: &[f64]| -> Result<Spectrum, Finding> {
            let spectrum =
                Spectrum::new(self.wavelength_nm.clone(), value.to_vec()).map_err(|error| refuse(error.to_string()))?;
            match how {
                Interpolation::Sprague => spectrum.resampled_sprague(step_nm),
                Interpolation::Linear => spectrum.resampled_linear(step_nm),
            }
            .map_err(|error| {
                let finding = refuse(error.to_string());
                match error {
                    ResampleError::Uneven { .. } | ResampleError::TooFew { .. } => {
                        finding.fix("take --interpolation linear, or keep the spacing of the file")
                    }
                    ResampleError::Step { .. } => finding.fix("take a step that the range of the data holds"),
                }
            })
        };
        let first = one(&self.value)?;
        let done = format!("{} interpolation at {step_nm} nm", how.name());
        let mut findings = vec![
            Finding::note(
                "convert-resampled",
                format!("{} points became {} by {done}", self.value.len(), first.value().len()),
            )
            .assumed("as asked for with --step-nm"),
        ];
        let widest = self.wavelength_nm.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
        if step_nm > widest * (1.0 + 1e-9) {
            findings.push(
                Finding::warning(
                    "convert-coarser",
                    format!("the step of {step_nm} nm is wider than the file's own spacing of {widest} nm"),
                )
                .assumed("values at the new points; what lies between them is lost")
                .fix("keep the file's spacing where integrals matter"),
            );
        }
        let mut series = Vec::new();
        let mut left_out = Vec::new();
        for one_series in &self.series {
            match one_series.value.iter().copied().collect::<Option<Vec<f64>>>() {
                Some(value) => series.push(Series {
                    name: one_series.name.clone(),
                    value: one(&value)?.value().iter().copied().map(Some).collect(),
                }),
                None => left_out.push(one_series.name.as_str()),
            }
        }
        if !left_out.is_empty() {
            findings.push(Finding::warning(
                "convert-resample-blank",
                format!("series with blanks are left out: {}", left_out.join(", ")),
            ));
        }
        let mut header = self.header.clone();
        header.insert("resampled".into(), done.into());
        let file = Self {
            wavelength_nm: first.wavelength_nm().to_vec(),
            value: first.value().to_vec(),
            series: if series.len() > 1 { series } else { Vec::new() },
            quantity: self.quantity.clone(),
            unit: self.unit.clone(),
            header,
        };
        Ok((file, findings))
    }
}
