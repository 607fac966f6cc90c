//! Header numbers of EULUMDAT against their definitions, against each other and against the light.
//!
//! Two numbers that changed places are still numbers: what tells is that one of them cannot be what its line says.
//! Limits are such that files by many hands keep them, but for those that do contradict themselves.

use isolux_photometry::IntensityDistribution;

use super::document::{Document, Header, LampSet};
use super::layout::HEADER;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::ratings;
use crate::text::Text;

/// Beyond this no side of a luminaire is believed, in mm.
const LARGEST_MM: f64 = 10_000.0;
/// Luminous sides may be larger than the body by this share and this many mm: makers round the two differently.
const LARGER: (f64, f64) = (0.01, 2.0);
/// Low-pressure sodium to aquarium blue, in K.
const COLOUR_K: (f64, f64) = (1500.0, 15_000.0);
/// More lamps than this are another number.
const MOST_LAMPS: f64 = 1000.0;

/// Says which numbers of the header cannot be meant.
pub(super) fn check(
    document: &Document,
    intensity: &IntensityDistribution,
    line_of: &impl Fn(usize) -> usize,
    text: &Text<'_>,
    findings: &mut Findings,
) {
    let mut checks = Checks {
        line_of,
        text,
        findings,
    };
    checks.one_plane(document);
    checks.body(&document.header);
    checks.opening(&document.header);
    checks.sides(&document.header, document.isym);
    checks.output(&document.header, intensity);
    checks.tilt(&document.header);
    for (index, set) in document.header.lamp_sets.iter().enumerate() {
        checks.lamps(set, HEADER + 6 * index);
    }
}

struct Checks<'c, 't, L> {
    line_of: &'c L,
    text: &'c Text<'t>,
    findings: &'c mut Findings,
}

impl<L: Fn(usize) -> usize> Checks<'_, '_, L> {
    fn say(&mut self, index: usize, code: &'static str, message: String, fix: &str) {
        let line = (self.line_of)(index);
        let raw = self.text.line(line);
        let column = raw.chars().take_while(|c| c.is_whitespace()).count() + 1;
        self.findings.push(
            Finding::warning(code, message)
                .at(line + 1, column)
                .raw(raw.trim())
                .assumed("as it stands")
                .fix(fix),
        );
    }

    /// One plane is line 3 = 1.
    fn one_plane(&mut self, document: &Document) {
        if document.c_deg.len() == 1 && document.isym != 1 {
            let message = format!("one C plane is rotational symmetry, which is 1, not {}", document.isym);
            let fix = "write 1, or compare lines 3 to 5 with the source";
            self.say(2, "ldt-isym-one-plane", message, fix);
        }
    }

    /// Lines 13–21 by themselves.
    fn body(&mut self, header: &Header) {
        for (index, value) in sizes(header) {
            if value < 0.0 {
                let message = format!("{} is {value} mm; a size is not below zero", name(index));
                self.say(index, "ldt-size", message, "correct the size");
            } else if value > LARGEST_MM {
                let message = format!("{} is {value} mm, larger than any luminaire", name(index));
                self.say(
                    index,
                    "ldt-size",
                    message,
                    "write millimetres; two lines may have changed places",
                );
            }
        }
        let (length, width) = (header.length_mm, header.width_mm);
        let rest = [width, header.height_mm];
        if length == Some(0.0)
            && let Some(other) = rest.into_iter().flatten().find(|&other| other > 0.0)
        {
            let message = format!("the length is 0, yet another size of the luminaire is {other} mm");
            let fix = "line 13 is the length, or the diameter of a round luminaire, whose width is 0";
            self.say(12, "ldt-size", message, fix);
        }
        let round_opening = header.luminous_length_mm.is_some_and(|l| l > 0.0) && header.luminous_width_mm == Some(0.0);
        if header.height_mm == Some(0.0) && width.is_some_and(|width| width > 0.0) && round_opening {
            let message = "the height is 0 and the luminous area round: width and height may have changed places";
            let fix = "write 0 as the width of a round luminaire, and its height into line 15";
            self.say(14, "ldt-size", message.to_owned(), fix);
        }
    }

