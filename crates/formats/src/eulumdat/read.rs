//! EULUMDAT bytes to the document and to absolute candela.

use isolux_photometry::{IntensityDistribution, Symmetry};
use serde_json::Value;

use super::layout::{self, HEADER, Layout, Token};
use super::{Document, Header, LampSet, ROOM_INDICES, symmetry};
use super::{claims, expand, header};
use crate::distribution::{Distribution, Luminaire};
use crate::finding::{Finding, Findings, Severity};
use crate::number::{self, NotANumber, Number};
use crate::plausible::{self, Stored};
use crate::quantities::utilisation::rough_direct_ratios;
use crate::read::{Format, Kind, Parsed, ReadOptions};
use crate::text::Text;

/// More points than this on the full circle, and than this many for each one that is stored, are refused: a rotational file
/// of a few kilobytes may claim any number.
const LARGEST_GRID: (usize, usize) = (1_000_000, 8);

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
    let distribution = document(&text, &mut findings)
        .and_then(|(document, places)| distribution(document, &places, &text, options, &mut findings));
    Parsed::new(Format::Eulumdat, Kind::Distribution, distribution, findings)
}

/// Reads bytes to the document that mirrors the file.
pub fn read_document(bytes: &[u8]) -> Parsed<Document> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let document = document(&text, &mut findings).map(|(document, _)| document);
    Parsed::new(Format::Eulumdat, Kind::Distribution, document, findings)
}

