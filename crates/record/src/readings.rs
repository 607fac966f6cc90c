//! `readings.csv`: append-only, one row a reading, each row with its checksum and the hash of all rows up to it.

use camino::{Utf8Path, Utf8PathBuf};

use crate::disk::sha256;
use crate::reading::{Electrical, Quality, Reading};

/// The header row. The first thirteen columns are the common ones of every readings file.
pub const HEADER: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,voltage_v,current_a,power_w,power_factor,\
session,burning,chain,row_crc";

/// The header row of format 2.
const HEADER_2: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,session,burning,chain,row_crc";

/// The header row of format 1.
const HEADER_1: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,row_crc";

/// Which columns a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// Format 1: no `session`, `burning`, `chain`.
    V1,
    /// Format 2: no electrical columns.
    V2,
    /// Format 3.
    #[default]
    V3,
}

impl Layout {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::V1, Self::V2, Self::V3];

    /// Whether each row has the hash of all rows up to it, and run.toml its own.
    pub const fn has_hashes(self) -> bool {
        !matches!(self, Self::V1)
    }

    /// The header row with its line end.
    pub fn header(self) -> String {
        match self {
            Self::V1 => format!("{HEADER_1}\n"),
            Self::V2 => format!("{HEADER_2}\n"),
            Self::V3 => format!("{HEADER}\n"),
        }
    }

    const fn columns(self) -> usize {
        match self {
            Self::V1 => 22,
            Self::V2 => 25,
            Self::V3 => 29,
        }
    }
}

/// What was found behind the last whole row: a write that a crash cut short. It is no reading and is ignored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TornTail {
    /// One-based line.
    pub line: usize,
    /// Its length in bytes.
    pub bytes: usize,
}

/// Rows, the torn tail if there is one, and where the whole rows end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Readings {
    /// Columns of the file.
    pub layout: Layout,
    /// The rows, `index` = position.
    pub rows: Vec<Reading>,
    /// What a crash left of the row after them.
    pub torn_tail: Option<TornTail>,
    /// Length of the file up to the end of the last whole row.
    pub whole_bytes: usize,
    /// Length of the file up to the end of each row.
    pub(crate) ends: Vec<usize>,
    /// `chain` of each row; empty in format 1.
    pub(crate) chains: Vec<String>,
}

impl Readings {
    /// Readings that stand in no file.
    pub fn of(rows: Vec<Reading>) -> Self {
        Self {
            rows,
            ..Self::default()
        }
    }

    /// Keeps the first `count` rows.
    pub(crate) fn truncate(&mut self, count: usize) {
        self.rows.truncate(count);
        self.ends.truncate(count);
        self.chains.truncate(count);
        self.torn_tail = None;
        self.whole_bytes = match self.ends.last() {
            Some(end) => *end,
            None => self.whole_bytes.min(self.layout.header().len()),
        };
    }

    /// The chain that the next row continues.
    pub(crate) fn chain(&self) -> Chain {
        Chain {
            layout: self.layout,
            last: self.chains.last().cloned().unwrap_or_default(),
        }
    }
}

/// The hash of all rows up to one: the first 16 digits of SHA-256 over the one before and the row's own fields. A row
/// that was removed, doubled, exchanged or taken from another run does not continue it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Chain {
    layout: Layout,
    last: String,
}

impl Chain {
    pub(crate) const fn new(layout: Layout) -> Self {
        Self {
            layout,
            last: String::new(),
        }
    }

    /// The hash of the rows so far; empty before the first.
    pub(crate) fn last(&self) -> &str {
        &self.last
    }

    /// Continues with the fields of a row before its `chain`, with their last comma.
    fn link(&self, fields: &str) -> String {
        sha256(format!("{}{fields}", self.last).as_bytes())[..16].to_owned()
    }

    /// The row of `reading` with chain, checksum and line end, and the chain after it.
    pub(crate) fn row(&self, reading: &Reading) -> (String, Self) {
        let mut row = fields(reading);
        let mut next = self.clone();
        if self.layout == Layout::V3 {
            let line = &reading.electrical;
            for value in [line.voltage_v, line.current_a, line.power_w, line.power_factor] {
                row.push_str(&optional(value));
                row.push(',');
            }
        }
        if self.layout.has_hashes() {
            let burning = reading.burning.map_or_else(String::new, |burning| burning.to_string());
            row.push_str(&format!("{},{burning},", reading.session));
            next.last = self.link(&row);
            row.push_str(&format!("{},", next.last));
        }
        let crc = crc32fast::hash(row.as_bytes());
        row.push_str(&format!("{crc:08x}\n"));
        (row, next)
    }
}

