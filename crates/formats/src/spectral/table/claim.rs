//! Whether a table is a spectrum at all. A wrong yes gives a colour temperature to a price list.

use super::columns::Columns;
use super::rows::{Row, without_nm};
use crate::finding::Finding;
use crate::number;
use crate::spectral::axis::{AxisUnit, is_wavelength_heading};

/// Wavelengths without a unit are in this range of nm.
const RANGE_NM: (f64, f64) = (100.0, 20_000.0);
/// Fewest rows that show how the first column rises.
const FEWEST: usize = 3;
/// No step between wavelengths is longer than this part of the shorter of the two.
const LONGEST_STEP: f64 = 0.25;

/// Names that say nothing of what stands below them.
const SILENT: [&str; 8] = ["", "x", "x1", "col1", "column1", "column 1", "unnamed: 0", "v1"];

/// Words of a comment above the data that name an abscissa which is no wavelength.
const OTHER_ABSCISSAE: [&str; 24] = [
    "position",
    "time",
    "date",
    "temperature",
    "temp",
    "price",
    "depth",
    "distance",
    "index",
    "pixel",
    "angle",
    "theta",
    "gamma",
    "voltage",
    "current",
    "energy",
    "frequency",
    "pressure",
    "latitude",
    "longitude",
    "year",
    "length",
    "height",
    "radius",
];

/// Why the table is no spectrum; none where a heading, a unit or, without any name, the numbers alone say that it is
/// one.
pub(super) fn refusal(columns: &Columns, names: &[&str], above: Option<&Row<'_>>, body: &[Row<'_>]) -> Option<Finding> {
    let refused = |row: &Row<'_>, column: usize, message: String| {
        Some(
            Finding::error("table-no-spectrum", message)
                .at(row.line, column)
                .raw(row.text)
                .fix(
                    "if it is a spectrum, name its columns in a heading such as wavelength_nm,value, or say which \
                     they are with --columns 1,2",
                ),
        )
    };
    let heading = above.filter(|_| !names.is_empty());
    if let (Some(row), Some(name)) = (heading, names.get(columns.wavelength)) {
        if is_wavelength_heading(name) || AxisUnit::of(name).is_some() {
            return None;
        }
        if !SILENT.contains(&name.to_lowercase().as_str()) {
            let message = format!("the heading names “{name}”, which is no wavelength: this table is no spectrum");
            return refused(row, row.column(columns.wavelength), message);
        }
    } else if let Some(row) = above.filter(|row| row.comment)
        && let Some(word) = other_abscissa(row)
    {
        let message =
            format!("the line above the data names “{word}”, which is no wavelength: this table is no spectrum");
        return refused(row, 1, message);
    }
    if rises_like_wavelengths(columns.wavelength, body) {
        return None;
    }
    let row = &body[0];
    let message = "nothing says that these are wavelengths, and they are not like any: this table is no spectrum";
    refused(row, row.column(columns.wavelength), message.to_owned())
}

/// The first word of a comment that names another abscissa.
fn other_abscissa<'t>(row: &Row<'t>) -> Option<&'t str> {
    let first = row.text.trim_start_matches(|c: char| !c.is_alphanumeric());
    let word = first.split(|c: char| !c.is_alphanumeric()).next()?;
    OTHER_ABSCISSAE.contains(&word.to_lowercase().as_str()).then_some(word)
}

/// Numbers that keep one direction, in the range of light and in steps as spectra have them.
fn rises_like_wavelengths(column: usize, body: &[Row<'_>]) -> bool {
    let x: Vec<f64> = body
        .iter()
        .filter(|row| !row.comment)
        .filter_map(|row| number::read_up_to(without_nm(row.cells.get(column)?), f64::MAX).ok())
        .map(|number| number.value)
        .collect();
    let steps = || x.windows(2).map(|pair| (pair[1] - pair[0], pair[0].min(pair[1])));
    let rising = steps().filter(|(step, _)| *step > 0.0).count();
    let falling = steps().filter(|(step, _)| *step < 0.0).count();
    let one_way = rising.max(falling) * 20 >= 19 * x.len().saturating_sub(1);
    x.len() >= FEWEST
        && one_way
        && x.iter().filter(|x| (RANGE_NM.0..=RANGE_NM.1).contains(x)).count() * 20 >= 19 * x.len()
        && steps()
            .filter(|(step, shorter)| step.abs() > LONGEST_STEP * shorter)
            .count()
            * 20
            <= x.len()
}
