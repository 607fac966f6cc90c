//! The lux meter: a Gigahertz-Optik P-9710 with a photometric detector of 0.3 nA/lx.
//!
//! A measurement begins with its request and takes the integration time. Eight ranges of the detector's current, five
//! digits. Commands and answers after the "P-9710 Operating Manual" V1.20, chapter 15.

use std::sync::Arc;
use std::sync::atomic::{AtomicI32, AtomicU8, Ordering};

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, InMotion, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    driver: "gigahertz-p9710",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("luxmeter", "?a_per_lx=3e-10")],
    sweeps: Some(InMotion::OnRequest {
        open: "&integration_ms=100",
        integration_ms: 100,
    }),
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(Optometer::new()),
};

/// Ten bits a byte.
const BYTE_S: f64 = 10.0 / 9600.0;
/// Detector's sensitivity, A/lx.
const A_PER_LX: f64 = 3e-10;

/// The meter.
pub struct Optometer {
    automatic: bool,
    /// 0: 2 mA to 7: 200 pA; measurements under way change it.
    range: Arc<AtomicU8>,
    /// 0.1 ms.
    integration: u16,
    /// % of the range that the last measurement used, in tenths.
    percent_tenths: Arc<AtomicI32>,
}

/// What stands between two commands stands between their answers.
enum Part {
    Text(String),
    Spacer(char),
    /// `MV`, `GR`, `GP`: known once the light has been integrated.
    Value,
    Range,
    Percent,
}

/// The reading of one measurement.
struct Measured {
    lux: f64,
    range: u8,
    percent_tenths: i32,
}

impl Optometer {
    /// The meter at power-up.
    pub fn new() -> Self {
        Self {
            automatic: true,
            range: Arc::new(AtomicU8::new(3)),
            integration: 1000,
            percent_tenths: Arc::default(),
        }
    }

    /// Runs the commands of a line; what they answer, or the number of the error.
    fn run(&mut self, line: &str) -> Result<(Vec<Part>, bool), u8> {
        let mut parts = Vec::new();
        let mut measures = false;
        let mut rest = line;
        while let Some(first) = rest.chars().next() {
            if matches!(first, ',' | ';' | ' ' | '\t') {
                parts.push(Part::Spacer(first));
                rest = &rest[1..];
                continue;
            }
            let command = rest.get(..2).ok_or(1)?;
            let parameter = &rest[2..];
            let length = parameter.find(|c: char| !c.is_ascii_digit()).unwrap_or(parameter.len());
            let number = parameter[..length].parse::<u16>().ok();
            rest = &parameter[length..];
            let text = match (command, number) {
                ("GI", None) => "P-9710 4.7".to_owned(),
                ("TT", None) => "1234".to_owned(),
                ("GU", None) => "\"lx\"".to_owned(),
                ("MB", None) => "100%".to_owned(),
                ("GR", None) => {
                    parts.push(Part::Range);
                    continue;
                }
                ("GP", None) => {
                    parts.push(Part::Percent);
                    continue;
                }
                ("MV", None) => {
                    measures = true;
                    parts.push(Part::Value);
                    continue;
                }
                ("GS", Some(0)) => u8::from(self.automatic).to_string(),
                ("GS", Some(1)) => self.range.load(Ordering::Relaxed).to_string(),
                ("GS", Some(3)) => self.integration.to_string(),
                ("SB", Some(on @ (0 | 1))) => {
                    self.automatic = on == 1;
                    continue;
                }
                ("SR", Some(range @ 0..=7)) => {
                    self.range.store(range as u8, Ordering::Relaxed);
                    continue;
                }
                ("SN", Some(tenths @ 1..=59_999)) => {
                    self.integration = tenths;
                    continue;
                }
                ("SB" | "SR" | "SN" | "GS", Some(_)) => return Err(8),
                ("SB" | "SR" | "SN" | "GS", None) => return Err(2),
                _ => return Err(1),
            };
            parts.push(Part::Text(text));
        }
        Ok((parts, measures))
    }
}

