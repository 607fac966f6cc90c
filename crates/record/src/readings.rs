//! `readings.csv`: append-only, one row a reading, each row with its checksum.

use camino::{Utf8Path, Utf8PathBuf};

use crate::reading::{Quality, Reading};

/// The header row. The first thirteen columns are the common ones of every readings file.
pub const HEADER: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,row_crc";

const COLUMNS: usize = 22;

/// What was found behind the last whole row: a write that a crash cut short. It is no reading and is ignored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TornTail {
    /// One-based line.
    pub line: usize,
    /// Its length in bytes.
    pub bytes: usize,
}

/// Rows, the torn tail if there is one, and where the whole rows end.
#[derive(Debug, Clone, PartialEq)]
pub struct Readings {
    /// The rows, `index` = position.
    pub rows: Vec<Reading>,
    /// What a crash left of the row after them.
    pub torn_tail: Option<TornTail>,
    /// Length of the file up to the end of the last whole row.
    pub whole_bytes: usize,
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
    #[error(
        "{file}:{line}: row {row} is damaged: checksum {found} written, {computed} computed; restore the file from a copy"
    )]
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

/// The row of `reading` with its checksum and line end.
pub fn row(reading: &Reading) -> String {
    let optional = |value: Option<f64>| value.map_or_else(String::new, number);
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
    let crc = crc32fast::hash(row.as_bytes());
    row.push_str(&format!("{crc:08x}\n"));
    row
}

/// Reads a whole file of a run.
///
/// # Errors
/// [`ReadingsError`] with line and row.
pub fn read(file: &Utf8Path) -> Result<Readings, ReadingsError> {
    let bytes = std::fs::read(file).map_err(|error| ReadingsError::Io {
        file: file.to_owned(),
        message: error.to_string(),
    })?;
    parse(file, &bytes)
}

/// Parses the bytes of a readings file; `file` is for messages.
///
/// A last line without its line end is the torn tail of a crash and is set aside. A whole line with a wrong checksum is
/// damage, wherever it stands.
///
/// # Errors
/// [`ReadingsError`] with line and row.
pub fn parse(file: &Utf8Path, bytes: &[u8]) -> Result<Readings, ReadingsError> {
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let header = lines.next().unwrap_or_default();
    if header != format!("{HEADER}\n").as_bytes() {
        let found = String::from_utf8_lossy(header).trim_end().chars().take(120).collect();
        return Err(ReadingsError::Header {
            file: file.to_owned(),
            found,
        });
    }
    let mut readings = Readings {
        rows: Vec::new(),
        torn_tail: None,
        whole_bytes: header.len(),
    };
    for line in lines {
        let line_number = readings.rows.len() + 2;
        if line.last() != Some(&b'\n') {
            readings.torn_tail = Some(TornTail {
                line: line_number,
                bytes: line.len(),
            });
            break;
        }
        let reading = parse_row(file, line_number, readings.rows.len(), line)?;
        readings.rows.push(reading);
        readings.whole_bytes += line.len();
    }
    Ok(readings)
}

fn parse_row(file: &Utf8Path, line: usize, row: usize, bytes: &[u8]) -> Result<Reading, ReadingsError> {
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
    if fields.len() != COLUMNS {
        return Err(fault(
            "row_crc",
            format!("{} columns, expected {COLUMNS}", fields.len()),
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
        }
    }

    fn file(count: u64) -> Vec<u8> {
        let mut text = format!("{HEADER}\n");
        (0..count).for_each(|index| text.push_str(&row(&reading(index))));
        text.into_bytes()
    }

    fn parse(bytes: &[u8]) -> Result<Readings, ReadingsError> {
        super::parse(Utf8Path::new("readings.csv"), bytes)
    }

    #[test]
    fn the_row_is_what_the_contract_says() {
        let text = row(&reading(0));
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
        let mut text = format!("{HEADER}\n{}", row(&reading(0)));
        text.push_str(&row(&reading(2)));
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
        let text = format!("{HEADER}\n{}", row(&contradiction));
        assert!(matches!(
            parse(text.as_bytes()),
            Err(ReadingsError::Content {
                column: "illuminance_lx",
                ..
            })
        ));
        assert!(matches!(parse(b"index,block\n"), Err(ReadingsError::Header { .. })));
    }

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
            // A line end that vanishes or appears may cut the file short, but never yields other rows than were written.
            if let Ok(readings) = parse(&bytes) {
                let original = parse(&whole).unwrap().rows;
                prop_assert!(readings.rows.len() < original.len() && original.starts_with(&readings.rows));
            }
        }
    }
}
