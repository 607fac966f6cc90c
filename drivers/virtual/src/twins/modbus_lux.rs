//! A lux meter on Modbus, unit 1: an RS-485 transmitter that gives its reading in lx (u32, registers 0007h and 0008h)
//! and in thousandths of a lux (u32, registers 0002h and 0003h), the upper word first; function 03 and 04 alike.
//!
//! A new value after each integration of the room's meter. There is one range, and no number below zero: noise about a
//! dark offset is cut off there, as such instruments do.

use isolux_darkroom::Instrument;
use isolux_transport::{LineSettings, Parity};

use crate::modbus::{Exception, Query, Wanted, take};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    driver: "modbus-lux",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("luxmeter", "?profile=u32-thousandths&unit=1")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(ModbusLux),
};

const UNIT: u8 = 1;
/// Ten bits a byte at 9600 baud, s.
const BYTE_S: f64 = 10.0 / 9600.0;
/// From the end of a request to the first byte of its answer, s.
const LATENCY_S: f64 = 0.01;
/// The converter's end, lx.
const END_LX: f64 = 250_000.0;
/// First register of the reading in thousandths and of the one in lx.
const THOUSANDTHS: u16 = 2;
const LUX: u16 = 7;

/// The meter.
pub(crate) struct ModbusLux;

/// What it indicates at `now_s`, lx.
fn indicated_lx(world: &World, now_s: f64) -> f64 {
    let room = world.room();
    let period_s = room.document().luxmeter.integration_s;
    let conversion = ((now_s / period_s).floor() - 1.0).max(0.0);
    let from_s = conversion * period_s;
    let light = world.meter_lx(from_s, from_s + period_s);
    let indicated = room.indicated_for_lx(light, world.temperature_c(from_s), 0);
    let noise = room.reading_noise_lx(indicated) * room.meter_noise(conversion as u64);
    (indicated + noise).clamp(0.0, END_LX)
}

fn words(value: u32) -> [u16; 2] {
    [(value >> 16) as u16, value as u16]
}

fn answer(query: &Query, world: &World, now_s: f64) -> Vec<u8> {
    let (from, count) = match query.wanted() {
        Ok(Wanted::Read { from, count }) => (from, count),
        Ok(Wanted::Write { .. }) => return query.refused(Exception::Function),
        Err(exception) => return query.refused(exception),
    };
    let (first, steps_per_lx) = match from {
        THOUSANDTHS..=3 => (THOUSANDTHS, 1000.0),
        LUX..=8 => (LUX, 1.0),
        _ => return query.refused(Exception::Address),
    };
    let raw = words((indicated_lx(world, now_s) * steps_per_lx).round() as u32);
    match raw.get(usize::from(from - first)..usize::from(from - first + count)) {
        Some(wanted) => query.registers(wanted),
        None => query.refused(Exception::Address),
    }
}

impl Twin for ModbusLux {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        loop {
            let query = take(inbox)?;
            // On a line every other unit is another device.
            if query.unit == UNIT {
                let bytes = answer(&query, world, now_s);
                let line_s = (query.length() + bytes.len()) as f64 * BYTE_S;
                return Some(Answer::At(now_s + line_s + LATENCY_S, bytes));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Switches;
    use isolux_darkroom::Darkroom;

    fn ask(world: &mut World, now_s: f64, mbap: &[u8]) -> Vec<u8> {
        let mut inbox = [&[0, 9, 0, 0, 0, 6], mbap].concat();
        match ModbusLux.receive(&mut inbox, world, now_s) {
            Some(Answer::At(_, bytes)) => bytes[8..].to_vec(),
            _ => panic!(),
        }
    }

    #[test]
    fn both_registers_show_the_light_of_the_last_integration() {
        let mut document = Darkroom::default();
        document.luxmeter.noise_rel = 0.0;
        document.luxmeter.noise_lx = 0.0;
        document.luxmeter.integration_s = 1.0;
        let mut world = World::new(document);
        let illuminated = Switches {
            lamp: true,
            shutter_open: true,
            baffle_in: false,
        };
        world.set_switches(illuminated, 0.0);
        let room = world.room();
        let truth = room.indicated_for_lx(world.meter_lx(4.0, 5.0), world.temperature_c(4.0), 0);
        let answer = ask(&mut world, 5.5, &[1, 3, 0, 2, 0, 2]);
        assert_eq!(answer[0], 4);
        let shown = u32::from_be_bytes([answer[1], answer[2], answer[3], answer[4]]);
        assert_eq!(shown, (truth * 1000.0).round() as u32);
        let answer = ask(&mut world, 5.5, &[1, 4, 0, 7, 0, 2]);
        assert_eq!(
            u32::from_be_bytes([answer[1], answer[2], answer[3], answer[4]]),
            truth.round() as u32
        );
        // One register of a reading is an answer, three are none.
        assert_eq!(ask(&mut world, 5.5, &[1, 3, 0, 8, 0, 1]).len(), 3);
        assert_eq!(ask(&mut world, 5.5, &[1, 3, 0, 7, 0, 3]), [Exception::Address as u8]);
        assert_eq!(ask(&mut world, 5.5, &[1, 6, 0, 7, 0, 3]), [Exception::Function as u8]);
    }

    #[test]
    fn another_unit_does_not_answer() {
        let mut world = World::new(Darkroom::default());
        let mut inbox = vec![0, 9, 0, 0, 0, 6, 2, 3, 0, 7, 0, 2];
        assert!(ModbusLux.receive(&mut inbox, &mut world, 1.0).is_none());
        assert!(inbox.is_empty());
    }
}
