//! LM-63 bytes to absolute candela.

use super::Edition;
use super::header;
use super::layout::{self, Layout, Token};
use super::preamble::{self, Tilt};
use super::scene::Scene;
use super::write::TiltFactors;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings, Severity};
use crate::number;
use crate::plausible::{self, Stored};
use crate::read::{Beside, Format, Kind, Parsed, ReadOptions};
use crate::text::Text;

/// Reads bytes to absolute candela; a tilt file is named, not opened.
pub fn read(bytes: &[u8], options: ReadOptions) -> Parsed<Distribution> {
    read_beside(bytes, options, &|_| Err("only the file itself was given".to_owned()))
}

/// [`read`], and `beside` opens the tilt file.
pub fn read_beside(bytes: &[u8], options: ReadOptions, beside: Beside<'_>) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let distribution = distribution(&text, options, beside, &mut findings);
    Parsed::new(Format::Ies, Kind::Distribution, distribution, findings)
}

fn distribution(
    text: &Text<'_>,
    options: ReadOptions,
    beside: Beside<'_>,
    findings: &mut Findings,
) -> Option<Distribution> {
    let Some(preamble) = preamble::read(text, findings) else {
        findings.push(
            Finding::error("ies-truncated", "no line begins with TILT= and no line holds numbers")
                .at(text.len().max(1), 1)
                .raw(text.line(text.len().saturating_sub(1)))
                .fix("fetch the file again"),
        );
        return None;
    };
    let tokens = layout::tokens(text, preamble.numbers_from, findings);
    let mut reader = Reader {
        tokens: &tokens,
        findings,
    };
    let (tilt, start) = match &preamble.tilt {
        Tilt::None => (None, 0),
        Tilt::Include => reader.tilt().map(|(tilt, start)| (Some(tilt), start))?,
        Tilt::File(name) => {
            let place = (preamble.tilt_line.unwrap_or(0) + 1, 6);
            (tilt_file(name, place, beside, reader.findings), 0)
        }
    };
    let layout = layout::find(&tokens, start, text, reader.findings)?;
    let vertical = reader.block(layout.vertical, layout.nv, "vertical angle", "ies-angle-number");
    let horizontal = reader.block(layout.horizontal, layout.nh, "horizontal angle", "ies-angle-number");
    let values = reader.block(
        layout.candela,
        layout.nv * layout.nh,
        "candela value",
        "ies-candela-number",
    );
    let lamp = reader.lamp(start, &layout, preamble.edition, options);
    let (vertical, horizontal, values) = (vertical?, horizontal?, values?);
    let (lamp, factor) = lamp?;
    let candela: Vec<f64> = values.iter().map(|value| value * factor).collect();
    let places: Vec<(usize, usize)> = tokens[layout.candela..]
        .iter()
        .take(values.len())
        .map(|token| (token.line + 1, token.column))
        .collect();
    let scene = Scene {
        text,
        preamble: &preamble,
        lamp: &lamp,
        layout: &layout,
        tokens: &tokens,
    };
    scene.unit(findings);
    let (grid, symmetry, native) = scene.grid(&vertical, &horizontal, &candela, findings)?;
    let raws = |index: usize| tokens[layout.candela + index].text;
    plausible::check(
        &Stored {
            planes_deg: &horizontal,
            angles_deg: &vertical,
            values: &values,
            places: &places,
            raw: &raws,
            poles: lamp.photometric_type == 'C',
            ends_with_newline: text.ends_with_newline,
        },
        findings,
    );
    let lumens_at = tokens.get(start + 1).map(|token| (token.line + 1, token.column));
    plausible::flux(&grid, lamp.flux_lm(), lumens_at, None, findings);
    let numbers = header::Numbers {
        tokens: &tokens,
        start,
        layout: &layout,
        lamp: &lamp,
        vertical: &vertical,
        horizontal: &horizontal,
    };
    header::check(&numbers, &grid, findings);
    let header = scene.header(tilt.as_ref(), &vertical, &horizontal);
    Some(Distribution {
        intensity: grid,
        symmetry,
        lamp_flux_lm: lamp.flux_lm(),
        absolute: lamp.absolute,
        native,
        luminaire: scene.luminaire(),
        header,
        eulumdat: None,
    })
}

