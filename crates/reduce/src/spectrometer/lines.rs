//! Wavelength scale and bandpass from the lines of a lamp.
//!
//! The lamp stands close before the entrance while the lamp of the bench is off: its spectra are of the kind
//! `lamp_off`, dark taken off. A line counts where it stands alone; others of the lamp beside it are part of its image.

use isolux_record::lines::{Line, LineList};
use isolux_record::spectra::{LineFound, SpectralCorrections, SpectrumRecord, WAVELENGTHS_FORMAT, WavelengthScale};
use isolux_record::{ReadingKind, Run};

use super::error::InstrumentError;
use super::image::{Found, Sample, Shape, fit};
use super::scale::{Scale, bandpass};
use super::{Spectra, made, steady};
use crate::instrument::{Chain, Linear};

/// As many lines at least.
const LEAST_LINES: usize = 4;
/// The lines reach from this or below to this or above, nm: beyond them hardly any light counts for colour.
const COVERED_NM: [f64; 2] = [450.0, 650.0];
/// How far the stated wavelengths may be off, nm.
const SEARCHED_NM: f64 = 8.0;
/// A line that counts is so many of its uncertainties above the background.
const LEAST_SIGNAL: f64 = 20.0;
/// A line with this share of the strongest has to be there.
const STRONG_REL: f64 = 0.3;
/// Light of no line above this share of the strongest is of something else.
const UNKNOWN_REL: f64 = 0.1;
/// Strengths of lines beside another are known in kind; half of each is their uncertainty.
const STRENGTH_U_REL: f64 = 0.5;
/// So many times the χ² of the other shape.
const MUCH_WORSE: f64 = 4.0;
/// With another of this strength nearer than the bandpass it is not known which of both is seen.
const EQUAL_REL: f64 = 0.5;
/// A line whose place depends more than this on what is beside it is blended, as a share of the bandpass.
const BLENDED_REL: f64 = 0.02;
/// A line farther off the scale than this share of the bandpass is not the line of the list.
const ROUGH_REL: f64 = 0.1;
/// The light of the lines may change by this much from the first spectrum to the last.
const CHANGE_REL: f64 = 0.2;
/// Half width of what a line is fitted in, in bandpasses.
const WINDOW: f64 = 1.3;

/// The wavelength scale and the bandpass that a run with a line lamp gives.
///
/// # Errors
/// [`InstrumentError`]: saturated, another lamp, blended, lines that do not lie on a smooth scale.
pub fn wavelengths(run: &Run, list: &LineList) -> Result<WavelengthScale, InstrumentError> {
    let shown = Shown::of(run, list)?;
    let fwhm_nm = shown.first_fwhm_nm()?;
    let found = shown.found(fwhm_nm)?;
    let scale = Scale::through(&found);
    if let Some((line, residual_nm)) = found
        .iter()
        .map(|found| (found, scale.residual_nm(found)))
        .find(|(_, residual_nm)| residual_nm.abs() > ROUGH_REL * fwhm_nm)
    {
        return Err(InstrumentError::Rough {
            wavelength_nm: line.wavelength_nm,
            residual_nm,
        });
    }
    let (fwhm_nm, u_fwhm_nm) = bandpass(&found);
    Ok(WavelengthScale {
        format: WAVELENGTHS_FORMAT.to_owned(),
        fwhm_nm,
        u_fwhm_nm,
        range_nm: [found[0].wavelength_nm, found[found.len() - 1].wavelength_nm],
        made: made(run, &list.lamp),
        line: found
            .iter()
            .map(|found| LineFound {
                wavelength_nm: found.wavelength_nm,
                stated_nm: found.image.centre_nm,
                u_nm: found.u_nm,
                residual_nm: scale.residual_nm(found),
                fwhm_nm: found.image.fwhm_nm,
            })
            .collect(),
        offset_nm: scale.offset_nm,
        covariance_nm2: scale.covariance_nm2,
    })
}

/// The mean spectrum of the lamp on the scale that the instrument states.
struct Shown<'a> {
    list: &'a LineList,
    samples: Vec<Sample>,
    /// By how much the stated wavelengths are too long, roughly, nm.
    shift_nm: f64,
    /// The strongest pixel above the background, counts a second.
    peak_per_s: f64,
    background_per_s: f64,
}

