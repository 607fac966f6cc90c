//! CGATS `.sp` (ArgyllCMS, BabelColor): keywords, a data format, rows of data.

mod pairs;
mod tokens;

use serde_json::{Map, Value};

use self::pairs::Pairs;
use self::tokens::{Token, cells, tokens};
use super::file::SpectrumFile;
use super::point::Point;
use super::points::Draft;
use super::{columns, write_cgats};
use crate::file_format::FileFormat;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::SP,
    title: "CGATS",
    extensions: &["sp"],
    detect: |source| !source.is_xml() && (looks_like(source.text()) || source.extension == "sp"),
    read: |source| {
        if looks_like(source.text()) {
            source.spectrum(read)
        } else {
            columns::read(source, Format::SP)
        }
    },
    write_distribution: None,
    write_spectrum: Some(write_cgats::cgats),
};

/// Whether a CGATS data block stands in the file.
pub(crate) fn looks_like(text: &Text<'_>) -> bool {
    let mark = ["SPECT", "CGATS", "CCSS", "CMF", "CTI"];
    let first = text.lines().map(str::trim).find(|l| !l.is_empty()).unwrap_or("");
    mark.iter().any(|m| first.starts_with(m))
        && text
            .lines()
            .any(|l| matches!(l.trim(), "BEGIN_DATA" | "BEGIN_DATA_FORMAT") || l.trim().starts_with("SPECTRAL_"))
        || text.lines().any(|l| l.trim() == "BEGIN_DATA_FORMAT")
}