    /// The luminous area is part of the luminaire.
    fn opening(&mut self, header: &Header) {
        let (Some(length), Some(width)) = (header.length_mm, header.width_mm) else {
            return;
        };
        if length <= 0.0 {
            return;
        }
        let (lum_length, lum_width) = (header.luminous_length_mm, header.luminous_width_mm);
        if lum_length == Some(0.0)
            && let Some(across) = lum_width.filter(|&across| across > 0.0)
        {
            let message = format!("the luminous area has no length, but a width of {across} mm");
            let fix = "line 16 is the length, or the diameter of a round area, whose width is 0";
            self.say(15, "ldt-size", message, fix);
        }
        let across = if width > 0.0 { width } else { length };
        // 0 stands for a height that nobody knew.
        let height = header.height_mm.filter(|&height| height > 0.0).unwrap_or(f64::INFINITY);
        let pairs = [
            (15, lum_length, length, "long"),
            (16, lum_width, across, "wide"),
            (17, header.luminous_height_mm[0], height, "high"),
            (18, header.luminous_height_mm[1], height, "high"),
            (19, header.luminous_height_mm[2], height, "high"),
            (20, header.luminous_height_mm[3], height, "high"),
        ];
        for (index, luminous, body, word) in pairs {
            let Some(luminous) = luminous else { continue };
            if luminous > body * (1.0 + LARGER.0) + LARGER.1 {
                let message = format!(
                    "{} is {luminous} mm, yet the luminaire is only {body} mm {word}",
                    name(index)
                );
                let fix = "compare lines 13 to 21 with the data sheet; two may have changed places";
                self.say(index, "ldt-size", message, fix);
            }
        }
    }

    /// Sides that the light's symmetry makes equal are equally high.
    fn sides(&mut self, header: &Header, isym: u8) {
        let [c0, c90, c180, c270] = header.luminous_height_mm;
        let mirrored: &[(usize, Option<f64>, Option<f64>, &str)] = &[
            (17, c0, c180, "C0 and C180"),
            (18, c90, c270, "C90 and C270"),
            (18, c90, c0, "C90 and C0"),
        ];
        let wanted = match isym {
            1 => mirrored,
            2 => &mirrored[1..2],
            3 => &mirrored[..1],
            4 => &mirrored[..2],
            _ => return,
        };
        let odd = wanted
            .iter()
            .find(|(_, a, b, _)| a.zip(*b).is_some_and(|(a, b)| a != b));
        if let Some((index, _, _, sides)) = odd {
            let message =
                format!("symmetry {isym} makes {sides} equal, yet the luminous sides there are not equally high");
            let fix = "compare lines 17 to 22 with the data sheet; two may have changed places";
            self.say(*index, "ldt-size", message, fix);
        }
    }

    /// A light output ratio that no light can have; others are compared with the integral.
    fn output(&mut self, header: &Header, intensity: &IntensityDistribution) {
        if let Some(lorl) = header.lorl_percent
            && lorl <= 0.0
            && !header.fractions_unstated()
            && intensity.flux().value() > 0.0
        {
            let message = format!("the light output ratio is {lorl} %, though there is light");
            self.say(
                22,
                "flux-lorl",
                message,
                "write the ratio in %, or leave the line blank",
            );
        }
    }

    fn tilt(&mut self, header: &Header) {
        match header.tilt_deg {
            Some(tilt) if tilt.abs() > 90.0 => {
                let message = format!("a tilt of {tilt}° is no position of measurement");
                self.say(
                    24,
                    "ldt-tilt",
                    message,
                    "write the tilt of the luminaire in degrees, or 0",
                );
            }
            Some(tilt) if tilt != 0.0 => {
                let message =
                    format!("the luminaire was tilted by {tilt}° as it was measured; the light is not turned back");
                self.say(
                    24,
                    "ldt-tilt",
                    message,
                    "turn the luminaire where it is used, or write 0",
                );
            }
            _ => {}
        }
    }

