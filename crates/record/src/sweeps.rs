//! `sweeps/NNN.csv`: one sweep of γ, or of C around a ring, as it was read, positions and light with the instants of
//! request and answer.
//!
//! No number in it is corrected: what the light belongs to is computed from it by the reduction, and can be computed
//! again by a better one.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use crate::disk::sha256;
use crate::plan::Way;
use crate::row_crc;
use crate::table::{ObservationError, Problem};

/// First line of a file, before the sweep's description.
const FIRST: &str = "# isolux-sweep/1";
/// Columns of the samples.
const COLUMNS: &str = "what,asked_s,answered_s,value,digit,raw,crc32";

/// One sweep: the description, and what was read in the order of its answers.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRecord {
    /// What it is.
    pub of: SweepOf,
    /// Positions of the axis that moved.
    pub positions: Vec<PositionSample>,
    /// Conversions of the lux meter.
    pub light: Vec<LightSample>,
}

/// What a sweep is: everything but its samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepOf {
    /// Number in the run, from 0; names the file.
    pub index: u64,
    /// Name of the plan's block.
    pub block: String,
    /// Number of the point in the plan.
    pub point: u64,
    /// Why it ended before its end or cannot be used; none for a whole sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torn: Option<String>,
    /// Half-plane at which C rests, read back, degrees; of a ring C at its beginning.
    pub c_deg: f64,
    /// The half-plane of the plan, degrees; of a ring C at its beginning.
    pub c_target_deg: f64,
    /// C at its end, where the sweep is a ring: C moved while γ rested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ring_to_c_deg: Option<f64>,
    /// First and last γ of the plan on the way, degrees: what lies outside belongs to run-up and run-out. Of a ring
    /// its γ twice.
    pub gamma_deg: [f64; 2],
    /// Cruising speed as the drive has taken it, °/s.
    pub speed_deg_s: f64,
    /// Distance of the detector, mm.
    pub distance_mm: f64,
    /// Range of the meter, held through the sweep.
    pub range: i32,
    /// Light of so long is in each conversion, s.
    pub integration_s: f64,
    /// A new conversion about so often by a clock of the meter's own, s, of which an answer gives the last one; none
    /// where each begins with its request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update_interval_s: Option<f64>,
    /// Seconds of the run at which the lamp was switched on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp_on_s: Option<f64>,
    /// Temperature of the room in °C, where it is measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient_c: Option<f64>,
    /// Number of the session, and of the burning of the lamp.
    pub session: u32,
    /// Number of the burning of the lamp.
    pub burning: u32,
}

/// Where the axis was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionSample {
    /// Seconds of the run at which its answer was complete.
    pub answered_s: f64,
    /// Place by the axis' own count, degrees.
    pub place_deg: f64,
}

/// One conversion of the meter.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSample {
    /// Seconds of the run at which its request was on the line.
    pub asked_s: f64,
    /// Seconds of the run at which its answer was complete, or was given up.
    pub answered_s: f64,
    /// Illuminance as the meter said it, times its calibration factor, lx; none where there is no number, or where one
    /// cannot be relied on.
    pub illuminance_lx: Option<f64>,
    /// One digit, lx.
    pub digit_lx: f64,
    /// The answer's bytes in hexadecimal digits; why there is no number where there are none.
    pub raw: String,
}

/// A sweep in run.toml.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepEntry {
    /// Its number, which names the file.
    pub index: u64,
    /// Number of the point in the plan.
    pub point: u64,
    /// Kept as evidence, and repeated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub torn: bool,
    /// Conversions in it.
    pub samples: u64,
    /// SHA-256 of the file.
    pub sha256: String,
}

impl SweepEntry {
    /// The file's name in the run.
    pub fn file(&self) -> String {
        format!("sweeps/{:03}.csv", self.index)
    }
}