/// Reads the first table of the file.
pub(crate) fn read(text: &Text<'_>, mut findings: Findings) -> Parsed<SpectrumFile> {
    let mut keywords: Map<String, Value> = Map::new();
    let mut places: Vec<(String, usize)> = Vec::new();
    let mut fields: Vec<Token<'_>> = Vec::new();
    let mut data: Vec<Token<'_>> = Vec::new();
    let mut rows_in_lines: Vec<usize> = Vec::new();
    let (mut section, mut seen_data, mut seen_end, mut seen_format) = (Section::Keywords, false, false, false);
    let mut whole = true;
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let trimmed = line.trim();
        if trimmed.is_empty() || (trimmed.starts_with('#') && section != Section::Data) {
            continue;
        }
        match trimmed {
            "BEGIN_DATA_FORMAT" => {
                section = Section::Fields;
                seen_format = true;
                continue;
            }
            "END_DATA_FORMAT" if section == Section::Fields => {
                section = Section::Keywords;
                continue;
            }
            "BEGIN_DATA" => {
                section = Section::Data;
                seen_data = true;
                continue;
            }
            "END_DATA" => {
                seen_end = true;
                break;
            }
            _ => {}
        }
        match section {
            Section::Keywords => {
                let (key, value) = trimmed.split_once(|c: char| c.is_whitespace()).unwrap_or((trimmed, ""));
                let value = value.trim().trim_matches('"');
                if key == "WEIGHTING_FUNCTION" {
                    // One line each for illuminant, observer and filter.
                    let before = keywords.get(key).and_then(Value::as_str);
                    let all = before.map_or(value.to_owned(), |before| format!("{before}; {value}"));
                    keywords.insert(key.to_owned(), all.into());
                    places.push((key.to_owned(), number));
                } else if key != "KEYWORD" {
                    if keywords.insert(key.to_owned(), value.into()).is_some() {
                        findings.push(
                            Finding::warning("sp-keyword-repeated", format!("{key} stands here again"))
                                .at(number, 1)
                                .raw(line)
                                .assumed("the last one"),
                        );
                    }
                    places.push((key.to_owned(), number));
                }
            }
            Section::Fields => fields.extend(tokens(line, number)),
            Section::Data => {
                let row = cells(line, number, fields.len());
                if trimmed.starts_with('#') && row.len() != fields.len() {
                    continue;
                }
                rows_in_lines.push(row.len());
                data.extend(row);
            }
        }
    }
    let place = |key: &str| places.iter().rev().find(|(k, _)| k == key).map_or(1, |(_, line)| *line);
    let mut fail = |finding: Finding, findings: &mut Findings| {
        whole = false;
        findings.push(finding);
    };
    if !seen_data || !seen_format {
        fail(
            Finding::error("sp-no-data", "the file has no BEGIN_DATA_FORMAT and BEGIN_DATA")
                .at(text.len().max(1), 1)
                .fix("the file is cut: fetch it again"),
            &mut findings,
        );
        return Parsed::refused(Some(Format::SP), Some(Kind::Spectrum), findings);
    }
    if !seen_end {
        fail(
            Finding::error("sp-end", "END_DATA is missing: the file is cut")
                .at(text.len().max(1), 1)
                .fix("fetch the file again"),
            &mut findings,
        );
    }
    let numeric = |key: &str, findings: &mut Findings, whole: &mut bool| -> Option<f64> {
        let raw = keywords.get(key)?.as_str()?.to_owned();
        match number::read(&raw) {
            Ok(n) => Some(n.value),
            Err(error) => {
                *whole = false;
                findings.push(
                    Finding::error("sp-number", format!("{key}: {error}"))
                        .at(place(key), 1)
                        .raw(&raw),
                );
                None
            }
        }
    };
    let stated_fields = numeric("NUMBER_OF_FIELDS", &mut findings, &mut whole);
    let stated_sets = numeric("NUMBER_OF_SETS", &mut findings, &mut whole);
    let bands = numeric("SPECTRAL_BANDS", &mut findings, &mut whole);
    let start = numeric("SPECTRAL_START_NM", &mut findings, &mut whole);
    let end = numeric("SPECTRAL_END_NM", &mut findings, &mut whole);

    let named: Vec<Option<f64>> = fields.iter().map(|f| wavelength_of(f.text)).collect();
    let spectral: Vec<usize> = (0..named.len()).filter(|&i| named[i].is_some()).collect();
    if let Some(stated) = stated_fields
        && stated != fields.len() as f64
    {
        findings.push(
            Finding::error(
                "sp-fields",
                format!("NUMBER_OF_FIELDS is {stated}, {} fields are named", fields.len()),
            )
            .at(place("NUMBER_OF_FIELDS"), 1)
            .assumed("the fields that are named")
            .fix("correct the number, or check for a lost field"),
        );
    }
    if let Some(bands) = bands
        && bands != spectral.len() as f64
    {
        findings.push(
            Finding::error(
                "sp-bands",
                format!("SPECTRAL_BANDS is {bands}, {} wavelengths are named", spectral.len()),
            )
            .at(place("SPECTRAL_BANDS"), 1)
            .assumed("the wavelengths that are named")
            .fix("correct the number, or check for a lost field"),
        );
    }
    let width = fields.len();
    if let Some(pairs) = Pairs::of(&fields) {
        let mut draft = pairs.draft(&data, text.encoding, whole, &mut findings);
        draft.header.extend(keywords);
        let file = draft.finish(&mut findings);
        return Parsed::new(Format::SP, Kind::Spectrum, file, findings);
    }
    if spectral.is_empty() || width == 0 {
        findings.push(
            Finding::error("sp-no-wavelength", "no field names a wavelength: this is no spectrum")
                .at(fields.first().map_or(1, |f| f.line), 1)
                .fix("fields are named SPEC_380 or nm380"),
        );
        return Parsed::refused(Some(Format::SP), Some(Kind::Spectrum), findings);
    }
    if !data.len().is_multiple_of(width) || data.is_empty() {
        whole = false;
        let line = data.last().map_or(text.len().max(1), |t| t.line);
        findings.push(
            Finding::error(
                "sp-data",
                format!(
                    "{} values stand in the data, which is no multiple of {width} fields",
                    data.len()
                ),
            )
            .at(line, 1)
            .fix("check for a lost, doubled or torn number"),
        );
    }
    let sets = data.len() / width;
    if let Some(stated) = stated_sets
        && stated != sets as f64
    {
        // A doubled line is where the count went wrong.
        let doubled = (1..sets).find(|&set| {
            let texts = |set: usize| data[set * width..(set + 1) * width].iter().map(|token| token.text);
            texts(set).eq(texts(set - 1))
        });
        let line = doubled.map_or(place("NUMBER_OF_SETS"), |set| data[set * width].line);
        findings.push(
            Finding::error("sp-sets", format!("NUMBER_OF_SETS is {stated}, {sets} sets follow"))
                .at(line, 1)
                .assumed("the sets that stand there")
                .fix("correct the number, or check for a lost line"),
        );
    }
    // ArgyllCMS names fields by whole nm and gives the exact grid by start, end and number.
    let grid = match (start, end, bands) {
        (Some(a), Some(b), Some(n)) if n == spectral.len() as f64 && n >= 2.0 && b > a => {
            Some(move |k: usize| a + (b - a) * k as f64 / (n - 1.0))
        }
        _ => None,
    };
    let mut off = None;
    let mut draft = Draft::new(text.encoding);
    let mut comma = false;
    for (k, &field) in spectral.iter().enumerate() {
        let name = named[field].unwrap_or(0.0);
        let x = match &grid {
            Some(grid) if (grid(k) - name).abs() <= 1.0 => grid(k),
            Some(_) => {
                off.get_or_insert(fields[field]);
                name
            }
            None => name,
        };
        let mut value = Vec::with_capacity(sets);
        for set in 0..sets {
            let token = data[set * width + field];
            match number::read_up_to(token.text, number::LARGEST_SPECTRAL) {
                Ok(n) => {
                    comma |= n.comma;
                    value.push(Some(n.value));
                }
                Err(error) => {
                    whole = false;
                    findings.push(
                        Finding::error("sp-number", error.to_string())
                            .at(token.line, token.column)
                            .raw(token.text),
                    );
                }
            }
        }
        draft.points.push(Point {
            line: data.get(field).map_or(1, |t| t.line),
            column: data.get(field).map_or(1, |t| t.column),
            x,
            value,
        });
    }
    if let Some(field) = off {
        whole = false;
        findings.push(
            Finding::error(
                "sp-grid",
                "the field's name contradicts SPECTRAL_START_NM, SPECTRAL_END_NM and SPECTRAL_BANDS",
            )
            .at(field.line, field.column)
            .raw(field.text)
            .fix("correct the name or the three numbers"),
        );
    }
    if comma {
        findings
            .push(Finding::note("sp-decimal-comma", "numbers are written with a decimal comma").at(data[0].line, 1));
    }
    let name_field = fields.iter().position(|f| {
        matches!(
            f.text.to_ascii_uppercase().as_str(),
            "SAMPLE_NAME" | "SAMPLE_ID" | "NAME"
        )
    });
    draft.names = (0..sets)
        .map(|set| {
            name_field.map_or_else(
                || format!("set {}", set + 1),
                |f| data[set * width + f].text.trim_matches('"').to_owned(),
            )
        })
        .collect();
    for field in (0..width).filter(|i| spectral.binary_search(i).is_err()) {
        if let Some(token) = data.get(field) {
            keywords
                .entry(fields[field].text.to_owned())
                .or_insert_with(|| token.text.trim_matches('"').into());
        }
    }
    draft.quantity = keywords
        .get("SPECTRAL_UNITS")
        .or_else(|| keywords.get("MEAS_TYPE"))
        .and_then(Value::as_str)
        .map(str::to_owned);
    draft.header.extend(keywords);
    draft.axis = Some(super::axis::AxisUnit::Nanometre);
    draft.whole = whole;
    let file = draft.finish(&mut findings);
    Parsed::new(Format::SP, Kind::Spectrum, file, findings)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Section {
    Keywords,
    Fields,
    Data,
}

/// `SPEC_380`, `SPECTRAL_NM380`, `SPECTRAL_NM_380`, `nm380`, `R_380`, `380nm`, `380`: the number is the wavelength.
fn wavelength_of(field: &str) -> Option<f64> {
    let upper = field.trim_matches('"').to_ascii_uppercase();
    let digits = [
        "SPECTRAL_NM_",
        "SPECTRAL_NM",
        "SPECTRAL_",
        "SPEC_",
        "NM_",
        "NM",
        "R_",
        "",
    ]
    .iter()
    .find_map(|prefix| upper.strip_prefix(prefix))?;
    let digits = digits.strip_suffix("NM").unwrap_or(digits);
    let nm = number::read(digits).ok()?.value;
    (1.0..1e5).contains(&nm).then_some(nm)
}
