//! Edits of a distribution: turned, made symmetric, resampled, scaled, described anew. Nothing is changed in silence:
//! each edit gives a sentence, and the files that have a place for remarks keep it.

mod description;
mod record;
mod request;

use isolux_photometry::{IntensityDistribution, Symmetry};

use self::description::refused;
pub use self::request::Edit;
use crate::distribution::Distribution;
use crate::eulumdat;
use crate::finding::Finding;
use crate::luminaire::Luminaire;
use crate::number::shortest;

/// Finest step of a new grid in degrees: ten times finer than any goniophotometer's file.
const FINEST_STEP_DEG: f64 = 0.05;
/// Angles that differ by less are the same.
const SAME_DEG: f64 = 1e-6;

impl Distribution {
    /// The distribution after `edits`, in their order, with a note for each.
    ///
    /// # Errors
    /// A finding that says which edit cannot be made and why.
    pub fn edited(&self, edits: &[Edit]) -> Result<(Self, Vec<Finding>), Finding> {
        let mut edited = self.clone();
        let mut changes: Vec<String> = Vec::new();
        for edit in edits {
            changes.push(match edit {
                Edit::RotateC(deg) => edited.rotate_c(*deg)?,
                Edit::Symmetrize(symmetry) => edited.symmetrize(*symmetry)?,
                Edit::Resample(c_deg, gamma_deg) => edited.resample(*c_deg, *gamma_deg)?,
                Edit::ScaleFlux(flux_lm) => edited.scale_flux(*flux_lm)?,
                Edit::Set(key, text) => edited.set(key, text)?,
            });
        }
        let mut notes: Vec<Finding> = changes
            .iter()
            .map(|change| Finding::note("convert-edited", change.clone()))
            .collect();
        if let Some(old) = edited.record(edits, &changes) {
            let message = "the line of date and user has no room for the record of the changes beside its text";
            notes.push(
                Finding::note("convert-date-cut", message)
                    .raw(&old)
                    .assumed("the end of its text is cut off"),
            );
        }
        Ok((edited, notes))
    }

    fn rotate_c(&mut self, deg: f64) -> Result<String, Finding> {
        if !deg.is_finite() || deg.abs() > 360.0 {
            return Err(refused(
                format!("the light cannot be turned by {deg}°"),
                "give an angle from -360 to 360",
            ));
        }
        let turned: Vec<f64> = self
            .intensity
            .c_deg()
            .iter()
            .map(|c| (c + deg).rem_euclid(360.0))
            .collect();
        let on_grid = turned.iter().any(|c| *c < SAME_DEG || 360.0 - c < SAME_DEG);
        let mut sentence = format!("turned by {}° in C", shortest(deg, 6));
        if !self.intensity.is_rotational() {
            let old = &self.intensity;
            // Formats begin at C 0°; where no half-plane comes to lie there, the old ones are kept and interpolated.
            let mut planes: Vec<f64> = if on_grid {
                turned
                    .iter()
                    .map(|c| if 360.0 - c < SAME_DEG { 0.0 } else { round(*c) })
                    .collect()
            } else {
                sentence.push_str(", interpolated between the half-planes");
                old.c_deg().to_vec()
            };
            planes.sort_by(f64::total_cmp);
            let rows = planes.iter().flat_map(|c| old.half_plane_cd(c - deg)).collect();
            self.relight(planes, old.gamma_deg().to_vec(), rows)?;
        }
        let quarters = deg / 90.0;
        if (quarters - quarters.round()).abs() < SAME_DEG {
            let quarters = (quarters.round() as i64).rem_euclid(4) as usize;
            turn_sizes(&mut self.luminaire, quarters);
            if let Some(document) = &mut self.eulumdat {
                turn_header(&mut document.header, quarters);
            }
        } else {
            sentence.push_str("; length and width are kept as they were");
        }
        Ok(sentence)
    }

    fn symmetrize(&mut self, symmetry: Symmetry) -> Result<String, Finding> {
        let old = &self.intensity;
        let gammas = old.gamma_deg().to_vec();
        let (name, planes) = match symmetry {
            Symmetry::None => return Err(refused("no symmetry was asked for".to_owned(), "name one")),
            Symmetry::Rotational => ("rotational", vec![0.0]),
            Symmetry::C0C180 => ("symmetric about C0–C180", vec![0.0, 180.0]),
            Symmetry::C90C270 => ("symmetric about C90–C270", vec![90.0, 270.0]),
            Symmetry::Quadrant => ("symmetric about both planes", vec![0.0, 90.0, 180.0, 270.0]),
        };
        let mut all = planes;
        let rows: Vec<f64> = if symmetry == Symmetry::Rotational {
            let widths = old.plane_widths_deg();
            let mean = |column: usize| -> f64 {
                let planes = (0..widths.len()).map(|plane| widths[plane] * old.row(plane)[column]);
                planes.sum::<f64>() / 360.0
            };
            (0..gammas.len()).map(mean).collect()
        } else {
            for &c in old.c_deg() {
                all.extend(symmetry.images_deg(c).into_iter().map(round));
            }
            all.sort_by(f64::total_cmp);
            all.dedup_by(|a, b| (*a - *b).abs() < SAME_DEG);
            let images = all.iter().flat_map(|&c| mean_of(old, &symmetry.images_deg(c)));
            images.collect()
        };
        let most = difference(&all, &rows, old);
        self.relight(all, gammas, rows)?;
        Ok(format!(
            "made {name}; intensities changed by up to {} cd",
            shortest(most, 3)
        ))
    }

