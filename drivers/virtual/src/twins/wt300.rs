//! The power meter: a Yokogawa WT310E on Modbus/TCP, RTU or MBAP as the request comes.
//!
//! Items 1 to 9 as delivered, in input registers 2001 to 2018 (07D0h on the wire), single precision, high word first;
//! function
//! 04. What it has not is 7E951BEEh, what is beyond the range 7E94F56Ah. After IM WT310-17EN, chapter 9.

use isolux_darkroom::Instrument;
use isolux_darkroom::noise::{Noise, Stream};
use isolux_transport::{LineSettings, Parity};

use super::powermeter::{Seen, seen};
use crate::modbus::{Exception, Query, Wanted, take};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Powermeter,
    driver: "yokogawa-wt300",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("powermeter", "?unit=1")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| {
        Box::new(Wt300 {
            noise: Noise::new(world.room().document().seed, Stream::PowerMeter),
        })
    },
};

const UNIT: u8 = 1;
/// First input register of the items.
const FIRST: u16 = 0x07D0;
const NO_DATA: u32 = 0x7E95_1BEE;
const OVER_RANGE: u32 = 0x7E94_F56A;
/// From the end of a request to its answer.
const LATENCY_S: f64 = 0.02;

/// The meter.
pub(crate) struct Wt300 {
    noise: Noise,
}

/// U, I, P, S, Q, λ, φ, fU and fI; the meter of the room has no frequency.
fn items(world: &World, noise: Noise, now_s: f64) -> [u32; 9] {
    let Seen {
        voltage_v,
        current_a,
        power_w,
        over_range,
    } = seen(world, noise, now_s);
    let bits = |value: f64| (value as f32).to_bits();
    let of_current = |value: f64| if over_range { OVER_RANGE } else { bits(value) };
    let apparent = voltage_v * current_a;
    let factor = power_w / apparent;
    let (lambda, phi) = match (over_range, apparent > 0.0) {
        (true, _) => (OVER_RANGE, OVER_RANGE),
        (false, true) => (bits(factor), bits(factor.acos().to_degrees())),
        (false, false) => (NO_DATA, NO_DATA),
    };
    let reactive = (apparent * apparent - power_w * power_w).max(0.0).sqrt();
    [
        bits(voltage_v),
        of_current(current_a),
        of_current(power_w),
        of_current(apparent),
        of_current(reactive),
        lambda,
        phi,
        NO_DATA,
        NO_DATA,
    ]
}

fn answer(query: &Query, world: &World, noise: Noise, now_s: f64) -> Vec<u8> {
    let (from, count) = match query.wanted() {
        Ok(Wanted::Read { from, count }) if query.function == 4 => (from, count),
        Ok(_) => return query.refused(Exception::Function),
        Err(exception) => return query.refused(exception),
    };
    let words: Vec<u16> = items(world, noise, now_s)
        .into_iter()
        .flat_map(|item| [(item >> 16) as u16, item as u16])
        .collect();
    let at = from.checked_sub(FIRST).map(usize::from);
    match at.and_then(|at| words.get(at..at + usize::from(count))) {
        Some(wanted) => query.registers(wanted),
        None => query.refused(Exception::Address),
    }
}

impl Twin for Wt300 {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        loop {
            let query = take(inbox)?;
            if query.unit == UNIT {
                let bytes = answer(&query, world, self.noise, now_s);
                return Some(Answer::At(now_s + LATENCY_S, bytes));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Switches;
    use isolux_darkroom::Darkroom;

    #[test]
    fn items_as_delivered_and_the_patterns_of_no_number() {
        let mut document = Darkroom::default();
        document.lamp.power_factor = 0.8;
        document.powermeter.noise_rel = 0.0;
        document.powermeter.gain_error_rel = 0.0;
        let mut world = World::new(document);
        let noise = Noise::new(1, Stream::PowerMeter);
        let ask = |world: &mut World, pdu: [u8; 5]| {
            let mut inbox = [&[0, 9, 0, 0, 0, 6, 1][..], &pdu].concat();
            match (Wt300 { noise }).receive(&mut inbox, world, 5.0) {
                Some(Answer::At(_, bytes)) => bytes[7..].to_vec(),
                _ => panic!("a request is answered at once"),
            }
        };
        let number = |bytes: &[u8], item: usize| {
            let at = 2 + 4 * item;
            f32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
        };
        let off = ask(&mut world, [4, 0x07, 0xD0, 0, 12]);
        assert_eq!((number(&off, 0), number(&off, 2)), (24.0, 0.0));
        assert_eq!(off[22..26], NO_DATA.to_be_bytes());
        let lamp = Switches {
            lamp: true,
            ..Switches::default()
        };
        world.set_switches(lamp, 0.0);
        let on = ask(&mut world, [4, 0x07, 0xD0, 0, 12]);
        assert!((number(&on, 2) - 4.2).abs() < 1e-6 && (number(&on, 5) - 0.8).abs() < 1e-6);
        // Function 03 has other registers, and item 10 is none.
        assert_eq!(ask(&mut world, [3, 0x07, 0xD0, 0, 2]), [0x83, 1]);
        assert_eq!(ask(&mut world, [4, 0x07, 0xE2, 0, 2]), [0x84, 2]);
    }
}
