//! CGATS data whose wavelengths stand beside their values.

use super::tokens::Token;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::spectral::point::Point;
use crate::spectral::points::Draft;

/// Fields `SPECTRAL_NM` and, behind each, `SPECTRAL_VAL`, `SPECTRAL_DEC` or `SPECTRAL_PCT`: the wavelengths stand in
/// the data.
pub(super) struct Pairs {
    width: usize,
    /// Columns of wavelength and value.
    columns: Vec<(usize, usize)>,
}

impl Pairs {
    pub fn of(fields: &[Token<'_>]) -> Option<Self> {
        let is = |at: usize, names: &[&str]| {
            let name = fields
                .get(at)
                .map(|field| field.text.trim_matches('"').to_ascii_uppercase());
            name.is_some_and(|name| names.contains(&name.as_str()))
        };
        let value = ["SPECTRAL_VAL", "SPECTRAL_DEC", "SPECTRAL_PCT"];
        let columns: Vec<(usize, usize)> = (0..fields.len())
            .filter(|&at| is(at, &["SPECTRAL_NM"]) && is(at + 1, &value))
            .map(|at| (at, at + 1))
            .collect();
        let width = fields.len();
        (!columns.is_empty()).then_some(Self { width, columns })
    }

    /// One pair of fields: every row is a point. Several: every row is a spectrum over the same wavelengths.
    pub fn draft(&self, data: &[Token<'_>], encoding: &str, whole: bool, findings: &mut Findings) -> Draft {
        let mut draft = Draft::new(encoding);
        draft.axis = Some(crate::spectral::axis::AxisUnit::Nanometre);
        draft.whole = whole && data.len().is_multiple_of(self.width);
        if !data.len().is_multiple_of(self.width) {
            let message = format!("{} values are no multiple of {} fields", data.len(), self.width);
            let line = data.last().map_or(1, |token| token.line);
            findings.push(
                Finding::error("sp-data", message)
                    .at(line, 1)
                    .fix("check for a lost or doubled number"),
            );
        }
        let mut read =
            |token: &Token<'_>, whole: &mut bool| match number::read_up_to(token.text, number::LARGEST_SPECTRAL) {
                Ok(number) => Some(number.value),
                Err(error) => {
                    *whole = false;
                    let finding = Finding::error("sp-number", error.to_string());
                    findings.push(finding.at(token.line, token.column).raw(token.text));
                    None
                }
            };
        let mut differs = None;
        for (index, row) in data.chunks_exact(self.width).enumerate() {
            for (k, &(nm, value)) in self.columns.iter().enumerate() {
                let x = read(&row[nm], &mut draft.whole).unwrap_or(0.0);
                let y = read(&row[value], &mut draft.whole);
                if self.columns.len() == 1 || index == 0 {
                    draft.points.push(Point {
                        line: row[nm].line,
                        column: row[nm].column,
                        x,
                        value: vec![y],
                    });
                } else if draft.points[k].x == x {
                    draft.points[k].value.push(y);
                } else {
                    differs.get_or_insert(row[nm]);
                }
            }
        }
        if let Some(token) = differs {
            draft.whole = false;
            let finding = Finding::error("sp-grid", "this set has other wavelengths than the first");
            findings.push(
                finding
                    .at(token.line, token.column)
                    .raw(token.text)
                    .fix("put it into a file of its own"),
            );
        }
        draft
    }
}
