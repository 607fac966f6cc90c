//! LM-63-2002 and LM-63-2019 to the byte.

use isolux_photometry::{IntensityDistribution, Symmetry};

use super::{Edition, GENERATION_TYPES};
use crate::eulumdat::Written;
use crate::finding::{Finding, Findings};
use crate::number;

/// What an LM-63 file says beside the light.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Facts {
    /// Keyword lines in order, without brackets: (`MANUFAC`, text). Text with line breaks continues with `[MORE]`.
    pub keywords: Vec<(String, String)>,
    /// Flux of all lamps in lm; none for absolute photometry (written as −1).
    pub lamp_flux_lm: Option<f64>,
    /// Number of lamps.
    pub lamp_count: f64,
    /// Luminous opening in m: width, length, height, with the format's codes for shapes.
    pub opening_m: [f64; 3],
    /// Input power in W.
    pub watts: f64,
    /// 2019: the file generation type, one of [`GENERATION_TYPES`]; undefined where none is given.
    pub generation: Option<String>,
    /// Written as `TILT=INCLUDE`.
    pub tilt: Option<TiltFactors>,
}

/// A tilt table: kept, never applied.
#[derive(Debug, Clone, PartialEq)]
pub struct TiltFactors {
    /// Lamp-to-luminaire geometry, 1 to 3.
    pub geometry: f64,
    /// Tilt angles in degrees.
    pub angle_deg: Vec<f64>,
    /// The factor on the candela at each angle.
    pub factor: Vec<f64>,
}

/// Longest line of LM-63-2002, CR LF included.
const LINE: usize = 256;

/// Writes a distribution in candela, multiplier and factors 1. The symmetry that the intensities really have is kept
/// where LM-63 has a class for it.
pub fn write(intensity: &IntensityDistribution, facts: &Facts, edition: Edition) -> Written {
    let mut findings = Findings::new();
    let mut lines: Vec<String> = Vec::new();
    lines.push(
        if edition >= Edition::E2019 {
            "IES:LM-63-2019"
        } else {
            "IESNA:LM-63-2002"
        }
        .to_owned(),
    );
    keywords(&mut lines, facts, &mut findings);
    match &facts.tilt {
        None => lines.push("TILT=NONE".to_owned()),
        Some(tilt) => {
            lines.push("TILT=INCLUDE".to_owned());
            lines.push(number::plain(tilt.geometry));
            lines.push(tilt.angle_deg.len().to_string());
            wrap(
                &mut lines,
                tilt.angle_deg.iter().map(|&angle| number::significant(angle, 10)),
            );
            wrap(
                &mut lines,
                tilt.factor.iter().map(|&factor| number::significant(factor, 10)),
            );
        }
    }
    let (planes, horizontal) = stored(intensity, &mut findings);
    let gamma = intensity.gamma_deg();
    let ends = [gamma.first().copied(), gamma.last().copied()];
    if !matches!(ends, [Some(0.0 | 90.0), Some(90.0 | 180.0)]) {
        let message = "vertical angles of LM-63 begin at 0° or 90° and end at 90° or 180°; these do not";
        findings.push(Finding::warning("ies-vertical-range", message).assumed("the angles as they are"));
    }
    let (count, per_lamp) = match facts.lamp_flux_lm {
        Some(flux) if facts.lamp_count > 0.0 => (facts.lamp_count, flux / facts.lamp_count),
        Some(flux) => (1.0, flux),
        None => (if facts.lamp_count > 0.0 { facts.lamp_count } else { 1.0 }, -1.0),
    };
    let [width, length, height] = facts.opening_m;
    let numbers = [
        number::plain(count),
        number::significant(per_lamp, 10),
        "1".into(),
        gamma.len().to_string(),
        horizontal.len().to_string(),
        "1".into(),
        "2".into(),
        number::significant(width, 9),
        number::significant(length, 9),
        number::significant(height, 9),
    ];
    lines.push(numbers.join(" "));
    let third = if edition >= Edition::E2019 {
        facts.generation.clone().unwrap_or_else(|| {
            let message = "how the data came about is not known; the file generation type says so";
            findings.push(
                Finding::note("ies-generation", message)
                    .assumed("1.00001, undefined or older file")
                    .fix("state it: convert --generation 1.00000 (measured), 1.10000 (measured, accredited), 1.00010 (simulated) …"),
            );
            GENERATION_TYPES[0].0.to_owned()
        })
    } else {
        "1".into()
    };
    lines.push(format!("1 {third} {}", number::significant(facts.watts, 9)));
    wrap(&mut lines, gamma.iter().map(|&angle| number::significant(angle, 10)));
    wrap(
        &mut lines,
        horizontal.iter().map(|&angle| number::significant(angle, 10)),
    );
    for plane in planes {
        wrap(
            &mut lines,
            intensity
                .row(plane)
                .iter()
                .map(|&candela| number::significant(candela, 9)),
        );
    }
    let mut bytes = Vec::new();
    for line in &lines {
        let (encoded, ..) = encoding_rs::WINDOWS_1252.encode(line);
        bytes.extend_from_slice(&encoded);
        bytes.extend_from_slice(b"\r\n");
    }
    Written {
        bytes,
        findings: findings.into_vec(),
    }
}