/// The table of a tilt file; what is wrong with it is said at the line of the file that names it.
fn tilt_file(name: &str, place: (usize, usize), beside: Beside<'_>, findings: &mut Findings) -> Option<TiltFactors> {
    let say = |finding: Finding| finding.at(place.0, place.1).raw(name);
    let without = |message: String| {
        Finding::warning("ies-tilt-file", message)
            .assumed("no tilt: the candela are as they stand here")
            .fix("put the tilt file beside this one, or write TILT=INCLUDE with its table, or TILT=NONE")
    };
    let opened = match beside(name) {
        Ok(opened) => opened,
        Err(why) => {
            let message = format!("the tilt factors stand in another file, which was not read: {why}");
            findings.push(say(without(message)));
            return None;
        }
    };
    let mut inside = Findings::new();
    let text = Text::decode(&opened.bytes, &mut inside);
    let tokens = layout::tokens(&text, 0, &mut inside);
    let mut reader = Reader {
        tokens: &tokens,
        findings: &mut inside,
    };
    let table = reader
        .tilt()
        .filter(|&(_, end)| end == tokens.len())
        .map(|(tilt, _)| tilt);
    if table.is_none() {
        let worst = inside
            .into_vec()
            .into_iter()
            .find(|finding| finding.severity == Severity::Error);
        let why = worst.map_or_else(
            || format!("{} numbers are not geometry, count, angles and factors", tokens.len()),
            |finding| format!("line {}: {}", finding.line.unwrap_or(1), finding.message),
        );
        let message = format!("{} was opened, but is no tilt table: {why}", opened.path);
        findings.push(say(without(message)));
        return None;
    }
    let message = format!("the tilt factors were read from {}", opened.path);
    let finding = Finding::warning("ies-tilt-factors", message);
    findings.push(say(
        finding.assumed("kept, not applied: the candela are those of the measured position")
    ));
    table
}

/// The thirteen numbers, decoded. What could not be read is `None`.
#[derive(Debug)]
pub(super) struct Lamp {
    pub(super) count: Option<f64>,
    pub(super) lumens_per_lamp: Option<f64>,
    pub(super) absolute: bool,
    pub(super) multiplier: f64,
    pub(super) photometric_type: char,
    pub(super) metres: Option<f64>,
    pub(super) units: &'static str,
    pub(super) opening: [Option<f64>; 3],
    pub(super) ballast_factor: f64,
    pub(super) third: Option<f64>,
    pub(super) third_text: Option<String>,
    pub(super) watts: Option<f64>,
}

impl Lamp {
    /// Flux of all lamps, stated; none for absolute photometry.
    pub(super) fn flux_lm(&self) -> Option<f64> {
        let flux = self.count? * self.lumens_per_lamp?;
        (!self.absolute && flux > 0.0).then_some(flux)
    }
}

struct Reader<'r, 't> {
    tokens: &'r [Token<'t>],
    findings: &'r mut Findings,
}

impl Reader<'_, '_> {
    /// The file ends before what is needed.
    fn ended(&mut self, what: &str) {
        let finding = Finding::error("ies-truncated", format!("the file ends before {what}"));
        let finding = match self.tokens.last() {
            Some(last) => finding.at(last.line + 1, last.column).raw(last.text),
            None => finding,
        };
        self.findings.push(finding.fix("fetch the file again"));
    }

    fn number(&mut self, index: usize, what: &str, code: &'static str) -> Option<f64> {
        let Some(token) = self.tokens.get(index) else {
            self.ended(what);
            return None;
        };
        match number::read(token.text) {
            Ok(number) if !number.comma => {
                if number.bare_exponent {
                    let finding = number::bare_exponent(token.text);
                    self.findings.push(finding.at(token.line + 1, token.column));
                }
                Some(number.value)
            }
            Ok(_) | Err(_) => {
                let why = number::read(token.text)
                    .err()
                    .map_or("this is not a number".to_owned(), |error| error.to_string());
                self.findings.push(
                    Finding::error(code, format!("{what}: {why}"))
                        .at(token.line + 1, token.column)
                        .raw(token.text)
                        .fix("correct the number"),
                );
                None
            }
        }
    }

