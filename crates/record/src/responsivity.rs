//! Curves over wavelength beside a station that its lux meter names: what its head answers, and the light under which
//! it was calibrated. A run keeps their numbers in run.toml, whose checksum speaks for every digit.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use crate::disk::sha256;
use crate::table::{Fields, ObservationError, Problem, Table};

/// A curve reaches at least so far: what is outside its table counts as zero.
const VISIBLE_NM: [f64; 2] = [380.0, 780.0];
/// Its points are at most so far apart.
const WIDEST_STEP_NM: f64 = 20.0;

/// The curves of a run's lux meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeterCurves {
    /// Relative spectral responsivity of the head.
    pub responsivity: WavelengthCurve,
    /// Relative spectrum of the light under which the calibration factor holds; none for CIE standard illuminant A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_light: Option<WavelengthCurve>,
}

/// A relative curve over wavelength, as its file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WavelengthCurve {
    /// Name of the file.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Wavelengths in nm, rising.
    pub wavelength_nm: Vec<f64>,
    /// Values, one a wavelength, in a unit of their own.
    pub value: Vec<f64>,
    /// Relative standard uncertainty of each value (k = 1); empty where the file states none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub u_rel: Vec<f64>,
}

impl WavelengthCurve {
    /// The relative spectral responsivity of a head: `wavelength_nm`, `responsivity` and, where they are known,
    /// `u_rel`. A line that begins with `#` is a comment.
    ///
    /// # Errors
    /// [`ObservationError`] with line for a missing column, numbers that are none, wavelengths that do not rise or
    /// leave out a part of 380 nm to 780 nm.
    pub fn responsivity(file: &Utf8Path, text: &str) -> Result<Self, ObservationError> {
        Self::parse(file, text, "responsivity")
    }

    /// The relative spectrum of a light: `wavelength_nm` and `power`.
    ///
    /// # Errors
    /// As [`responsivity`](Self::responsivity).
    pub fn light(file: &Utf8Path, text: &str) -> Result<Self, ObservationError> {
        Self::parse(file, text, "power")
    }

    fn parse(file: &Utf8Path, text: &str, column: &'static str) -> Result<Self, ObservationError> {
        let without_comments = |line| if str::starts_with(line, '#') { "" } else { line };
        let lines: Vec<&str> = text.lines().map(without_comments).collect();
        let table = Table::parse(file, &lines.join("\n"), false)?;
        let columns = table.columns_with(file, &["wavelength_nm", column])?;
        let states_u = columns.contains_key("u_rel");
        let (mut wavelength_nm, mut value, mut u_rel) = (Vec::new(), Vec::new(), Vec::new());
        for fields in table.rows(file, &columns) {
            wavelength_nm.push(next_wavelength(&fields, wavelength_nm.last().copied())?);
            value.push(fields.within(column, 0.0, 1e9, "within 0 to 1e9")?);
            if states_u {
                u_rel.push(fields.within("u_rel", 0.0, 0.5, "a fraction within 0 to 0.5")?);
            }
        }
        let wrong = |problem| Err(ObservationError::new(file, None, problem));
        let Some(&last_nm) = wavelength_nm.last() else {
            return wrong(Problem::NoRows("wavelengths"));
        };
        if last_nm < VISIBLE_NM[1] {
            return wrong(Problem::OutOfRange {
                column: "wavelength_nm",
                found: last_nm,
                expected: "up to 780 nm at least: what is outside the table counts as zero",
            });
        }
        if value.iter().all(|value| *value == 0.0) {
            return wrong(Problem::OutOfRange {
                column,
                found: 0.0,
                expected: "above zero at some wavelength",
            });
        }
        Ok(Self {
            file: file.file_name().unwrap_or(file.as_str()).to_owned(),
            sha256: sha256(text.as_bytes()),
            wavelength_nm,
            value,
            u_rel,
        })
    }
}

