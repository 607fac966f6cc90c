//! The lux meter that the template of `ascii-lux` describes: no real instrument.
//!
//! ID?, UNIT LX and E?, ended by CR LF as the answers are. One range up to 200 klx, two decimals; a new value after
//! each integration of the room's meter.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    driver: "ascii-lux",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("luxmeter", "?profile=template")],
    sweeps: None,
    calibration: None,
    start: |_| Box::new(TemplateMeter),
};

/// Ten bits a byte at 9600 baud, s.
const BYTE_S: f64 = 10.0 / 9600.0;
/// From the end of a request to the first byte of its answer, s.
const LATENCY_S: f64 = 0.01;
const END_LX: f64 = 200_000.0;

/// The meter.
pub(crate) struct TemplateMeter;

fn answer(command: &str, world: &World, now_s: f64) -> String {
    match command {
        "ID?" => "ID LUX-1,0042,1.0".to_owned(),
        "UNIT LX" => "OK".to_owned(),
        "E?" => {
            let room = world.room();
            let period_s = room.document().luxmeter.integration_s;
            let conversion = ((now_s / period_s).floor() - 1.0).max(0.0);
            let from_s = conversion * period_s;
            let light = world.meter_lx(from_s, from_s + period_s);
            let indicated = room.indicated_for_lx(light, world.temperature_c(from_s), 0);
            let lux = indicated + room.reading_noise_lx(indicated) * room.meter_noise(conversion as u64);
            if lux > END_LX {
                "E OVER".to_owned()
            } else {
                format!("E {lux:.2} lx")
            }
        }
        _ => "ERR 1".to_owned(),
    }
}

impl Twin for TemplateMeter {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.windows(2).position(|bytes| bytes == b"\r\n")?;
        let line: Vec<u8> = inbox.drain(..end + 2).collect();
        let text = answer(&String::from_utf8_lossy(&line[..end]), world, now_s);
        let bytes = format!("{text}\r\n").into_bytes();
        let line_s = (line.len() + bytes.len()) as f64 * BYTE_S;
        Some(Answer::At(now_s + line_s + LATENCY_S, bytes))
    }
}
