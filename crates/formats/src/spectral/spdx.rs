//! ANSI/IES TM-27-14 `.spdx`.

use quick_xml::events::Event;
use quick_xml::reader::Reader;
use serde_json::Value;

use super::file::SpectrumFile;
use super::places::Places;
use super::point::Point;
use super::points::Draft;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;

/// Both namespaces that files carry.
pub(super) const NAMESPACES: [&str; 2] = ["iestm2714", "http://www.ies.org/iestm2714"];

/// The quantities that TM-27 names.
pub(super) const QUANTITIES: [&str; 12] = [
    "absorptance",
    "exitance",
    "flux",
    "intensity",
    "irradiance",
    "radiance",
    "reflectance",
    "relative",
    "transmittance",
    "R-Factor",
    "T-Factor",
    "other",
];

/// Deeper nesting than this is no spectrum; TM-27 has four levels.
const DEEPEST: usize = 64;

/// In front of the unit among the comments of a TM-27 file.
pub(super) const UNIT_COMMENT: &str = "unit of the values: ";

/// Whether the root element stands in the text.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    text.lines().take(30).any(|l| l.contains("<IESTM27"))
}

/// An element under way.
struct Open {
    name: String,
    text: String,
    at: usize,
    wavelength: Option<String>,
}

/// Reads the document.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let content = text.content();
    let places = Places::of(text);
    let mut reader = Reader::from_str(content);
    let mut draft = Draft::new(text.encoding);
    draft.axis = Some(super::axis::AxisUnit::Nanometre);
    let mut stack: Vec<Open> = Vec::new();
    let (mut root, mut distribution, mut closed) = (false, 0usize, false);
    let mut quantity: Option<(String, usize)> = None;
    loop {
        let before = reader.buffer_position() as usize;
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(error) => {
                let (line, column) = places.at((reader.error_position() as usize).min(content.len()));
                findings.push(
                    Finding::error("spdx-xml", format!("the XML is damaged: {error}"))
                        .at(line, column)
                        .raw(text.line(line - 1))
                        .fix("mend the tag, or fetch the file again"),
                );
                draft.whole = false;
                break;
            }
        };
        match event {
            Event::Start(start) => {
                let name = start.local_name().as_ref().to_owned();
                if stack.is_empty() {
                    if !name.to_ascii_uppercase().starts_with("IESTM27") {
                        let (line, column) = places.at(before);
                        findings.push(
                            Finding::error("spdx-root", format!("the root element is <{name}>, not <IESTM2714>"))
                                .at(places.line(skip_blank(content, before)).max(line), column)
                                .raw(&name)
                                .fix("this is no TM-27 file"),
                        );
                        return Parsed::refused(Some(Format::Spdx), Some(Kind::Spectrum), findings);
                    }
                    root = true;
                }
                let mut wavelength = None;
                for attribute in start.attributes() {
                    let Ok(attribute) = attribute else {
                        let (line, column) = places.at(before);
                        findings.push(
                            Finding::error("spdx-xml", "an attribute is damaged")
                                .at(line, column)
                                .raw(text.line(line - 1)),
                        );
                        draft.whole = false;
                        continue;
                    };
                    let key = attribute.key.as_ref().to_owned();
                    let value = attribute.value.clone().into_owned();
                    if stack.is_empty() {
                        namespace(&key, &value, places.at(before), &mut findings);
                        draft.header.insert(key, value.into());
                    } else if key == "wavelength" {
                        wavelength = Some(value);
                    }
                }
                if stack.len() >= DEEPEST {
                    let (line, column) = places.at(before);
                    findings.push(
                        Finding::error("spdx-depth", format!("elements are nested more than {DEEPEST} deep"))
                            .at(line, column)
                            .raw(&name)
                            .fix("a TM-27 file is four deep: check that this is one, or fetch the file again"),
                    );
                    return Parsed::refused(Some(Format::Spdx), Some(Kind::Spectrum), findings);
                }
                if name == "SpectralDistribution" {
                    distribution += 1;
                }
                stack.push(Open {
                    name,
                    text: String::new(),
                    at: skip_blank(content, before),
                    wavelength,
                });
            }
            Event::Empty(empty) => {
                let name = empty.local_name().as_ref().to_owned();
                let at = skip_blank(content, before);
                if name == "SpectralData" {
                    let (line, column) = places.at(at);
                    draft.whole = false;
                    findings.push(Finding::error("spdx-number", "no value stands here").at(line, column));
                } else if stack.is_empty() {
                    findings.push(
                        Finding::error("spdx-root", format!("the root element <{name}> is empty"))
                            .at(places.line(at), 1)
                            .raw(&name),
                    );
                    return Parsed::refused(Some(Format::Spdx), Some(Kind::Spectrum), findings);
                }
            }
            Event::Text(chunk) => {
                if let Some(open) = stack.last_mut() {
                    open.text.push_str(&chunk);
                } else if !chunk.trim().is_empty() && !chunk.trim_start_matches('\u{feff}').trim().is_empty() {
                    let (line, column) = places.at(skip_blank(content, before));
                    findings.push(
                        Finding::error("spdx-xml", "text stands outside the root element")
                            .at(line, column)
                            .raw(chunk.trim()),
                    );
                    draft.whole = false;
                }
            }
            Event::CData(chunk) => {
                if let Some(open) = stack.last_mut() {
                    open.text.push_str(&chunk);
                }
            }
            Event::GeneralRef(reference) => {
                if let Some(open) = stack.last_mut() {
                    match reference.resolve_char_ref() {
                        Ok(Some(c)) => open.text.push(c),
                        _ => {
                            if let Some(text) = quick_xml::escape::resolve_predefined_entity(&reference) {
                                open.text.push_str(text);
                            } else {
                                let (line, column) = places.at(before);
                                findings.push(
                                    Finding::warning("spdx-entity", "an entity is not known")
                                        .at(line, column)
                                        .raw(&format!("&{};", &*reference))
                                        .assumed("kept as written"),
                                );
                                open.text.push_str(&format!("&{};", &*reference));
                            }
                        }
                    }
                }
            }
            Event::End(_) => {
                if let Some(open) = stack.pop() {
                    closed = stack.is_empty();
                    let parent = stack.last().map_or("", |o| o.name.as_str());
                    close(&open, parent, &places, &mut draft, &mut quantity, &mut findings);
                }
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if !root && draft.whole {
        findings.push(
            Finding::error("spdx-root", "no element <IESTM2714> stands in this file")
                .at(1, 1)
                .raw(text.line(0)),
        );
        return Parsed::refused(Some(Format::Spdx), Some(Kind::Spectrum), findings);
    }
    if !closed && draft.whole {
        draft.whole = false;
        let open = stack.last().map_or(String::new(), |o| o.name.clone());
        findings.push(
            Finding::error("spdx-end", format!("the file ends inside <{open}>: it is cut"))
                .at(text.len(), 1)
                .raw(text.line(text.len().saturating_sub(1)))
                .fix("fetch the file again"),
        );
    }
    if draft.whole && distribution != 1 {
        findings.push(
            Finding::error(
                "spdx-distribution",
                format!("{distribution} elements <SpectralDistribution> where one is needed"),
            )
            .at(1, 1),
        );
        draft.whole = false;
    }
    match quantity {
        Some((name, at)) => {
            let (line, column) = places.at(at);
            if !QUANTITIES.iter().any(|q| q.eq_ignore_ascii_case(&name)) {
                findings.push(
                    Finding::warning("spdx-quantity", "TM-27 does not know this spectral quantity")
                        .at(line, column)
                        .raw(&name)
                        .assumed("kept as written")
                        .fix(format!("one of {}", QUANTITIES.join(", "))),
                );
            }
            draft.quantity = Some(name);
        }
        None if draft.whole => findings.push(
            Finding::warning("spdx-quantity", "SpectralQuantity is missing")
                .assumed("not stated")
                .fix("add <SpectralQuantity>relative</SpectralQuantity>, or what it is"),
        ),
        None => {}
    }
    // TM-27 has no field for a unit; the writer leaves it in the comments.
    if let Some((_, unit)) = draft
        .header
        .get("Comments")
        .and_then(Value::as_str)
        .and_then(|comments| comments.rsplit_once(UNIT_COMMENT))
    {
        draft.unit = Some(unit.trim().to_owned());
    }
    let file = draft.finish(&mut findings);
    Parsed::new(Format::Spdx, Kind::Spectrum, file, findings)
}

fn skip_blank(content: &str, from: usize) -> usize {
    content
        .get(from..)
        .and_then(|rest| rest.find(|c: char| !c.is_whitespace()))
        .map_or(from, |offset| from + offset)
}

fn namespace(key: &str, value: &str, (line, column): (usize, usize), findings: &mut Findings) {
    if key == "xmlns" && !NAMESPACES.contains(&value) {
        findings.push(
            Finding::warning("spdx-namespace", "this is no namespace of TM-27-14")
                .at(line, column)
                .raw(value)
                .assumed(NAMESPACES[0]),
        );
    }
    if key == "version" && value != "1.0" {
        findings.push(
            Finding::note("spdx-version", "the version is not 1.0")
                .at(line, column)
                .raw(value),
        );
    }
}

fn close(
    open: &Open,
    parent: &str,
    places: &Places<'_>,
    draft: &mut Draft,
    quantity: &mut Option<(String, usize)>,
    findings: &mut Findings,
) {
    let (line, column) = places.at(open.at);
    let text = open.text.trim();
    match (parent, open.name.as_str()) {
        (_, "SpectralData") => {
            let mut good = true;
            let mut read = |raw: &str, what: &str| match number::read_up_to(raw, number::LARGEST_SPECTRAL) {
                Ok(n) => {
                    if n.comma {
                        findings.push(
                            Finding::warning("spdx-decimal-comma", "XML numbers have a decimal point")
                                .at(line, column)
                                .raw(raw)
                                .assumed("a decimal comma"),
                        );
                    }
                    n.value
                }
                Err(error) => {
                    good = false;
                    findings.push(
                        Finding::error("spdx-number", format!("{what}: {error}"))
                            .at(line, column)
                            .raw(raw)
                            .fix("write the number that was measured"),
                    );
                    0.0
                }
            };
            let x = read(open.wavelength.as_deref().unwrap_or(""), "wavelength");
            let value = read(text, "value");
            draft.whole &= good;
            if good {
                draft.points.push(Point {
                    line,
                    column,
                    x,
                    value: vec![Some(value)],
                });
            }
        }
        ("SpectralDistribution", "SpectralQuantity") => {
            if quantity.is_some() {
                findings.push(
                    Finding::warning("spdx-repeated", "SpectralQuantity stands here again")
                        .at(line, column)
                        .raw(text)
                        .assumed("the last one"),
                );
            }
            *quantity = Some((text.to_owned(), open.at));
        }
        ("Header" | "SpectralDistribution", name) => {
            if ["BandwidthFWHM"].contains(&name)
                && let Err(error) = number::read(text)
            {
                findings.push(
                    Finding::warning("spdx-bandwidth", format!("{name}: {error}"))
                        .at(line, column)
                        .raw(text)
                        .assumed("not stated"),
                );
            }
            if draft.header.insert(name.to_owned(), Value::from(text)).is_some() {
                findings.push(
                    Finding::warning("spdx-repeated", format!("{name} stands here again"))
                        .at(line, column)
                        .raw(text)
                        .assumed("the last one"),
                );
            }
        }
        _ => {}
    }
}
