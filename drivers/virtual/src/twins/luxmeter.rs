//! The lux meter: a Konica Minolta T-10A with one head, address 00.
//!
//! A new value every half second; commands 10 (read), 28, 54 (PC mode), 55 (hold, broadcast). Frames and status
//! characters after "T-10 Communication specifications".

use isolux_darkroom::{Instrument, meter};
use isolux_transport::{LineSettings, Parity};

use crate::twin::{Answer, InMotion, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    driver: "konica-t10a",
    line: LineSettings {
        baud: 9600,
        data_bits: 7,
        parity: Parity::Even,
        stop_bits: 1,
    },
    opens: &[("luxmeter", "?head=0")],
    sweeps: Some(InMotion::ByOwnClock {
        update_interval_ms: 500,
    }),
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(T10A::new()),
};

const STX: u8 = 0x02;
const ETX: u8 = 0x03;
/// A request has 14 bytes, so it takes this long at 9600 baud with ten bits a byte; an answer takes this for each byte,
/// s.
const BYTE_S: f64 = 10.0 / 9600.0;

/// The meter.
pub struct T10A {
    /// Range in use, and whether the meter may change it.
    range: u8,
    automatic: bool,
    /// Number of the conversion that is held, if the meter holds.
    held: Option<u64>,
    remote: bool,
}

impl T10A {
    /// The meter at power-up: automatic range, running.
    pub fn new() -> Self {
        Self {
            range: 1,
            automatic: true,
            held: None,
            remote: false,
        }
    }

    fn command(&mut self, body: &[u8], world: &World, now_s: f64) -> Option<Vec<u8>> {
        let text = std::str::from_utf8(body).ok()?;
        let (head, command, parameters) = (text.get(0..2)?, text.get(2..4)?, text.get(4..8)?);
        match (head, command) {
            ("00", "54") => {
                self.remote = true;
                Some(frame(b"0054    "))
            }
            ("00" | "99", "55") => {
                let hold = parameters.starts_with('1');
                self.held = hold.then(|| last_conversion(world, now_s));
                None
            }
            ("00", "28") => Some(frame(b"0028    ")),
            ("00", "10") if self.remote => {
                let parameter: Vec<u8> = parameters.bytes().collect();
                match parameter[2] {
                    b'0' => self.automatic = true,
                    digit @ b'1'..=b'5' => {
                        self.automatic = false;
                        self.range = digit - b'0';
                    }
                    _ => return None,
                }
                Some(self.reading(parameter[0], world, now_s))
            }
            _ => None,
        }
    }

    fn reading(&mut self, hold: u8, world: &World, now_s: f64) -> Vec<u8> {
        let period = period_s(world);
        let conversion = self.held.unwrap_or_else(|| last_conversion(world, now_s));
        let from_s = conversion as f64 * period + world.room().document().luxmeter.clock_phase_s;
        let light = world.meter_lx(from_s, from_s + period);
        let room = world.room();
        let ambient_c = world.temperature_c(from_s);
        let indicate = |range: u8| {
            let indicated = room.indicated_for_lx(light, ambient_c, range);
            indicated + room.reading_noise_lx(indicated) * room.meter_noise(conversion)
        };
        if self.automatic {
            self.range = meter::auto_range(indicate(self.range), self.range);
        }
        let shown = meter::displayed_lx(indicate(self.range), self.range);
        let error = if shown.is_some() { b' ' } else { b'5' };
        let mut body = b"0010".to_vec();
        body.extend([
            if self.held.is_some() { b'1' } else { hold },
            error,
            b'0' + self.range,
            b'0',
        ]);
        body.extend(value(shown.unwrap_or(0.0), self.range));
        // Δ and % of a reference that nobody has set.
        body.extend(value(shown.unwrap_or(0.0), self.range));
        body.extend(b"      ");
        frame(&body)
    }
}

/// Between two conversions, s.
fn period_s(world: &World) -> f64 {
    let meter = &world.room().document().luxmeter;
    meter.by_its_clock_s(meter.integration_s)
}

/// Number of the last conversion that is complete at `now_s`.
fn last_conversion(world: &World, now_s: f64) -> u64 {
    let since_s = now_s - world.room().document().luxmeter.clock_phase_s;
    ((since_s / period_s(world)).floor() - 1.0).max(0.0) as u64
}

/// Sign, four digits, exponent e: digits × 10^(e − 4) lx.
fn value(shown_lx: f64, range: u8) -> Vec<u8> {
    let digits = (shown_lx / meter::digit_lx(range)).round() as i64;
    let sign = match digits {
        0 => '=',
        1.. => '+',
        _ => '-',
    };
    format!("{sign}{:04}{}", digits.abs(), range + 1).into_bytes()
}

