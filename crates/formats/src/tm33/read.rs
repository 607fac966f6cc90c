//! TM-33 documents to absolute candela.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::{Map, Value};

use super::table::{Table, is_point, table};
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::luminaire::Luminaire;
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::plausible::{self, Stored};
use crate::text::Text;
use crate::xml::{self, Element};

/// Planes that mirror each other scatter by this part of the peak at most.
const SAME: f64 = 0.05;

const ROOTS: [&str; 5] = [
    "LuminaireOpticalData",
    "ATLA_S001_A",
    "IESTM33-22",
    "IESTM33-18",
    "UNI11733",
];

/// Whether the text is a TM-33 document, by its root element.
pub fn looks_like(head: &Text<'_>) -> bool {
    let text = head.content();
    ROOTS.iter().any(|root| text.contains(&format!("<{root}")))
}

/// Reads bytes to absolute candela.
pub fn read(bytes: &[u8]) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let distribution = match xml::parse(text.content()) {
        Ok(root) => distribution(&root, &text, &mut findings),
        Err(error) => {
            findings.push(
                Finding::error("xml-malformed", error.reason)
                    .at(error.line, 1)
                    .fix("fetch the file again"),
            );
            None
        }
    };
    Parsed::new(Format::TM33, Kind::Distribution, distribution, findings)
}

fn distribution(root: &Element, text: &Text<'_>, findings: &mut Findings) -> Option<Distribution> {
    let emitters: Vec<&Element> = root.children.iter().filter(|child| child.name == "Emitter").collect();
    let mut tables = Vec::new();
    for emitter in &emitters {
        tables.extend(table(emitter, findings).ok()?);
    }
    let candela = added(&tables, root, findings)?;
    let first = tables.first()?;
    let (symmetry, rows) = circle(first, &candela, findings)?;
    let grid = match IntensityDistribution::expand(symmetry, &rows, first.vertical.clone()) {
        Ok(grid) => grid,
        Err(error) => {
            findings.push(
                Finding::error("tm33-angles", error.to_string())
                    .at(first.line, 1)
                    .fix("correct the angles"),
            );
            return None;
        }
    };
    symmetry_claimed(first, &grid, findings);
    for table in &tables {
        plausible::check(
            &Stored {
                planes_deg: &table.horizontal,
                angles_deg: &table.vertical,
                values: &table.values,
                places: &table.places,
                raw: &|index| table.raws.get(index).map_or("", String::as_str),
                poles: true,
            },
            findings,
        );
    }
    let lamp_flux_lm = sum(&emitters, &["RatedLumens"]);
    plausible::flux(&grid, lamp_flux_lm, None, None, findings);
    let mut header = match as_json(root) {
        Value::Object(map) => map,
        _ => Map::new(),
    };
    header.insert("root".into(), root.name.clone().into());
    header.insert("encoding".into(), text.encoding.into());
    Some(Distribution {
        intensity: grid,
        symmetry,
        // Without the flag (ATLA S001) the rated lumens are those of the lamps all the same.
        lamp_flux_lm: lamp_flux_lm.filter(|_| !first.absolute || !first.flagged),
        absolute: first.absolute,
        native: None,
        luminaire: luminaire(root, &emitters),
        header,
        eulumdat: None,
    })
}

/// The light of all emitters together, in cd.
fn added(tables: &[Table], root: &Element, findings: &mut Findings) -> Option<Vec<f64>> {
    let Some((first, others)) = tables.split_first() else {
        findings.push(
            Finding::error("tm33-no-intensity", "no emitter has luminous intensities")
                .at(root.line, 1)
                .fix("radiant, photon and spectral data alone cannot become candela"),
        );
        return None;
    };
    let mut candela = first.candela.clone();
    for other in others {
        if other.horizontal != first.horizontal || other.vertical != first.vertical {
            findings.push(
                Finding::error(
                    "tm33-emitters",
                    "the emitters are given on different angles and cannot be added",
                )
                .at(other.line, 1)
                .fix("give all emitters on the same angles"),
            );
            return None;
        }
        for (sum, value) in candela.iter_mut().zip(&other.candela) {
            *sum += value;
        }
    }
    if let Some(second) = others.first() {
        findings.push(
            Finding::note("tm33-emitters", format!("{} emitters are given", tables.len()))
                .at(second.line, 1)
                .assumed("their sum"),
        );
    }
    Some(candela)
}

