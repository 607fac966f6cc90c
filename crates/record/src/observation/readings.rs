//! Goniometer readings from any CSV with the columns of a run.

use std::collections::HashMap;

use camino::{Utf8Path, Utf8PathBuf};

use super::need::Need;
use crate::readings::{Layout, NAMES};
use crate::run::Run;
use crate::run::axis::Axis;
use crate::table::{Fields, ObservationError, Problem, Table, read_text};
use crate::{Quality, ReadingKind};

/// Where, when and how a reading was taken: all that a prediction needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingCoordinates {
    /// What the detector could see.
    pub kind: ReadingKind,
    /// Middle of the integration, in seconds on the time axis of the record; none: not known.
    pub time_s: Option<f64>,
    /// The same since the lamp was switched on; none: not known, the record began with it.
    pub lamp_s: Option<f64>,
    /// Read-back C in degrees.
    pub c_deg: f64,
    /// Read-back γ in degrees, signed.
    pub gamma_deg: f64,
    /// From the intersection of the axes to the detector's reference plane.
    pub distance_mm: f64,
    /// Sign of the last γ motion; 0: none or not known, and no backlash applies.
    pub travel: i8,
    /// The meter's range, where it is known.
    pub range: Option<i32>,
    /// Temperature of the room in °C, where it is known.
    pub ambient_c: Option<f64>,
    /// Which photometer head: 0 is the one with which the model was measured, or the only one.
    pub head: u32,
}

impl ReadingCoordinates {
    /// For how long the lamp had been on, in seconds: since it was switched on where that is known, else since the
    /// record began; none: not known, the lamp counts as stable.
    pub fn lamp_age_s(&self) -> Option<f64> {
        self.lamp_s.or(self.time_s)
    }
}

/// One row of observations.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingRow {
    /// One-based line in the file.
    pub line: u64,
    /// The row's own number, where it has one.
    pub index: Option<i64>,
    /// Name of the plan's block; empty where there is none.
    pub block: String,
    /// Where and when.
    pub at: ReadingCoordinates,
    /// What was read; present with [`Need::Values`] exactly when `quality` is ok.
    pub illuminance_lx: Option<f64>,
    /// Its stated standard uncertainty, above zero where present.
    pub u_lx: Option<f64>,
    /// What the reading is worth.
    pub quality: Quality,
}

/// A file of readings, with every column as it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Readings {
    path: Utf8PathBuf,
    header: Vec<String>,
    text: Vec<Vec<String>>,
    rows: Vec<ReadingRow>,
    luxmeter: Option<String>,
    notices: Vec<String>,
}

/// The columns that say where and when: the first of those of a run.
const COORDINATES: usize = 10;
/// The highest number of a photometer head.
const MOST_HEADS: i64 = 15;

impl Readings {
    /// Readings that are in no file.
    pub fn of(rows: Vec<ReadingRow>) -> Self {
        Self {
            path: Utf8PathBuf::new(),
            header: Vec::new(),
            text: vec![Vec::new(); rows.len()],
            rows,
            luxmeter: None,
            notices: Vec::new(),
        }
    }

    /// Readings from a CSV file.
    ///
    /// # Errors
    /// [`ObservationError`]: a missing column, a field that is no number, an uncertainty that is not positive, an index
    /// that is there twice, a row whose checksum does not fit.
    pub fn open(path: &Utf8Path, need: Need) -> Result<Self, ObservationError> {
        Self::parse(path, &read_text(path)?, need, false)
    }

