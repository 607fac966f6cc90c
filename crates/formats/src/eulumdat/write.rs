//! EULUMDAT to the byte: CRLF, CP1252, field widths, six lines a set.

use isolux_photometry::{IntensityDistribution, Symmetry};

use super::document::{Document, Header, isym, stored_planes};
use super::expand::stored_c_deg;
use super::fields::{Blank, Field, HEADER, SET, Value};
use super::layout::HEADER as HEADER_LINES;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::parsed::Written;
use crate::quantities::utilisation::direct_ratios;

/// Writes a distribution. `header.lamp_sets[0].flux_lm` is the flux that cd/klm refer to; the symmetry that the
/// intensities really have is kept in the file. Blank direct ratios, LORL and DFF are computed from the integral.
///
/// # Errors
/// A finding, when there is no lamp flux above zero to refer to.
pub fn write(intensity: &IntensityDistribution, header: &Header) -> Result<Written, Finding> {
    let printed = header
        .lamp_sets
        .first()
        .and_then(|set| set.flux_lm)
        .filter(|&flux| flux > 0.0)
        .map(|flux| number::fitted(flux, 12));
    let flux: f64 = printed
        .as_deref()
        .and_then(|flux| flux.parse().ok())
        .filter(|&flux| flux > 0.0)
        .ok_or_else(|| {
            Finding::error(
                "ldt-lamp-flux",
                "EULUMDAT needs a lamp flux above zero that cd/klm refer to",
            )
        })?;
    let tolerance = intensity.peak().intensity_cd.abs() * 1e-9;
    let detected = intensity.detect_symmetry(tolerance);
    let c_deg = intensity.c_deg();
    let symmetry = if storable(detected, c_deg) {
        detected
    } else {
        Symmetry::None
    };
    let class = isym(symmetry);
    let planes = stored_c_deg(class, c_deg, stored_planes(class, c_deg.len()), false);
    let factor = header.conversion_factor.filter(|&factor| factor > 0.0).unwrap_or(1.0);
    let scale = 1000.0 / (flux * factor);
    let mut intensity_cd_klm = Vec::with_capacity(planes.len() * intensity.gamma_deg().len());
    for plane in planes {
        let index = c_deg.iter().position(|&c| c == plane).unwrap_or(0);
        intensity_cd_klm.extend(intensity.row(index).iter().map(|candela| candela * scale));
    }
    let mut header = completed(header, intensity, flux);
    let unknown = zero_where_unknown(&mut header);
    let document = Document {
        header,
        isym: class,
        c_deg: c_deg.to_vec(),
        gamma_deg: intensity.gamma_deg().to_vec(),
        intensity_cd_klm,
    };
    let mut written = write_document(&document);
    if unknown > 0 {
        let message = format!("{unknown} sizes or powers are not known; a blank line there stops other readers");
        written
            .findings
            .push(Finding::note("ldt-unknown-zero", message).assumed("0, as the format has it"));
    }
    Ok(written)
}

/// Puts 0 for sizes, tilt and power that are not known, and says how many: readers that skip blank lines would take
/// every number after one for its neighbour.
fn zero_where_unknown(header: &mut Header) -> usize {
    let mut unknown = zeros(HEADER, header);
    for set in &mut header.lamp_sets {
        unknown += zeros(SET, set);
    }
    // Ten zeros stand for ratios that are not stated.
    for ratio in &mut header.direct_ratios {
        ratio.get_or_insert(0.0);
    }
    unknown
}

fn zeros<T>(fields: &[Field<T>], of: &mut T) -> usize {
    let mut unknown = 0;
    for field in fields {
        if let Value::Number(_, Blank::Zero, place, _) = field.value
            && place(of).is_none()
        {
            *place(of) = Some(0.0);
            unknown += 1;
        }
    }
    unknown
}

