//! TM-33 documents to absolute candela.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::{Map, Value};

use crate::distribution::{Distribution, Luminaire};
use crate::finding::{Finding, Findings};
use crate::number;
use crate::plausible::{self, Stored};
use crate::read::{Format, Kind, Parsed};
use crate::text::Text;
use crate::xml::{self, Element};

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
    Parsed::new(Format::Tm33, Kind::Distribution, distribution, findings)
}

fn distribution(root: &Element, text: &Text<'_>, findings: &mut Findings) -> Option<Distribution> {
    let mut tables = Vec::new();
    for emitter in root.children.iter().filter(|child| child.name == "Emitter") {
        tables.extend(table(emitter, findings).ok()?);
    }
    let Some(first) = tables.first() else {
        findings.push(
            Finding::error("tm33-no-intensity", "no emitter has luminous intensities")
                .at(root.line, 1)
                .fix("radiant, photon and spectral data alone cannot become candela"),
        );
        return None;
    };
    let mut candela = first.candela.clone();
    for other in &tables[1..] {
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
    if tables.len() > 1 {
        findings.push(
            Finding::note("tm33-emitters", format!("{} emitters are given", tables.len()))
                .at(tables[1].line, 1)
                .assumed("their sum"),
        );
    }
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
    plausible::check(
        &Stored {
            planes_deg: &first.horizontal,
            angles_deg: &first.vertical,
            values: &first.values,
            places: &first.places,
            raw: &|index| first.raws.get(index).map_or("", String::as_str),
            poles: true,
            ends_with_newline: true,
        },
        findings,
    );
    let emitters = || root.children.iter().filter(|child| child.name == "Emitter");
    let sum = |names: &[&str]| -> Option<f64> {
        let all: Vec<f64> = emitters()
            .filter_map(|emitter| number::read(emitter.words(names)?).ok())
            .map(|n| n.value)
            .collect();
        (!all.is_empty()).then(|| all.iter().sum()).filter(|&total| total > 0.0)
    };
    let lamp_flux_lm = sum(&["RatedLumens"]);
    let absolute = first.absolute;
    let watts = sum(&["InputWattage", "InputWatts"]);
    let header_of = |name: &[&str]| {
        root.child("Header")
            .and_then(|header| header.words(name))
            .unwrap_or_default()
            .to_owned()
    };
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
        lamp_flux_lm: lamp_flux_lm.filter(|_| !absolute || !first.flagged),
        absolute,
        native: None,
        luminaire: Luminaire {
            manufacturer: header_of(&["Manufacturer"]),
            name: header_of(&["Description"]),
            number: header_of(&["CatalogNumber"]),
            report: header_of(&["ReportNumber"]),
            date: header_of(&["ReportDate", "TestDate", "IssueDate"]),
            laboratory: header_of(&["Laboratory"]),
            lamp: emitters()
                .next()
                .and_then(|emitter| emitter.words(&["Description"]))
                .unwrap_or_default()
                .to_owned(),
            lamp_count: emitters()
                .next()
                .and_then(|e| number::read(e.words(&["Quantity"])?).ok())
                .map(|n| n.value),
            colour: emitters()
                .next()
                .and_then(|emitter| emitter.words(&["CCT"]))
                .unwrap_or_default()
                .to_owned(),
            rendering: emitters()
                .next()
                .and_then(|emitter| emitter.child("ColorRendering")?.words(&["Ra"]))
                .unwrap_or_default()
                .to_owned(),
            watts,
            ..sizes(root)
        },
        header,
        eulumdat: None,
    })
}

/// Housing and luminous opening in mm.
fn sizes(root: &Element) -> Luminaire {
    let mut luminaire = Luminaire::default();
    let Some(element) = root.child("Luminaire") else {
        return luminaire;
    };
    let read = |of: Option<&Element>, name: &str| -> Option<f64> {
        number::read(of?.words(&[name])?).ok().map(|number| number.value)
    };
    let housing = element.child("Dimensions");
    luminaire.length_mm = read(housing, "Length");
    luminaire.width_mm = read(housing, "Width");
    luminaire.height_mm = read(housing, "Height");
    let opening = element.child("LuminousOpening");
    if let Some(diameter) = read(opening, "Diameter") {
        (luminaire.luminous_length_mm, luminaire.luminous_width_mm) = (Some(diameter), Some(0.0));
    } else {
        luminaire.luminous_length_mm = read(opening, "Length");
        luminaire.luminous_width_mm = read(opening, "Width");
        luminaire.elliptic = opening
            .and_then(|opening| opening.words(&["Shape"]))
            .is_some_and(|shape| shape.eq_ignore_ascii_case("elliptical"));
    }
    luminaire
}

/// Intensities of one emitter on their grid.
struct Table {
    horizontal: Vec<f64>,
    vertical: Vec<f64>,
    /// As written.
    values: Vec<f64>,
    raws: Vec<String>,
    candela: Vec<f64>,
    places: Vec<(usize, usize)>,
    absolute: bool,
    /// The file says whether it is.
    flagged: bool,
    line: usize,
}

/// The element that holds the points, wherever the edition puts it.
fn holder(element: &Element) -> Option<&Element> {
    if element.children.iter().any(is_point) {
        return Some(element);
    }
    element
        .children
        .iter()
        .filter(|child| child.name != "CustomData")
        .find_map(holder)
}

fn is_point(element: &Element) -> bool {
    matches!(element.name.as_str(), "IntensityData" | "IntData")
}

/// A damaged table; its findings say how.
struct Damaged;