/// STX, body, ETX, block check (XOR after STX through ETX, two hexadecimal digits), CR, LF.
fn frame(body: &[u8]) -> Vec<u8> {
    let check = body.iter().fold(ETX, |check, byte| check ^ byte);
    let mut frame = vec![STX];
    frame.extend(body);
    frame.push(ETX);
    frame.extend(format!("{check:02X}\r\n").bytes());
    frame
}

impl Twin for T10A {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        loop {
            let start = inbox.iter().position(|byte| *byte == STX).unwrap_or(inbox.len());
            inbox.drain(..start);
            let end = inbox.iter().position(|byte| *byte == ETX)?;
            if inbox.len() < end + 3 {
                return None;
            }
            let request: Vec<u8> = inbox.drain(..end + 3).collect();
            let body = &request[1..end];
            let check = body.iter().fold(ETX, |check, byte| check ^ byte);
            let stated = std::str::from_utf8(&request[end + 1..])
                .ok()
                .and_then(|hex| u8::from_str_radix(hex, 16).ok());
            if stated != Some(check) || body.len() != 8 {
                continue;
            }
            if let Some(bytes) = self.command(body, world, now_s) {
                let late_s = world.room().meter_latency_s(last_conversion(world, now_s));
                let line_s = (14 + bytes.len()) as f64 * BYTE_S + late_s;
                return Some(Answer::At(now_s + line_s, bytes));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Switches;
    use isolux_darkroom::Darkroom;

    fn ask(twin: &mut T10A, world: &mut World, now_s: f64, body: &[u8]) -> Option<String> {
        let mut inbox = frame(body);
        match twin.receive(&mut inbox, world, now_s)? {
            Answer::At(_, bytes) => Some(String::from_utf8(bytes).unwrap()),
            Answer::When(..) => None,
        }
    }

    /// devices.md §2: PC mode is 02 "00541   " 03 "13"; hold "99551  0" has 02, run "99550  0" has 03, read "00100200"
    /// has 00.
    #[test]
    fn block_checks_are_the_published_ones() {
        for (body, check) in [
            (b"00541   ", "13"),
            (b"99551  0", "02"),
            (b"99550  0", "03"),
            (b"00100200", "00"),
        ] {
            let bytes = frame(body);
            assert_eq!(std::str::from_utf8(&bytes[10..12]).unwrap(), check);
            assert_eq!(bytes.len(), 14);
        }
    }

    #[test]
    fn it_shows_3_37_lx_with_a_digit_of_a_hundredth() {
        let mut document = Darkroom::default();
        document.luxmeter.noise_rel = 0.0;
        document.luxmeter.noise_lx = 0.0;
        document.luxmeter.gain_error_rel = 0.0;
        let mut world = World::new(document);
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            0.0,
        );
        let mut twin = T10A::new();
        assert_eq!(ask(&mut twin, &mut world, 2.0, b"00100200"), None, "not before PC mode");
        assert_eq!(ask(&mut twin, &mut world, 2.0, b"00541   ").unwrap().len(), 14);
        let answer = ask(&mut twin, &mut world, 2.1, b"00100200").unwrap();
        assert_eq!(answer.len(), 32);
        assert_eq!(&answer[1..15], "00100 10+03382", "{answer:?}");
        let answer = ask(&mut twin, &mut world, 2.1, b"00100230").unwrap();
        assert_eq!(&answer[5..15], "0 30+00034", "{answer:?}");
    }

    #[test]
    fn too_much_light_for_a_fixed_range_is_an_error_not_a_number() {
        let mut world =
            World::new(Darkroom::parse("[bench]\ndistance_mm = 1000.0\n[injected_effects]\nonly = true\n").unwrap());
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            0.0,
        );
        let mut twin = T10A::new();
        ask(&mut twin, &mut world, 2.0, b"00541   ");
        let answer = ask(&mut twin, &mut world, 2.0, b"00100210").unwrap();
        assert_eq!(&answer[6..7], "5");
        let answer = ask(&mut twin, &mut world, 2.0, b"00100200").unwrap();
        assert_eq!(&answer[6..8], " 3");
    }

    #[test]
    fn a_held_value_does_not_follow_the_light() {
        let mut world = World::new(Darkroom::default());
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            0.0,
        );
        let mut twin = T10A::new();
        ask(&mut twin, &mut world, 2.0, b"00541   ");
        assert_eq!(ask(&mut twin, &mut world, 2.0, b"99551  0"), None);
        world.set_switches(
            Switches {
                lamp: false,
                shutter_open: true,
                baffle_in: false,
            },
            3.0,
        );
        let held = ask(&mut twin, &mut world, 9.0, b"00101200").unwrap();
        assert!(held[9..15].contains("33"), "{held:?}");
        ask(&mut twin, &mut world, 9.0, b"99550  0");
        let dark = ask(&mut twin, &mut world, 9.0, b"00100200").unwrap();
        assert_eq!(&dark[10..13], "000", "{dark:?}");
    }
}
