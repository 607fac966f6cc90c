//! The tilt table of an LM-63 file: behind `TILT=INCLUDE`, or in the file that `TILT=` names.

use super::layout;
use super::numbers::Reader;
use crate::finding::{Finding, Findings, Severity};
use crate::options::Beside;
use crate::text::Text;

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

/// The table of a tilt file; what is wrong with it is said at the line of the file that names it.
pub(super) fn tilt_file(
    name: &str,
    place: (usize, usize),
    beside: Beside<'_>,
    findings: &mut Findings,
) -> Option<TiltFactors> {
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

impl Reader<'_, '_> {
    /// Factors of a tilt table and the index of the number after it.
    pub(super) fn tilt(&mut self) -> Option<(TiltFactors, usize)> {
        let geometry = self.number(0, "lamp-to-luminaire geometry", "ies-tilt-number")?;
        let count = self.number(1, "the number of tilt angles", "ies-tilt-number")?;
        if count.fract() != 0.0 || !(1.0..=10_000.0).contains(&count) || ![1.0, 2.0, 3.0].contains(&geometry) {
            let message = "geometry 1 to 3 and a number of tilt angles are needed after TILT=INCLUDE";
            self.push(
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
            self.push(
                3 + at,
                Finding::error("ies-tilt-angles", message).fix("correct the tilt table"),
            );
            return None;
        }
        let finding = Finding::warning("ies-tilt-factors", "tilt factors are given")
            .assumed("kept, not applied: the candela are those of the measured position");
        self.push(2 + count, finding);
        let tilt = TiltFactors {
            geometry,
            angle_deg,
            factor,
        };
        Some((tilt, 2 + 2 * count))
    }
}
