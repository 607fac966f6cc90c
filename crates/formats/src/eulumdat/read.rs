//! EULUMDAT bytes to the document and to absolute candela.

use super::document::{Document, Header, LampSet};
use super::layout::{self, HEADER, Layout, Token};
use super::light::{Places, distribution};
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::number::{self, NotANumber, Number};
use crate::parsed::{Format, Kind, Parsed, ReadOptions};
use crate::text::Text;

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
    let distribution = document(text, &mut findings)
        .and_then(|(document, places)| distribution(document, &places, text, options, &mut findings));
    Parsed::new(Format::Eulumdat, Kind::Distribution, distribution, findings)
}

/// Reads bytes to the document that mirrors the file.
pub fn read_document(bytes: &[u8]) -> Parsed<Document> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let document = document(&text, &mut findings).map(|(document, _)| document);
    Parsed::new(Format::Eulumdat, Kind::Distribution, document, findings)
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
    let places = Places {
        intensity: layout
            .intensity
            .iter()
            .map(|token| (token.line + 1, token.column))
            .collect(),
        lines: layout.lines.clone(),
    };
    if !layout.complete {
        return None;
    }
    let document = Document {
        header,
        isym: layout.isym,
        c_deg: c_deg?,
        gamma_deg: gamma_deg?,
        intensity_cd_klm: intensity?,
    };
    steps(&document, &layout, text, findings);
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
    fn line(&self, index: usize) -> Option<usize> {
        self.layout.lines.get(index).copied().flatten()
    }

    fn words(&mut self, index: usize) -> String {
        let Some(line) = self.line(index) else {
            return String::new();
        };
        let words = self.text.line(line).trim().to_owned();
        if beyond_bounds(&words) {
            self.findings.push(
                Finding::warning(
                    "ldt-text-number",
                    "a number beyond all bounds stands where text is expected",
                )
                .at(line + 1, 1)
                .raw(&words)
                .assumed("text")
                .fix("compare the line with the source"),
            );
        }
        words
    }

    /// What is unusual about how a number is written.
    fn taken(&mut self, number: Number, raw: &str, line: usize, column: usize) {
        self.commas += usize::from(number.comma);
        if number.bare_exponent {
            self.findings.push(number::bare_exponent(raw).at(line + 1, column));
        }
    }

    /// A number that may be blank: `None` with a note then, with an error where something else stands there.
    fn number(&mut self, index: usize, what: &str) -> Option<f64> {
        let line = self.line(index)?;
        let raw = self.text.line(line);
        match number::read(raw) {
            Ok(number) => {
                self.taken(number, raw, line, 1);
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

    fn header(&mut self) -> Header {
        let mut header = Header {
            company: self.words(0),
            type_indicator: self.number(1, "the type indicator"),
            c_step_deg: self.number(4, "the distance between C planes"),
            gamma_step_deg: self.number(6, "the distance between γ angles"),
            report: self.words(7),
            name: self.words(8),
            number: self.words(9),
            file_name: self.words(10),
            date_user: self.words(11),
            length_mm: self.number(12, "the length of the luminaire"),
            width_mm: self.number(13, "the width of the luminaire"),
            height_mm: self.number(14, "the height of the luminaire"),
            luminous_length_mm: self.number(15, "the length of the luminous area"),
            luminous_width_mm: self.number(16, "the width of the luminous area"),
            luminous_height_mm: [17, 18, 19, 20].map(|index| self.number(index, "the height of the luminous area")),
            dff_percent: self.number(21, "the downward flux fraction"),
            lorl_percent: self.number(22, "the light output ratio"),
            conversion_factor: self.number(23, "the conversion factor"),
            tilt_deg: self.number(24, "the tilt"),
            ..Header::default()
        };
        for set in 0..self.layout.sets {
            let first = HEADER + 6 * set;
            header.lamp_sets.push(LampSet {
                count: self.number(first, "the number of lamps"),
                lamp: self.words(first + 1),
                flux_lm: self.number(first + 2, "the flux of the lamps"),
                colour: self.words(first + 3),
                rendering: self.words(first + 4),
                watts: self.number(first + 5, "the power"),
            });
        }
        if let Some(ratios) = &self.layout.ratios {
            for (into, token) in header.direct_ratios.iter_mut().zip(ratios) {
                *into = self.token(token, "direct ratio", "ldt-header-number", true);
            }
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
                self.taken(number, token.text, token.line, token.column);
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

/// Whether a text is NaN, infinity or a power of ten beyond all bounds. Words that begin so (Information, Nano) and
/// long catalogue numbers (EAN) are text.
fn beyond_bounds(words: &str) -> bool {
    match number::read(words) {
        Err(NotANumber::NotFinite) => words.trim_start_matches(['+', '-']).parse::<f64>().is_ok(),
        Err(NotANumber::TooLarge) => words.contains(['e', 'E']),
        _ => false,
    }
}

/// Lines 5 and 7 against the angles that are listed.
fn steps(document: &Document, layout: &Layout<'_>, text: &Text<'_>, findings: &mut Findings) {
    let checks = [
        (
            document.header.c_step_deg,
            &document.c_deg,
            &layout.c,
            4,
            "C",
            "ldt-c-step",
        ),
        (
            document.header.gamma_step_deg,
            &document.gamma_deg,
            &layout.gamma,
            6,
            "γ",
            "ldt-gamma-step",
        ),
    ];
    for (stated, angles, tokens, line, name, code) in checks {
        let Some(stated) = stated else { continue };
        if angles.len() < 2 {
            continue;
        }
        let odd = angles
            .windows(2)
            .position(|pair| (pair[1] - pair[0] - stated).abs() > 0.051 * stated.abs().max(0.01));
        let line = layout.lines.get(line).copied().flatten().unwrap_or(line);
        let common = angles[1] - angles[0];
        let even = angles.windows(2).all(|pair| (pair[1] - pair[0] - common).abs() < 1e-6);
        if stated == 0.0 {
            if even && angles.len() > 2 {
                let message = format!("0 means angles that are not equidistant, yet {name} has {common}° throughout");
                let finding = Finding::warning(code, message)
                    .at(line + 1, 1)
                    .raw(text.line(line).trim());
                findings.push(finding.assumed("the angles as listed").fix(format!("write {common}")));
            }
            continue;
        }
        let Some(odd) = odd else { continue };
        let (from, to) = (angles[odd], angles[odd + 1]);
        let message = format!(
            "{name} goes from {from}° to {to}°, but line {} says that {name} is {stated}° apart",
            line + 1
        );
        let finding = Finding::warning(code, message).assumed("the angles as listed");
        // Angles that agree with each other speak against the step, one that does not speaks against itself.
        findings.push(if even && angles.len() > 2 {
            finding
                .at(line + 1, 1)
                .raw(&stated.to_string())
                .fix(format!("write {common}"))
        } else {
            let token = &tokens[odd + 1];
            let fix = format!(
                "correct the angle, or write 0 in line {} for angles that are not equidistant",
                line + 1
            );
            finding.at(token.line + 1, token.column).raw(token.text).fix(fix)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::beyond_bounds;

    #[test]
    fn words_are_no_numbers() {
        for text in [
            "INFINITY LIGHTING NO. W00006",
            "Nano 12",
            "4058075580602",
            "inf.",
            "",
            "5E2",
        ] {
            assert!(!beyond_bounds(text), "{text}");
        }
        for number in ["NaN", "-inf", "Infinity", "1e300"] {
            assert!(beyond_bounds(number), "{number}");
        }
    }
}
