//! The lux meter: a Gossen MAVOLUX 5032 by its MAVO-USB interface.
//!
//! A new value every two seconds; five ranges, 19.99 lx to 199.9 klx, four digits of which the first is 0 or 1.
//! Commands and answers after "Interface description MAVO-USB" 1.1/02.18.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    driver: "gossen-mavo-usb",
    line: LineSettings {
        baud: 9600,
        data_bits: 7,
        parity: Parity::Even,
        stop_bits: 2,
    },
    opens: &[("luxmeter", "")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(Mavolux::new()),
};

/// Start, seven bits, parity, two stop bits.
const BYTE_S: f64 = 11.0 / 9600.0;
/// Half a measurement a second.
const CONVERSION_S: f64 = 2.0;
/// Highest number of digits in every range.
const MOST_DIGITS: f64 = 1999.0;
/// The command interpreter takes no more, LF included.
const LONGEST: usize = 32;

/// The meter.
pub struct Mavolux {
    echo: bool,
    automatic: bool,
    range: u8,
    unit: &'static str,
}

/// A command of the interface description: what must be there, and what may follow it.
fn is(header: &str, least: &str, whole: &str) -> bool {
    header.len() >= least.len() && whole.starts_with(header)
}

/// Last digit of a range in lx.
fn digit_lx(range: u8) -> f64 {
    10f64.powi(i32::from(range) - 2)
}

impl Mavolux {
    /// The meter at power-up.
    pub fn new() -> Self {
        Self {
            echo: true,
            automatic: true,
            range: 0,
            unit: "LX",
        }
    }

    fn answer(&mut self, line: &str, world: &World, now_s: f64) -> String {
        let line = line.trim().to_ascii_uppercase();
        if line.len() + 1 > LONGEST {
            return "ERROR = 004".to_owned();
        }
        let (header, parameter) = line.split_once(' ').unwrap_or((&line, ""));
        let parameter = parameter.trim();
        let echoed = self.echo;
        let data = match self.command(header, parameter, world, now_s) {
            Ok(data) => data,
            Err(code) => return format!("ERROR = {code:03}"),
        };
        if !echoed && !self.echo {
            return data;
        }
        // The echo is the header as it was written; the description's examples keep the question mark in measurements
        // alone.
        let echo = if header.contains("PHO") {
            header
        } else {
            header.trim_end_matches('?')
        };
        format!("{echo} {data}").trim().to_owned()
    }

    fn command(&mut self, header: &str, parameter: &str, world: &World, now_s: f64) -> Result<String, u16> {
        // Optional parts of headers.
        let short = ["SYSTEM:", "SYST:", "SYS:"]
            .iter()
            .find_map(|part| header.strip_prefix(part));
        let short = short.unwrap_or(header);
        let short = ["MEASURE:", "MEAS:", "MEA:"]
            .iter()
            .find_map(|part| short.strip_prefix(part))
            .unwrap_or(short);
        let switch: Result<bool, u16> = match parameter {
            "ON" | "1" => Ok(true),
            "OFF" | "0" => Ok(false),
            "" => Err(102),
            _ => Err(107),
        };
        if let Some(query) = short.strip_suffix('?') {
            if !parameter.is_empty() {
                return Err(102);
            }
            return match query {
                "*IDN" => Ok("GOSSEN,M 502, 20387,01,V 1.00".to_owned()),
                "" => self.measure(world, now_s),
                _ if is(query, "PHO", "PHOTOMETRIC") => self.measure(world, now_s),
                _ if is(query, "RAN", "RANGE") => Ok(self.range.to_string()),
                "RAN:AUTO" | "RANGE:AUTO" => Ok(if self.automatic { "ON" } else { "OFF" }.to_owned()),
                _ if is(query, "VER", "VERSION") => Ok("V1.00 (2004)".to_owned()),
                _ => Err(105),
            };
        }
        match short {
            "*RST" => {
                *self = Self {
                    unit: self.unit,
                    ..Self::new()
                };
                Ok("ACK".to_owned())
            }
            _ if is(short, "ECH", "ECHO") => {
                self.echo = switch?;
                Ok(parameter.to_owned())
            }
            "RAN:AUTO" | "RANGE:AUTO" => {
                self.automatic = switch?;
                Ok(parameter.to_owned())
            }
            _ if is(short, "RAN", "RANGE") => match parameter.parse() {
                Ok(range @ 0..=4) => {
                    (self.range, self.automatic) = (range, false);
                    Ok(parameter.to_owned())
                }
                _ => Err(107),
            },
            "UNI:PHOT" | "UNIT:PHOT" | "UNIT:PHOTOMETRIC" => {
                self.unit = ["LX", "FC"]
                    .into_iter()
                    .find(|unit| *unit == parameter)
                    .ok_or(107_u16)?;
                Ok(parameter.to_owned())
            }
            _ => Err(101),
        }
    }

