//! The spectra of a calibration: by integration time, in the light of the lamp and behind the baffle.

use isolux_record::plan::Instrument;
use isolux_record::spectra::{SpectralCalibration, SpectrumRecord};
use isolux_record::{ReadingKind, Run};

use super::LINEARITY_MAX_REL;
use super::error::CalibrationError;
use crate::bandpass;
use crate::instrument::{Chain, Linear, bandpass_nm};
use crate::spectral::{ON_AXIS_DEG, is_lit};

/// Linear counts per second of every pixel, dark taken off.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rates {
    /// Counts per second.
    pub per_s: Vec<f64>,
    /// Standard uncertainty from the scatter of light and dark.
    pub u_per_s: Vec<f64>,
}

/// What the plan asked of the peak of a block without `peak_counts_rel`.
const AIM: f64 = 0.7;
/// Edges of classes of pixels by their counts, in shares of full scale.
const CLASSES: [f64; 6] = [0.02, 0.15, 0.3, 0.45, 0.6, 1.0];

/// The spectra of a run, sorted.
pub(super) struct Procedure<'a> {
    /// What its counts are corrected by.
    pub calibration: &'a SpectralCalibration,
    /// Spectra at the longest integration times, in the order of time.
    pub brightest: Vec<&'a SpectrumRecord>,
    /// Lit spectra of other blocks.
    levels: Vec<&'a SpectrumRecord>,
    /// Spectra with the baffle in the path.
    baffled: Vec<&'a SpectrumRecord>,
}

impl<'a> Procedure<'a> {
    /// Sorts the spectra of the run; none of them may be saturated.
    ///
    /// # Errors
    /// [`CalibrationError`] names a saturated spectrum, and what is missing.
    pub fn of(run: &'a Run) -> Result<Self, CalibrationError> {
        let calibration = run
            .header
            .spectral
            .as_ref()
            .ok_or(CalibrationError::NoSpectroradiometer)?;
        let aim = |record: &SpectrumRecord| {
            let mut blocks = run.header.plan.blocks().iter();
            let block = blocks.find(|block| block.name == record.block);
            block.and_then(|block| block.peak_counts_rel).unwrap_or(AIM)
        };
        let lit: Vec<&SpectrumRecord> = (run.spectra.iter())
            .filter(|record| is_lit(run, record) && record.gamma_deg.abs() < ON_AXIS_DEG)
            .collect();
        let most = lit.iter().map(|record| aim(record)).fold(0.0, f64::max);
        let (brightest, levels): (Vec<_>, Vec<_>) = lit.into_iter().partition(|record| aim(record) == most);
        let in_plan = |record: &&SpectrumRecord| {
            let mut blocks = run.header.plan.blocks().iter();
            blocks.any(|block| block.name == record.block && block.instrument == Instrument::Spectroradiometer)
        };
        let of_kind = |record: &&SpectrumRecord| record.kind == ReadingKind::Baffled && in_plan(record);
        let baffled: Vec<_> = run.spectra.iter().filter(of_kind).collect();
        if brightest.len() < 2 {
            return Err(CalibrationError::NoPart(
                "second spectrum at the longest integration time",
            ));
        }
        if levels.is_empty() {
            return Err(CalibrationError::NoPart("spectrum at a shorter integration time"));
        }
        if baffled.is_empty() {
            return Err(CalibrationError::NoPart("spectrum behind the baffle"));
        }
        for record in brightest.iter().chain(&levels).chain(&baffled) {
            if let Some(pixel) = record.pixels.iter().find(|pixel| pixel.saturated) {
                return Err(CalibrationError::Saturated {
                    file: format!("spectra/{:03}.csv", record.index),
                    wavelength_nm: pixel.wavelength_nm,
                });
            }
        }
        Ok(Self {
            calibration,
            brightest,
            levels,
            baffled,
        })
    }

    /// The true wavelength of a pixel that is said to be at `stated_nm`, nm.
    pub fn true_nm(&self, stated_nm: f64) -> f64 {
        self.calibration.corrections.true_nm(stated_nm)
    }