impl SweepOf {
    /// What it went along.
    pub fn way(&self) -> Way {
        match self.ring_to_c_deg {
            Some(to) => Way::Ring {
                gamma_deg: self.gamma_deg[0],
                c_deg: [self.c_target_deg, to],
            },
            None => Way::HalfPlane {
                c_deg: self.c_target_deg,
                gamma_deg: self.gamma_deg,
            },
        }
    }

    /// What its positions are called in the file.
    fn place(&self) -> &'static str {
        if self.ring_to_c_deg.is_some() {
            "c_deg"
        } else {
            "gamma_deg"
        }
    }
}

impl SweepRecord {
    /// Its entry in run.toml, for the bytes of its file.
    pub fn entry(&self, bytes: &[u8]) -> SweepEntry {
        SweepEntry {
            index: self.of.index,
            point: self.of.point,
            torn: self.of.torn.is_some(),
            samples: self.light.len() as u64,
            sha256: sha256(bytes),
        }
    }

    /// The file's bytes: the description as TOML behind `#`, then one row a sample with a checksum of its own.
    ///
    /// # Errors
    /// A description that TOML cannot hold.
    pub fn to_csv(&self) -> Result<String, toml::ser::Error> {
        let described = toml::to_string(&self.of)?;
        let mut text = format!("{FIRST}\n");
        for line in described.lines() {
            text += &format!("# {line}\n");
        }
        text += &format!("{COLUMNS}\n");
        let place = self.of.place();
        let mut rows: Vec<(f64, String)> = Vec::with_capacity(self.positions.len() + self.light.len());
        for sample in &self.positions {
            let row = format!("{place},,{},{},,,", sample.answered_s, sample.place_deg + 0.0);
            rows.push((sample.answered_s, row));
        }
        for sample in &self.light {
            let value = sample
                .illuminance_lx
                .map_or_else(String::new, |value| value.to_string());
            let LightSample {
                asked_s,
                answered_s,
                digit_lx,
                raw,
                ..
            } = sample;
            // Words of an instrument may have anything in them.
            let raw = raw.replace([',', '\n', '\r', '"'], " ");
            rows.push((
                *answered_s,
                format!("illuminance_lx,{asked_s},{answered_s},{value},{digit_lx},{raw},"),
            ));
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, row) in rows {
            text += &format!("{row}{}\n", row_crc::of(row.as_bytes()));
        }
        Ok(text)
    }