/// Reads the light of a window in the present range or, if it is automatic, in that which fits; the number of the
/// error.
fn measure(world: &World, from_s: f64, to_s: f64, automatic: bool, range: u8) -> Result<Measured, u8> {
    let light = world.meter_lx(from_s, to_s);
    let room = world.room();
    let ambient_c = world.temperature_c(from_s);
    let sample = sample(from_s);
    let indicate = |range: u8| {
        let indicated = room.indicated_for_lx(light, ambient_c, 8 - range);
        indicated + room.reading_noise_lx(indicated) * room.meter_noise(sample)
    };
    let full_scale_lx = |range: u8| 2e-3 * 10f64.powi(-i32::from(range)) / A_PER_LX;
    let share = |range: u8| indicate(range).abs() / full_scale_lx(range);
    let mut range = range;
    if automatic {
        while range > 0 && share(range) > 1.0 {
            range -= 1;
        }
        while range < 7 && share(range + 1) < 0.95 {
            range += 1;
        }
    }
    if share(range) > 1.0 {
        return Err(16);
    }
    Ok(Measured {
        lux: indicate(range),
        range,
        percent_tenths: (1000.0 * share(range)).round() as i32,
    })
}

/// Number of the measurement that begins at `from_s`: it draws the noise.
fn sample(from_s: f64) -> u64 {
    (from_s * 1000.0) as u64
}

/// `+x.xxxxE+xx`
fn scientific(value: f64) -> String {
    let text = format!("{:.4e}", value.abs());
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = |negative: bool| if negative { '-' } else { '+' };
    format!(
        "{}{mantissa}E{}{:02}",
        sign(value < 0.0),
        sign(exponent < 0),
        exponent.abs()
    )
}

impl Twin for Optometer {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.iter().position(|byte| *byte == b'\n')?;
        let line: Vec<u8> = inbox.drain(..=end).collect();
        let text = String::from_utf8_lossy(&line).into_owned();
        let from_s = now_s + line.len() as f64 * BYTE_S;
        let (parts, measures) = match self.run(text.trim_matches(['\r', '\n'])) {
            Ok(ran) => ran,
            Err(code) => return Some(Answer::At(from_s + 4.0 * BYTE_S, format!("?{code}\n").into_bytes())),
        };
        let (room, meter) = (world.room(), &world.room().document().luxmeter);
        let (from_s, to_s) = if measures {
            let from_s = from_s + room.meter_latency_s(sample(from_s));
            (
                from_s,
                from_s + meter.by_its_clock_s(f64::from(self.integration) * 1e-4),
            )
        } else {
            (from_s, from_s)
        };
        let (automatic, range, percent) = (
            self.automatic,
            Arc::clone(&self.range),
            Arc::clone(&self.percent_tenths),
        );
        let look = move |world: &World| {
            let mut value = String::new();
            if measures {
                match measure(world, from_s, to_s, automatic, range.load(Ordering::Relaxed)) {
                    Ok(measured) => {
                        range.store(measured.range, Ordering::Relaxed);
                        percent.store(measured.percent_tenths, Ordering::Relaxed);
                        value = scientific(measured.lux);
                    }
                    Err(code) => return format!("?{code}\n").into_bytes(),
                }
            }
            let text: String = parts
                .iter()
                .map(|part| match part {
                    Part::Text(text) => text.clone(),
                    Part::Spacer(spacer) => spacer.to_string(),
                    Part::Value => value.clone(),
                    Part::Range => range.load(Ordering::Relaxed).to_string(),
                    Part::Percent => format!("{:+.1}", f64::from(percent.load(Ordering::Relaxed)) / 10.0),
                })
                .collect();
            format!("{text}\n").into_bytes()
        };
        Some(Answer::When(to_s + 20.0 * BYTE_S, Box::new(look)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    #[test]
    fn it_answers_with_the_spacers_of_the_question_and_the_error_numbers_of_the_manual() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Optometer::new();
        let mut say = |line: &str| match twin.receive(&mut format!("{line}\n").into_bytes(), &mut world, 3.0) {
            Some(Answer::At(_, bytes)) => String::from_utf8(bytes).unwrap(),
            Some(Answer::When(_, look)) => String::from_utf8(look(&world)).unwrap(),
            None => String::new(),
        };
        assert_eq!(say("GI;TT,GU"), "P-9710 4.7;1234,\"lx\"\n");
        assert_eq!(say("SB0SR3GS0;GS1"), "0;3\n");
        assert_eq!(say("SN5000GS3"), "5000\n");
        assert_eq!(say("SB1"), "\n");
        assert_eq!(
            (say("SR8").as_str(), say("SR").as_str(), say("XX").as_str()),
            ("?8\n", "?2\n", "?1\n")
        );
        let measured = say("MV;GR,GP");
        assert!(
            measured.ends_with('\n') && measured.contains(';') && measured.len() > 15,
            "{measured}"
        );
        assert_eq!(scientific(123.45), "+1.2345E+02");
        assert_eq!(scientific(-0.000_12), "-1.2000E-04");
    }
}