    /// Readings of a run directory, compared with what was recorded: a last line that a power cut tore is left out. A
    /// folder with the readings of another program has no run.toml and is taken as it is.
    pub(super) fn open_run(folder: &Utf8Path, need: Need) -> Result<Self, ObservationError> {
        let path = folder.join("readings.csv");
        let failed = |problem| ObservationError::new(folder, None, problem);
        if folder.join("run.toml").is_file() {
            let run = Run::read(folder).map_err(|error| failed(Problem::Record(error.to_string())))?;
            let text = read_text(&path)?;
            let whole = text.get(..run.readings.whole_bytes).unwrap_or(&text);
            let mut readings = Self::parse(&path, whole, need, false)?;
            // A run of an older format has its times from run.toml.
            for (row, of_run) in readings.rows.iter_mut().zip(&run.readings.rows) {
                (row.at.time_s, row.at.lamp_s) = (of_run.time_s, of_run.lamp_s);
            }
            readings.luxmeter = run.header.luxmeter_name();
            readings.notices = run.notices;
            return Ok(readings);
        }
        if !path.is_file() {
            return Err(failed(Problem::NotARun));
        }
        let text = read_text(&path)?;
        let of_a_run = |layout: &Layout| text.starts_with(&layout.header());
        if Layout::ALL.iter().any(of_a_run) {
            return Err(failed(Problem::NoRunToml));
        }
        Self::parse(&path, &text, need, true)
    }

    /// What a person should know of the record that they come from.
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    fn parse(path: &Utf8Path, text: &str, need: Need, torn_tail: bool) -> Result<Self, ObservationError> {
        let table = Table::parse(path, text, torn_tail)?;
        let values: &[&str] = match need {
            Need::Values => &["illuminance_lx", "u_lx"],
            Need::Coordinates => &[],
        };
        let columns = table.columns_with(path, &[&NAMES[..COORDINATES], values].concat())?;
        let checksum_is_last = table.header.last().is_some_and(|name| name == "row_crc");
        let mut rows = Vec::new();
        let mut lines_of: HashMap<i64, u64> = HashMap::new();
        for fields in table.rows(path, &columns) {
            if checksum_is_last {
                fields.checked()?;
            }
            let parsed = parse_row(&fields, need)?;
            if let Some(index) = parsed.index
                && let Some(first) = lines_of.insert(index, fields.line())
            {
                return Err(fields.error(Problem::Duplicate {
                    what: format!("index {index}"),
                    first,
                }));
            }
            rows.push(parsed);
        }
        if rows.is_empty() {
            return Err(ObservationError::new(path, None, Problem::NoRows("readings")));
        }
        if columns.contains_key("burning") && !columns.contains_key("lamp_s") {
            let burning = table
                .rows(path, &columns)
                .map(|fields| fields.text("burning").parse().ok());
            place(&mut rows, &burning.collect::<Vec<_>>());
        }
        let (header, text) = table.into_text();
        Ok(Self {
            path: path.to_owned(),
            header,
            text,
            rows,
            luxmeter: None,
            notices: Vec::new(),
        })
    }

    /// The file.
    pub fn path(&self) -> &Utf8Path {
        &self.path
    }

    /// Column names as written.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// The fields of each row as written, in the order of [`header`](Self::header).
    pub fn text(&self) -> &[Vec<String>] {
        &self.text
    }

    /// The rows.
    pub fn rows(&self) -> &[ReadingRow] {
        &self.rows
    }

    /// Model and serial number of the lux meter, where the record of a run has them.
    pub fn luxmeter(&self) -> Option<&str> {
        self.luxmeter.as_deref()
    }

    /// Says which photometer head took them all.
    pub fn set_head(&mut self, head: u32) {
        self.rows.iter_mut().for_each(|row| row.at.head = head);
    }

    /// The readings but for these rows, counted from 0 and rising.
    #[must_use]
    pub fn without_rows(&self, left_out: &[usize]) -> Self {
        fn rest<T: Clone>(all: &[T], left_out: &[usize]) -> Vec<T> {
            let rows = all.iter().enumerate();
            rows.filter(|(index, _)| left_out.binary_search(index).is_err())
                .map(|(_, row)| row.clone())
                .collect()
        }
        Self {
            path: self.path.clone(),
            header: self.header.clone(),
            text: rest(&self.text, left_out),
            rows: rest(&self.rows, left_out),
            luxmeter: self.luxmeter.clone(),
            notices: self.notices.clone(),
        }
    }