impl<'a> Shown<'a> {
    fn of(run: &Run, list: &'a LineList) -> Result<Self, InstrumentError> {
        let Spectra { calibration, records } = Spectra::of(run, ReadingKind::LampOff, "a line lamp")?;
        // What is to be found is not corrected for.
        let mut own = calibration.clone();
        own.corrections = SpectralCorrections {
            wavelengths: None,
            ..own.corrections
        };
        let linear = |record: &SpectrumRecord| Linear::of(record, &own, Chain::ALL);
        let all = records
            .iter()
            .map(|record| linear(record))
            .collect::<Result<Vec<_>, _>>()?;
        let n = all.len() as f64;
        let nm = &all[0].wavelength_nm;
        let count = nm.len();
        let sample = |place: usize| {
            let (low, high) = (place.saturating_sub(1), (place + 1).min(count - 1));
            let sum: f64 = all.iter().filter_map(|of| of.per_s[place]).sum();
            let squares: f64 = all.iter().map(|of| of.u_per_s[place].powi(2)).sum();
            Sample {
                stated_nm: nm[place],
                pixel_nm: (nm[high] - nm[low]) / (high - low) as f64,
                per_s: sum / n,
                u_per_s: squares.sqrt() / n,
            }
        };
        let black = calibration.dark_pixels[1];
        let samples: Vec<Sample> = (black..count).map(sample).collect();
        let mut levels: Vec<f64> = samples.iter().map(|sample| sample.per_s).collect();
        levels.sort_by(f64::total_cmp);
        let background_per_s = levels.get(levels.len() / 2).copied().unwrap_or_default();
        let highest = samples.iter().max_by(|a, b| a.per_s.total_cmp(&b.per_s));
        let dark = || InstrumentError::Dark {
            lamp: list.lamp.clone(),
        };
        let highest = highest.ok_or_else(dark)?;
        let peak_per_s = highest.per_s - background_per_s;
        if peak_per_s < LEAST_SIGNAL * highest.u_per_s {
            return Err(dark());
        }
        steady(&records, &own, CHANGE_REL)?;
        let mut shown = Self {
            list,
            samples,
            shift_nm: 0.0,
            peak_per_s,
            background_per_s,
        };
        shown.shift_nm = shown.shift();
        Ok(shown)
    }

    /// Light above the background at a wavelength that the instrument states, over the strongest.
    fn at_rel(&self, stated_nm: f64) -> f64 {
        let above = self.samples.partition_point(|sample| sample.stated_nm < stated_nm);
        let inside = (1..self.samples.len()).contains(&above);
        let light = if inside {
            self.samples[above].per_s.max(self.samples[above - 1].per_s)
        } else {
            0.0
        };
        ((light - self.background_per_s) / self.peak_per_s).max(0.0)
    }

    /// The shift under which most lines of the list have light; roots, so that weak lines count beside strong ones.
    fn shift(&self) -> f64 {
        let steps = (SEARCHED_NM / 0.1).round() as i32;
        let shifts = (-steps..=steps).map(|step| 0.1 * f64::from(step));
        let light = |shift_nm: f64| -> f64 {
            let lines = self.list.line.iter();
            lines
                .map(|line| (line.strength_rel * self.at_rel(line.wavelength_nm + shift_nm)).sqrt())
                .sum()
        };
        // Of equal ones the smallest.
        shifts
            .map(|shift_nm| (shift_nm, light(shift_nm)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.abs().total_cmp(&a.0.abs())))
            .map_or(0.0, |(shift_nm, _)| shift_nm)
    }

    /// Width of the strongest image at half its height.
    fn first_fwhm_nm(&self) -> Result<f64, InstrumentError> {
        let above = |sample: &Sample| sample.per_s - self.background_per_s > 0.5 * self.peak_per_s;
        let peak = self.samples.iter().enumerate();
        let peak = peak
            .max_by(|a, b| a.1.per_s.total_cmp(&b.1.per_s))
            .map_or(0, |(place, _)| place);
        let width: f64 = self.samples[..peak]
            .iter()
            .rev()
            .take_while(|sample| above(sample))
            .chain(self.samples[peak..].iter().take_while(|sample| above(sample)))
            .map(|sample| sample.pixel_nm)
            .sum();
        let fwhm_nm = width.max(self.samples[peak].pixel_nm);
        self.nothing_else(fwhm_nm)?;
        Ok(fwhm_nm)
    }

    /// That all light is of the list, and its strong lines have some.
    fn nothing_else(&self, fwhm_nm: f64) -> Result<(), InstrumentError> {
        let lamp = || self.list.lamp.clone();
        let (first, last) = (
            self.samples[0].stated_nm,
            self.samples[self.samples.len() - 1].stated_nm,
        );
        for line in self.list.line.iter().filter(|line| line.strength_rel >= STRONG_REL) {
            let stated_nm = line.wavelength_nm + self.shift_nm;
            let seen = (first + fwhm_nm..=last - fwhm_nm).contains(&stated_nm);
            let near = self
                .samples
                .iter()
                .filter(|of| (of.stated_nm - stated_nm).abs() < fwhm_nm);
            let is_there = near
                .into_iter()
                .any(|of| of.per_s - self.background_per_s > LEAST_SIGNAL * of.u_per_s);
            // Glass and silicon end where mercury goes on.
            if seen && line.wavelength_nm > 400.0 && !is_there {
                return Err(InstrumentError::Missing {
                    lamp: lamp(),
                    wavelength_nm: line.wavelength_nm,
                    within_nm: SEARCHED_NM,
                });
            }
        }
        let of_no_line = |sample: &&Sample| {
            let mut lines = self.list.line.iter();
            !lines.any(|line| (line.wavelength_nm + self.shift_nm - sample.stated_nm).abs() < 2.5 * fwhm_nm)
        };
        let other = self.samples.iter().filter(of_no_line);
        let brightest = other.max_by(|a, b| a.per_s.total_cmp(&b.per_s));
        match brightest.map(|sample| {
            (
                sample.stated_nm,
                (sample.per_s - self.background_per_s) / self.peak_per_s,
            )
        }) {
            Some((stated_nm, share_rel)) if share_rel > UNKNOWN_REL => Err(InstrumentError::Unknown {
                lamp: lamp(),
                stated_nm,
                share_rel,
            }),
            _ => Ok(()),
        }
    }

