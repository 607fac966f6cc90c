//! The supply that feeds the lamp: channel 1 of a Rigol DP832. Off at power-up, levels of zero.
//!
//! Commands after the DP800 programming guide as cited by public drivers.

use isolux_darkroom::Instrument;
use isolux_darkroom::electrical::lights;
use isolux_transport::{LineSettings, Parity};

use crate::scpi::{Errors, ILLEGAL_VALUE, UNDEFINED_HEADER, Unit, line, reply, run_line};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::{Switches, World};

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Supply,
    driver: "scpi-supply",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("supply", "?profile=dp800&channel=1&voltage_v=24&current_a=0.35")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(Supply::new(world)),
};

const IDENTITY: &str = "RIGOL TECHNOLOGIES,DP832,DP8C000000001,00.01.14";
/// Largest voltage and current of each channel.
const MOST: [(f64, f64); 3] = [(32.0, 3.2), (32.0, 3.2), (5.3, 3.2)];
/// The channel that the lamp hangs on.
const OF_THE_LAMP: usize = 0;

#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    voltage_v: f64,
    current_a: f64,
    on: bool,
}

/// The supply.
pub(crate) struct Supply {
    channels: [Channel; 3],
    errors: Errors,
}

impl Supply {
    /// The supply at power-up; on where the lamp was on already.
    pub fn new(world: &World) -> Self {
        let mut channels = [Channel::default(); 3];
        if world.switches().lamp {
            channels[OF_THE_LAMP] = Channel {
                voltage_v: world.room().document().lamp.voltage_v,
                current_a: MOST[OF_THE_LAMP].1,
                on: true,
            };
        }
        Self {
            channels,
            errors: Errors::default(),
        }
    }

    /// Gives the lamp what its channel has.
    fn feed(&self, world: &mut World, now_s: f64) {
        let Channel {
            voltage_v,
            current_a,
            on,
        } = self.channels[OF_THE_LAMP];
        let lamp = on && lights(world.room().document(), voltage_v, current_a);
        world.set_supply_v(if on { voltage_v } else { 0.0 });
        let switches = world.switches();
        world.set_switches(Switches { lamp, ..switches }, now_s);
    }

    fn run(&mut self, unit: &Unit, world: &mut World, now_s: f64) -> Result<Option<String>, (i32, &'static str)> {
        for (header, most) in [
            ("SOURce#:VOLTage", MOST.map(|most| most.0)),
            ("SOURce#:CURRent", MOST.map(|most| most.1)),
        ] {
            let Some(numbers) = unit.is(header) else { continue };
            let place = numbers[0]
                .checked_sub(1)
                .filter(|place| *place < MOST.len())
                .ok_or(UNDEFINED_HEADER)?;
            let channel = &mut self.channels[place];
            let level = if header.ends_with("VOLTage") {
                &mut channel.voltage_v
            } else {
                &mut channel.current_a
            };
            if unit.query {
                return Ok(Some(format!("{level:.3}")));
            }
            let wanted = unit.parameter().and_then(|text| text.parse::<f64>().ok());
            *level = wanted
                .filter(|value| (0.0..=most[place]).contains(value))
                .ok_or(ILLEGAL_VALUE)?;
            self.feed(world, now_s);
            return Ok(None);
        }
        // CH1 where none is named; what is set follows it.
        let (place, rest) = match unit.parameters.split_first() {
            Some((name, rest)) if name.starts_with("CH") => {
                let number = name[2..].parse::<usize>().ok().and_then(|number| number.checked_sub(1));
                (number.filter(|place| *place < MOST.len()).ok_or(ILLEGAL_VALUE)?, rest)
            }
            _ => (OF_THE_LAMP, &unit.parameters[..]),
        };
        let Channel { voltage_v, on, .. } = self.channels[place];
        let loaded = place == OF_THE_LAMP && world.switches().lamp;
        let line = loaded.then(|| world.electrical(now_s));
        if unit.is("OUTPut").or(unit.is("OUTPut:STATe")).is_some() {
            if unit.query {
                return Ok(Some(if on { "ON" } else { "OFF" }.to_owned()));
            }
            self.channels[place].on = match rest {
                [word] if word == "ON" || word == "1" => true,
                [word] if word == "OFF" || word == "0" => false,
                _ => return Err(ILLEGAL_VALUE),
            };
            self.feed(world, now_s);
            return Ok(None);
        }
        if !unit.query {
            return Err(UNDEFINED_HEADER);
        }
        if unit.is("OUTPut:OVP:QUES").or(unit.is("OUTPut:OCP:QUES")).is_some() {
            return Ok(Some("NO".to_owned()));
        }
        let measured = if unit.is("MEASure:VOLTage").is_some() {
            if on { voltage_v } else { 0.0 }
        } else if unit.is("MEASure:CURRent").is_some() {
            line.map_or(0.0, |line| line.current_a)
        } else if unit.is("MEASure:POWEr").is_some() {
            line.map_or(0.0, |line| line.power_w)
        } else {
            return Err(UNDEFINED_HEADER);
        };
        Ok(Some(format!("{measured:.4}")))
    }
}

impl Twin for Supply {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let requested = line(inbox)?;
        let mut errors = std::mem::take(&mut self.errors);
        let answer = run_line(&requested, IDENTITY, &mut errors, |unit| self.run(unit, world, now_s));
        self.errors = errors;
        Some(reply(&requested, &answer, now_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    #[test]
    fn the_lamp_lights_where_the_levels_suffice_and_is_dark_where_the_output_is_off() {
        let mut world = World::new(Darkroom::default());
        world.set_supply_v(0.0);
        let mut supply = Supply::new(&world);
        let mut say =
            |world: &mut World, text: &str| match supply.receive(&mut format!("{text}\n").into_bytes(), world, 3.0) {
                Some(Answer::At(_, bytes)) => String::from_utf8(bytes).unwrap(),
                _ => panic!("a line is answered or not, at once"),
            };
        say(&mut world, ":SOUR1:VOLT 24;:SOUR1:CURR 0.35");
        assert_eq!(
            say(&mut world, ":SOUR1:VOLT?;:SOUR1:CURR?;:OUTP? CH1"),
            "24.000;0.350;OFF\r\n"
        );
        assert_eq!(world.electrical(4.0).voltage_v, 0.0);
        say(&mut world, ":OUTP CH1,ON");
        assert!(world.switches().lamp && (world.electrical(5.0).power_w - 4.2).abs() < 1e-9);
        assert_eq!(
            say(&mut world, ":OUTP? CH1;:OUTP:OVP:QUES? CH1;:MEAS:VOLT? CH1"),
            "ON;NO;24.0000\r\n"
        );
        say(&mut world, ":SOUR1:VOLT 12");
        assert!(!world.switches().lamp, "below its voltage it stays dark");
        say(&mut world, ":SOUR1:VOLT 24;:OUTP CH1,OFF");
        assert!(!world.switches().lamp && world.electrical(6.0).voltage_v == 0.0);
        assert_eq!(
            say(&mut world, ":SOUR1:VOLT 40;:SYST:ERR?"),
            "-224,\"Illegal parameter value\"\r\n"
        );
    }
}
