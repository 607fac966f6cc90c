//! `readings.csv`: append-only, one row a reading, each row with its checksum and the hash of all rows up to it.

mod columns;
mod error;
mod layout;
mod row;

use camino::Utf8Path;

pub use self::columns::HEADER;
pub(crate) use self::columns::NAMES;
pub use self::error::ReadingsError;
pub use self::layout::Layout;
pub(crate) use self::row::Chain;
use self::row::parse_row;
use crate::reading::Reading;

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
    /// `chain` of each row.
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
        Chain::after(self.layout, self.chains.last().cloned().unwrap_or_default())
    }
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
        readings.chains.push(chain.last().to_owned());
    }
    (readings, None)
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::reading::{Electrical, Quality, ReadingKind, Role};

    pub(crate) fn reading(index: u64) -> Reading {
        Reading {
            index,
            block: "lit".to_owned(),
            kind: ReadingKind::Lit,
            time_s: Some(1812.5),
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
            lamp_s: Some(1800.25),
            electrical: Electrical::default(),
        }
    }

    /// A file of these readings.
    fn of(readings: &[Reading]) -> String {
        in_layout(Layout::V4, readings)
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
        let text = Chain::new(Layout::V4).row(&reading(0)).0;
        assert!(
            text.starts_with("0,lit,lit,1812.5,15,0,10000,-1,1,,3.37,0.01,ok,"),
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
    fn what_the_power_meter_gave_has_a_cell_each_and_what_it_did_not_an_empty_one() {
        let mut illuminated = reading(0);
        illuminated.electrical = Electrical {
            voltage_v: Some(230.25),
            current_a: None,
            power_w: Some(9.5),
            power_factor: Some(-0.93),
        };
        let text = of(&[illuminated.clone(), reading(1)]);
        let row = text.lines().nth(1).unwrap();
        assert!(row.contains(",02,230.25,,9.5,-0.93,0,1,1800.25,"), "{row}");
        let read = parse(text.as_bytes()).unwrap().rows;
        assert_eq!((&read[0], read[1].electrical), (&illuminated, Electrical::default()));
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

    /// Rows of format 3 as the program before wrote them.
    #[test]
    fn a_file_of_format_3_is_read_and_its_chain_is_what_it_was() {
        let text = in_layout(Layout::V3, &[reading(0), reading(1)]);
        assert!(text.lines().all(|line| line.split(',').count() == 29) && !text.contains("lamp_s"));
        let readings = parse(text.as_bytes()).unwrap();
        let row = &readings.rows[1];
        assert_eq!((readings.layout, row.burning), (Layout::V3, Some(1)));
        assert_eq!((row.time_s, row.lamp_s), (None, Some(1800.25)));
        assert_eq!(readings.chains[1], CHAIN_OF_FORMAT_3);
    }

    /// Of the second of two such rows, computed by SHA-256 of the row's fields outside this program.
    const CHAIN_OF_FORMAT_3: &str = "d715d7654f6992ee";

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