    fn block(&mut self, from: usize, count: usize, what: &str, code: &'static str) -> Option<Vec<f64>> {
        if from.saturating_add(count) > self.tokens.len() {
            self.ended(&format!("{count} numbers, each a {what}, are complete"));
            return None;
        }
        let mut values = Vec::with_capacity(count);
        for index in from..from + count {
            values.extend(self.number(index, what, code));
        }
        (values.len() == count).then_some(values)
    }

    fn complain(&mut self, index: usize, finding: Finding) {
        let finding = match self.tokens.get(index) {
            Some(token) => finding.at(token.line + 1, token.column).raw(token.text),
            None => finding,
        };
        self.findings.push(finding);
    }

    /// Factors of a tilt table and the index of the number after it.
    fn tilt(&mut self) -> Option<(TiltFactors, usize)> {
        let geometry = self.number(0, "lamp-to-luminaire geometry", "ies-tilt-number")?;
        let count = self.number(1, "the number of tilt angles", "ies-tilt-number")?;
        if count.fract() != 0.0 || !(1.0..=10_000.0).contains(&count) || ![1.0, 2.0, 3.0].contains(&geometry) {
            let message = "geometry 1 to 3 and a number of tilt angles are needed after TILT=INCLUDE";
            self.complain(
                1,
                Finding::error("ies-tilt-number", message).fix("compare with the tilt table's angles"),
            );
            return None;
        }
        let count = count as usize;
        let angle_deg = self.block(2, count, "tilt angle", "ies-tilt-number");
        let factor = self.block(2 + count, count, "tilt factor", "ies-tilt-number");
        let (angle_deg, factor) = (angle_deg?, factor?);
        if let Some(at) = angle_deg.windows(2).position(|pair| pair[1] <= pair[0]) {
            let message = "tilt angles must rise; the number of tilt angles may be wrong";
            self.complain(
                3 + at,
                Finding::error("ies-tilt-angles", message).fix("correct the tilt table"),
            );
            return None;
        }
        let finding = Finding::warning("ies-tilt-factors", "tilt factors are given")
            .assumed("kept, not applied: the candela are those of the measured position");
        self.complain(2 + count, finding);
        let tilt = TiltFactors {
            geometry,
            angle_deg,
            factor,
        };
        Some((tilt, 2 + 2 * count))
    }

    /// The thirteen numbers and the factor on every candela value.
    fn lamp(&mut self, start: usize, layout: &Layout, edition: Edition, options: ReadOptions) -> Option<(Lamp, f64)> {
        const CODE: &str = "ies-header-number";
        let count = self.number(start, "the number of lamps", CODE);
        if let Some(odd) = count.filter(|count| count.fract() != 0.0 || *count < 1.0) {
            let message = format!("{odd} lamps");
            self.complain(
                start,
                Finding::warning("ies-lamp-count", message).fix("write a whole number from 1"),
            );
        }
        let lumens = self.number(start + 1, "lumens per lamp", CODE);
        let absolute = lumens.is_some_and(|lumens| lumens < 0.0);
        if let Some(odd) = lumens.filter(|&lumens| (lumens < 0.0 && lumens != -1.0) || lumens == 0.0) {
            let finding = Finding::warning("ies-lumens", format!("{odd} lumens per lamp"))
                .assumed(if absolute {
                    "absolute photometry, as with −1"
                } else {
                    "not stated"
                })
                .fix("write the lumens of one lamp, or −1 for absolute photometry");
            self.complain(start + 1, finding);
        }
        let multiplier = self.number(start + 2, "the candela multiplier", CODE);
        let photometric_type = match self.number(start + 5, "the photometric type", CODE)? {
            1.0 => 'C',
            2.0 => 'B',
            3.0 => 'A',
            _ => {
                let finding = Finding::error("ies-type", "the photometric type must be 1 (C), 2 (B) or 3 (A)");
                self.complain(start + 5, finding.fix("correct the sixth of the ten numbers"));
                return None;
            }
        };
        let (units, metres) = match self.number(start + 6, "the unit of the dimensions", CODE) {
            Some(1.0) => ("feet", Some(0.3048)),
            Some(2.0) => ("metres", Some(1.0)),
            Some(_) => {
                let finding = Finding::error("ies-units", "the unit of the dimensions must be 1 (feet) or 2 (metres)");
                self.complain(start + 6, finding.assumed("no dimensions"));
                ("unknown", None)
            }
            None => ("unknown", None),
        };
        let opening = [7, 8, 9].map(|offset| self.number(start + offset, "a dimension of the opening", CODE));
        let (ballast, third, watts) = match layout.factors {
            Some(at) => (
                self.number(at, "the ballast factor", CODE),
                self.number(at + 1, "the photometric factor", CODE),
                self.number(at + 2, "input watts", CODE),
            ),
            None => (Some(1.0), None, None),
        };
        let third_text = layout
            .factors
            .and_then(|at| self.tokens.get(at + 1))
            .map(|token| token.text.to_owned());
        if let Some(odd) = watts.filter(|&watts| watts < 0.0) {
            let at = layout.factors.unwrap_or(start) + 2;
            self.complain(
                at,
                Finding::warning("ies-watts", format!("{odd} W input power")).assumed("as it stands"),
            );
        }
        let (multiplier, ballast_factor) = (multiplier?, ballast?);
        let mut factor = self.factor(start + 2, multiplier, "the candela multiplier", "ies-multiplier")?;
        if let Some(at) = layout.factors {
            factor *= self.factor(at, ballast_factor, "the ballast factor", "ies-ballast-factor")?;
            factor *= self.third(at + 1, third, edition, options)?;
        }
        let lamp = Lamp {
            count,
            lumens_per_lamp: lumens.filter(|_| !absolute),
            absolute,
            multiplier,
            photometric_type,
            metres,
            units,
            opening,
            ballast_factor,
            third,
            third_text,
            watts,
        };
        Some((lamp, factor))
    }

