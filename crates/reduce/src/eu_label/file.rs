//! `eu_label.csv`: the product information as a table for a product database.

use isolux_record::Run;
use isolux_units::digits::value_at;

use super::{Known, Row, label};
use crate::Reduction;
use crate::error::ReduceError;

/// Name of the file among the results.
pub const FILE: &str = "eu_label.csv";

/// Its text; none where the job has no table `[eu_label]`.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub(crate) fn file(reduction: &Reduction, run: &Run) -> Result<Option<String>, ReduceError> {
    let Some(label) = label(reduction, run)? else {
        return Ok(None);
    };
    let lines = label.rows.iter().map(line);
    let head = "parameter,value,unit,measured,expanded_uncertainty,unit_measured,source\n".to_owned();
    Ok(Some(std::iter::once(head).chain(lines).collect()))
}

fn line(row: &Row) -> String {
    let (value, unit, source) = match &row.known {
        Known::Measured { value, unit, .. } => (value.as_str(), *unit, "measured".to_owned()),
        Known::Stated(text) => (text.as_str(), "", "stated".to_owned()),
        Known::NotKnown(why) => ("", "", format!("not known: {why}")),
    };
    let (measured, expanded, of) = match &row.known {
        Known::Measured {
            quantity: Some(quantity),
            ..
        } => {
            let places = |number: f64| value_at(number, 0.1 * quantity.u_of_parts, -9);
            let expanded = row
                .expanded()
                .map_or_else(String::new, |(expanded, _)| places(expanded));
            (places(quantity.value), expanded, quantity.unit.to_string())
        }
        _ => Default::default(),
    };
    let cells = [row.name, value, unit, &measured, &expanded, &of, &source].map(quoted);
    cells.join(",") + "\n"
}

/// A cell as RFC 4180 has it.
pub fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