/// A readings file that cannot be trusted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadingsError {
    /// It cannot be read at all.
    #[error("{file}: {message}")]
    Io {
        /// The file.
        file: Utf8PathBuf,
        /// What the system said.
        message: String,
    },
    /// Its first line is not the header of this version.
    #[error("{file}:1: not the header of a run's readings, found `{found}`")]
    Header {
        /// The file.
        file: Utf8PathBuf,
        /// The line found.
        found: String,
    },
    /// A row whose bytes are not those that were written.
    #[error("{file}:{line}: row {row} is damaged: checksum {found} written, {computed} computed")]
    Checksum {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Number of the row, from 0.
        row: usize,
        /// The checksum in the row.
        found: String,
        /// The checksum of the row.
        computed: String,
    },
    /// A row that does not continue the rows before it.
    #[error(
        "{file}:{line}: row {row} does not continue the rows before it: rows were removed, exchanged or taken from another run"
    )]
    Chain {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Number of the row, from 0.
        row: usize,
    },
    /// A row with a right checksum whose content cannot be.
    #[error("{file}:{line}: column {column}: {message}")]
    Content {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What is wrong.
        message: String,
    },
}

/// A number, or an empty cell.
fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, number)
}

/// The columns that all formats have, each with its comma.
fn fields(reading: &Reading) -> String {
    let mut row = [
        reading.index.to_string(),
        reading.block.clone(),
        reading.kind.to_string(),
        optional(reading.time_s),
        number(reading.c_deg),
        number(reading.gamma_deg),
        number(reading.distance_mm),
        reading.travel.to_string(),
        reading.range.to_string(),
        optional(reading.ambient_c),
        optional(reading.illuminance_lx),
        optional(reading.u_lx),
        reading.quality.to_string(),
        reading.role.to_string(),
        reading.point.to_string(),
        reading.repeat.to_string(),
        number(reading.c_target_deg),
        number(reading.gamma_target_deg),
        optional(reading.digit_lx),
        optional(reading.integration_s),
        reading.raw.clone(),
    ]
    .join(",");
    row.push(',');
    row
}

/// Parses the bytes of a readings file; `file` is for messages.
///
/// A last line without its line end is the torn tail of a crash and is set aside. A whole line with a wrong checksum is
/// damage, wherever it stands.
///
/// # Errors
/// [`ReadingsError`] with line and row.
pub fn parse(file: &Utf8Path, bytes: &[u8]) -> Result<Readings, ReadingsError> {
    match parse_whole(file, bytes) {
        (readings, None) => Ok(readings),
        (_, Some(error)) => Err(error),
    }
}

/// As [`parse`], with the whole rows before the first that is damaged.
pub(crate) fn parse_whole(file: &Utf8Path, bytes: &[u8]) -> (Readings, Option<ReadingsError>) {
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let header = lines.next().unwrap_or_default();
    let mut readings = Readings::default();
    let layout = Layout::ALL
        .into_iter()
        .find(|layout| header == layout.header().as_bytes());
    let Some(layout) = layout else {
        let found = String::from_utf8_lossy(header).trim_end().chars().take(120).collect();
        let file = file.to_owned();
        return (readings, Some(ReadingsError::Header { file, found }));
    };
    readings.layout = layout;
    readings.whole_bytes = header.len();
    let mut chain = Chain::new(readings.layout);
    for line in lines {
        let line_number = readings.rows.len() + 2;
        if line.last() != Some(&b'\n') {
            readings.torn_tail = Some(TornTail {
                line: line_number,
                bytes: line.len(),
            });
            break;
        }
        match parse_row(file, line_number, readings.rows.len(), line, &mut chain) {
            Ok(reading) => readings.rows.push(reading),
            Err(error) => return (readings, Some(error)),
        }
        readings.whole_bytes += line.len();
        readings.ends.push(readings.whole_bytes);
        if readings.layout.has_hashes() {
            readings.chains.push(chain.last.clone());
        }
    }
    (readings, None)
}