    /// Parses a file of `sweeps/`.
    ///
    /// # Errors
    /// [`ObservationError`] with the line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, ObservationError> {
        let fault = |line: usize, what: String| ObservationError::new(file, Some(line as u64), Problem::Record(what));
        let mut lines = text.lines().enumerate().map(|(place, line)| (place + 1, line));
        if lines.next().is_none_or(|(_, first)| first != FIRST) {
            return Err(fault(1, format!("not a sweep of a run: it begins with `{FIRST}`")));
        }
        let mut described = String::new();
        let head = lines.by_ref().find(|(_, line)| match line.strip_prefix("# ") {
            Some(line) => {
                described += line;
                described += "\n";
                false
            }
            None => true,
        });
        match head {
            Some((_, COLUMNS)) => {}
            Some((line, other)) => return Err(fault(line, format!("`{other}` are not the columns {COLUMNS}"))),
            None => return Err(fault(1, "has no samples".to_owned())),
        }
        let of: SweepOf = toml::from_str(&described).map_err(|error| fault(2, error.message().to_owned()))?;
        let (mut positions, mut light) = (Vec::new(), Vec::new());
        for (line, row) in lines {
            let fields: Vec<&str> = row.split(',').collect();
            let [what, requested, answered, value, digit, raw, _] = fields.as_slice() else {
                return Err(fault(line, format!("{} columns, expected 7", fields.len())));
            };
            row_crc::covered(row.as_bytes())
                .map_err(|_| fault(line, "the row is damaged: its checksum is another".to_owned()))?;
            let number = |field: &str| match field.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(fault(line, format!("`{field}` is no finite number"))),
            };
            let answered_s = number(answered)?;
            match *what {
                what if what == of.place() => positions.push(PositionSample {
                    answered_s,
                    place_deg: number(value)?,
                }),
                "illuminance_lx" => light.push(LightSample {
                    asked_s: number(requested)?,
                    answered_s,
                    illuminance_lx: if value.is_empty() { None } else { Some(number(value)?) },
                    digit_lx: number(digit)?,
                    raw: (*raw).to_owned(),
                }),
                other => {
                    return Err(fault(
                        line,
                        format!("`{other}` is neither {} nor illuminance_lx", of.place()),
                    ));
                }
            }
        }
        Ok(Self { of, positions, light })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn sweep(index: u64) -> SweepRecord {
        SweepRecord {
            of: SweepOf {
                index,
                block: "lit".to_owned(),
                point: 3,
                torn: None,
                c_deg: 14.999,
                c_target_deg: 15.0,
                ring_to_c_deg: None,
                gamma_deg: [-180.0, 180.0],
                speed_deg_s: 10.0,
                distance_mm: 3700.0,
                range: 4,
                integration_s: 0.1,
                update_interval_s: None,
                lamp_on_s: Some(2.5),
                ambient_c: None,
                session: 0,
                burning: 1,
            },
            positions: (0..5)
                .map(|k| PositionSample {
                    answered_s: 100.0 + f64::from(k),
                    place_deg: 10.0 * f64::from(k) - 20.0,
                })
                .collect(),
            light: (0..4)
                .map(|k| LightSample {
                    asked_s: 100.1 + f64::from(k),
                    answered_s: 100.25 + f64::from(k),
                    illuminance_lx: (k != 2).then_some(3.25),
                    digit_lx: 0.01,
                    raw: if k == 2 { "no answer" } else { "2b0a" }.to_owned(),
                })
                .collect(),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let sweep = sweep(7);
        let text = sweep.to_csv().unwrap();
        assert_eq!(SweepRecord::parse(Utf8Path::new("s.csv"), &text).unwrap(), sweep);
        assert_eq!(sweep.entry(text.as_bytes()).file(), "sweeps/007.csv");
    }

    #[test]
    fn a_ring_has_positions_of_c() {
        let mut ring = sweep(7);
        (ring.of.c_target_deg, ring.of.ring_to_c_deg, ring.of.gamma_deg) = (0.0, Some(360.0), [20.0, 20.0]);
        let text = ring.to_csv().unwrap();
        assert!(
            text.contains("\nc_deg,,100,-20,") && !text.contains("\ngamma_deg,"),
            "{text}"
        );
        let read = SweepRecord::parse(Utf8Path::new("s.csv"), &text).unwrap();
        assert_eq!(read, ring);
        assert_eq!(read.of.way().at_deg(90.0), (90.0, 20.0));
        let mixed = text.replace("# ring_to_c_deg = 360.0\n", "");
        assert!(SweepRecord::parse(Utf8Path::new("s.csv"), &mixed).is_err());
    }

    #[test]
    fn one_changed_sign_is_noticed_with_its_line() {
        let text = sweep(0).to_csv().unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let first = lines.iter().position(|line| line.starts_with("gamma_deg,")).unwrap();
        for line in first..lines.len() {
            let mut changed: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
            changed[line] = changed[line].replacen('1', "2", 1);
            if changed[line] == lines[line] {
                continue;
            }
            let error = SweepRecord::parse(Utf8Path::new("s.csv"), &changed.join("\n")).unwrap_err();
            assert!(
                error.to_string().starts_with(&format!("s.csv:{}:", line + 1)),
                "{error}"
            );
        }
        assert!(SweepRecord::parse(Utf8Path::new("s.csv"), "").is_err());
        assert!(SweepRecord::parse(Utf8Path::new("s.csv"), &text.replace("range", "rank")).is_err());
    }
}