/// The table of an emitter, if it has one.
fn table(emitter: &Element, findings: &mut Findings) -> Result<Option<Table>, Damaged> {
    let Some(holder) = holder(emitter) else {
        return Ok(None);
    };
    if let Some(metric) = holder.words(&["Metric"])
        && !metric.trim().eq_ignore_ascii_case("luminous")
    {
        let message = format!("intensities of metric {metric} are not luminous");
        findings.push(
            Finding::note("tm33-metric", message)
                .at(holder.line, 1)
                .assumed("left out"),
        );
        return Ok(None);
    }
    let kind: String = holder
        .words(&["PhotometryType", "Type"])
        .unwrap_or("C")
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect();
    if !kind.to_ascii_uppercase().ends_with('C') {
        findings.push(
            Finding::error("tm33-type", format!("photometry type {kind} is not read here"))
                .at(holder.line, 1)
                .fix("convert the data to type C"),
        );
        return Err(Damaged);
    }
    let multiplier = match holder.words(&["Multiplier"]).map(number::read) {
        None => 1.0,
        Some(Ok(number)) if number.value > 0.0 => number.value,
        Some(_) => {
            findings
                .push(Finding::error("tm33-multiplier", "the multiplier is no number above zero").at(holder.line, 1));
            return Err(Damaged);
        }
    };
    if multiplier != 1.0 {
        let message = format!("the multiplier {multiplier} multiplies every intensity");
        findings.push(Finding::note("tm33-multiplier", message).at(holder.line, 1));
    }
    let mut points: Vec<(f64, f64, f64, usize, &str)> = Vec::new();
    let mut whole = true;
    for point in holder.children.iter().filter(|child| is_point(child)) {
        let mut value = |raw: Option<&str>, what: &str| {
            let read = raw.map_or(Err(number::NotANumber::Blank), number::read);
            if let Err(error) = &read {
                whole = false;
                let finding = Finding::error("tm33-number", format!("{what}: {error}")).at(point.line, 1);
                findings.push(finding.raw(raw.unwrap_or("")).fix("correct the number"));
            }
            read.ok().map(|number| number.value)
        };
        let h = value(point.attribute(&["horz", "horizontal", "h"]), "horizontal angle");
        let v = value(point.attribute(&["vert", "vertical", "v"]), "vertical angle");
        let intensity = value(Some(&point.text), "intensity");
        if let (Some(h), Some(v), Some(intensity)) = (h, v, intensity) {
            points.push((h, v, intensity, point.line, &point.text));
        }
    }
    if !whole {
        return Err(Damaged);
    }
    stated_counts(holder, &points, findings);
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    if let Some(pair) = points
        .windows(2)
        .find(|pair| pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1)
    {
        let message = format!("the direction {}°, {}° is given twice", pair[1].0, pair[1].1);
        let line = pair[0].3.max(pair[1].3);
        findings.push(
            Finding::error("tm33-point-doubled", message)
                .at(line, 1)
                .raw(pair[1].4)
                .fix("remove one of them"),
        );
        return Err(Damaged);
    }
    let mut horizontal: Vec<f64> = points.iter().map(|point| point.0).collect();
    horizontal.dedup();
    let mut vertical: Vec<f64> = points.iter().map(|point| point.1).collect();
    vertical.sort_by(f64::total_cmp);
    vertical.dedup();
    if points.len() != horizontal.len().saturating_mul(vertical.len()) {
        let gap = points.iter().enumerate().find(|(index, point)| {
            point.0 != horizontal[(index / vertical.len()).min(horizontal.len() - 1)]
                || point.1 != vertical[index % vertical.len()]
        });
        let line = gap.map_or(holder.line, |(_, point)| point.3);
        let message = format!(
            "{} directions are given; {} horizontal × {} vertical angles need {}",
            points.len(),
            horizontal.len(),
            vertical.len(),
            horizontal.len() * vertical.len()
        );
        findings.push(
            Finding::error("tm33-points-missing", message)
                .at(line, 1)
                .fix("a point before this line is missing"),
        );
        return Err(Damaged);
    }
    let flag = holder.words(&["AbsolutePhotometry"]);
    let absolute = flag.is_none_or(|flag| flag.eq_ignore_ascii_case("true") || flag == "1");
    if !absolute {
        findings.push(
            Finding::warning("tm33-relative", "the intensities are marked as not absolute")
                .at(holder.line, 1)
                .assumed("candela with the rated lumens"),
        );
    }
    Ok(Some(Table {
        horizontal,
        vertical,
        values: points.iter().map(|point| point.2).collect(),
        raws: points.iter().map(|point| point.4.to_owned()).collect(),
        candela: points.iter().map(|point| point.2 * multiplier).collect(),
        places: points.iter().map(|point| (point.3, 1)).collect(),
        absolute,
        flagged: flag.is_some(),
        line: holder.line,
    }))
}

fn stated_counts(holder: &Element, points: &[(f64, f64, f64, usize, &str)], findings: &mut Findings) {
    let distinct = |of: fn(&(f64, f64, f64, usize, &str)) -> f64| {
        let mut all: Vec<f64> = points.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all.len()
    };
    for (name, found) in [
        ("NumberMeasured", points.len()),
        ("NumberHorz", distinct(|point| point.0)),
        ("NumberVert", distinct(|point| point.1)),
    ] {
        let Some(child) = holder.child(name) else { continue };
        if child.text.parse() != Ok(found) {
            findings.push(
                Finding::warning("tm33-count", format!("{name} contradicts the data, which have {found}"))
                    .at(child.line, 1)
                    .raw(&child.text)
                    .assumed("the data")
                    .fix("correct the count"),
            );
        }
    }
}

type Rows = Vec<(f64, Vec<f64>)>;

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