    /// The same spectra, corrected by other things.
    pub fn with<'b>(&self, calibration: &'b SpectralCalibration) -> Procedure<'b>
    where
        'a: 'b,
    {
        Procedure {
            calibration,
            brightest: self.brightest.clone(),
            levels: self.levels.clone(),
            baffled: self.baffled.clone(),
        }
    }

    /// By which corrections its spectra are corrected.
    pub fn corrected_by(&self) -> String {
        self.calibration.corrections.name()
    }

    /// Mean rates of the brightest spectra, and of those behind the baffle.
    pub fn light_and_stray(&self) -> Result<(Rates, Rates), CalibrationError> {
        Ok((self.mean(&self.brightest)?, self.mean(&self.baffled)?))
    }

    /// Light of the last of the brightest spectra over that of the first, less 1.
    pub fn change_rel(&self) -> Result<f64, CalibrationError> {
        let total =
            |record: &SpectrumRecord| -> Result<f64, CalibrationError> { Ok(self.rates(record)?.per_s.iter().sum()) };
        let [first, .., last] = self.brightest[..] else {
            return Ok(0.0);
        };
        Ok(total(last)? / total(first)? - 1.0)
    }

    /// The largest difference of rates at other integration times from the mean of the brightest, relative, over
    /// classes of pixels by their counts.
    ///
    /// # Errors
    /// [`CalibrationError::Nonlinear`] where it is more than three standard uncertainties of noise, half the lamp's
    /// change and [`LINEARITY_MAX_REL`] allow.
    pub fn nonlinearity_rel(&self, light: &Rates, change_rel: f64) -> Result<f64, CalibrationError> {
        let long_s = self.brightest[0].integration_s;
        let mut largest: f64 = 0.0;
        for record in &self.levels {
            let rates = self.rates(record)?;
            for edges in CLASSES.windows(2) {
                let (mut weights, mut sum, mut counts, mut pixels) = (0.0, 0.0, 0.0, 0.0);
                for (place, &bright) in light.per_s.iter().enumerate() {
                    let share = bright * long_s / self.calibration.full_scale_counts;
                    if !(edges[0]..edges[1]).contains(&share) {
                        continue;
                    }
                    let ratio = rates.per_s[place] / bright;
                    let u = (rates.u_per_s[place] / bright).hypot(ratio * light.u_per_s[place] / bright);
                    weights += 1.0 / (u * u);
                    sum += (ratio - 1.0) / (u * u);
                    counts += share;
                    pixels += 1.0;
                }
                if pixels == 0.0 {
                    continue;
                }
                let difference_rel: f64 = sum / weights;
                let allowed_rel = 3.0 / weights.sqrt() + 0.5 * change_rel.abs() + LINEARITY_MAX_REL;
                if difference_rel.abs() > allowed_rel {
                    return Err(CalibrationError::Nonlinear {
                        of_full_scale: counts / pixels,
                        difference_rel,
                        allowed_rel,
                        short_s: record.integration_s,
                        long_s,
                    });
                }
                largest = largest.max(difference_rel.abs());
            }
        }
        Ok(largest)
    }

    fn mean(&self, records: &[&SpectrumRecord]) -> Result<Rates, CalibrationError> {
        let all = records
            .iter()
            .map(|record| self.rates(record))
            .collect::<Result<Vec<_>, _>>()?;
        let n = all.len() as f64;
        let pixels = 0..all.iter().map(|rates| rates.per_s.len()).min().unwrap_or_default();
        let sum = |of: &dyn Fn(&Rates) -> f64| all.iter().map(of).sum::<f64>();
        Ok(Rates {
            per_s: pixels
                .clone()
                .map(|place| sum(&|rates| rates.per_s[place]) / n)
                .collect(),
            u_per_s: pixels
                .map(|place| sum(&|rates| rates.u_per_s[place].powi(2)).sqrt() / n)
                .collect(),
        })
    }

    /// What a new factor multiplies, corrected as every spectrum is.
    fn rates(&self, record: &SpectrumRecord) -> Result<Rates, CalibrationError> {
        let linear = Linear::of(record, self.calibration, Chain::ALL)?;
        // No pixel is saturated.
        let raw: Vec<f64> = linear.per_s.into_iter().map(Option::unwrap_or_default).collect();
        let Some(fwhm_nm) = bandpass_nm(self.calibration, Chain::ALL) else {
            return Ok(Rates {
                per_s: raw,
                u_per_s: linear.u_per_s,
            });
        };
        let weights = bandpass::weights(&linear.wavelength_nm, fwhm_nm);
        let value = |of: &Vec<(usize, f64)>| of.iter().map(|(pixel, weight)| weight * raw[*pixel]).sum();
        let square = |of: &Vec<(usize, f64)>| -> f64 {
            let parts = of
                .iter()
                .map(|(pixel, weight)| (weight * linear.u_per_s[*pixel]).powi(2));
            parts.sum()
        };
        Ok(Rates {
            per_s: weights.iter().map(value).collect(),
            u_per_s: weights.iter().map(|of| square(of).sqrt()).collect(),
        })
    }
}