fn parse_row(
    file: &Utf8Path,
    line: usize,
    row: usize,
    bytes: &[u8],
    chain: &mut Chain,
) -> Result<Reading, ReadingsError> {
    let columns = chain.layout.columns();
    let body = &bytes[..bytes.len() - 1];
    let split = body.iter().rposition(|&byte| byte == b',').map_or(0, |comma| comma + 1);
    let (covered, written) = body.split_at(split);
    let computed = format!("{:08x}", crc32fast::hash(covered));
    let damaged = || ReadingsError::Checksum {
        file: file.to_owned(),
        line,
        row,
        found: String::from_utf8_lossy(written).chars().take(16).collect(),
        computed: computed.clone(),
    };
    if written != computed.as_bytes() {
        return Err(damaged());
    }
    let fault = |column: &'static str, message: String| ReadingsError::Content {
        file: file.to_owned(),
        line,
        column,
        message,
    };
    let text = std::str::from_utf8(covered).map_err(|_| damaged())?;
    let fields: Vec<&str> = text.split(',').collect();
    if fields.len() != columns {
        return Err(fault(
            "row_crc",
            format!("{} columns, expected {columns}", fields.len()),
        ));
    }
    let parse = |column: &'static str, field: &str| -> Result<f64, ReadingsError> {
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(fault(column, format!("`{field}` is no finite number"))),
        }
    };
    let optional = |column: &'static str, field: &str| -> Result<Option<f64>, ReadingsError> {
        if field.is_empty() {
            Ok(None)
        } else {
            parse(column, field).map(Some)
        }
    };
    macro_rules! word {
        ($column:literal, $field:expr) => {
            $field
                .parse()
                .map_err(|error| fault($column, format!("`{}`: {error}", $field)))?
        };
    }
    let electrical = match chain.layout {
        Layout::V1 | Layout::V2 => Electrical::default(),
        Layout::V3 => Electrical {
            voltage_v: optional("voltage_v", fields[21])?,
            current_a: optional("current_a", fields[22])?,
            power_w: optional("power_w", fields[23])?,
            power_factor: optional("power_factor", fields[24])?,
        },
    };
    // `session`, `burning` and `chain`, where there are such.
    let [session, burning, linked_to] = match chain.layout {
        Layout::V1 => ["0", "", ""],
        Layout::V2 => [fields[21], fields[22], fields[23]],
        Layout::V3 => [fields[25], fields[26], fields[27]],
    };
    let reading = Reading {
        index: word!("index", fields[0]),
        block: fields[1].to_owned(),
        kind: word!("kind", fields[2]),
        time_s: optional("time_s", fields[3])?,
        c_deg: parse("c_deg", fields[4])?,
        gamma_deg: parse("gamma_deg", fields[5])?,
        distance_mm: parse("distance_mm", fields[6])?,
        travel: word!("travel", fields[7]),
        range: word!("range", fields[8]),
        ambient_c: optional("ambient_c", fields[9])?,
        illuminance_lx: optional("illuminance_lx", fields[10])?,
        u_lx: optional("u_lx", fields[11])?,
        quality: word!("quality", fields[12]),
        role: word!("role", fields[13]),
        point: word!("point", fields[14]),
        repeat: word!("repeat", fields[15]),
        c_target_deg: parse("c_target_deg", fields[16])?,
        gamma_target_deg: parse("gamma_target_deg", fields[17])?,
        digit_lx: optional("digit_lx", fields[18])?,
        integration_s: optional("integration_s", fields[19])?,
        raw: fields[20].to_owned(),
        session: word!("session", session),
        burning: if burning.is_empty() {
            None
        } else {
            Some(word!("burning", burning))
        },
        electrical,
    };
    if reading.index != row as u64 {
        return Err(fault(
            "index",
            format!("is {}, expected {row}: a row is missing or doubled", reading.index),
        ));
    }
    if reading.illuminance_lx.is_some() != (reading.quality == Quality::Ok) {
        return Err(fault(
            "illuminance_lx",
            "must be given exactly when quality is ok".to_owned(),
        ));
    }
    if chain.layout.has_hashes() {
        // All fields but `chain` itself and the checksum, which `covered` ends before.
        let linked = &text[..text.len() - linked_to.len() - 1];
        if chain.link(linked) != linked_to {
            return Err(ReadingsError::Chain {
                file: file.to_owned(),
                line,
                row,
            });
        }
        linked_to.clone_into(&mut chain.last);
    }
    Ok(reading)
}

