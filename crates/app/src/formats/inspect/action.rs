//! A spectrum beside a colour that it should have, and weighted with an action spectrum that a person gives.

use camino::Utf8Path;
use isolux_formats::{Content, Finding};
use isolux_spectrum::Spectrum;
use isolux_spectrum::steps::target;

use super::inspection::{Inspection, Quantities, RatedColour};
use super::mismatch::spectrum;
use crate::Failure;

/// An action spectrum that a person gives. None is built in: the data of CIE S 026 are licensed under CC BY-SA 4.0.
#[derive(Debug, Clone)]
pub struct Action {
    spectrum: Spectrum,
    findings: Vec<Finding>,
}

impl Action {
    /// Reads it.
    ///
    /// # Errors
    /// A file that holds no spectrum, or one with an error; the message says which finding.
    pub fn read(file: &Utf8Path) -> Result<Self, Failure> {
        let mut findings = Vec::new();
        let spectrum = spectrum(file, &mut findings)?;
        Ok(Self { spectrum, findings })
    }
}

/// Whether there is a colour for a rated temperature in K.
pub fn is_rated_cct_k(cct_k: f64) -> bool {
    target(cct_k).is_some()
}

impl Inspection {
    fn light(&self) -> Option<Spectrum> {
        match &self.content {
            Some(Content::Spectrum(file)) => file.spectrum().ok(),
            _ => None,
        }
    }

    /// Adds to a spectrum's quantities how far its colour is from that of a rated temperature in K.
    pub fn compared_with(&mut self, cct_k: f64) {
        let colour = self.light().and_then(|light| light.chromaticity());
        let (Some(colour), Some(target), Quantities::Spectrum(of)) = (colour, target(cct_k), &mut self.quantities)
        else {
            return;
        };
        of.rated_colour = Some(RatedColour {
            cct_k,
            of: target.name.to_owned(),
            steps: colour.steps_from(target.chromaticity),
        });
    }

    /// Adds to a spectrum's quantities its daylight efficacy ratio for `action`, and what was found in that file.
    pub fn acting_by(&mut self, action: &Action) {
        let light = self.light();
        if let (Some(light), Quantities::Spectrum(of)) = (light, &mut self.quantities) {
            of.daylight_efficacy_ratio = Some(light.daylight_efficacy_ratio(&action.spectrum));
            self.findings.extend_from_slice(&action.findings);
        }
    }
}