/// Plane indices and horizontal angles to write: 0, 0–90, 0–180 or 0–360 with C0 repeated at 360.
fn stored(intensity: &IntensityDistribution, findings: &mut Findings) -> (Vec<usize>, Vec<f64>) {
    let c_deg = intensity.c_deg();
    let tolerance = intensity.peak().intensity.value().abs() * 1e-9;
    let has = |angle: f64| c_deg.contains(&angle);
    let last = match intensity.detect_symmetry(tolerance) {
        Symmetry::Rotational => 0.0,
        Symmetry::Quadrant if has(0.0) && has(90.0) => 90.0,
        Symmetry::C0C180 | Symmetry::Quadrant if has(0.0) && has(180.0) => 180.0,
        Symmetry::C90C270 => {
            findings.push(Finding::note(
                "ies-symmetry",
                "LM-63-2002 has no class for symmetry about C90–C270; all planes are written",
            ));
            360.0
        }
        _ => 360.0,
    };
    if last == 0.0 {
        return (vec![0], vec![0.0]);
    }
    let mut planes: Vec<usize> = (0..c_deg.len()).filter(|&plane| c_deg[plane] <= last).collect();
    let mut angles: Vec<f64> = planes.iter().map(|&plane| c_deg[plane]).collect();
    if last == 360.0 {
        if angles.first() == Some(&0.0) {
            planes.push(0);
            angles.push(360.0);
        } else {
            let message = "horizontal angles of LM-63 begin at 0°; these do not";
            findings.push(Finding::warning("ies-horizontal-range", message).assumed("the angles as they are"));
        }
    }
    (planes, angles)
}

/// Numbers joined by blanks into lines that stay within the limit.
fn wrap(lines: &mut Vec<String>, numbers: impl Iterator<Item = String>) {
    let mut line = String::new();
    for number in numbers {
        if !line.is_empty() && line.len() + 1 + number.len() > LINE - 2 {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(&number);
    }
    lines.push(line);
}

fn keywords(lines: &mut Vec<String>, facts: &Facts, findings: &mut Findings) {
    for (name, text) in &facts.keywords {
        for (part, words) in text.split('\n').enumerate() {
            let tag = if part == 0 { name.as_str() } else { "MORE" };
            let clean: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let mut rest = clean.as_str();
            let mut tag = tag;
            loop {
                let room = LINE - 2 - tag.len() - 3;
                let cut = rest.char_indices().nth(room).map_or(rest.len(), |(at, _)| at);
                lines.push(format!("[{tag}] {}", &rest[..cut]).trim_end().to_owned());
                rest = &rest[cut..];
                if rest.is_empty() {
                    break;
                }
                tag = "MORE";
            }
            if encoding_rs::WINDOWS_1252.encode(words).2 {
                let message = format!("keyword [{name}] has characters that are not in CP1252");
                findings.push(
                    Finding::warning("ies-text-encoding", message)
                        .raw(words)
                        .assumed("numeric references"),
                );
            }
        }
    }
    for required in ["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC"] {
        if !facts.keywords.iter().any(|(name, _)| name == required) {
            lines.push(format!("[{required}]"));
        }
    }
}
