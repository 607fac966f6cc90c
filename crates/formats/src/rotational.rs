//! `gamma_deg,intensity_cd`: a rotational distribution in candela, as CSV.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::{Map, Value};

use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::luminaire::Luminaire;
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::plausible::{self, Stored};
use crate::text::Text;
use crate::unfinished::unfinished_line;

/// Whether this is the rotational distribution that a model may name: `gamma_deg,intensity_cd`.
pub fn looks_like(head: &Text<'_>) -> bool {
    let names: Vec<&str> = head.line(0).split(',').map(str::trim).collect();
    names == ["gamma_deg", "intensity_cd"]
}

/// Reads `gamma_deg,intensity_cd`, a rotational distribution in candela.
pub fn read(bytes: &[u8]) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    unfinished_line(&text, &mut findings);
    let (mut gamma_deg, mut intensity_cd) = (Vec::new(), Vec::new());
    let (mut raws, mut places) = (Vec::new(), Vec::new());
    let mut whole = true;
    for (index, line) in text.lines().enumerate().skip(1) {
        if line.trim().is_empty() {
            continue;
        }
        let cells: Vec<&str> = line.split(',').collect();
        if cells.len() != 2 {
            whole = false;
            let message = format!("{} cells stand where γ and intensity are needed", cells.len());
            findings.push(
                Finding::error("csv-cells", message)
                    .at(index + 1, 1)
                    .raw(line)
                    .fix("write gamma_deg,intensity_cd"),
            );
            continue;
        }
        let mut column = 1;
        for (cell, into) in cells.iter().zip([&mut gamma_deg, &mut intensity_cd]) {
            match number::read(cell) {
                Ok(read) => {
                    into.push(read.value);
                }
                Err(error) => {
                    whole = false;
                    findings.push(
                        Finding::error("csv-number", error.to_string())
                            .at(index + 1, column)
                            .raw(cell),
                    );
                }
            }
            column += cell.chars().count() + 1;
        }
        raws.push(cells[1]);
        places.push((index + 1, cells[0].chars().count() + 2));
    }
    let mut document = None;
    if whole {
        if gamma_deg.windows(2).all(|pair| pair[0] < pair[1]) {
            let stored = Stored {
                planes_deg: &[0.0],
                angles_deg: &gamma_deg,
                values: &intensity_cd,
                places: &places,
                raw: &|index| raws[index],
                poles: true,
            };
            plausible::check(&stored, &mut findings);
        }
        match IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd) {
            Ok(intensity) => {
                let header = Map::from_iter([("encoding".to_owned(), Value::from(text.encoding))]);
                document = Some(Distribution {
                    intensity,
                    symmetry: Symmetry::Rotational,
                    lamp_flux_lm: None,
                    absolute: true,
                    native: None,
                    luminaire: Luminaire::default(),
                    header,
                    eulumdat: None,
                });
            }
            Err(error) => findings.push(Finding::error("distribution-invalid", error.to_string())),
        }
    }
    Parsed::new(Format::CSV, Kind::Distribution, document, findings)
}