/// The mirror planes of the class must be on the grid, else its planes cannot be counted; class 3 begins at plane
/// 3·Mc/4 + 1, which is none where four does not divide Mc.
fn storable(symmetry: Symmetry, c_deg: &[f64]) -> bool {
    let has = |angle: f64| c_deg.contains(&angle);
    match symmetry {
        Symmetry::None => true,
        Symmetry::Rotational => has(0.0),
        Symmetry::C0C180 => has(0.0) && has(180.0),
        Symmetry::C90C270 => has(90.0) && has(270.0) && c_deg.len().is_multiple_of(4),
        Symmetry::Quadrant => [0.0, 90.0, 180.0, 270.0].into_iter().all(has),
    }
}

/// LORL and DFF from the integral, the steps from the angles, where they are blank.
fn completed(header: &Header, intensity: &IntensityDistribution, flux: f64) -> Header {
    let mut header = header.clone();
    let integral = intensity.flux_lm();
    let down = intensity.flux_between_lm(0.0, 90.0);
    if integral > 0.0 {
        if header.fractions_unstated() {
            (header.lorl_percent, header.dff_percent) = (None, None);
        }
        header.lorl_percent.get_or_insert(100.0 * integral / flux);
        header.dff_percent.get_or_insert(100.0 * down / integral);
    }
    fill_ratios(&mut header, intensity);
    header.c_step_deg = Some(step(intensity.c_deg(), 360.0));
    header.gamma_step_deg = Some(step(intensity.gamma_deg(), 0.0));
    header
        .type_indicator
        .get_or_insert(if intensity.c_deg().len() == 1 { 1.0 } else { 3.0 });
    header
}

/// Direct ratios from the integral where none is stated: blank, or ten zeros.
fn fill_ratios(header: &mut Header, intensity: &IntensityDistribution) {
    let stated = header
        .direct_ratios
        .iter()
        .any(|ratio| ratio.is_some_and(|ratio| ratio != 0.0));
    if !stated && let Some(ratios) = direct_ratios(intensity) {
        header.direct_ratios = ratios.map(Some);
    }
}

/// The file as it was read, with blank LORL, DFF and direct ratios computed from the integral; every other field kept.
pub fn rewrite(document: &Document, intensity: &IntensityDistribution) -> Written {
    let mut document = document.clone();
    let flux = document
        .header
        .lamp_sets
        .first()
        .and_then(|set| set.flux_lm)
        .unwrap_or(1000.0);
    let (c_step, gamma_step) = (document.header.c_step_deg, document.header.gamma_step_deg);
    document.header = completed(&document.header, intensity, flux);
    document.header.c_step_deg = c_step.or(document.header.c_step_deg);
    document.header.gamma_step_deg = gamma_step.or(document.header.gamma_step_deg);
    write_document(&document)
}

/// The common distance of the angles; 0 where they have none. `turn`: the angles close into a circle of that many
/// degrees.
fn step(angles: &[f64], turn: f64) -> f64 {
    let [first, second, ..] = *angles else { return 0.0 };
    let step = second - first;
    let even = angles.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < 1e-6);
    let closed = turn == 0.0 || (step * angles.len() as f64 - turn).abs() < 1e-6;
    if even && closed { step } else { 0.0 }
}

/// Writes a document as it is.
pub fn write_document(document: &Document) -> Written {
    let mut out = Lines {
        bytes: Vec::new(),
        findings: Findings::new(),
        number: 0,
    };
    let mut header = document.header.clone();
    let counts = [
        (2, usize::from(document.isym)),
        (3, document.c_deg.len()),
        (5, document.gamma_deg.len()),
        (25, header.lamp_sets.len()),
    ];
    for line in 0..HEADER_LINES {
        match counts.iter().find(|(at, _)| *at == line) {
            Some((_, count)) => out.number(Some(*count as f64), 4),
            None => out.fields(HEADER.iter().filter(|field| field.line == line), &mut header),
        }
    }
    for set in &mut header.lamp_sets {
        out.fields(SET, set);
    }
    for ratio in header.direct_ratios {
        out.number(ratio, 7);
    }
    for &angle in document.c_deg.iter().chain(&document.gamma_deg) {
        out.exact(angle, 6);
    }
    out.intensities(&document.intensity_cd_klm);
    Written {
        bytes: out.bytes,
        findings: out.findings.into_vec(),
    }
}

