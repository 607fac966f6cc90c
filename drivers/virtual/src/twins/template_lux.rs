//! The lux meter that the templates of `ascii-lux` describe: no real instrument.
//!
//! ID?, UNIT LX, E? and M?, ended by CR LF as the answers are. One range up to 200 klx, two decimals. E? gets the last
//! value, of which there is a new one after each integration of the room's meter; M? begins one of 100 ms.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, InMotion, Twin, TwinKind};
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
    sweeps: Some(InMotion::OnRequest {
        open: "-on-request",
        integration_ms: 100,
    }),
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(TemplateMeter),
};

/// Ten bits a byte at 9600 baud, s.
const BYTE_S: f64 = 10.0 / 9600.0;
/// From the end of a request to the first byte of its answer, s.
const LATENCY_S: f64 = 0.01;
const END_LX: f64 = 200_000.0;
/// Integration time of a conversion that M? begins, s.
const ON_REQUEST_S: f64 = 0.1;
/// The longest answer to it, bytes.
const LONGEST: usize = 16;

/// The meter.
pub(crate) struct TemplateMeter;

/// The value of the light in a window, conversion number `index`.
fn value(world: &World, [from_s, to_s]: [f64; 2], index: u64) -> String {
    let room = world.room();
    let light = world.meter_lx(from_s, to_s);
    let indicated = room.indicated_for_lx(light, world.temperature_c(from_s), 0);
    let lux = indicated + room.reading_noise_lx(indicated) * room.meter_noise(index);
    if lux > END_LX {
        "E OVER".to_owned()
    } else {
        format!("E {lux:.2} lx")
    }
}

fn answer(command: &str, world: &World, now_s: f64) -> String {
    match command {
        "ID?" => "ID LUX-1,0042,1.0".to_owned(),
        "UNIT LX" => "OK".to_owned(),
        "E?" => {
            let period_s = world.room().document().luxmeter.integration_s;
            let conversion = ((now_s / period_s).floor() - 1.0).max(0.0);
            let from_s = conversion * period_s;
            value(world, [from_s, from_s + period_s], conversion as u64)
        }
        _ => "ERR 1".to_owned(),
    }
}

/// A conversion that a request begins which was complete on the line at `asked_s`.
fn measure(world: &World, asked_s: f64) -> Answer {
    let (room, meter) = (world.room(), &world.room().document().luxmeter);
    let index = (asked_s * 1000.0) as u64;
    let from_s = asked_s + room.meter_latency_s(index);
    let to_s = from_s + meter.by_its_clock_s(ON_REQUEST_S);
    Answer::When(
        to_s + LONGEST as f64 * BYTE_S,
        Box::new(move |world| format!("{}\r\n", value(world, [from_s, to_s], index)).into_bytes()),
    )
}

impl Twin for TemplateMeter {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let end = inbox.windows(2).position(|bytes| bytes == b"\r\n")?;
        let line: Vec<u8> = inbox.drain(..end + 2).collect();
        if line[..end] == *b"M?" {
            return Some(measure(world, now_s + line.len() as f64 * BYTE_S));
        }
        let text = answer(&String::from_utf8_lossy(&line[..end]), world, now_s);
        let bytes = format!("{text}\r\n").into_bytes();
        let line_s = (line.len() + bytes.len()) as f64 * BYTE_S;
        Some(Answer::At(now_s + line_s + LATENCY_S, bytes))
    }
}
