//! CGATS `.sp` (ArgyllCMS, BabelColor): keywords, a data format, rows of data.

mod pairs;
mod sections;
mod tokens;

use serde_json::{Map, Value};

use self::pairs::Pairs;
use self::sections::{Sections, Stated};
use self::tokens::Token;
use super::axis::AxisUnit;
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
    let file = draft(text, &mut findings).and_then(|draft| draft.finish(&mut findings));
    Parsed::new(Format::SP, Kind::Spectrum, file, findings)
}

fn draft(text: &Text<'_>, findings: &mut Findings) -> Option<Draft> {
    let mut sections = Sections::of(text, findings)?;
    let mut number = |key: &str| sections.number(key, findings);
    let (stated_fields, stated_sets) = (number("NUMBER_OF_FIELDS"), number("NUMBER_OF_SETS"));
    let bands = number("SPECTRAL_BANDS");
    let (start, end) = (number("SPECTRAL_START_NM"), number("SPECTRAL_END_NM"));
    let Sections {
        keywords,
        fields,
        data,
        mut whole,
        ..
    } = sections;

    let named = fields.iter().enumerate();
    let spectral: Vec<(usize, f64)> = named
        .filter_map(|(k, field)| Some((k, wavelength_of(field.text)?)))
        .collect();
    check_fields(stated_fields, fields.len(), bands, spectral.len(), findings);
    if let Some(pairs) = Pairs::of(&fields) {
        let mut draft = pairs.draft(&data, text.encoding, whole, findings);
        draft.header.extend(keywords);
        return Some(draft);
    }
    if spectral.is_empty() {
        findings.push(
            Finding::error("sp-no-wavelength", "no field names a wavelength: this is no spectrum")
                .at(fields.first().map_or(1, |f| f.line), 1)
                .fix("fields are named SPEC_380 or nm380"),
        );
        return None;
    }
    let width = fields.len();
    if !data.len().is_multiple_of(width) || data.is_empty() {
        whole = false;
        let message = format!(
            "{} values stand in the data, which is no multiple of {width} fields",
            data.len()
        );
        findings.push(
            Finding::error("sp-data", message)
                .at(data.last().map_or(text.len().max(1), |token| token.line), 1)
                .fix("check for a lost, doubled or torn number"),
        );
    }
    let sets: Vec<&[Token<'_>]> = data.chunks_exact(width).collect();
    check_sets(stated_sets, &sets, findings);

    let mut draft = Draft::new(text.encoding);
    draft.axis = Some(AxisUnit::Nanometre);
    let (exact, off) = exact_nm(&spectral, start, end, bands);
    let mut comma = false;
    for (x, &(field, _)) in exact.into_iter().zip(&spectral) {
        let value = column(&sets, field, &mut comma, findings);
        whole &= value.len() == sets.len();
        let (line, column) = data.get(field).map_or((1, 1), |token| (token.line, token.column));
        draft.points.push(Point { line, column, x, value });
    }
    if let Some(field) = off.map(|field| fields[field]) {
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
    draft.whole = whole;
    draft.names = names(&fields, &sets);
    let keywords = header(keywords, &fields, &data);
    let quantity = keywords.get("SPECTRAL_UNITS").or_else(|| keywords.get("MEAS_TYPE"));
    draft.quantity = quantity.and_then(Value::as_str).map(str::to_owned);
    draft.header.extend(keywords);
    Some(draft)
}

/// Wavelengths of the fields. ArgyllCMS names fields by whole nm and gives the exact grid by start, end and number;
/// beside them the first field whose name contradicts that grid.
fn exact_nm(spectral: &[(usize, f64)], start: Stated, end: Stated, bands: Stated) -> (Vec<f64>, Option<usize>) {
    let named = || spectral.iter().map(|&(_, name)| name).collect();
    let (Some((a, _)), Some((b, _)), Some((n, _))) = (start, end, bands) else {
        return (named(), None);
    };
    if n != spectral.len() as f64 || n < 2.0 || b <= a {
        return (named(), None);
    }
    let mut off = None;
    let exact = |(k, &(field, name)): (usize, &(usize, f64))| {
        let exact = a + (b - a) * k as f64 / (n - 1.0);
        if (exact - name).abs() <= 1.0 {
            return exact;
        }
        off.get_or_insert(field);
        name
    };
    (spectral.iter().enumerate().map(exact).collect(), off)
}

/// The numbers of fields and of wavelengths that are stated, against those that are named.
fn check_fields(fields: Stated, named: usize, bands: Stated, spectral: usize, findings: &mut Findings) {
    for (stated, found, code, key, what) in [
        (fields, named, "sp-fields", "NUMBER_OF_FIELDS", "fields"),
        (bands, spectral, "sp-bands", "SPECTRAL_BANDS", "wavelengths"),
    ] {
        if let Some((stated, line)) = stated
            && stated != found as f64
        {
            findings.push(
                Finding::error(code, format!("{key} is {stated}, {found} {what} are named"))
                    .at(line, 1)
                    .assumed(format!("the {what} that are named"))
                    .fix("correct the number, or check for a lost field"),
            );
        }
    }
}

/// The number of sets that is stated, against those that stand there.
fn check_sets(stated: Stated, sets: &[&[Token<'_>]], findings: &mut Findings) {
    let Some((stated, line)) = stated.filter(|(stated, _)| *stated != sets.len() as f64) else {
        return;
    };
    // A doubled line is where the count went wrong.
    let same = |a: &[Token<'_>], b: &[Token<'_>]| a.iter().zip(b).all(|(a, b)| a.text == b.text);
    let doubled = sets.windows(2).find(|pair| same(pair[0], pair[1]));
    let line = doubled.map_or(line, |pair| pair[1][0].line);
    let found = sets.len();
    findings.push(
        Finding::error("sp-sets", format!("NUMBER_OF_SETS is {stated}, {found} sets follow"))
            .at(line, 1)
            .assumed("the sets that stand there")
            .fix("correct the number, or check for a lost line"),
    );
}

/// The values of one field, set by set; fewer than sets where one is no number.
fn column(sets: &[&[Token<'_>]], field: usize, comma: &mut bool, findings: &mut Findings) -> Vec<Option<f64>> {
    let mut values = Vec::with_capacity(sets.len());
    for token in sets.iter().map(|set| set[field]) {
        match number::read_up_to(token.text, number::LARGEST_SPECTRAL) {
            Ok(number) => {
                *comma |= number.comma;
                values.push(Some(number.value));
            }
            Err(error) => findings.push(
                Finding::error("sp-number", error.to_string())
                    .at(token.line, token.column)
                    .raw(token.text),
            ),
        }
    }
    values
}

/// What the file calls its sets.
fn names(fields: &[Token<'_>], sets: &[&[Token<'_>]]) -> Vec<String> {
    let of_names = ["SAMPLE_NAME", "SAMPLE_ID", "NAME"];
    let field = fields
        .iter()
        .position(|field| of_names.iter().any(|name| field.text.eq_ignore_ascii_case(name)));
    let name = |(k, set): (usize, &&[Token<'_>])| {
        field.map_or_else(
            || format!("set {}", k + 1),
            |field| set[field].text.trim_matches('"').to_owned(),
        )
    };
    sets.iter().enumerate().map(name).collect()
}

/// The keywords, and of the fields without a wavelength what the first set has there.
fn header(mut keywords: Map<String, Value>, fields: &[Token<'_>], data: &[Token<'_>]) -> Map<String, Value> {
    for (field, token) in fields
        .iter()
        .zip(data)
        .filter(|(field, _)| wavelength_of(field.text).is_none())
    {
        keywords
            .entry(field.text)
            .or_insert_with(|| token.text.trim_matches('"').into());
    }
    keywords
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