    fn factor(&mut self, index: usize, factor: f64, what: &str, code: &'static str) -> Option<f64> {
        if factor <= 0.0 {
            let finding = Finding::error(code, format!("{what} is {factor}; it must be above zero"));
            self.complain(
                index,
                finding.fix("write 1 unless every candela value is to be multiplied"),
            );
            return None;
        }
        let unusual = match code {
            "ies-ballast-factor" => !(0.5..=1.3).contains(&factor),
            _ => !(1e-4..=1e4).contains(&factor),
        };
        if unusual {
            let finding = Finding::warning(code, format!("{what} is {factor}, which is unusual"));
            self.complain(
                index,
                finding
                    .assumed("a factor on every candela value")
                    .fix("check the order of the numbers"),
            );
        } else if factor != 1.0 {
            self.complain(
                index,
                Finding::note(code, format!("{what} {factor} multiplies every candela value")),
            );
        }
        Some(factor)
    }

    /// The twelfth number: ballast-lamp photometric factor (1986, 1991), future use (1995, 2002), file generation type
    /// (2019).
    fn third(&mut self, index: usize, value: Option<f64>, edition: Edition, options: ReadOptions) -> Option<f64> {
        let value = value?;
        match edition {
            Edition::E1986 | Edition::E1991 => self.factor(
                index,
                value,
                "the ballast-lamp photometric factor",
                "ies-photometric-factor",
            ),
            Edition::E1995 | Edition::E2002 => {
                if value == 1.0 {
                    return Some(1.0);
                }
                let code = "ies-future-use";
                let message = format!("this edition keeps the field for future use, yet it is {value}");
                if options.apply_future_use {
                    if value <= 0.0 {
                        self.complain(
                            index,
                            Finding::error(code, message).fix("it cannot multiply the candela"),
                        );
                        return None;
                    }
                    self.complain(
                        index,
                        Finding::warning(code, message).assumed("multiplied, as asked for"),
                    );
                    return Some(value);
                }
                let finding = Finding::warning(code, message).assumed("not multiplied");
                self.complain(
                    index,
                    finding.fix("--apply-future-use multiplies every candela value by it"),
                );
                Some(1.0)
            }
            Edition::E2019 => {
                if !(1.0..1.2).contains(&value) {
                    let finding =
                        Finding::warning("ies-generation", "this is no file generation type (1.00000 to 1.11100)");
                    self.complain(index, finding.assumed("not known"));
                }
                Some(1.0)
            }
        }
    }
}