    /// Where and when each reading was taken.
    pub fn coordinates(&self) -> Vec<ReadingCoordinates> {
        self.rows.iter().map(|row| row.at).collect()
    }
}

/// Readings of a run of format 3 without their run.toml: their times are those of the lamp, which begin anew with
/// every burning.
fn place(rows: &mut [ReadingRow], burnings: &[Option<u32>]) {
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|&row| rows[row].index);
    let mut axis = Axis::default();
    for row in order {
        let at = &mut rows[row].at;
        at.lamp_s = at.time_s;
        at.time_s = Some(axis.next(burnings[row], at.lamp_s, 0.0, None));
    }
}

fn parse_row(fields: &Fields<'_>, need: Need) -> Result<ReadingRow, ObservationError> {
    let kind = fields.word("kind")?;
    let quality = match fields.text("quality") {
        "" => Quality::Ok,
        _ => fields.word("quality")?,
    };
    // What an axis reads back at 180° may lie beyond it by its tolerance, which is 1° at most.
    let gamma_deg = fields.within("gamma_deg", -181.0, 181.0, "between -181 and 181")?;
    let travel = fields.whole("travel")?.unwrap_or(0);
    fields.require((-1..=1).contains(&travel), "travel", travel as f64, "-1, 0 or 1")?;
    let head = fields.whole("head")?.unwrap_or(0);
    fields.require((0..=MOST_HEADS).contains(&head), "head", head as f64, "0 to 15")?;
    let (illuminance_lx, u_lx) = match (need, quality) {
        (Need::Values, Quality::Ok) => (Some(fields.number("illuminance_lx")?), Some(fields.positive("u_lx")?)),
        (Need::Values | Need::Coordinates, _) => (None, None),
    };
    Ok(ReadingRow {
        line: fields.line(),
        index: fields.whole("index")?,
        block: fields.text("block").to_owned(),
        at: ReadingCoordinates {
            kind,
            time_s: fields.optional("time_s")?,
            lamp_s: fields.optional("lamp_s")?,
            c_deg: fields.number("c_deg")?,
            gamma_deg,
            distance_mm: fields.positive("distance_mm")?,
            travel: travel as i8,
            range: fields.whole("range")?.map(|range| range as i32),
            ambient_c: fields.optional("ambient_c")?,
            head: head as u32,
        },
        illuminance_lx,
        u_lx,
        quality,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str =
        "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx\n";

    fn read(rows: &str, need: Need) -> Result<Readings, ObservationError> {
        Readings::parse(Utf8Path::new("r.csv"), &format!("{HEADER}{rows}"), need, false)
    }

    #[test]
    fn reads_what_a_run_writes() {
        let readings = read(
            "7,A,lit,252.0,0.0,-70.0,2000.0,1,0,,0.28,0.01\n8,A,capped,,0,0,2000,0,,,-0.1,0.01\n",
            Need::Values,
        )
        .unwrap();
        let row = &readings.rows()[0];
        assert_eq!(
            (row.line, row.index, row.at.gamma_deg, row.at.travel),
            (2, Some(7), -70.0, 1)
        );
        assert_eq!(row.at.ambient_c, None);
        assert_eq!(
            readings.rows()[1].illuminance_lx,
            Some(-0.1),
            "a negative reading is data"
        );
        assert_eq!(readings.rows()[1].at.time_s, None);
    }

    #[test]
    fn an_axis_may_stand_beyond_the_pole_by_its_tolerance() {
        let row = |gamma_deg: &str| format!("0,A,lit,1,0,{gamma_deg},2000,1,0,,1,1\n");
        let readings = read(&row("180.0001"), Need::Values).unwrap();
        assert_eq!(readings.rows()[0].at.gamma_deg, 180.0001);
        let refused = read(&row("-181.5"), Need::Values).unwrap_err().to_string();
        assert_eq!(
            refused,
            "r.csv:2: `gamma_deg` = -181.5: it must be between -181 and 181"
        );
    }

    #[test]
    fn says_file_line_and_what_is_wrong() {
        let complaint = |rows: &str| read(rows, Need::Values).unwrap_err().to_string();
        assert_eq!(
            complaint("0,A,lit,1,0,0,2000,1,0,,NaN,0.01\n"),
            "r.csv:2: `illuminance_lx` = `NaN` is no finite number"
        );
        assert_eq!(
            complaint("0,A,lit,1,0,0,2000,1,0,,1,0\n"),
            "r.csv:2: `u_lx` = 0: it must be above zero"
        );
        assert_eq!(
            complaint("0,A,lit,1,0,0,2000,1,0,,1,1\n0,A,lit,1,0,0,2000,1,0,,1,1\n"),
            "r.csv:3: index 0 is there twice; the first is on line 2"
        );
        assert_eq!(
            complaint("0,A,lit,1,0,0,2000,1,0,,1\n"),
            "r.csv:2: has 11 fields where the header has 12"
        );
        assert_eq!(
            complaint("0,A,dark,1,0,0,2000,1,0,,1,1\n"),
            "r.csv:2: `kind` = `dark` is none of lit, baffled, lamp_off, capped"
        );
        assert_eq!(complaint(""), "r.csv: holds no readings");
    }

    #[test]
    fn a_prediction_needs_no_values_and_keeps_extra_columns() {
        let text = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,true_illuminance_lx\n\
                    43,A,lit,396.0,15.0,70.0,2000.0,-1,0,24.75,0.27655843\n";
        let path = Utf8Path::new("h.csv");
        let readings = Readings::parse(path, text, Need::Coordinates, false).unwrap();
        assert_eq!(readings.text()[0][10], "0.27655843");
        let refused = Readings::parse(path, text, Need::Values, false).unwrap_err();
        assert!(matches!(
            refused.problem,
            Problem::MissingColumn {
                column: "illuminance_lx",
                ..
            }
        ));
    }

    #[test]
    fn a_copy_of_an_older_run_has_one_axis_and_the_age_of_the_lamp() {
        let header = format!("{},burning\n", HEADER.trim_end());
        let row =
            |index: u32, time_s: &str, burning: u32| format!("{index},A,lit,{time_s},0,0,2000,1,0,,1,1,{burning}\n");
        // In another order than they were taken in.
        let rows = [
            row(2, "1800", 2),
            row(0, "1800", 1),
            row(3, "1810", 2),
            row(1, "1810", 1),
        ];
        let readings =
            Readings::parse(Utf8Path::new("r.csv"), &(header + &rows.concat()), Need::Values, false).unwrap();
        let times: Vec<_> = readings
            .rows()
            .iter()
            .map(|row| (row.at.time_s, row.at.lamp_s))
            .collect();
        let of = |time_s: f64, lamp_s: f64| (Some(time_s), Some(lamp_s));
        assert_eq!(
            times,
            [
                of(3610.0, 1800.0),
                of(1800.0, 1800.0),
                of(3620.0, 1810.0),
                of(1810.0, 1810.0)
            ]
        );
    }

    #[test]
    fn a_changed_row_is_found_and_a_torn_tail_left_out() {
        let row = "0,A,lit,1,0,0,2000,1,0,,1,1,ok,";
        let crc = crc32fast::hash(row.as_bytes());
        let header = format!("{},quality,row_crc\n", HEADER.trim_end());
        let path = Utf8Path::new("r.csv");
        let good = format!("{header}{row}{crc:08x}\n1,A,lit,1,0,0,20");
        assert_eq!(
            Readings::parse(path, &good, Need::Values, true).unwrap().rows().len(),
            1
        );
        let changed = good.replace(",1,1,ok", ",2,1,ok");
        let refused = Readings::parse(path, &changed, Need::Values, true).unwrap_err();
        assert!(matches!(refused.problem, Problem::Checksum { .. }), "{refused}");
        assert_eq!(refused.line, Some(2));
    }
}