    fn resample(&mut self, c_step: f64, gamma_step: f64) -> Result<String, Finding> {
        let old = &self.intensity;
        let gammas = old.gamma_deg();
        let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
        let grid = |name: &str, from: f64, span: f64, step: f64| -> Result<Vec<f64>, Finding> {
            let count = span / step;
            let whole = step.is_finite() && step >= FINEST_STEP_DEG && (count - count.round()).abs() < SAME_DEG;
            if !whole || count.round() < 1.0 {
                let message = format!("{name} cannot have steps of {step}° over {span}°");
                let fix = format!("give a step from {FINEST_STEP_DEG}° on that divides {span}°");
                return Err(refused(message, &fix));
            }
            Ok((0..=count.round() as usize)
                .map(|k| round(from + k as f64 * step))
                .collect())
        };
        let mut planes = grid("C", 0.0, 360.0, c_step)?;
        planes.pop();
        if old.is_rotational() {
            planes = vec![0.0];
        }
        let angles = grid("γ", first, last - first, gamma_step)?;
        let at = |c: f64| angles.iter().map(move |gamma| old.intensity_cd_at(c, *gamma));
        let rows = planes.iter().flat_map(|&c| at(c)).collect();
        let before = old.flux_lm();
        self.relight(planes, angles, rows)?;
        Ok(format!(
            "resampled at {}° of C and {}° of γ, bilinear; the flux went from {} to {} lm",
            shortest(c_step, 6),
            shortest(gamma_step, 6),
            shortest(before, 6),
            shortest(self.intensity.flux_lm(), 6)
        ))
    }

    fn scale_flux(&mut self, flux_lm: f64) -> Result<String, Finding> {
        let own = self.intensity.flux_lm();
        let factor = flux_lm / own;
        if !(factor.is_finite() && factor > 0.0 && own > 0.0) {
            let message = format!("{own} lm cannot be scaled to {flux_lm} lm");
            return Err(refused(message, "give a flux above zero in lm"));
        }
        let scaled = self.intensity.scaled(factor);
        self.intensity = scaled.map_err(|error| refused(error.to_string(), "give a smaller flux"))?;
        self.native = None;
        self.lamp_flux_lm = self.lamp_flux_lm.map(|lamps| lamps * factor);
        if let Some(document) = &mut self.eulumdat {
            for set in &mut document.header.lamp_sets {
                set.flux_lm = set.flux_lm.map(|lamps| lamps * factor);
            }
        }
        Ok(format!(
            "flux scaled from {} to {} lm (intensities and lamps × {})",
            shortest(own, 6),
            shortest(flux_lm, 6),
            shortest(factor, 6)
        ))
    }

    fn relight(&mut self, c_deg: Vec<f64>, gamma_deg: Vec<f64>, intensity_cd: Vec<f64>) -> Result<(), Finding> {
        let grid = IntensityDistribution::new(c_deg, gamma_deg, intensity_cd);
        self.intensity = grid.map_err(|error| refused(error.to_string(), "leave this edit out"))?;
        self.symmetry = self
            .intensity
            .detect_symmetry(1e-9 * self.intensity.peak().intensity_cd.abs());
        self.native = None;
        if let Some(document) = &mut self.eulumdat {
            // What follows from the light is computed anew.
            let header = &mut document.header;
            (header.lorl_percent, header.dff_percent, header.type_indicator) = (None, None, None);
            header.direct_ratios = [None; 10];
        }
        Ok(())
    }
}

/// Length lies along C90–C270, width along C0–C180; a width of zero is a round luminaire, which stays.
fn swap(length: &mut Option<f64>, width: &mut Option<f64>) {
    if width.is_some_and(|width| width > 0.0) {
        std::mem::swap(length, width);
    }
}

fn turn_sizes(luminaire: &mut Luminaire, quarters: usize) {
    if quarters % 2 == 1 {
        swap(&mut luminaire.length_mm, &mut luminaire.width_mm);
        swap(&mut luminaire.luminous_length_mm, &mut luminaire.luminous_width_mm);
        if let Some([x, y, _]) = &mut luminaire.luminous_body_mm {
            std::mem::swap(x, y);
        }
    }
    luminaire.luminous_height_mm.rotate_right(quarters);
}

fn turn_header(header: &mut eulumdat::Header, quarters: usize) {
    if quarters % 2 == 1 {
        swap(&mut header.length_mm, &mut header.width_mm);
        swap(&mut header.luminous_length_mm, &mut header.luminous_width_mm);
    }
    header.luminous_height_mm.rotate_right(quarters);
}

/// The mean of several half-planes, one value a γ.
fn mean_of(grid: &IntensityDistribution, planes_deg: &[f64]) -> Vec<f64> {
    let mut mean = vec![0.0; grid.gamma_deg().len()];
    for &c in planes_deg {
        for (sum, value) in mean.iter_mut().zip(grid.half_plane_cd(c)) {
            *sum += value / planes_deg.len() as f64;
        }
    }
    mean
}

/// The largest difference, in cd, to what `old` has in the same directions.
fn difference(planes_deg: &[f64], rows: &[f64], old: &IntensityDistribution) -> f64 {
    let width = old.gamma_deg().len();
    let all = if planes_deg.len() == 1 { old.c_deg() } else { planes_deg };
    all.iter().enumerate().fold(0.0_f64, |most, (plane, &c)| {
        let row = if planes_deg.len() == 1 { 0 } else { plane };
        let pairs = old.half_plane_cd(c).into_iter().zip(&rows[row * width..]);
        pairs.fold(most, |most, (before, after)| most.max((after - before).abs()))
    })
}

/// Sums of steps without the dust of their binary fractions.
fn round(deg: f64) -> f64 {
    (deg * 1e9).round() / 1e9
}