/// Where the numbers stand that later checks speak of.
#[derive(Debug)]
pub(super) struct Places {
    /// One-based line and column.
    pub intensity: Vec<(usize, usize)>,
    /// Zero-based lines of the header fields.
    pub lines: Vec<Option<usize>>,
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

/// Whether a text is NaN, infinity or a power of ten beyond all bounds. Words that begin so (Information, Nano) and long
/// catalogue numbers (EAN) are text.
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

fn distribution(
    document: Document,
    places: &Places,
    text: &Text<'_>,
    options: ReadOptions,
    findings: &mut Findings,
) -> Option<Distribution> {
    let header = &document.header;
    let line_of = |index: usize| places.lines.get(index).copied().flatten().unwrap_or(index);
    let set = header.lamp_sets.first()?;
    let flux_line = line_of(HEADER + 2);
    let flux = match set.flux_lm {
        Some(flux) if flux > 0.0 => flux,
        other => {
            let message = if other.is_none() {
                "no lamp flux is stated"
            } else {
                "the lamp flux is not above zero"
            };
            findings.push(
                Finding::error("ldt-lamp-flux", format!("{message}; cd/klm cannot become candela"))
                    .at(flux_line + 1, 1)
                    .raw(text.line(flux_line))
                    .fix("write the flux of the lamps in lm into line 26c"),
            );
            return None;
        }
    };
    let factor_line = line_of(23);
    let conversion = match header.conversion_factor {
        Some(1.0) => 1.0,
        Some(factor) if factor > 0.0 => {
            findings.push(
                Finding::warning(
                    "ldt-conversion-factor",
                    format!("the intensities are multiplied by the conversion factor {factor}"),
                )
                .at(factor_line + 1, 1)
                .raw(text.line(factor_line))
                .assumed("a factor on every intensity"),
            );
            factor
        }
        Some(_) => {
            findings.push(
                Finding::error("ldt-conversion-factor", "the conversion factor is not above zero")
                    .at(factor_line + 1, 1)
                    .raw(text.line(factor_line))
                    .fix("write 1 unless every intensity is to be multiplied"),
            );
            return None;
        }
        None if crate::text_is_blank(text.line(factor_line)) => {
            findings.push(
                Finding::warning("ldt-conversion-factor", "the conversion factor is blank")
                    .at(factor_line + 1, 1)
                    .assumed("1")
                    .fix("write 1"),
            );
            1.0
        }
        None => return None,
    };
    let most = LARGEST_GRID.0.max(LARGEST_GRID.1 * document.intensity_cd_klm.len());
    if document.c_deg.len().saturating_mul(document.gamma_deg.len()) > most {
        let message = format!(
            "{} × {} directions are more than a file can mean",
            document.c_deg.len(),
            document.gamma_deg.len()
        );
        findings.push(
            Finding::error("ldt-grid-too-large", message)
                .at(line_of(3) + 1, 1)
                .fix("check lines 4 and 6"),
        );
        return None;
    }
    sets(header, &line_of, findings);
    claims::type_indicator(&document, line_of(1) + 1, findings);
    if document.isym == 3 {
        order_of_class_three(&document, &line_of, options, findings);
    }
    let factor = conversion * flux / 1000.0;
    let intensity = match expand::expand(&document, factor, options.isym3_c90_first) {
        Ok(intensity) => intensity,
        Err(error) => {
            findings.push(Finding::error("ldt-angles", error.to_string()).fix("correct the angles of C or γ"));
            return None;
        }
    };
    let stored = expand::stored_c_deg(
        document.isym,
        &document.c_deg,
        document.intensity_cd_klm.len() / document.gamma_deg.len(),
        options.isym3_c90_first,
    );
    let raw = |index: usize| {
        places
            .intensity
            .get(index)
            .map_or("", |&(line, _)| text.line(line - 1).trim())
    };
    let written = Stored {
        planes_deg: &stored,
        angles_deg: &document.gamma_deg,
        values: &document.intensity_cd_klm,
        places: &places.intensity,
        raw: &raw,
        poles: true,
        ends_with_newline: text.ends_with_newline,
    };
    plausible::check(&written, findings);
    if let Some((index, (line, column))) =
        plausible::closing(&written, written.values).and_then(|index| Some((index, *places.intensity.get(index)?)))
    {
        let (values, ng) = (written.values, document.gamma_deg.len());
        let peak = values.iter().fold(0.0, |most: f64, &value| most.max(value));
        let severity = plausible::closing_severity(&values[..ng], &values[values.len() - ng..], peak);
        findings.push(
            Finding::new(
                severity,
                "ldt-closing-plane",
                "the planes at C0 and C360 are one plane, yet they differ",
            )
            .at(line, column)
            .raw(raw(index))
            .assumed("the plane at C0")
            .fix("compare both planes with the source"),
        );
    }
    let contradicted = plausible::flux(
        &intensity,
        Some(flux),
        Some((flux_line + 1, 1)),
        header.lorl_percent.map(|lorl| (lorl, line_of(22) + 1)),
        findings,
    );
    stated_ratios(header, &intensity, &line_of, contradicted, findings);
    header::check(&document, &intensity, &line_of, text, findings);
    let mut json = document.header_json();
    json.insert("encoding".into(), Value::from(text.encoding));
    json.insert("line_ending".into(), Value::from(text.line_ending));
    let absolute = set.count.is_some_and(|count| count < 0.0);
    let luminaire = luminaire(header);
    Some(Distribution {
        intensity,
        symmetry: symmetry(document.isym),
        lamp_flux_lm: Some(flux),
        absolute,
        native: None,
        luminaire,
        header: json,
        eulumdat: (!options.isym3_c90_first).then(|| Box::new(document)),
    })
}

/// Downward flux fraction in percentage points: of 85 files by many hands whose value means their light, none is farther
/// off than 0.5.
const DFF_APART: f64 = 1.0;
/// Direct ratios, for a note and for a warning. Of 25 files by many hands 17 are within 0.045 of the integral; two of narrow
/// beams are 0.10 and 0.12 off, which another spacing of the luminaires explains; six are 0.15 to 0.7 off: values of
/// another luminaire, left over from a template.
const RATIO_APART: (f64, f64) = (0.07, 0.15);
/// Direct ratios that programs computed by coarse zones fall by so much, here and there, where they should rise.
const DIP: f64 = 0.002;

/// Downward flux fraction and direct ratios against the integral. `contradicted`: the light output ratio is that of other
/// light; what was computed from that light then says so once more, as a note.
fn stated_ratios(
    header: &Header,
    intensity: &IntensityDistribution,
    line_of: &impl Fn(usize) -> usize,
    contradicted: bool,
    findings: &mut Findings,
) {
    let (down, all) = (intensity.flux_between(0.0, 90.0).value(), intensity.flux().value());
    if header.fractions_unstated() && all > 0.0 {
        let message = "light output ratio and downward flux fraction are zero, though there is light";
        findings.push(
            Finding::note("ldt-unstated", message)
                .at(line_of(21) + 1, 1)
                .assumed("not stated"),
        );
    } else if let Some(stated) = header.dff_percent
        && all > 0.0
        && (stated - 100.0 * down / all).abs() > DFF_APART
    {
        let message = format!(
            "{:.1} % of the integral goes down; stated is {stated} %",
            100.0 * down / all
        );
        let severity = if contradicted { Severity::Note } else { Severity::Warning };
        findings.push(
            Finding::new(severity, "flux-dff", message)
                .at(line_of(21) + 1, 1)
                .assumed("the intensities")
                .fix("correct the downward flux fraction, or look for damage in the intensities"),
        );
    }
    let stated = header.direct_ratios;
    let first = line_of(HEADER + 6 * header.lamp_sets.len() - 1) + 1;
    // Zeros stand for blanks.
    if stated.iter().flatten().all(|&ratio| ratio == 0.0) {
        return;
    }
    let say = |at: usize, message: &str| {
        Finding::warning("ldt-direct-ratios", message)
            .at(first + at + 1, 1)
            .raw(&stated[at].unwrap_or(0.0).to_string())
            .assumed("as they stand")
            .fix("compare the ratios with the source; two may be swapped")
    };
    // A share of the flux; programs round up.
    let share = |ratio: Option<f64>| ratio.is_none_or(|ratio| (0.0..=1.05).contains(&ratio));
    if let Some(at) = (0..10).find(|&at| !share(stated[at])) {
        findings.push(say(at, "a direct ratio is a share of the flux, from 0 to 1"));
        return;
    }
    let falls = |a: usize, b: usize| stated[a].zip(stated[b]).is_some_and(|(a, b)| b < a - DIP);
    if let Some(at) = (1..10).find(|&at| falls(at - 1, at)) {
        // Without the one before they go on rising: that one is too large.
        let odd = if at > 1 && !falls(at - 2, at) { at - 1 } else { at };
        findings.push(say(odd, "the direct ratios do not rise with the room index"));
        return;
    }
    let Some(computed) = rough_direct_ratios(intensity) else {
        return;
    };
    let apart = |at: usize| stated[at].map_or(0.0, |ratio| (ratio - computed[at]).abs());
    let worst = (0..10).max_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap_or(0);
    if apart(worst) > RATIO_APART.0 {
        let (far, limit) = (apart(worst) > RATIO_APART.1, RATIO_APART);
        let message = format!(
            "the direct ratio for k = {} is {}, the intensities give {:.3} (note from {} apart, warning from {})",
            ROOM_INDICES[worst],
            stated[worst].unwrap_or(0.0),
            computed[worst],
            limit.0,
            limit.1
        );
        let (severity, fix) = if far {
            (
                if contradicted { Severity::Note } else { Severity::Warning },
                "leave the ten ratios blank to have them computed, or look for damage in the intensities",
            )
        } else {
            (Severity::Note, "another spacing of the luminaires may explain it")
        };
        findings.push(
            Finding::new(severity, "ldt-direct-ratios", message)
                .at(first + worst + 1, 1)
                .assumed("as they stand")
                .fix(fix),
        );
    }
}

fn sets(header: &Header, line_of: &impl Fn(usize) -> usize, findings: &mut Findings) {
    if header.lamp_sets.len() > 1 {
        let message = format!("{} sets of lamps are listed", header.lamp_sets.len());
        findings.push(
            Finding::note("ldt-lamp-sets", message)
                .at(line_of(25) + 1, 1)
                .assumed("candela with the flux of the first set"),
        );
    }
    if header.lamp_sets.first().is_some_and(|set| set.count == Some(0.0)) {
        findings.push(
            Finding::warning("ldt-lamp-count", "the number of lamps is 0")
                .at(line_of(HEADER) + 1, 1)
                .raw("0")
                .assumed("relative photometry; line 26c is the flux of all lamps together")
                .fix("write the number of lamps, or −1 for absolute photometry"),
        );
    }
}

/// The order matters where the planes are not the same forwards and backwards.
fn order_of_class_three(
    document: &Document,
    line_of: &impl Fn(usize) -> usize,
    options: ReadOptions,
    findings: &mut Findings,
) {
    let ng = document.gamma_deg.len();
    let planes: Vec<&[f64]> = document.intensity_cd_klm.chunks(ng).collect();
    if planes.iter().zip(planes.iter().rev()).all(|(a, b)| a == b) {
        return;
    }
    let (order, other) = if options.isym3_c90_first {
        (
            "C90 through C180 to C270, as asked for",
            "leave the option out to read C270 first",
        )
    } else {
        (
            "C270 through C0 to C90, as the format has it",
            "if the light falls to the wrong side, read it with --isym3 c90-first",
        )
    };
    findings.push(
        Finding::note(
            "ldt-isym3-order",
            "symmetry 3: some programs store C90 first, and the file cannot say which",
        )
        .at(line_of(2) + 1, 1)
        .raw("3")
        .assumed(order)
        .fix(other),
    );
}

fn luminaire(header: &Header) -> Luminaire {
    let set = header.lamp_sets.first().cloned().unwrap_or_default();
    Luminaire {
        manufacturer: header.company.clone(),
        name: header.name.clone(),
        number: header.number.clone(),
        report: header.report.clone(),
        date: header.date_user.clone(),
        laboratory: String::new(),
        length_mm: header.length_mm,
        width_mm: header.width_mm,
        height_mm: header.height_mm,
        luminous_length_mm: header.luminous_length_mm,
        luminous_width_mm: header.luminous_width_mm,
        luminous_height_mm: header.luminous_height_mm,
        lamp: set.lamp,
        lamp_count: set.count.map(f64::abs),
        colour: set.colour,
        rendering: set.rendering,
        watts: set.watts,
        luminous_body_mm: None,
        tilt_deg: header.tilt_deg,
    }
}

/// The indicator for a symmetry.
pub(super) const fn isym(symmetry: Symmetry) -> u8 {
    match symmetry {
        Symmetry::None => 0,
        Symmetry::Rotational => 1,
        Symmetry::C0C180 => 2,
        Symmetry::C90C270 => 3,
        Symmetry::Quadrant => 4,
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
