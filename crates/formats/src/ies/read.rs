//! LM-63 bytes to absolute candela.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::{Map, Value, json};

use super::angles;
use super::header;
use super::layout::{self, Layout, Token};
use super::preamble::{self, Preamble, Tilt};
use super::shape::Shape;
use super::write::TiltFactors;
use super::{Edition, GENERATION_TYPES};
use crate::distribution::{Distribution, Luminaire, Native};
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
    let (grid, symmetry, native) = scene.grid(&vertical, &horizontal, &candela, findings)?;
    let raws = |index: usize| tokens[layout.candela + index].text;
    let self_check = plausible::check(
        &Stored {
            planes_deg: &horizontal,
            angles_deg: &vertical,
            values: &values,
            places: &places,
            raw: &raws,
            poles: lamp.photometric_type == 'C',
            ends_with_newline: text.ends_with_newline,
            unit_cd: factor,
        },
        options.self_check,
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
        self_check,
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

/// What was read, for the parts that are put together from it.
struct Scene<'s, 't> {
    text: &'s Text<'t>,
    preamble: &'s Preamble,
    lamp: &'s Lamp,
    layout: &'s Layout,
    tokens: &'s [Token<'t>],
}

/// Planes with their horizontal angles.
type Planes<'c> = Vec<(f64, &'c [f64])>;

type Grid = (IntensityDistribution, Symmetry, Option<Native>);

impl Scene<'_, '_> {
    fn place(&self, index: usize) -> (usize, usize) {
        self.tokens
            .get(index)
            .map_or((1, 1), |token| (token.line + 1, token.column))
    }

    fn grid(&self, vertical: &[f64], horizontal: &[f64], candela: &[f64], findings: &mut Findings) -> Option<Grid> {
        let at_vertical = self.place(self.layout.vertical);
        if vertical.len() < 2 {
            let message = "one vertical angle is no distribution";
            findings.push(
                Finding::error("ies-angles", message)
                    .at(at_vertical.0, at_vertical.1)
                    .fix("at least two are needed"),
            );
            return None;
        }
        let made = match self.lamp.photometric_type {
            'C' => self.type_c(vertical, horizontal, candela, findings),
            other => self.type_a_or_b(other, vertical, horizontal, candela, findings),
        };
        match made {
            Ok(grid) => Some(grid),
            Err(message) => {
                findings.push(
                    Finding::error("ies-angles", message)
                        .at(at_vertical.0, at_vertical.1)
                        .fix("correct the angles or the photometric type"),
                );
                None
            }
        }
    }

    fn type_c(
        &self,
        vertical: &[f64],
        horizontal: &[f64],
        candela: &[f64],
        findings: &mut Findings,
    ) -> Result<Grid, String> {
        let nv = vertical.len();
        let (line, column) = self.place(self.layout.vertical);
        let (first, last) = (vertical[0], vertical[nv - 1]);
        if !(matches!(first, 0.0 | 90.0) && matches!(last, 90.0 | 180.0)) && (0.0..=180.0).contains(&first) {
            let message =
                format!("vertical angles go from {first}° to {last}°; the standard has 0° or 90° to 90° or 180°");
            findings.push(
                Finding::warning("ies-vertical-range", message)
                    .at(line, column)
                    .assumed("no light outside these angles"),
            );
        }
        let rows: Vec<(f64, &[f64])> = horizontal.iter().copied().zip(candela.chunks(nv)).collect();
        let (symmetry, rows) = self.circle(rows, findings)?;
        let rows: Vec<(f64, Vec<f64>)> = rows.into_iter().map(|(c, row)| (c, row.to_vec())).collect();
        let grid =
            IntensityDistribution::expand(symmetry, &rows, vertical.to_vec()).map_err(|error| error.to_string())?;
        Ok((grid, symmetry, None))
    }

