//! The thirteen numbers of an LM-63 file: lamp, geometry, factors on the candela.

use super::edition::Edition;
use super::layout::Layout;
use super::numbers::Reader;
use crate::finding::Finding;
use crate::options::ReadOptions;

/// More lamps than this are another number.
const MOST_LAMPS: f64 = 1000.0;

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

impl Reader<'_, '_> {
    /// The thirteen numbers and the factor on every candela value.
    pub(super) fn lamp(
        &mut self,
        start: usize,
        layout: &Layout,
        edition: Edition,
        options: ReadOptions,
    ) -> Option<(Lamp, f64)> {
        const CODE: &str = "ies-header-number";
        let count = self.number(start, "the number of lamps", CODE);
        if let Some(odd) = count.filter(|count| count.fract() != 0.0 || !(1.0..=MOST_LAMPS).contains(count)) {
            let finding = Finding::warning("ies-lamp-count", format!("{odd} is no number of lamps"));
            let fix = "write a whole number from 1; the lumens of one lamp stand second";
            self.push(start, finding.assumed("as it stands").fix(fix));
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
            self.push(start + 1, finding);
        }
        let multiplier = self.number(start + 2, "the candela multiplier", CODE);
        let photometric_type = match self.number(start + 5, "the photometric type", CODE)? {
            1.0 => 'C',
            2.0 => 'B',
            3.0 => 'A',
            _ => {
                let finding = Finding::error("ies-type", "the photometric type must be 1 (C), 2 (B) or 3 (A)");
                self.push(start + 5, finding.fix("correct the sixth of the ten numbers"));
                return None;
            }
        };
        let (units, metres) = match self.number(start + 6, "the unit of the dimensions", CODE) {
            Some(1.0) => ("feet", Some(0.3048)),
            Some(2.0) => ("metres", Some(1.0)),
            Some(_) => {
                let finding = Finding::error("ies-units", "the unit of the dimensions must be 1 (feet) or 2 (metres)");
                self.push(start + 6, finding.assumed("no dimensions"));
                ("unknown", None)
            }
            None => ("unknown", None),
        };
        let opening = [7, 8, 9].map(|offset| self.number(start + offset, "a dimension of the opening", CODE));
        let at = layout.factors;
        let ballast = self.number(at, "the ballast factor", CODE);
        let third = self.number(at + 1, "the photometric factor", CODE);
        let watts = self.number(at + 2, "input watts", CODE);
        let third_text = self.tokens.get(at + 1).map(|token| token.text.to_owned());
        if let Some(odd) = watts.filter(|&watts| watts < 0.0) {
            let finding = Finding::warning("ies-watts", format!("{odd} W input power"));
            self.push(at + 2, finding.assumed("as it stands"));
        }
        let (multiplier, ballast_factor) = (multiplier?, ballast?);
        let mut factor = self.factor(start + 2, multiplier, "the candela multiplier", "ies-multiplier")?;
        factor *= self.factor(at, ballast_factor, "the ballast factor", "ies-ballast-factor")?;
        factor *= self.third(at + 1, third, edition, options)?;
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
            self.push(
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
            self.push(
                index,
                finding
                    .assumed("a factor on every candela value")
                    .fix("check the order of the numbers"),
            );
        } else if factor != 1.0 {
            self.push(
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
                        self.push(
                            index,
                            Finding::error(code, message).fix("it cannot multiply the candela"),
                        );
                        return None;
                    }
                    self.push(
                        index,
                        Finding::warning(code, message).assumed("multiplied, as asked for"),
                    );
                    return Some(value);
                }
                let finding = Finding::warning(code, message).assumed("not multiplied");
                self.push(
                    index,
                    finding.fix("--apply-future-use multiplies every candela value by it"),
                );
                Some(1.0)
            }
            Edition::E2019 => {
                if !(1.0..1.2).contains(&value) {
                    let finding =
                        Finding::warning("ies-generation", "this is no file generation type (1.00000 to 1.11100)");
                    self.push(index, finding.assumed("not known"));
                }
                Some(1.0)
            }
        }
    }
}
