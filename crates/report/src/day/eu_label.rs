//! Energy label and product information of the light source (Regulation (EU) 2019/2015).

use isolux_reduce::eu_label::{FILE, Known, NOT_STATED, Row, label};
use isolux_reduce::{Quantity, ReduceError};

use super::results::DayResults;
use crate::document::Section;

/// None where the job has no table `[eu_label]`.
///
/// # Errors
/// [`ReduceError`] never for a distribution that is one already.
pub fn section(day_results: &DayResults) -> Result<Option<Section>, ReduceError> {
    let Some(label) = label(&day_results.reduction, &day_results.run)? else {
        return Ok(None);
    };
    let mut section = Section::new("EU energy label and product information");
    section.paragraph(label.sentence());
    let (known, not_known): (Vec<&Row>, Vec<&Row>) = label
        .rows
        .iter()
        .partition(|row| !matches!(row.known, Known::NotKnown(_)));
    let rows = known.into_iter().map(|row| {
        let (value, source) = match &row.known {
            Known::Measured { value, unit, quantity } => {
                let stated = quantity.as_ref().map_or_else(|| "–".to_owned(), Quantity::brief);
                let space = if matches!(*unit, "" | "°") { "" } else { " " };
                (format!("{value}{space}{unit}"), stated)
            }
            Known::Stated(text) => (text.clone(), "stated".to_owned()),
            Known::NotKnown(_) => Default::default(),
        };
        vec![row.what.to_owned(), value, source]
    });
    let rows = rows.collect();
    section.table(&["parameter (Annex V, Table 3)", "value", "measured, or stated"], rows);
    let (not_stated, others): (Vec<&Row>, Vec<&Row>) = not_known
        .into_iter()
        .partition(|row| matches!(&row.known, Known::NotKnown(why) if why == NOT_STATED));
    if !others.is_empty() {
        section.subheading("Not known");
        let rows = others.into_iter().map(|row| {
            let why = match &row.known {
                Known::NotKnown(why) => why.clone(),
                _ => String::new(),
            };
            vec![row.what.to_owned(), why]
        });
        let rows = rows.collect();
        section.table(&["parameter", "why"], rows);
    }
    if !not_stated.is_empty() {
        let names: Vec<&str> = not_stated.iter().map(|row| row.what).collect();
        section.paragraph(format!("Not stated: {}.", names.join(", ")));
    }
    section.paragraph(format!(
        "By Annexes I, II and V of Regulation (EU) 2019/2015, for the lamp as it was measured: reference control settings, full load and a \
         light source without its luminaire are for the supplier to see to. The same table is in {FILE}."
    ));
    Ok(Some(section))
}