    /// Symmetry class and stored planes within [0, 360).
    fn circle<'c>(&self, rows: Planes<'c>, findings: &mut Findings) -> Result<(Symmetry, Planes<'c>), String> {
        let (line, column) = self.place(self.layout.horizontal);
        let first = rows.first().map_or(0.0, |row| row.0);
        let last = rows.last().map_or(0.0, |row| row.0);
        let odd = |message: String, assumed: &str| {
            Finding::warning("ies-horizontal-range", message)
                .at(line, column)
                .assumed(assumed.to_owned())
        };
        if rows.len() == 1 {
            if first != 0.0 {
                findings.push(odd(
                    format!("the only horizontal angle is {first}°"),
                    "rotational symmetry",
                ));
            }
            return Ok((Symmetry::Rotational, vec![(0.0, rows[0].1)]));
        }
        match (first, last) {
            (0.0, 90.0) => Ok((Symmetry::Quadrant, rows)),
            (0.0, 180.0) => Ok((Symmetry::C0C180, rows)),
            (90.0, 270.0) => {
                if self.preamble.edition >= Edition::E2002 {
                    let message = "horizontal angles from 90° to 270° belong to the 1995 edition".to_owned();
                    findings.push(odd(message, "symmetry about C90–C270"));
                }
                Ok((Symmetry::C90C270, rows))
            }
            (-90.0, 90.0) => {
                let message = "horizontal angles from −90° to 90° in type C".to_owned();
                findings.push(odd(message, "symmetry about C90–C270"));
                Ok((
                    Symmetry::C90C270,
                    rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect(),
                ))
            }
            _ => Ok((Symmetry::None, self.full_circle(rows, findings)?)),
        }
    }

    fn full_circle<'c>(&self, rows: Planes<'c>, findings: &mut Findings) -> Result<Planes<'c>, String> {
        let (line, column) = self.place(self.layout.horizontal);
        let (first, last) = (rows[0].0, rows[rows.len() - 1].0);
        if last - first > 360.0 {
            return Err(format!(
                "horizontal angles from {first}° to {last}° are more than a circle"
            ));
        }
        let widest = rows.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
        let gap = 360.0 - (last - first);
        if first < 0.0 {
            let message = format!("horizontal angles begin at {first}°");
            findings.push(
                Finding::warning("ies-horizontal-range", message)
                    .at(line, column)
                    .assumed("C = H + 360° below zero"),
            );
        }
        if gap > 1e-6 {
            let message = format!("horizontal angles go from {first}° to {last}°");
            let finding = if gap <= 1.5 * widest {
                Finding::note("ies-horizontal-range", message).assumed("a full circle")
            } else {
                Finding::warning("ies-horizontal-range", message)
                    .assumed("a full circle, interpolated over the gap")
                    .fix("the standard ends at 0°, 90°, 180° or 360°")
            };
            findings.push(finding.at(line, column));
            return Ok(rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect());
        }
        let mut rows = rows;
        if let Some((_, closing)) = rows.pop()
            && let Some((_, opening)) = rows.first()
            && let Some(at) = (0..closing.len()).find(|&at| closing[at] != opening[at])
        {
            let index = self.layout.candela + rows.len() * self.layout.nv + at;
            let (line, column) = self.place(index);
            let token = self.tokens.get(index).map_or("", |token| token.text);
            findings.push(
                Finding::warning(
                    "ies-closing-plane",
                    format!("the planes at {first}° and {last}° are one plane, yet they differ"),
                )
                .at(line, column)
                .raw(token)
                .assumed(format!("the plane at {first}°"))
                .fix("repeat the first plane as the last"),
            );
        }
        Ok(rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect())
    }

    fn type_a_or_b(
        &self,
        kind: char,
        vertical: &[f64],
        horizontal: &[f64],
        candela: &[f64],
        findings: &mut Findings,
    ) -> Result<Grid, String> {
        let reach = vertical
            .iter()
            .chain(horizontal)
            .fold(0.0_f64, |most, angle| most.max(angle.abs()));
        let (line, column) = self.place(self.layout.vertical);
        if reach > 90.0 {
            let message = format!("type {kind} has angles within ±90°; these reach {reach}°");
            findings.push(
                Finding::warning("ies-angle-range", message)
                    .at(line, column)
                    .assumed("the same coordinates beyond 90°")
                    .fix("check the photometric type"),
            );
        }
        if horizontal.len() == 1 {
            findings.push(
                Finding::warning("ies-horizontal-range", format!("one horizontal angle in type {kind}"))
                    .at(line, column)
                    .assumed("the same candela at every horizontal angle")
                    .fix("check the photometric type"),
            );
        }
        let source = angles::Native {
            type_a: kind == 'A',
            vertical_deg: vertical,
            horizontal_deg: horizontal,
            candela,
        };
        let grid = source.resampled().map_err(|error| error.to_string())?;
        let step = grid.gamma_deg().get(1).copied().unwrap_or(90.0);
        let smallest = source.smallest_step().unwrap_or(step);
        let message = format!("type {kind} is resampled to C-γ every {step}°");
        let finding = if step > smallest.min(30.0) + 1e-9 {
            Finding::warning(
                "ies-resampled",
                format!("{message}; its smallest step, {smallest}°, is too fine"),
            )
        } else {
            Finding::note("ies-resampled", format!("{message}, its smallest step"))
        };
        findings.push(
            finding
                .at(line, column)
                .assumed("V = 0, H = 0 is γ = 0, positive H is C0, positive V is C90"),
        );
        let native = Native {
            photometry_type: if kind == 'A' { "A" } else { "B" },
            vertical_deg: vertical.to_vec(),
            horizontal_deg: horizontal.to_vec(),
            intensity_cd: candela.chunks(vertical.len()).map(<[f64]>::to_vec).collect(),
            c0_axis: "horizontal_positive",
        };
        Ok((grid, source.symmetry(), Some(native)))
    }

    fn header(&self, tilt: Option<&TiltFactors>, vertical: &[f64], horizontal: &[f64]) -> Map<String, Value> {
        let lamp = self.lamp;
        let keywords: Vec<Value> = self
            .preamble
            .keywords
            .iter()
            .map(|keyword| json!({ "name": keyword.name, "text": keyword.text }))
            .collect();
        let tilt = match (&self.preamble.tilt, tilt) {
            (Tilt::File(name), None) => json!({ "file": name }),
            (Tilt::File(name), Some(tilt)) => {
                json!({ "file": name, "geometry": tilt.geometry, "angle_deg": tilt.angle_deg, "factor": tilt.factor })
            }
            (_, Some(tilt)) => {
                json!({ "geometry": tilt.geometry, "angle_deg": tilt.angle_deg, "factor": tilt.factor })
            }
            _ => Value::Null,
        };
        let opening: Vec<f64> = lamp.opening.iter().flatten().copied().collect();
        let shape = <[f64; 3]>::try_from(opening)
            .ok()
            .map(|opening| Shape::of(opening).name());
        let mut header = json!({
            "version": self.preamble.version,
            "edition": self.preamble.edition.year(),
            "keywords": keywords,
            "labels": self.preamble.labels,
            "tilt": tilt,
            "lamp_count": lamp.count,
            "lumens_per_lamp": lamp.lumens_per_lamp,
            "candela_multiplier": lamp.multiplier,
            "vertical_angles": vertical.len(),
            "horizontal_angles": horizontal.len(),
            "photometric_type": lamp.photometric_type.to_string(),
            "units": lamp.units,
            "width": lamp.opening[0],
            "length": lamp.opening[1],
            "height": lamp.opening[2],
            "opening_shape": shape,
            "ballast_factor": lamp.ballast_factor,
            "input_watts": lamp.watts,
            "encoding": self.text.encoding,
            "line_ending": self.text.line_ending,
        });
        match self.preamble.edition {
            Edition::E1986 | Edition::E1991 => header["photometric_factor"] = lamp.third.into(),
            Edition::E1995 | Edition::E2002 => header["future_use"] = lamp.third.into(),
            Edition::E2019 => {
                header["file_generation_type"] = lamp.third_text.clone().into();
                header["file_generation"] = lamp.third.and_then(generation).into();
            }
        }
        match header {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }

    fn luminaire(&self) -> Luminaire {
        let lamp = self.lamp;
        let keyword = |name: &str| {
            let found = self
                .preamble
                .keywords
                .iter()
                .find(|keyword| keyword.name.eq_ignore_ascii_case(name));
            found.map_or(String::new(), |keyword| keyword.text.replace('\n', " "))
        };
        let mut luminaire = Luminaire {
            manufacturer: keyword("MANUFAC"),
            name: keyword("LUMINAIRE"),
            number: keyword("LUMCAT"),
            report: keyword("TEST"),
            date: keyword("ISSUEDATE"),
            laboratory: keyword("TESTLAB"),
            lamp: keyword("LAMP"),
            lamp_count: lamp.count,
            watts: lamp.watts,
            ..Luminaire::default()
        };
        if let (Some(metres), [Some(width), Some(length), Some(height)]) = (lamp.metres, lamp.opening) {
            let mm = |value: f64| value.abs() * metres * 1000.0;
            let shape = Shape::of([width, length, height]);
            let (across, along) = match shape {
                shape if shape.is_round() => (mm(if width == 0.0 { height } else { width }), 0.0),
                Shape::HorizontalCylinderAlongLength => (mm(length), mm(height)),
                Shape::HorizontalCylinderAlongWidth => (mm(height), mm(width)),
                _ => (mm(length), mm(width)),
            };
            luminaire.luminous_length_mm = Some(across);
            luminaire.luminous_width_mm = Some(along);
            luminaire.luminous_height_mm = [Some(if height > 0.0 { mm(height) } else { 0.0 }); 4];
            luminaire.elliptic = shape.is_elliptic();
        }
        luminaire
    }
}

/// What a file generation type means, if it is one.
fn generation(value: f64) -> Option<&'static str> {
    let types = GENERATION_TYPES.iter();
    let found = types
        .into_iter()
        .find(|(code, _)| code.parse::<f64>().is_ok_and(|code| (code - value).abs() < 5e-6));
    found.map(|&(_, meaning)| meaning)
}