/// The shortest decimal that reads back as the same number; never −0.
fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::reading::{ReadingKind, Role};
    use proptest::prelude::*;

    pub(crate) fn reading(index: u64) -> Reading {
        Reading {
            index,
            block: "lit".to_owned(),
            kind: ReadingKind::Lit,
            time_s: Some(1800.25),
            c_deg: 15.0,
            gamma_deg: -0.0,
            distance_mm: 10_000.0,
            travel: -1,
            range: 1,
            ambient_c: None,
            illuminance_lx: Some(3.37),
            u_lx: Some(0.01),
            quality: Quality::Ok,
            role: Role::Point,
            point: 7,
            repeat: 0,
            c_target_deg: 15.0,
            gamma_target_deg: 0.0,
            digit_lx: Some(0.01),
            integration_s: Some(0.5),
            raw: "02".to_owned(),
            session: 0,
            burning: Some(1),
            electrical: Electrical::default(),
        }
    }

    /// A file of these readings.
    fn of(readings: &[Reading]) -> String {
        in_layout(Layout::V3, readings)
    }

    fn in_layout(layout: Layout, readings: &[Reading]) -> String {
        let mut chain = Chain::new(layout);
        let mut text = layout.header();
        for reading in readings {
            let (row, next) = chain.row(reading);
            text.push_str(&row);
            chain = next;
        }
        text
    }

    fn file(count: u64) -> Vec<u8> {
        of(&(0..count).map(reading).collect::<Vec<_>>()).into_bytes()
    }

    fn parse(bytes: &[u8]) -> Result<Readings, ReadingsError> {
        super::parse(Utf8Path::new("readings.csv"), bytes)
    }

    #[test]
    fn the_row_is_what_the_contract_says() {
        let text = Chain::new(Layout::V3).row(&reading(0)).0;
        assert!(
            text.starts_with("0,lit,lit,1800.25,15,0,10000,-1,1,,3.37,0.01,ok,"),
            "{text}"
        );
        let (covered, crc) = text.trim_end().rsplit_once(',').unwrap();
        // zlib.crc32 of the same bytes is the same function.
        assert_eq!(
            crc,
            format!("{:08x}", crc32fast::hash(format!("{covered},").as_bytes()))
        );
        assert_eq!(crc.len(), 8);
        assert_eq!(parse(&file(3)).unwrap().rows[2].index, 2);
    }

    #[test]
    fn damage_is_located_and_a_missing_row_is_missed() {
        let mut bytes = file(5);
        let row_2 = bytes
            .iter()
            .enumerate()
            .filter(|(_, byte)| **byte == b'\n')
            .nth(2)
            .unwrap()
            .0
            + 5;
        bytes[row_2] ^= 1;
        assert!(matches!(
            parse(&bytes),
            Err(ReadingsError::Checksum { line: 4, row: 2, .. })
        ));
        let text = of(&[reading(0), reading(2)]);
        assert!(matches!(
            parse(text.as_bytes()),
            Err(ReadingsError::Content {
                line: 3,
                column: "index",
                ..
            })
        ));
        let contradiction = Reading {
            quality: Quality::OverRange,
            ..reading(0)
        };
        let text = of(&[contradiction]);
        assert!(matches!(
            parse(text.as_bytes()),
            Err(ReadingsError::Content {
                column: "illuminance_lx",
                ..
            })
        ));
        assert!(matches!(parse(b"index,block\n"), Err(ReadingsError::Header { .. })));
    }

    /// Each row is whole and has the number of its place; only the hash of the rows before tells.
    #[test]
    fn a_row_of_another_run_does_not_continue_this_one() {
        let mut other = reading(1);
        other.illuminance_lx = Some(3.38);
        let (ours, theirs) = (of(&[0, 1, 2].map(reading)), of(&[reading(0), other, reading(2)]));
        let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
        let (ours, theirs) = (lines(&ours), lines(&theirs));
        for place in [2, 3] {
            let mut mixed = ours.clone();
            mixed[place].clone_from(&theirs[place]);
            let text = mixed.join("\n") + "\n";
            // Row 1 of the other run follows row 0, which both have, but our row 2 does not follow it.
            match parse(text.as_bytes()) {
                Err(ReadingsError::Chain { row, .. }) => assert_eq!(row, 2),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn a_file_of_format_1_is_read() {
        let mut text = format!("{HEADER_1}\n");
        for index in 0..2 {
            let mut row = fields(&reading(index));
            row.push_str(&format!("{:08x}\n", crc32fast::hash(row.as_bytes())));
            assert_eq!(row, Chain::new(Layout::V1).row(&reading(index)).0);
            text.push_str(&row);
        }
        let readings = parse(text.as_bytes()).unwrap();
        assert_eq!((readings.layout, readings.rows.len()), (Layout::V1, 2));
        assert_eq!(readings.rows[1].burning, None);
    }

    #[test]
    fn what_the_power_meter_gave_has_a_cell_each_and_what_it_did_not_an_empty_one() {
        let mut lit = reading(0);
        lit.electrical = Electrical {
            voltage_v: Some(230.25),
            current_a: None,
            power_w: Some(9.5),
            power_factor: Some(-0.93),
        };
        let text = of(&[lit.clone(), reading(1)]);
        let row = text.lines().nth(1).unwrap();
        assert!(row.contains(",02,230.25,,9.5,-0.93,0,1,"), "{row}");
        let read = parse(text.as_bytes()).unwrap().rows;
        assert_eq!((&read[0], read[1].electrical), (&lit, Electrical::default()));
        for word in ["NAN", "inf", "9.91E37V"] {
            let mut row = row.replacen(",9.5,", &format!(",{word},"), 1);
            row.truncate(row.rfind(',').unwrap() + 1);
            let crc = crc32fast::hash(row.as_bytes());
            let text = format!("{HEADER}\n{row}{crc:08x}\n");
            match parse(text.as_bytes()) {
                Err(ReadingsError::Content { column: "power_w", .. }) => {}
                other => panic!("{word}: {other:?}"),
            }
        }
    }

    /// Rows of format 2 as the program before wrote them.
    #[test]
    fn a_file_of_format_2_is_read_and_its_chain_is_what_it_was() {
        let text = in_layout(Layout::V2, &[reading(0), reading(1)]);
        assert!(text.starts_with(HEADER_2) && text.lines().nth(1).unwrap().split(',').count() == 25);
        let readings = parse(text.as_bytes()).unwrap();
        assert_eq!((readings.layout, readings.rows[1].burning), (Layout::V2, Some(1)));
        assert_eq!(readings.chains[1], CHAIN_OF_FORMAT_2);
    }

    /// Of the second of two such rows, computed by SHA-256 of the row's fields outside this program.
    const CHAIN_OF_FORMAT_2: &str = "480f44fedebf7f01";

    proptest! {
        #[test]
        fn cut_anywhere_it_keeps_every_whole_row_and_nothing_else(cut in 0_usize..2000) {
            let whole = file(10);
            let cut = cut.min(whole.len());
            let header = HEADER.len() + 1;
            match parse(&whole[..cut]) {
                Err(error) => prop_assert!(cut < header, "{error}"),
                Ok(readings) => {
                    let rows = whole[header..cut].split_inclusive(|byte| *byte == b'\n').filter(|row| row.ends_with(b"\n")).count();
                    prop_assert_eq!(readings.rows.len(), rows);
                    prop_assert_eq!(readings.torn_tail.is_some(), readings.whole_bytes != cut);
                }
            }
        }

        #[test]
        fn any_flipped_bit_is_noticed(place in 0_usize..10_000, bit in 0_u8..8) {
            let whole = file(6);
            let mut bytes = whole.clone();
            let place = place % (bytes.len() - 1);
            bytes[place] ^= 1 << bit;
            // A line end that vanishes or appears may cut the file short, but never yields other rows than were
            // written.
            if let Ok(readings) = parse(&bytes) {
                let original = parse(&whole).unwrap().rows;
                prop_assert!(readings.rows.len() < original.len() && original.starts_with(&readings.rows));
            }
        }
    }
}