/// The wavelength of a row, which follows `before_nm`.
fn next_wavelength(fields: &Fields<'_>, before_nm: Option<f64>) -> Result<f64, ObservationError> {
    let column = "wavelength_nm";
    let nm = fields.within(column, 100.0, 10_000.0, "within 100 to 10000 nm")?;
    let Some(before_nm) = before_nm else {
        return fields.require(
            nm <= VISIBLE_NM[0],
            column,
            nm,
            "380 nm at most in the first row: what is outside the table counts as zero",
        );
    };
    fields.above(column, before_nm)?;
    let near = nm - before_nm <= WIDEST_STEP_NM || before_nm >= VISIBLE_NM[1] || nm <= VISIBLE_NM[0];
    fields.require(
        near,
        column,
        nm,
        "at most 20 nm above that of the row before, from 380 nm to 780 nm",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(row: impl Fn(f64) -> String) -> String {
        let rows = (0..=40).map(|k| row(380.0 + 10.0 * f64::from(k)));
        rows.fold(
            "# of the institute\nwavelength_nm,responsivity,u_rel\n".to_owned(),
            |text, row| text + &row + "\n",
        )
    }

    fn bell(nm: f64) -> String {
        format!("{nm},{:.6},0.01", (-((nm - 555.0) / 60.0).powi(2)).exp())
    }

    #[test]
    fn a_curve_is_kept_as_its_file_has_it() {
        let file = Utf8Path::new("lab/head.csv");
        let curve = WavelengthCurve::responsivity(file, &text(bell)).unwrap();
        assert_eq!((curve.file.as_str(), curve.wavelength_nm.len()), ("head.csv", 41));
        assert_eq!((curve.wavelength_nm[40], curve.u_rel[40]), (780.0, 0.01));
        assert_eq!(curve.sha256, sha256(text(bell).as_bytes()));
        let curves = MeterCurves {
            responsivity: curve,
            calibration_light: None,
        };
        let written = toml::to_string(&curves).unwrap();
        assert_eq!(toml::from_str::<MeterCurves>(&written).unwrap(), curves);
    }

    #[test]
    fn what_is_no_curve_of_a_head_is_refused_with_its_line() {
        let of = |text: &str| {
            let file = Utf8Path::new("head.csv");
            WavelengthCurve::responsivity(file, text).unwrap_err().to_string()
        };
        let one = |at: f64, other: &'static str| text(|nm| if nm == at { other.to_owned() } else { bell(nm) });
        for (text, expected) in [
            (
                text(bell).replace("responsivity", "response"),
                "head.csv:1: column `responsivity` is missing",
            ),
            (
                one(380.0, "400,0.1,0.01"),
                "head.csv:3: `wavelength_nm` = 400: it must be 380 nm at most",
            ),
            (
                one(400.0, "390,0.1,0.01"),
                "head.csv:5: `wavelength_nm` = 390: it must be above that",
            ),
            (
                one(500.0, "500,x,0.01"),
                "head.csv:15: `responsivity` = `x` is no finite number",
            ),
            (
                one(500.0, "500,-0.1,0.01"),
                "head.csv:15: `responsivity` = -0.1: it must be within",
            ),
            (
                one(500.0, "500,0.3,0.9"),
                "head.csv:15: `u_rel` = 0.9: it must be a fraction",
            ),
            (
                one(500.0, "500,0.3"),
                "head.csv:15: has 2 fields where the header has 3",
            ),
            (
                text(|nm| {
                    if (500.0..600.0).contains(&nm) {
                        String::new()
                    } else {
                        bell(nm)
                    }
                }),
                "`wavelength_nm` = 600: it must be at most 20 nm above",
            ),
            (
                text(|nm| if nm > 700.0 { String::new() } else { bell(nm) }),
                "head.csv: `wavelength_nm` = 700: it must be up to 780 nm",
            ),
            (text(|nm| format!("{nm},0,0")), "above zero at some wavelength"),
            ("wavelength_nm,responsivity\n".to_owned(), "holds no wavelengths"),
        ] {
            let message = of(&text);
            assert!(message.contains(expected), "{message}\n{expected}");
        }
    }
}
