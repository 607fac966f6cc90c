//! The points of one emitter, read onto their grid.

use crate::finding::{Finding, Findings};
use crate::number;
use crate::xml::Element;

/// Intensities of one emitter on their grid.
pub(super) struct Table {
    pub horizontal: Vec<f64>,
    pub vertical: Vec<f64>,
    /// As written.
    pub values: Vec<f64>,
    pub raws: Vec<String>,
    pub candela: Vec<f64>,
    pub places: Vec<(usize, usize)>,
    pub absolute: bool,
    /// The file says whether it is.
    pub flagged: bool,
    pub line: usize,
    /// `SymmType` and its line.
    pub symmetry: Option<(String, usize)>,
}

/// Parts of an emitter whose points are no luminous intensities.
const NOT_LUMINOUS: [&str; 9] = [
    "CustomData",
    "RadiantData",
    "PhotonData",
    "SpectralData",
    "AngularColor",
    "IllumData",
    "IrradData",
    "PFDData",
    "SpecIrradData",
];

/// The element that holds the points, wherever the edition puts it.
fn holder(element: &Element) -> Option<&Element> {
    if element.children.iter().any(is_point) {
        return Some(element);
    }
    element
        .children
        .iter()
        .filter(|child| !NOT_LUMINOUS.contains(&child.name.as_str()))
        .find_map(holder)
}

pub(super) fn is_point(element: &Element) -> bool {
    matches!(element.name.as_str(), "IntensityData" | "IntData")
}

/// A damaged table; its findings say how.
pub(super) struct Damaged;

/// The table of an emitter, if it has one.
pub(super) fn table(emitter: &Element, findings: &mut Findings) -> Result<Option<Table>, Damaged> {
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
    let mut damaged = |finding| {
        findings.push(finding);
        Damaged
    };
    only_type_c(holder).map_err(&mut damaged)?;
    let multiplier = multiplier(holder).map_err(damaged)?;
    if multiplier != 1.0 {
        let message = format!("the multiplier {multiplier} multiplies every intensity");
        findings.push(Finding::note("tm33-multiplier", message).at(holder.line, 1));
    }
    let mut points = points(holder, findings)?;
    stated_counts(holder, &points, findings);
    points.sort_by(|a, b| {
        a.horizontal
            .total_cmp(&b.horizontal)
            .then(a.vertical.total_cmp(&b.vertical))
    });
    let (horizontal, vertical) = grid(holder, &points).map_err(|finding| {
        findings.push(finding);
        Damaged
    })?;
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
        values: points.iter().map(|point| point.intensity).collect(),
        raws: points.iter().map(|point| point.text.to_owned()).collect(),
        candela: points.iter().map(|point| point.intensity * multiplier).collect(),
        places: points.iter().map(|point| (point.line, 1)).collect(),
        absolute,
        flagged: flag.is_some(),
        line: holder.line,
        symmetry: holder
            .child("SymmType")
            .or_else(|| holder.child("Symm"))
            .map(|child| (child.text.clone(), child.line)),
    }))
}

fn only_type_c(holder: &Element) -> Result<(), Finding> {
    let kind: String = holder
        .words(&["PhotometryType", "Type"])
        .unwrap_or("C")
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect();
    if kind.to_ascii_uppercase().ends_with('C') {
        return Ok(());
    }
    Err(
        Finding::error("tm33-type", format!("photometry type {kind} is not read here"))
            .at(holder.line, 1)
            .fix("convert the data to type C"),
    )
}

fn multiplier(holder: &Element) -> Result<f64, Finding> {
    match holder.words(&["Multiplier"]).map(number::read) {
        None => Ok(1.0),
        Some(Ok(number)) if number.value > 0.0 => Ok(number.value),
        Some(_) => Err(Finding::error("tm33-multiplier", "the multiplier is no number above zero").at(holder.line, 1)),
    }
}

/// One direction as it stands in the file.
struct Point<'x> {
    horizontal: f64,
    vertical: f64,
    intensity: f64,
    line: usize,
    text: &'x str,
}

/// The points in the order of the file.
fn points<'x>(holder: &'x Element, findings: &mut Findings) -> Result<Vec<Point<'x>>, Damaged> {
    let mut points = Vec::new();
    let mut whole = true;
    for point in holder.children.iter().filter(|child| is_point(child)) {
        let mut value = |raw: Option<&str>, what: &str| {
            let read = raw.map_or(Err(number::NotANumber::Blank), number::read);
            if let Err(error) = &read {
                whole = false;
                let finding = Finding::error("tm33-number", format!("{what}: {error}")).at(point.line, point.column);
                findings.push(finding.raw(raw.unwrap_or("")).fix("correct the number"));
            }
            read.map_or(0.0, |number| number.value)
        };
        points.push(Point {
            horizontal: value(point.attribute(&["horz", "horizontal", "h"]), "horizontal angle"),
            vertical: value(point.attribute(&["vert", "vertical", "v"]), "vertical angle"),
            intensity: value(Some(&point.text), "intensity"),
            line: point.line,
            text: &point.text,
        });
    }
    if whole { Ok(points) } else { Err(Damaged) }
}

/// Horizontal and vertical angles of the sorted points, which have every pair of them once.
fn grid(holder: &Element, points: &[Point<'_>]) -> Result<(Vec<f64>, Vec<f64>), Finding> {
    let twice = |pair: &&[Point<'_>]| pair[0].horizontal == pair[1].horizontal && pair[0].vertical == pair[1].vertical;
    if let Some(pair) = points.windows(2).find(twice) {
        let message = format!(
            "the direction {}°, {}° is given twice",
            pair[1].horizontal, pair[1].vertical
        );
        let line = pair[0].line.max(pair[1].line);
        return Err(Finding::error("tm33-point-doubled", message)
            .at(line, 1)
            .raw(pair[1].text)
            .fix("remove one of them"));
    }
    let horizontal = distinct(points, |point| point.horizontal);
    let vertical = distinct(points, |point| point.vertical);
    let (nh, nv) = (horizontal.len(), vertical.len());
    if points.len() != nh.saturating_mul(nv) {
        let gap = points.iter().enumerate().find(|(index, point)| {
            point.horizontal != horizontal[(index / nv).min(nh - 1)] || point.vertical != vertical[index % nv]
        });
        let message = format!(
            "{} directions are given; {nh} horizontal × {nv} vertical angles need {}",
            points.len(),
            nh * nv
        );
        return Err(Finding::error("tm33-points-missing", message)
            .at(gap.map_or(holder.line, |(_, point)| point.line), 1)
            .fix("a point before this line is missing"));
    }
    Ok((horizontal, vertical))
}

/// The angles that occur, rising.
fn distinct(points: &[Point<'_>], of: fn(&Point<'_>) -> f64) -> Vec<f64> {
    let mut all: Vec<f64> = points.iter().map(of).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

fn stated_counts(holder: &Element, points: &[Point<'_>], findings: &mut Findings) {
    for (name, found) in [
        ("NumberMeasured", points.len()),
        ("NumberHorz", distinct(points, |point| point.horizontal).len()),
        ("NumberVert", distinct(points, |point| point.vertical).len()),
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
