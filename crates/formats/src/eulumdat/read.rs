//! EULUMDAT bytes to the document and to absolute candela.

use super::document::{Document, Header, LampSet};
use super::fields::{self, Field, Value};
use super::layout::{self, HEADER, Layout, Token};
use super::light::{Places, distribution};
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::number::{self, NotANumber};
use crate::options::ReadOptions;
use crate::parsed::{Format, Kind, Parsed};
use crate::text::Text;
use crate::unfinished::unfinished_line;

/// Whether the first lines are those of an EULUMDAT file: lines 2–7 are numbers and lines 3, 4, 6 can be counts.
pub fn looks_like(head: &Text<'_>) -> bool {
    let value = |line: usize| number::read(head.line(line)).ok().map(|number| number.value);
    let count =
        |line, least: f64, most: f64| value(line).is_some_and(|v| v.fract() == 0.0 && (least..=most).contains(&v));
    count(2, 0.0, 4.0)
        && count(3, 1.0, 100_000.0)
        && count(5, 2.0, 100_000.0)
        && value(4).is_some()
        && value(6).is_some()
}

/// Reads bytes to absolute candela.
pub fn read(bytes: &[u8], options: ReadOptions) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    read_text(&text, findings, options)
}

/// [`read`] of a text that is decoded; `findings` are those of its decoding.
pub(crate) fn read_text(text: &Text<'_>, mut findings: Findings, options: ReadOptions) -> Parsed<Distribution> {
    unfinished_line(text, &mut findings);
    let distribution = document(text, &mut findings)
        .and_then(|(document, places)| distribution(document, &places, text, options, &mut findings));
    Parsed::new(Format::EULUMDAT, Kind::Distribution, distribution, findings)
}

/// Reads bytes to the document that mirrors the file.
pub fn read_document(bytes: &[u8]) -> Parsed<Document> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let document = document(&text, &mut findings).map(|(document, _)| document);
    Parsed::new(Format::EULUMDAT, Kind::Distribution, document, findings)
}

fn document(text: &Text<'_>, findings: &mut Findings) -> Option<(Document, Places)> {
    let layout = layout::find(text, findings)?;
    let mut fields = Fields {
        text,
        layout: &layout,
        findings,
        commas: 0,
    };
    let header = fields.header();
    let c_deg = fields.block(&layout.c, "C angle", "ldt-angle-number");
    let gamma_deg = fields.block(&layout.gamma, "γ angle", "ldt-angle-number");
    let intensity = fields.block(&layout.intensity, "intensity", "ldt-intensity-number");
    let commas = fields.commas;
    if commas > 0 {
        let message = format!("{commas} numbers have a decimal comma");
        findings.push(
            Finding::warning("ldt-decimal-comma", message)
                .assumed("a decimal point")
                .fix("write a point"),
        );
    }
    let places: Vec<(usize, usize)> = layout
        .intensity
        .iter()
        .map(|token| (token.line + 1, token.column))
        .collect();
    let document = Document {
        header,
        isym: layout.isym,
        c_deg: c_deg?,
        gamma_deg: gamma_deg?,
        intensity_cd_klm: intensity?,
    };
    steps(&document, findings);
    Some((document, places))
}

/// Reads fields by their number in an undamaged file.
struct Fields<'f, 't> {
    text: &'t Text<'t>,
    layout: &'f Layout<'t>,
    findings: &'f mut Findings,
    commas: usize,
}

impl Fields<'_, '_> {
    /// A number that may be blank: `None` with a note then, with an error where something else stands there.
    fn number(&mut self, line: usize, what: &str) -> Option<f64> {
        let raw = self.text.line(line);
        match number::read(raw) {
            Ok(number) => {
                self.commas += usize::from(number.comma);
                Some(number.value)
            }
            Err(NotANumber::Blank) => {
                let note = Finding::note("ldt-blank", format!("{what} is blank"));
                self.findings.push(note.at(line + 1, 1).assumed("not stated"));
                None
            }
            Err(error) => {
                self.findings.push(
                    Finding::error("ldt-header-number", format!("{what}: {error}"))
                        .at(line + 1, 1)
                        .raw(raw)
                        .fix("correct the number"),
                );
                None
            }
        }
    }

    fn fields<T>(&mut self, fields: &[Field<T>], first: usize, into: &mut T) {
        for field in fields {
            let line = first + field.line;
            match field.value {
                Value::Text(place, _) => self.text.line(line).trim().clone_into(place(into)),
                Value::Number(what, _, place, _) => *place(into) = self.number(line, what),
            }
        }
    }

    fn header(&mut self) -> Header {
        let mut header = Header::default();
        self.fields(fields::HEADER, 0, &mut header);
        for set in 0..self.layout.sets {
            let mut lamps = LampSet::default();
            self.fields(fields::SET, HEADER + 6 * set, &mut lamps);
            header.lamp_sets.push(lamps);
        }
        for (into, token) in header.direct_ratios.iter_mut().zip(&self.layout.ratios) {
            *into = self.token(token, "direct ratio", "ldt-header-number", true);
        }
        header
    }

    fn block(&mut self, tokens: &[Token<'_>], what: &str, code: &'static str) -> Option<Vec<f64>> {
        let mut values = Vec::with_capacity(tokens.len());
        for token in tokens {
            if let Some(value) = self.token(token, what, code, false) {
                values.push(value);
            }
        }
        (values.len() == tokens.len()).then_some(values)
    }

    fn token(&mut self, token: &Token<'_>, what: &str, code: &'static str, may_be_blank: bool) -> Option<f64> {
        match number::read(token.text) {
            Ok(number) => {
                self.commas += usize::from(number.comma);
                Some(number.value)
            }
            Err(NotANumber::Blank) if may_be_blank => None,
            Err(error) => {
                let finding = Finding::error(code, format!("{what}: {error}"));
                self.findings.push(
                    finding
                        .at(token.line + 1, token.column)
                        .raw(token.text)
                        .fix("correct the number"),
                );
                None
            }
        }
    }
}

/// Lines 5 and 7 against the angles that are listed.
fn steps(document: &Document, findings: &mut Findings) {
    let header = &document.header;
    let checks = [
        (header.c_step_deg, &document.c_deg, 5, "C", "ldt-c-step"),
        (header.gamma_step_deg, &document.gamma_deg, 7, "γ", "ldt-gamma-step"),
    ];
    for (stated, angles, line, name, code) in checks {
        // 0 means angles that are not equidistant.
        let Some(stated) = stated.filter(|&step| step != 0.0) else {
            continue;
        };
        let off = |pair: &&[f64]| (pair[1] - pair[0] - stated).abs() > 0.051 * stated.abs().max(0.01);
        if let Some(pair) = angles.windows(2).find(off) {
            let (from, to) = (pair[0], pair[1]);
            let message = format!("{name} goes from {from}° to {to}°, yet {name} is said to be {stated}° apart");
            let finding = Finding::warning(code, message).at(line, 1).raw(&stated.to_string());
            let fix = "correct the angle, or write 0 here for angles that are not equidistant";
            findings.push(finding.assumed("the angles as listed").fix(fix));
        }
    }
}
