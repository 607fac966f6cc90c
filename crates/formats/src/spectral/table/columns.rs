//! Which column holds the wavelengths, which the values, and what a heading says of them.

use super::rows::{Row, without_nm};
use crate::finding::{Finding, Findings};
use crate::number::{self, LARGEST_SPECTRAL as LARGEST};
use crate::spectral::axis::{AxisUnit, is_wavelength_heading};
use crate::spectral::quantity::{is_radiometric, quantity_of};

/// Which columns are what.
pub(super) struct Columns {
    pub(super) wavelength: usize,
    pub(super) values: Vec<usize>,
    /// Where bins end, which begin at the wavelength.
    pub(super) upper: Option<usize>,
    /// The first of the values was chosen for what it is.
    pub(super) chosen: bool,
}

impl Columns {
    /// The two columns that a person names, counted from 1.
    pub(super) fn requested([wavelength, value]: [usize; 2], width: usize) -> Result<Self, Finding> {
        let inside = |column: usize| (1..=width).contains(&column);
        if inside(wavelength) && inside(value) && wavelength != value {
            return Ok(Self {
                wavelength: wavelength - 1,
                values: vec![value - 1],
                upper: None,
                chosen: true,
            });
        }
        let message = format!("columns {wavelength} and {value} were asked for, the table has {width}");
        Err(Finding::error("csv-columns", message).fix("give the columns of wavelengths and values, such as 1,2"))
    }

    pub(super) fn of(names: &[&str], body: &[Row<'_>], width: usize, findings: &mut Findings) -> Self {
        let numbers = |k: usize| {
            let good = body.iter().filter(|r| r.cells.len() == width && r.is_number(k)).count();
            2 * good > body.len()
        };
        let named = names.iter().position(|n| is_wavelength_heading(n)).or_else(|| {
            names
                .iter()
                .position(|n| AxisUnit::of(n).is_some() && !is_quantity(n) && !per_something(n))
        });
        // Without a heading: the first column that keeps one direction and never is 0 (0, 1, 2 … counts lines).
        let ordered = |k: usize| {
            let x: Vec<f64> = body
                .iter()
                .filter(|r| r.cells.len() == width)
                .filter_map(|r| number::read_up_to(without_nm(r.cells[k]), LARGEST).ok())
                .map(|n| n.value)
                .collect();
            let rising = x.windows(2).filter(|p| p[1] > p[0]).count();
            let falling = x.windows(2).filter(|p| p[1] < p[0]).count();
            let counts = x.len() > 2 && (x[0] == 0.0 || x[0] == 1.0) && x.windows(2).all(|p| p[1] - p[0] == 1.0);
            !counts
                && x.first().is_some_and(|x| *x > 0.0)
                && rising.max(falling) * 20 >= 19 * x.len().saturating_sub(1).max(1)
        };
        let wavelength = named
            .or_else(|| (0..width).find(|&k| numbers(k) && ordered(k)))
            .unwrap_or(0);
        if names.is_empty() && width > 2 {
            findings.push(
                Finding::note(
                    "csv-no-heading",
                    format!("{width} columns stand here without a heading"),
                )
                .at(body[0].line, 1)
                .raw(body[0].text)
                .assumed(format!(
                    "column {} holds the wavelengths, the others are series",
                    wavelength + 1
                )),
            );
        }
        let mut values = Vec::new();
        for k in (0..width).filter(|&k| k != wavelength) {
            let name = names.get(k).copied().unwrap_or("");
            let counter = k < wavelength
                && (name.is_empty()
                    || ["index", "pixel", "no", "nr", "#", "id"].contains(&name.to_lowercase().as_str()));
            if counter && wavelength > 0 {
                continue;
            }
            if numbers(k) || (width == 2) {
                values.push(k);
            } else {
                findings.push(
                    Finding::note(
                        "csv-column-text",
                        format!("column {} holds no numbers and is not read", k + 1),
                    )
                    .at(body[0].line, body[0].column(k))
                    .raw(name),
                );
            }
        }
        let preferred = preferred(names, &values, body);
        let chosen = preferred.is_some();
        if let Some((k, finding)) = preferred {
            findings.push(finding.at(body[0].line, body[0].column(k)).raw(names[k]));
            values.retain(|other| *other != k);
            values.insert(0, k);
        }
        Self {
            wavelength,
            values,
            upper: None,
            chosen,
        }
    }
}

/// The column to read first where that is not the first: the spectrum itself beside what it was computed from.
fn preferred(names: &[&str], values: &[usize], body: &[Row<'_>]) -> Option<(usize, Finding)> {
    let named = |wanted: &str| values.iter().copied().find(|&k| names.get(k) == Some(&wanted));
    // Ocean Optics' Jaz: W wavelength, D dark, R reference (where there is one), S sample, P processed.
    if let (Some(_), Some(sample)) = (named("D"), named("S")) {
        let illuminated = |k: usize| {
            body.iter()
                .filter_map(|row| number::read_up_to(row.cells.get(k)?, LARGEST).ok())
                .any(|n| n.value != 0.0)
        };
        return Some(match named("P").filter(|&k| illuminated(k)) {
            Some(processed) => (
                processed,
                Finding::note(CHOSEN, "the columns are D dark, S sample and P processed")
                    .assumed("P, the processed spectrum"),
            ),
            None => (
                sample,
                Finding::warning(CHOSEN, "the columns are D dark and S sample, and nothing is processed")
                    .assumed("S, from which neither the dark is taken nor a calibration made")
                    .fix("save the processed spectrum, or subtract the dark"),
            ),
        });
    }
    let raw = |k: usize| names.get(k).is_some_and(|name| is_raw(name));
    let measured = |k: usize| names.get(k).is_some_and(|name| is_radiometric(name) && !is_raw(name));
    let first = *values.first()?;
    let better = values.iter().copied().find(|&k| measured(k)).filter(|_| raw(first))?;
    let message = format!("“{}” is what “{}” was computed from", names[first], names[better]);
    Some((
        better,
        Finding::note(CHOSEN, message).assumed("the column with a radiometric quantity"),
    ))
}

/// Code of the finding that says which of several columns is the spectrum.
const CHOSEN: &str = "csv-column-chosen";

/// What a detector gives before dark and calibration.
pub(super) fn is_raw(name: &str) -> bool {
    let lower = name.to_lowercase();
    ["count", "dark", "background", "adc", "raw", "reference"]
        .iter()
        .any(|word| lower.contains(word))
}

/// Whether all wavelengths are too small for nm.
pub(super) fn small(body: &[Row<'_>], wavelength: usize) -> bool {
    body.iter()
        .filter_map(|row| number::read(without_nm(row.cells.get(wavelength)?)).ok())
        .all(|n| n.value < 30.0)
}

/// `W/(m²·nm)` is no wavelength; `1/cm` and `m/z` stand on the abscissa.
fn per_something(name: &str) -> bool {
    name.contains('/') && !name.contains("1/cm") && !name.contains("m/z")
}

fn is_quantity(name: &str) -> bool {
    quantity_of(name).0.is_some()
}