/// The sum of a number over the emitters that state it, if it is above zero.
fn sum(emitters: &[&Element], names: &[&str]) -> Option<f64> {
    let stated = |emitter: &&Element| number::read(emitter.words(names)?).ok();
    let all: Vec<f64> = emitters.iter().filter_map(stated).map(|n| n.value).collect();
    Some(all.iter().sum()).filter(|&total: &f64| total > 0.0)
}

/// What the header and the first emitter say of it.
fn luminaire(root: &Element, emitters: &[&Element]) -> Luminaire {
    fn stated(element: Option<&Element>, names: &[&str]) -> String {
        element
            .and_then(|element| element.words(names))
            .unwrap_or_default()
            .to_owned()
    }
    // As the editions of 2018 and of 2023 have it.
    let first = |one: String, other: String| if one.is_empty() { other } else { one };
    let (header, emitter) = (root.child("Header"), emitters.first().copied());
    let rendering = emitter.and_then(|emitter| emitter.child("ColorRendering"));
    Luminaire {
        manufacturer: stated(header, &["Manufacturer"]),
        name: stated(header, &["Description"]),
        number: stated(header, &["CatalogNumber"]),
        report: stated(header, &["ReportNumber"]),
        date: stated(header, &["ReportDate", "TestDate", "IssueDate"]),
        laboratory: stated(header, &["Laboratory"]),
        lamp: stated(emitter, &["Description"]),
        lamp_count: number::read(&stated(emitter, &["Quantity"])).ok().map(|n| n.value),
        colour: first(
            stated(emitter, &["CCT"]),
            stated(
                emitter.and_then(|emitter| emitter.child("ColorTemperature")),
                &["FixedCCT"],
            ),
        ),
        rendering: first(
            stated(rendering, &["Ra"]),
            stated(rendering.and_then(|rendering| rendering.child("CIE_CRI")), &["Ra"]),
        ),
        watts: sum(emitters, &["InputWattage", "InputWatts"]),
        ..sizes(root)
    }
}

/// Housing and luminous opening in mm. As in LM-63 length lies along C0–C180 and width along C90–C270.
fn sizes(root: &Element) -> Luminaire {
    let mut luminaire = Luminaire::default();
    let Some(element) = root.child("Luminaire") else {
        return luminaire;
    };
    let read = |of: Option<&Element>, name: &str| -> Option<f64> {
        number::read(of?.words(&[name])?).ok().map(|number| number.value)
    };
    let housing = element.child("Dimensions");
    let (along_c0, along_c90) = (read(housing, "Length"), read(housing, "Width"));
    (luminaire.length_mm, luminaire.width_mm) = match along_c90 {
        Some(0.0) => (along_c0, along_c90),
        _ => (along_c90, along_c0),
    };
    luminaire.height_mm = read(housing, "Height");
    let opening = element.child("LuminousOpening");
    let elliptical = opening
        .and_then(|opening| opening.words(&["Shape"]))
        .is_some_and(|shape| shape.eq_ignore_ascii_case("elliptical"));
    if let Some(diameter) = read(opening, "Diameter") {
        (luminaire.luminous_length_mm, luminaire.luminous_width_mm) = (Some(diameter), Some(0.0));
    } else if let (Some(length), Some(width)) = (read(opening, "Length"), read(opening, "Width")) {
        let sign = if elliptical { -1.0 } else { 1.0 };
        luminaire.set_luminous_body([sign * length, sign * width, 0.0]);
    }
    luminaire
}