struct Lines {
    bytes: Vec<u8>,
    findings: Findings,
    number: usize,
}

impl Lines {
    fn end(&mut self) {
        self.bytes.extend_from_slice(b"\r\n");
        self.number += 1;
    }

    fn fields<'f, T: 'f>(&mut self, fields: impl IntoIterator<Item = &'f Field<T>>, of: &mut T) {
        for field in fields {
            match field.value {
                Value::Text(place, _) => self.words(place(of), field.width),
                Value::Number(_, Blank::Is(value), place, _) => self.number(place(of).or(Some(value)), field.width),
                Value::Number(_, _, place, _) => self.number(*place(of), field.width),
            }
        }
    }

    /// A text field: CP1252, cut to its width.
    fn words(&mut self, text: &str, width: usize) {
        let line = self.number + 1;
        let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let cut: String = clean.chars().take(width).collect();
        if cut.len() < clean.len() {
            let message = format!("the field holds {width} characters; the text is cut");
            self.findings.push(
                Finding::warning("ldt-text-cut", message)
                    .at(line, 1)
                    .raw(text)
                    .assumed(cut.clone()),
            );
        }
        for character in cut.chars() {
            let mut buffer = [0; 4];
            let (encoded, _, lost) = encoding_rs::WINDOWS_1252.encode(character.encode_utf8(&mut buffer));
            if lost {
                let message = format!("{character:?} is not in CP1252");
                self.findings.push(
                    Finding::warning("ldt-text-encoding", message)
                        .at(line, 1)
                        .raw(text)
                        .assumed("?"),
                );
                self.bytes.push(b'?');
            } else {
                self.bytes.extend_from_slice(&encoded);
            }
        }
        self.end();
    }

    /// A number of the header, rounded to its width; blank where it is not known.
    fn number(&mut self, value: Option<f64>, width: usize) {
        if let Some(value) = value {
            let text = number::fitted(value, width);
            if text
                .parse::<f64>()
                .is_ok_and(|read| (read - value).abs() > 5e-4 * value.abs())
            {
                let message = format!("{value} does not fit the field's {width} characters");
                let finding = Finding::note("ldt-header-rounded", message).at(self.number + 1, 1);
                self.findings.push(finding.assumed(text.clone()));
            }
            self.bytes.extend_from_slice(text.as_bytes());
        }
        self.end();
    }

    /// A number that must not be rounded: wider than its field where it needs to be.
    fn exact(&mut self, value: f64, width: usize) {
        let text = number::fitted(value, width);
        let kept = text.parse::<f64>().is_ok_and(|read| read == value);
        self.bytes
            .extend_from_slice(if kept { text } else { number::shortest(value, 10) }.as_bytes());
        self.end();
    }

    /// Six characters where they keep a value to 1e-7 of itself, as many as that takes where they do not; readers go by
    /// lines, and a rounded tail cannot be distinguished from a measured one.
    fn intensities(&mut self, values: &[f64]) {
        let first = self.number + 1;
        let mut wide = 0;
        for &value in values {
            let text = number::fitted(value, 6);
            let kept = text
                .parse::<f64>()
                .is_ok_and(|read| (read - value).abs() <= 1e-7 * value.abs());
            wide += usize::from(!kept);
            self.bytes
                .extend_from_slice(if kept { text } else { number::shortest(value, 9) }.as_bytes());
            self.end();
        }
        if wide > 0 {
            let message = format!("{wide} intensities need more than the field's 6 characters to stay what they are");
            let finding = Finding::note("ldt-intensity-wide", message).at(first, 1);
            self.findings.push(finding.assumed("nine significant digits"));
        }
    }
}
