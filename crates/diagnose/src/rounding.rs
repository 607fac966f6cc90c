//! Readings of a meter with few digits: what was rounded away is no noise.
//!
//! Two readings at nearly the same light are rounded by the same amount, however often they are repeated, and where the
//! light changes by less than a digit the reading does not follow it. The stated uncertainty holds that share (a
//! rectangle of one digit), but averaging does not make it smaller.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};

use crate::calibration::{ALIKE, NEGLIGIBLE_ROUNDING, OWN, QUIET};
use crate::table::Row;
use crate::whitening::without;

/// Whether a row scatters by so much less than its digit that the display does not show it: what such rows differ by is
/// their rounding, which their neighbours in time at the same light have too, however independent the meter's noise is.
pub fn hides_noise(row: &Row) -> bool {
    let rounding = row.digit / 12_f64.sqrt();
    (row.u * row.u - rounding * rounding).max(0.0).sqrt() < QUIET * row.digit
}

/// Rows that are rounded alike.
#[derive(Debug, Clone, Default)]
pub struct Rounding {
    /// Rows of each group, with the standard deviation of their common error in the unit of the rows.
    groups: Vec<Vec<(usize, f64)>>,
    /// Rows of each digit, with the level's place from its middle in the unit of the rows: what a reading that stays
    /// put is off.
    digits: Vec<Vec<(usize, f64)>>,
}

impl Rounding {
    /// Groups the rows by meter range, expected `level` and, where they scatter by less than the display, by what they
    /// show; rows without a digit stay on their own.
    pub fn new(rows: &[Row], level: &[f64]) -> Self {
        let mut groups: HashMap<_, Vec<(usize, f64)>> = HashMap::new();
        let mut digits: HashMap<_, Vec<(usize, f64)>> = HashMap::new();
        for (i, (row, level)) in rows.iter().zip(level).enumerate() {
            let common = row.digit / 12_f64.sqrt();
            if common > NEGLIGIBLE_ROUNDING * row.u {
                let place = level / row.digit;
                let whose = (row.file, row.range.to_bits(), row.digit.to_bits());
                let cell = ((place + 0.5) / ALIKE).floor() as i64;
                let shown = hides_noise(row).then(|| (row.measured / row.digit).round() as i64);
                groups.entry((whose, cell, shown)).or_default().push((i, common));
                let off = (place - (place + 0.5).floor()) * row.digit;
                let digit = (place + 0.5).floor() as i64;
                digits.entry((whose, digit, shown)).or_default().push((i, off));
            }
        }
        let sorted = |groups: Vec<Vec<(usize, f64)>>| {
            let mut groups: Vec<_> = groups.into_iter().filter(|group| group.len() > 1).collect();
            groups.sort_by_key(|group| group[0].0);
            groups
        };
        Self {
            groups: sorted(groups.into_values().collect()),
            digits: sorted(digits.into_values().collect()),
        }
    }

    /// Makes rows that were scaled to unit variance by `row_scale` independent of each other, column by column.
    ///
    /// A group's covariance is diag(s²) + c·cᵀ, a digit's that of its groups + w·wᵀ with w the places of its
    /// levels; W = I − (1 − 1/√(1+|v|²))·v·vᵀ/|v|² with v = c/s whitens what 1/s has scaled, and the same
    /// for w after it.
    pub fn whiten(&self, row_scale: &DVector<f64>, matrix: &mut DMatrix<f64>) {
        if self.groups.is_empty() && self.digits.is_empty() {
            return;
        }
        self.whiten_groups(row_scale, matrix);
        let mut places = DMatrix::zeros(row_scale.len(), 1);
        for &(i, off) in self.digits.iter().flatten() {
            places[(i, 0)] = off * row_scale[i];
        }
        self.whiten_groups(row_scale, &mut places);
        for digit in &self.digits {
            let along: Vec<(usize, f64)> = digit.iter().map(|&(i, _)| (i, places[(i, 0)])).collect();
            for mut column in matrix.column_iter_mut() {
                without(&along, column.as_mut_slice());
            }
        }
    }

