//! `init --standard`: a virtual room whose lamp is a standard with a certificate, and a station that is calibrated with
//! it.

use camino::Utf8Path;
use isolux_darkroom::certificate::{self, Stated};
use isolux_darkroom::{Darkroom, Room};
use isolux_record::document::SourceText;
use isolux_virtual::Instrument;
use isolux_virtual::station::{CALIBRATION_FILE, calibration, in_memory, station_in};
use isolux_virtual::twins::Choice;
use jiff::{Span, Timestamp, tz::TimeZone};

use crate::Failure;

const ROOM_FILE: &str = "room.toml";
/// The certificate, and its table.
const STANDARD_FILE: &str = "standard.toml";
const TABLE_FILE: &str = "standard.csv";
/// Days since the certificate was issued, and for which it is valid.
const ISSUED_DAYS: i64 = 30;
const VALID_DAYS: i64 = 365;

/// What the room has otherwise than the built-in one: a filament lamp of 48 W and 3000 lm as bright as illuminant A,
/// the lux meter at the distance of its illuminance.
const OTHERWISE: [(&str, &str, &str); 17] = [
    ("[lamp]", "flux_lm", "3000.0"),
    ("[lamp]", "ring_diameter_mm", "[0.0]"),
    ("[lamp]", "leds_per_ring", "[1]"),
    ("[lamp]", "exponent", "1.0"),
    ("[lamp]", "ellipticity_rel", "0.0"),
    ("[lamp]", "flux_spread_rel", "0.0"),
    ("[lamp]", "aim_spread_deg", "0.0"),
    ("[lamp]", "temperature_k", "2802.0"),
    ("[lamp]", "power_w", "48.0"),
    ("[lamp]", "power_warmup_share", "0.1"),
    ("[bench]", "distance_mm", "2000.0"),
    ("[powermeter]", "range_a", "5.0"),
    ("[injected_effects.lamp_warmup]", "amplitude_rel", "0.01"),
    ("[injected_effects.lamp_warmup]", "time_constant_s", "120.0"),
    ("[injected_effects.floor_reflection]", "albedo", "0.02"),
    ("[injected_effects.distance_offset]", "offset_mm", "0.6"),
    ("[injected_effects.spectro_bandpass]", "fwhm_nm", "2.0"),
];

/// The same instrument before a line lamp, and behind a filter: a room and a station each.
const BEFORE_LINES: [&str; 2] = ["room-lines.toml", "station-lines.toml"];
const BEHIND_FILTER: [&str; 2] = ["room-filter.toml", "station-filter.toml"];
const FILTER_FILE: &str = "filter.toml";
const FILTER: &str = "\
# A long-pass filter before the entrance of the spectroradiometer, for --cut-on.
format = \"isolux-filter/1\"
designation = \"virtual OG515\"
cut_on_nm = 515.0                       # half of the most is transmitted
opaque_below_nm = 460.0
transmittance_below_max = 1e-6          # below that
";

/// Room, certificate, station and former factors, with the twins of `choice`, and what the procedures of the
/// spectroradiometer itself are tried with.
///
/// # Errors
/// Never for the files as they are shipped.
pub fn files(choice: &Choice) -> Result<Vec<(&'static str, String)>, Failure> {
    let mut choice = choice.clone();
    // Nothing else measures the current of the lamp.
    choice.add(Instrument::Powermeter);
    let room_text = room();
    let source = SourceText {
        file: Utf8Path::new(ROOM_FILE),
        text: &room_text,
    };
    let no_file = |_: &str| Err("a standard lamp has no table of intensities".to_owned());
    let (document, _) = Darkroom::complete(source, &no_file).map_err(Failure::bad_input)?;
    let day = |days: i64| {
        let today = Timestamp::now().to_zoned(TimeZone::UTC).date();
        today.saturating_add(Span::new().days(days)).to_string()
    };
    let stated = Stated {
        days: (day(-ISSUED_DAYS), day(VALID_DAYS - ISSUED_DAYS)),
        ..Stated::default()
    };
    let written = certificate::write(&document, &stated, TABLE_FILE);
    let outlets = in_memory(&choice);
    let station = station_in(Some(ROOM_FILE), &document, &outlets);
    let mut files = vec![
        (ROOM_FILE, room_text.clone()),
        (STANDARD_FILE, written.document),
        (TABLE_FILE, written.table),
        ("station.toml", station),
    ];
    for ([room, station], key, value) in [
        (BEFORE_LINES, "line_lamp_lx", "100.0"),
        (BEHIND_FILTER, "filter_cut_on_nm", "515.0"),
    ] {
        files.push((room, changed(&room_text, &[("[spectroradiometer]", key, value)])));
        files.push((station, station_in(Some(room), &document, &outlets)));
    }
    files.push((FILTER_FILE, FILTER.to_owned()));
    files.extend(calibration(&Room::new(document), &outlets).map(|text| (CALIBRATION_FILE, text)));
    Ok(files)
}

/// The built-in room with that lamp.
fn room() -> String {
    changed(super::ROOM, &OTHERWISE)
}

/// The room in `text` with other values of some keys.
fn changed(text: &str, otherwise: &[(&str, &str, &str)]) -> String {
    let mut table = "";
    let mut changed = String::new();
    for line in text.lines() {
        table = if line.starts_with('[') { line } else { table };
        let key = line.split([' ', '=']).next().unwrap_or("");
        let comment = line.find('#').map_or("", |at| &line[at..]);
        let other = otherwise.iter().find(|(of, name, _)| *of == table && *name == key);
        changed += &match other {
            Some((_, _, value)) => format!("{:<31} {comment}", format!("{key} = {value}")),
            None => line.to_owned(),
        };
        changed.push('\n');
    }
    changed
}

#[cfg(test)]
mod tests {
    use isolux_record::{Standard, Station};

    use super::*;

    #[test]
    fn every_other_value_reaches_the_room_and_the_files_fit_together() {
        let files = files(&Choice::default()).unwrap();
        let text = |name: &str| &files.iter().find(|(file, _)| *file == name).unwrap().1;
        for (table, key, value) in OTHERWISE {
            let (_, rest) = text(ROOM_FILE).split_once(&format!("\n{table}\n")).unwrap();
            let part = rest.split("\n[").next().unwrap();
            assert!(part.contains(&format!("{key} = {value}")), "{table} {key}");
        }
        let read = |name: &str| Ok(text(name).clone());
        let standard = Standard::parse(Utf8Path::new(STANDARD_FILE), text(STANDARD_FILE), &read).unwrap();
        assert!(standard.spectral().is_some() && standard.illuminance().is_some());
        let station = Station::parse(Utf8Path::new("station.toml"), text("station.toml")).unwrap();
        assert!(station.powermeter().is_some());
        assert_eq!(standard.document().conditions.current_a, 2.0);
    }
}