type Rows = Vec<(f64, Vec<f64>)>;

/// What `SymmType` says (`Symm_Full`, `_Quad`, `_Bi0`, `_Bi90`), against the light on the whole circle.
fn symmetry_claimed(table: &Table, grid: &IntensityDistribution, findings: &mut Findings) {
    let Some((claim, line)) = &table.symmetry else { return };
    let letters: String = claim.chars().filter(char::is_ascii_alphanumeric).collect();
    let claimed = match letters.to_ascii_lowercase().trim_start_matches("symm") {
        "full" => Symmetry::Rotational,
        "quad" => Symmetry::Quadrant,
        "bi0" => Symmetry::C0C180,
        "bi90" => Symmetry::C90C270,
        _ => return,
    };
    let found = grid.detect_symmetry(SAME * grid.peak().intensity_cd);
    let there = found == claimed
        || found == Symmetry::Rotational
        || (found == Symmetry::Quadrant && claimed != Symmetry::Rotational);
    if !there {
        let message = format!("{claim} is claimed, but the intensities do not have this symmetry");
        findings.push(
            Finding::warning("tm33-symmetry", message)
                .at(*line, 1)
                .raw(claim)
                .assumed("the points as they stand")
                .fix("correct the symmetry, or look for damage in the intensities"),
        );
    }
}

/// Symmetry class by the range of horizontal angles, as in LM-63.
fn circle(table: &Table, candela: &[f64], findings: &mut Findings) -> Option<(Symmetry, Rows)> {
    let angles = &table.horizontal;
    let mut rows: Rows = angles
        .iter()
        .copied()
        .zip(candela.chunks(table.vertical.len()).map(<[f64]>::to_vec))
        .collect();
    let (first, last) = (*angles.first()?, *angles.last()?);
    if first < 0.0 || last > 360.0 {
        let message = format!("horizontal angles from {first}° to {last}°");
        findings.push(
            Finding::error("tm33-angles", message)
                .at(table.line, 1)
                .fix("horizontal angles lie within 0° to 360°"),
        );
        return None;
    }
    if angles.len() == 1 {
        return Some((Symmetry::Rotational, rows));
    }
    let symmetry = match (first, last) {
        (0.0, 90.0) => Symmetry::Quadrant,
        (0.0, 180.0) => Symmetry::C0C180,
        (90.0, 270.0) => Symmetry::C90C270,
        _ => Symmetry::None,
    };
    if last == 360.0 && first == 0.0 {
        let closing = rows.pop()?;
        if rows.first().is_some_and(|opening| opening.1 != closing.1) {
            findings.push(
                Finding::warning(
                    "tm33-closing-plane",
                    "the planes at 0° and 360° are one plane, yet they differ",
                )
                .at(table.line, 1)
                .assumed("the plane at 0°"),
            );
        }
    }
    Some((symmetry, rows))
}

/// Every field but the points.
fn as_json(element: &Element) -> Value {
    let mut map = Map::new();
    for (name, value) in &element.attributes {
        map.insert(format!("@{name}"), value.clone().into());
    }
    for child in element
        .children
        .iter()
        .filter(|child| !is_point(child) && child.name != "SpectralData")
    {
        let value = as_json(child);
        match map.get_mut(&child.name) {
            Some(Value::Array(list)) => list.push(value),
            Some(other) => {
                let before = other.take();
                *other = Value::Array(vec![before, value]);
            }
            None => {
                map.insert(child.name.clone(), value);
            }
        }
    }
    if map.is_empty() {
        return if element.text.is_empty() {
            Value::Null
        } else {
            element.text.clone().into()
        };
    }
    if !element.text.is_empty() {
        map.insert("#text".into(), element.text.clone().into());
    }
    Value::Object(map)
}
