//! Stored planes of an EULUMDAT file to the full circle, and which stored plane stands at which C.

use isolux_photometry::{IntensityDistribution, Symmetry, SymmetryError};

use super::document::{Document, stored_planes, symmetry};

/// C of each stored plane, in the order in which the file stores them.
///
/// `c_deg`: the Mc angles of the file. Symmetry 3 begins at C270 and passes C0 to C90; `c90_first` is the order of the
/// programs that begin at C90 and pass C180. A file that lists only the planes it stores is taken at its word.
pub(super) fn stored_c_deg(isym: u8, c_deg: &[f64], planes: usize, c90_first: bool) -> Vec<f64> {
    let mc = c_deg.len();
    if planes != stored_planes(isym, mc) || mc <= planes {
        return c_deg.iter().copied().take(planes).collect();
    }
    if isym != 3 {
        return c_deg[..planes].to_vec();
    }
    let start = if c90_first {
        c_deg.iter().position(|&c| c >= 90.0 - 1e-6).unwrap_or(mc / 4)
    } else {
        c_deg.iter().position(|&c| c >= 270.0 - 1e-6).unwrap_or(3 * mc / 4)
    };
    (0..planes).map(|offset| c_deg[(start + offset) % mc]).collect()
}

/// The full circle in candela; the angles of C are those that the file lists.
pub(super) fn expand(
    document: &Document,
    factor: f64,
    c90_first: bool,
) -> Result<IntensityDistribution, SymmetryError> {
    let ng = document.gamma_deg.len();
    let planes = document.intensity_cd_klm.len() / ng.max(1);
    let candela: Vec<f64> = document.intensity_cd_klm.iter().map(|value| value * factor).collect();
    if document.isym == 1 {
        let mut c_deg: Vec<f64> = document.c_deg.iter().copied().filter(|&c| c < 360.0).collect();
        if c_deg.is_empty() {
            c_deg.push(0.0);
        }
        let row = &candela[..ng.min(candela.len())];
        let all = row.repeat(c_deg.len());
        return Ok(IntensityDistribution::new(c_deg, document.gamma_deg.clone(), all)?);
    }
    let stored = stored_c_deg(document.isym, &document.c_deg, planes, c90_first);
    let rows: Vec<(f64, Vec<f64>)> = stored
        .iter()
        .zip(candela.chunks(ng.max(1)))
        // C360 is C0; where both stand there the first is kept.
        .filter(|(c, _)| symmetry(document.isym) != Symmetry::None || **c < 360.0)
        .map(|(&c, row)| (c, row.to_vec()))
        .collect();
    IntensityDistribution::expand(symmetry(document.isym), &rows, document.gamma_deg.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(mc: usize) -> Vec<f64> {
        (0..mc).map(|plane| plane as f64 * 360.0 / mc as f64).collect()
    }

    #[test]
    fn class_three_begins_at_c270() {
        let stored = stored_c_deg(3, &circle(8), 5, false);
        assert_eq!(stored, [270.0, 315.0, 0.0, 45.0, 90.0]);
        assert_eq!(stored_c_deg(3, &circle(8), 5, true), [90.0, 135.0, 180.0, 225.0, 270.0]);
        assert_eq!(stored_c_deg(4, &circle(8), 3, false), [0.0, 45.0, 90.0]);
        assert_eq!(stored_c_deg(4, &[0.0, 45.0, 90.0], 3, false), [0.0, 45.0, 90.0]);
    }

    #[test]
    fn a_class_three_file_fills_both_halves() {
        let document = Document {
            header: super::super::Header::default(),
            isym: 3,
            c_deg: circle(4),
            gamma_deg: vec![0.0, 90.0],
            // C270, C0, C90
            intensity_cd_klm: vec![1.0, 70.0, 1.0, 50.0, 1.0, 90.0],
        };
        let full = expand(&document, 2.0, false).unwrap();
        assert_eq!(full.c_deg(), [0.0, 90.0, 180.0, 270.0]);
        let at = |c| full.intensity_cd_at(c, 90.0);
        assert_eq!([at(0.0), at(90.0), at(180.0), at(270.0)], [100.0, 180.0, 100.0, 140.0]);
    }
}
