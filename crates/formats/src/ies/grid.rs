//! The table that an LM-63 file is to hold: its type, its angles, its candela.

use std::borrow::Cow;

use isolux_photometry::{IntensityDistribution, Symmetry};

use super::photometry::Photometry;
use crate::distribution::Native;
use crate::finding::{Finding, Findings};

/// Candela over vertical and horizontal angles, one row a horizontal angle.
pub(super) struct Grid<'g> {
    pub photometry: Photometry,
    pub vertical_deg: Cow<'g, [f64]>,
    pub horizontal_deg: Vec<f64>,
    pub rows_cd: Vec<Cow<'g, [f64]>>,
}

/// Directions that a turned grid has at most: 0.25° over the half-space.
const FINEST_STEP_DEG: f64 = 0.25;

impl<'g> Grid<'g> {
    /// Type C: the symmetry that the intensities really have is kept where LM-63-2002 has a class for it: horizontal
    /// angles 0, 0–90, 0–180, or 0–360 with C0 repeated at 360.
    pub fn type_c(intensity: &'g IntensityDistribution, findings: &mut Findings) -> Self {
        let gamma = intensity.gamma_deg();
        let ends = [gamma.first().copied(), gamma.last().copied()];
        if !matches!(ends, [Some(0.0 | 90.0), Some(90.0 | 180.0)]) {
            let message = "vertical angles of LM-63 begin at 0° or 90° and end at 90° or 180°; these do not";
            findings.push(Finding::warning("ies-vertical-range", message).assumed("the angles as they are"));
        }
        let (planes, horizontal_deg) = stored(intensity, findings);
        Self {
            photometry: Photometry::C,
            vertical_deg: Cow::Borrowed(gamma),
            horizontal_deg,
            rows_cd: planes
                .iter()
                .map(|&plane| Cow::Borrowed(intensity.row(plane)))
                .collect(),
        }
    }

    /// Types A and B as they were read.
    pub fn native(native: &'g Native, photometry: Photometry) -> Self {
        Self {
            photometry,
            vertical_deg: Cow::Borrowed(&native.vertical_deg),
            horizontal_deg: native.horizontal_deg.clone(),
            rows_cd: native
                .intensity_cd
                .iter()
                .map(|row| Cow::Borrowed(row.as_slice()))
                .collect(),
        }
    }

    /// C–γ turned into type A or B over the half-space in front, at the smallest step of γ; what lies behind is lost,
    /// and said. Where left and right agree the horizontal angles begin at 0, LM-63's class for lateral symmetry.
    pub fn turned(intensity: &IntensityDistribution, photometry: Photometry, findings: &mut Findings) -> Self {
        let (behind, all) = (intensity.flux_between_lm(90.0, 180.0), intensity.flux_lm());
        if behind.abs() > 1e-9 * all.abs() {
            let message = format!(
                "{behind:.4} lm of {all:.4} lm go behind the plane of the luminaire, where type {} has no angles",
                photometry.letter()
            );
            findings.push(
                Finding::warning("ies-behind", message)
                    .assumed("the half-space in front")
                    .fix("keep type C for this luminaire"),
            );
        }
        let steps = intensity.gamma_deg().windows(2).map(|pair| pair[1] - pair[0]);
        let step = steps.fold(30.0, f64::min).max(FINEST_STEP_DEG);
        let quarter = (90.0 / step - 1e-9).ceil();
        let step = 90.0 / quarter;
        let quarter = quarter as i32;
        let angles = |from: i32| -> Vec<f64> { (from..=quarter).map(|at| f64::from(at) * step).collect() };
        let message = format!("turned from C-γ to type {} every {step}°", photometry.letter());
        findings.push(
            Finding::note("ies-resampled", message).assumed("γ = 0 is V = 0, H = 0, C0 is positive H, C90 positive V"),
        );
        let vertical = angles(-quarter);
        let row = |horizontal: f64| -> Vec<f64> {
            let toward = |&vertical: &f64| intensity.toward(photometry.direction(vertical, horizontal));
            vertical.iter().map(toward).collect()
        };
        let right: Vec<Vec<f64>> = angles(0).into_iter().map(row).collect();
        let left: Vec<Vec<f64>> = angles(-quarter)
            .into_iter()
            .filter(|&angle| angle < 0.0)
            .map(row)
            .collect();
        let tolerance = 1e-9 * intensity.peak().intensity_cd.abs();
        let same = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance);
        let lateral = left
            .iter()
            .rev()
            .zip(&right[1..])
            .all(|(left, right)| same(left, right));
        let (from, rows) = if lateral {
            (0, right)
        } else {
            (-quarter, [left, right].concat())
        };
        Self {
            photometry,
            vertical_deg: Cow::Owned(vertical),
            horizontal_deg: angles(from),
            rows_cd: rows.into_iter().map(Cow::Owned).collect(),
        }
    }
}

/// Plane indices and horizontal angles to write: 0, 0–90, 0–180 or 0–360 with C0 repeated at 360.
fn stored(intensity: &IntensityDistribution, findings: &mut Findings) -> (Vec<usize>, Vec<f64>) {
    let c_deg = intensity.c_deg();
    let tolerance = intensity.peak().intensity_cd.abs() * 1e-9;
    let has = |angle: f64| c_deg.contains(&angle);
    let last = match intensity.detect_symmetry(tolerance) {
        Symmetry::Rotational => 0.0,
        Symmetry::Quadrant if has(0.0) && has(90.0) => 90.0,
        Symmetry::C0C180 | Symmetry::Quadrant if has(0.0) && has(180.0) => 180.0,
        Symmetry::C90C270 => {
            findings.push(Finding::note(
                "ies-symmetry",
                "LM-63-2002 has no class for symmetry about C90–C270; all planes are written",
            ));
            360.0
        }
        _ => 360.0,
    };
    if last == 0.0 {
        return (vec![0], vec![0.0]);
    }
    let mut planes: Vec<usize> = (0..c_deg.len()).filter(|&plane| c_deg[plane] <= last).collect();
    let mut angles: Vec<f64> = planes.iter().map(|&plane| c_deg[plane]).collect();
    if last == 360.0 {
        if angles.first() == Some(&0.0) {
            planes.push(0);
            angles.push(360.0);
        } else {
            let message = "horizontal angles of LM-63 begin at 0°; these do not";
            findings.push(Finding::warning("ies-horizontal-range", message).assumed("the angles as they are"));
        }
    }
    (planes, angles)
}