    /// Lines 26a–f of the set that begins at field `first`.
    fn lamps(&mut self, set: &LampSet, first: usize) {
        if let Some(count) = set.count
            && (count.fract() != 0.0 || count.abs() > MOST_LAMPS)
        {
            let message = format!("{} is no number of lamps", count.abs());
            let fix = "write a whole number, or its negative for absolute photometry";
            self.say(first, "ldt-lamp-count", message, fix);
        }
        let lamps = set.count.map_or(1.0, |count| count.abs().max(1.0));
        if let Some(flux) = set.flux_lm.filter(|&flux| ratings::dim(lamps, flux)) {
            let message = format!("{flux} lm are no flux of {lamps} lamps");
            self.say(
                first + 2,
                "ldt-lamp-flux",
                message,
                "write the flux of all lamps of the set in lm",
            );
        }
        if let Some(kelvin) = colour(&set.colour) {
            let message = format!("{kelvin} is no correlated colour temperature of a lamp in K");
            let fix = "write the colour temperature in K, or nothing";
            self.say(first + 3, "ldt-colour-temperature", message, fix);
        }
        if let Some(index) = rendering(&set.rendering) {
            let message = format!("{index} is neither a group nor an index of colour rendering");
            let fix = "write Ra, at most 100, or a group from 1A to 4";
            self.say(first + 4, "ldt-colour-rendering", message, fix);
        }
        match set.watts {
            Some(watts) if watts < 0.0 => {
                let message = format!("a power of {watts} W is below zero");
                self.say(first + 5, "ldt-power", message, "write the power with gear in W");
            }
            Some(0.0) if set.flux_lm.is_some_and(|flux| flux > 0.0) => {
                // Programs that do not know the power write 0, since others refuse a blank.
                let line = (self.line_of)(first + 5);
                let note = Finding::note("ldt-power", "the power is 0 W, though there is light");
                let note = note.at(line + 1, 1).raw(self.text.line(line).trim());
                self.findings
                    .push(note.assumed("not stated").fix("write the power with gear in W"));
            }
            Some(watts) => {
                // Absolute photometry may count in other units, as for ultraviolet: too little says nothing.
                let absolute = set.count.is_some_and(|count| count < 0.0);
                let flux = set.flux_lm.filter(|&flux| !absolute || flux > watts);
                if let Some(message) = flux.and_then(|flux| ratings::efficacy(flux, watts)) {
                    let fix = "compare lines 26c and 26f with the data sheet; two numbers may have changed places";
                    self.say(first + 5, "flux-efficacy", message, fix);
                }
            }
            None => {}
        }
    }
}

/// Fields 12–20 that are stated.
fn sizes(header: &Header) -> impl Iterator<Item = (usize, f64)> {
    let [c0, c90, c180, c270] = header.luminous_height_mm;
    let all = [
        header.length_mm,
        header.width_mm,
        header.height_mm,
        header.luminous_length_mm,
        header.luminous_width_mm,
        c0,
        c90,
        c180,
        c270,
    ];
    all.into_iter()
        .enumerate()
        .filter_map(|(at, size)| size.map(|size| (12 + at, size)))
}

const fn name(index: usize) -> &'static str {
    match index {
        12 => "the length",
        13 => "the width",
        14 => "the height",
        15 => "the length of the luminous area",
        16 => "the width of the luminous area",
        17 => "the luminous height at C0",
        18 => "the luminous height at C90",
        19 => "the luminous height at C180",
        _ => "the luminous height at C270",
    }
}

/// The number in line 26d if it stands alone, or with K, and is no colour temperature. 0 stands for a blank; three
/// digits may be a lamp's colour code (840: Ra 80–89, 4000 K).
fn colour(words: &str) -> Option<f64> {
    let words = words.trim();
    let (bare, kelvin) = match words.strip_suffix(['K', 'k']) {
        Some(bare) => (bare, true),
        None => (words, false),
    };
    let value = number::read(bare).ok()?.value;
    let code =
        !kelvin && value.fract() == 0.0 && (500.0..1000.0).contains(&value) && (18.0..=80.0).contains(&(value % 100.0));
    (value != 0.0 && !code && !(COLOUR_K.0..=COLOUR_K.1).contains(&value)).then_some(value)
}

/// The number in line 26e if it stands alone and is no colour rendering. 0 stands for a blank, 1 to 4 are groups.
fn rendering(words: &str) -> Option<f64> {
    let value = number::read(words).ok()?.value;
    let group = [0.0, 1.0, 2.0, 3.0, 4.0].contains(&value);
    (!group && !(20.0..=100.0).contains(&value)).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_as_they_are_written() {
        for good in [
            "", "0", "4000", "4000 K", "2700K", "840", "740", "nw/4200", "827", "6500", "tw",
        ] {
            assert_eq!(colour(good), None, "{good}");
        }
        for (odd, value) in [
            ("80", 80.0),
            ("450", 450.0),
            ("19800", 19_800.0),
            ("6.9", 6.9),
            ("-3000", -3000.0),
        ] {
            assert_eq!(colour(odd), Some(value), "{odd}");
        }
    }

    #[test]
    fn renderings_as_they_are_written() {
        for good in ["", "0", "1A", "1B/86", "Ra > 80", "25", "100", "3"] {
            assert_eq!(rendering(good), None, "{good}");
        }
        for (odd, value) in [
            ("4000", 4000.0),
            ("6.9", 6.9),
            ("12.1", 12.1),
            ("-1", -1.0),
            ("101", 101.0),
        ] {
            assert_eq!(rendering(odd), Some(value), "{odd}");
        }
    }
}
