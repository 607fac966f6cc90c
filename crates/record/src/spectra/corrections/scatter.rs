//! `isolux-scatter/1`: where light falls that a spectroradiometer scatters inside.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use super::{Made, check_made, parse};
use crate::document::bounds::within;
use crate::document::{DocumentError, Fault};

/// Value of `format`.
pub const FORMAT: &str = "isolux-scatter/1";

/// More bands than this are pixels.
const MOST_BANDS: usize = 200;

/// What a spectroradiometer scatters, as a matrix over bands of wavelength: the line spread function of Zong, Brown,
/// Johnson, Lykke and Ohno (Appl. Opt. 45, 1111, 2006) in coarse steps. One band is a share that falls evenly on all
/// pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// [`FORMAT`].
    pub format: String,
    /// Edges between the bands, rising; pixels beyond the first and the last belong to the bands at the ends. None: one
    /// band.
    pub edges_nm: Vec<f64>,
    /// `share_rel[i][j]`: counts that light of band j leaves, spread evenly over all pixels of band i, over the counts
    /// of that light at its own wavelengths.
    pub share_rel: Vec<Vec<f64>>,
    /// Their standard uncertainties (k = 1), which they share: all are too large or too small together.
    pub u_share_rel: Vec<Vec<f64>>,
    /// Where it comes from.
    pub made: Made,
}

impl Scatter {
    /// Reads a file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        parse(file, text, FORMAT, check)
    }

    /// The matrix with every share larger by `share` of its standard uncertainty.
    pub fn move_by(&mut self, share: f64) {
        let pairs = self
            .share_rel
            .iter_mut()
            .flatten()
            .zip(self.u_share_rel.iter().flatten());
        pairs.for_each(|(value, u)| *value += share * u);
    }

    /// The band of a wavelength.
    pub fn band(&self, wavelength_nm: f64) -> usize {
        self.edges_nm.partition_point(|edge| *edge <= wavelength_nm)
    }
}

fn check(scatter: &Scatter) -> Result<(), Fault> {
    check_made(&scatter.made)?;
    let bands = scatter.edges_nm.len() + 1;
    if bands > MOST_BANDS {
        return Err(Fault::new(
            "edges_nm",
            format!("makes {bands} bands; {MOST_BANDS} at most"),
        ));
    }
    if !scatter.edges_nm.is_sorted_by(|a, b| a < b) {
        return Err(Fault::new("edges_nm", "does not rise"));
    }
    for edge_nm in &scatter.edges_nm {
        within("edges_nm", *edge_nm, 100.0..=10_000.0, " nm")?;
    }
    for (key, matrix, range) in [
        ("share_rel", &scatter.share_rel, -0.01..=0.5),
        ("u_share_rel", &scatter.u_share_rel, 0.0..=0.5),
    ] {
        if matrix.len() != bands || matrix.iter().any(|row| row.len() != bands) {
            let message = format!("needs {bands} rows of {bands} numbers, one more than `edges_nm`");
            return Err(Fault::new(key, message));
        }
        for share_rel in matrix.iter().flatten() {
            within(key, *share_rel, range.clone(), " (a fraction of the counts of a band)")?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::wavelengths::tests::scale;
    use super::*;

    #[test]
    fn a_matrix_survives_its_file_and_one_that_is_none_is_refused() {
        let scatter = Scatter {
            format: FORMAT.to_owned(),
            edges_nm: vec![500.0, 600.0],
            share_rel: vec![vec![0.001, 0.002, 0.003]; 3],
            u_share_rel: vec![vec![0.0001; 3]; 3],
            made: scale().made,
        };
        let text = toml::to_string(&scatter).unwrap();
        let file = Utf8Path::new("s.toml");
        let read = Scatter::parse(file, &text).unwrap();
        assert_eq!(read, scatter);
        assert_eq!([450.0, 500.0, 599.0, 700.0].map(|nm| read.band(nm)), [0, 1, 1, 2]);
        for (from, to, expected) in [
            (
                "[500.0, 600.0]",
                "[500.0]",
                "s.toml:3:1: share_rel: needs 2 rows of 2 numbers",
            ),
            ("[500.0, 600.0]", "[600.0, 500.0]", "edges_nm: does not rise"),
            ("0.003", "0.9", "share_rel: is 0.9"),
        ] {
            assert!(text.contains(from), "{text}");
            let error = Scatter::parse(file, &text.replacen(from, to, 1)).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