    fn measure(&mut self, world: &World, now_s: f64) -> Result<String, u16> {
        let conversion = ((now_s / CONVERSION_S).floor() - 1.0).max(0.0) as u64;
        let from_s = conversion as f64 * CONVERSION_S;
        let light = world.meter_lx(from_s, from_s + CONVERSION_S);
        let room = world.room();
        let ambient_c = world.temperature_c(from_s);
        let indicate = |range: u8| {
            let indicated = room.indicated_for_lx(light, ambient_c, range + 1);
            indicated + room.reading_noise_lx(indicated) * room.meter_noise(conversion)
        };
        let digits = |range: u8| (indicate(range) / digit_lx(range)).round();
        if self.automatic {
            while self.range < 4 && digits(self.range).abs() > MOST_DIGITS {
                self.range += 1;
            }
            while self.range > 0 && digits(self.range - 1).abs() < 0.9 * MOST_DIGITS {
                self.range -= 1;
            }
        }
        let digits = digits(self.range);
        if digits.abs() > MOST_DIGITS {
            return Err(19);
        }
        let (digits, exponent) = match self.unit {
            "FC" => ((digits / 10.763_910_42).round(), i32::from(self.range) - 2),
            _ => (digits, i32::from(self.range) - 2),
        };
        let sign = if exponent < 0 { "-" } else { "" };
        Ok(format!("{digits:.0}E{sign}{:02} {}", exponent.abs(), self.unit).replace("-0E", "0E"))
    }
}

impl Twin for Mavolux {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.iter().position(|byte| *byte == b'\n')?;
        let line: Vec<u8> = inbox.drain(..=end).collect();
        let text = self.answer(&String::from_utf8_lossy(&line), world, now_s);
        let bytes = format!("{text}\n").into_bytes();
        Some(Answer::At(now_s + (line.len() + bytes.len()) as f64 * BYTE_S, bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    /// Exchanges printed in the interface description.
    #[test]
    fn it_answers_as_the_description_prints() {
        let world = World::new(Darkroom::default());
        let mut twin = Mavolux::new();
        let mut say = |line: &str| twin.answer(line, &world, 10.0);
        assert_eq!(say("*IDN?"), "*IDN GOSSEN,M 502, 20387,01,V 1.00");
        assert_eq!(say("RAN 4"), "RAN 4");
        assert_eq!(say("ran:auto off"), "RAN:AUTO OFF");
        assert_eq!(say("uni:phot lx"), "UNI:PHOT LX");
        assert!(say("measure:photo?").starts_with("MEASURE:PHOTO? 0E02 LX"));
        assert_eq!(say("RAN?"), "RAN 4");
        assert_eq!(say("echo off"), "ECHO OFF");
        assert!(say("measure:photo?").starts_with("0E02 LX"));
        assert_eq!(say("echo on"), "ECHO ON");
        assert_eq!(say("RANGE ?"), "ERROR = 107");
        assert_eq!(say("RAN 5"), "ERROR = 107");
        assert_eq!(say("XYZ"), "ERROR = 101");
    }
}