    /// The lines that stand alone, rising.
    fn found(&self, fwhm_nm: f64) -> Result<Vec<Found>, InstrumentError> {
        let of = |shape| -> (Vec<Found>, usize) {
            let (mut found, mut blended) = (Vec::new(), 0);
            for line in &self.list.line {
                match self.line(line, fwhm_nm, shape) {
                    Some(line) if line.u_nm <= BLENDED_REL * fwhm_nm => found.push(line),
                    Some(_) => blended += 1,
                    None => {}
                }
            }
            (found, blended)
        };
        let [triangle, gaussian] = [Shape::Triangle, Shape::Gaussian].map(of);
        let mean_chi2 = |found: &[Found]| {
            let sum: f64 = found.iter().map(|found| found.image.chi2).sum();
            sum / found.len().max(1) as f64
        };
        let (better, other) = if mean_chi2(&triangle.0) <= mean_chi2(&gaussian.0) {
            (triangle, gaussian)
        } else {
            (gaussian, triangle)
        };
        // A shape that fits much worse is not the one of this instrument.
        let plausible = mean_chi2(&other.0) < MUCH_WORSE * mean_chi2(&better.0).max(1.0);
        let (mut found, blended) = better;
        for line in found.iter_mut().filter(|_| plausible) {
            let same = other.0.iter().find(|other| other.wavelength_nm == line.wavelength_nm);
            if let Some(same) = same {
                let third = 3.0_f64.sqrt();
                line.u_nm = line.u_nm.hypot((same.image.centre_nm - line.image.centre_nm) / third);
                line.u_fwhm_nm = (same.image.fwhm_nm - line.image.fwhm_nm).abs() / third;
            }
        }
        if found.len() < LEAST_LINES {
            return Err(InstrumentError::Blended {
                lamp: self.list.lamp.clone(),
                used: found.len(),
                blended,
                least: LEAST_LINES,
                fwhm_nm,
            });
        }
        let (first_nm, last_nm) = (found[0].wavelength_nm, found[found.len() - 1].wavelength_nm);
        let [from_nm, to_nm] = COVERED_NM;
        if first_nm > from_nm || last_nm < to_nm {
            return Err(InstrumentError::Range {
                first_nm,
                last_nm,
                from_nm,
                to_nm,
            });
        }
        Ok(found)
    }

    /// One line, with what lies beside it; none where it is too weak or beyond the pixels.
    fn line(&self, line: &Line, fwhm_nm: f64, shape: Shape) -> Option<Found> {
        let stated_nm = line.wavelength_nm + self.shift_nm;
        // The highest pixel near it is where it begins.
        let near = self
            .samples
            .iter()
            .filter(|of| (of.stated_nm - stated_nm).abs() < fwhm_nm);
        let start_nm = near.max_by(|a, b| a.per_s.total_cmp(&b.per_s))?.stated_nm;
        let half_nm = WINDOW * fwhm_nm;
        let within = |sample: &&Sample| (sample.stated_nm - start_nm).abs() <= half_nm;
        let samples: Vec<Sample> = self.samples.iter().filter(within).copied().collect();
        let (first, last) = (samples.first()?, samples.last()?);
        // At an end of the detector a part of the image is missing.
        let whole = last.stated_nm - first.stated_nm > 1.5 * half_nm;
        let beside = |more: f64| -> Vec<(f64, f64)> {
            let others = self
                .list
                .line
                .iter()
                .filter(|other| other.wavelength_nm != line.wavelength_nm);
            others
                .map(|other| {
                    (
                        other.wavelength_nm - line.wavelength_nm,
                        other.strength_rel / line.strength_rel,
                    )
                })
                .filter(|(off_nm, _)| off_nm.abs() < 2.0 * half_nm)
                .map(|(off_nm, strength)| (off_nm, strength * more))
                .collect()
        };
        let image = fit(&samples, &beside(1.0), start_nm, fwhm_nm, shape).filter(|_| whole)?;
        if image.signal_to_noise < LEAST_SIGNAL {
            return None;
        }
        let mut others = beside(1.0).into_iter();
        let changed = if others.any(|(off_nm, strength)| off_nm.abs() < fwhm_nm && strength > EQUAL_REL) {
            f64::INFINITY
        } else if beside(1.0).is_empty() {
            0.0
        } else {
            let more = fit(&samples, &beside(1.0 + STRENGTH_U_REL), start_nm, fwhm_nm, shape);
            more.map_or(f64::INFINITY, |more| (more.centre_nm - image.centre_nm).abs())
        };
        Some(Found {
            wavelength_nm: line.wavelength_nm,
            u_nm: image.u_nm.hypot(changed),
            image,
            u_fwhm_nm: 0.0,
        })
    }
}