    fn whiten_groups(&self, row_scale: &DVector<f64>, matrix: &mut DMatrix<f64>) {
        for group in &self.groups {
            let mut along = Vec::with_capacity(group.len());
            for &(i, common) in group {
                let common = common * row_scale[i];
                let own = (1.0 - common * common).max(OWN).sqrt();
                along.push((i, common / own));
                matrix.row_mut(i).scale_mut(1.0 / own);
            }
            for mut column in matrix.column_iter_mut() {
                without(&along, column.as_mut_slice());
            }
        }
    }

    /// The least that noise can be, as a share of the stated uncertainties: readings that all came out the same are no
    /// better than their digit.
    pub fn least_scale(rows: &[Row]) -> f64 {
        let squares = rows
            .iter()
            .map(|row| (row.digit * row.digit / 12.0 / (row.u * row.u)).min(1.0));
        (squares.sum::<f64>() / rows.len().max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::ObservationKind;

    #[test]
    fn whitening_is_the_inverse_root_of_the_covariance() {
        let u = [0.4, 0.35, 0.5];
        let rows: Vec<Row> = u
            .iter()
            .map(|&u| Row {
                digit: 1.0,
                range: 1.0,
                ..Row::bare(ObservationKind::Reading, 0.0, u)
            })
            .collect();
        let level = [5.0, 5.05, 5.1];
        let rounding = Rounding::new(&rows, &level);
        let common = 1.0 / 12_f64.sqrt();
        let covariance = DMatrix::from_fn(3, 3, |i, k| {
            let alone = if i == k { u[i] * u[i] } else { common * common };
            alone + (level[i] - 5.0) * (level[k] - 5.0)
        });
        let row_scale = DVector::from_iterator(3, u.iter().map(|u| 1.0 / u));
        let mut whitener = DMatrix::from_diagonal(&row_scale);
        rounding.whiten(&row_scale, &mut whitener);
        let unit = &whitener * covariance * whitener.transpose();
        assert!((unit - DMatrix::identity(3, 3)).amax() < 1e-12);
    }

    #[test]
    fn a_hundred_equal_readings_know_their_level_to_a_digit() {
        let rows = vec![
            Row {
                digit: 0.01,
                range: 1.0,
                ..Row::bare(ObservationKind::Reading, 3.4, 0.0038)
            };
            100
        ];
        let rounding = Rounding::new(&rows, &[3.4; 100]);
        let row_scale = DVector::from_element(100, 1.0 / 0.0038);
        let mut column = DMatrix::from_element(100, 1, 1.0 / 0.0038);
        rounding.whiten(&row_scale, &mut column);
        let u_level = 1.0 / column.norm();
        assert!((0.0028..0.0032).contains(&u_level), "{u_level}");
    }

    #[test]
    fn a_level_at_the_end_of_a_digit_is_shown_as_either_and_no_contradiction() {
        let shown = |i: usize| 0.01 + 0.01 * (i % 2) as f64;
        let rows: Vec<Row> = (0..100)
            .map(|i| Row {
                digit: 0.01,
                range: 1.0,
                ..Row::bare(ObservationKind::Reading, shown(i), 0.003)
            })
            .collect();
        let rounding = Rounding::new(&rows, &[0.0152; 100]);
        let row_scale = DVector::from_element(100, 1.0 / 0.003);
        let mut off = DMatrix::from_fn(100, 1, |i, _| (shown(i) - 0.0152) * row_scale[i]);
        rounding.whiten(&row_scale, &mut off);
        assert!(off.norm_squared() < 10.0, "{} σ²", off.norm_squared());
    }

    #[test]
    fn a_plateau_of_one_digit_says_nothing_of_what_lies_under_it() {
        let level: Vec<f64> = (0..500).map(|i| 0.0105 + 3e-6 * f64::from(i)).collect();
        let row = Row {
            digit: 0.01,
            range: 1.0,
            ..Row::bare(ObservationKind::Reading, 0.01, 0.0038)
        };
        let rounding = Rounding::new(&vec![row; 500], &level);
        let row_scale = DVector::from_element(500, 1.0 / 0.0038);
        let mut off = DMatrix::from_fn(500, 1, |i, _| (0.01 - level[i]) * row_scale[i]);
        rounding.whiten(&row_scale, &mut off);
        assert!(off.norm() < 1.2, "{} σ", off.norm());
    }
}
