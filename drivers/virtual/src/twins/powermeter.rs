//! The power meter: a GW Instek GPM-8213 in the supply line of the lamp.
//!
//! Numeric items as in Yokogawa's grammar; engineering notation with five digits; `NAN` where there is nothing to
//! divide by, `INF` beyond the range. After public captures of a GPM-8213.

use isolux_darkroom::Instrument;
use isolux_darkroom::noise::{Noise, Stream};
use isolux_transport::{LineSettings, Parity};

use crate::scpi::{Errors, ILLEGAL_VALUE, UNDEFINED_HEADER, Unit, line, reply, run_line};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Powermeter,
    driver: "scpi-meter",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("powermeter", "?profile=gpm-8213")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(Meter::new(world)),
};

const IDENTITY: &str = "GWInstek,GPM-8213,GES000001,V1.05";
/// A new value, the mean over as long.
const UPDATE_S: f64 = 0.25;
/// Items that can be chosen.
const MOST_ITEMS: usize = 34;

/// What an item can be: its name in a command, in the header of the answer.
const FUNCTIONS: [(&str, &str); 6] = [
    ("U", "Urms"),
    ("I", "Irms"),
    ("P", "P"),
    ("S", "S"),
    ("Q", "Q"),
    ("LAMBDA", "PF"),
];

/// The meter.
pub(crate) struct Meter {
    items: Vec<usize>,
    noise: Noise,
    errors: Errors,
}

impl Meter {
    /// The meter at power-up.
    pub fn new(world: &World) -> Self {
        Self {
            items: vec![0, 1, 2, 3, 5],
            noise: Noise::new(world.room().document().seed, Stream::PowerMeter),
            errors: Errors::default(),
        }
    }
}

/// What a power meter in this room sees of the supply line, with its gain and its noise.
pub(crate) struct Seen {
    pub voltage_v: f64,
    pub current_a: f64,
    pub power_w: f64,
    /// The current is beyond the range: there is no number of it, nor of what is computed from it.
    pub over_range: bool,
}

/// The update before `now_s`.
pub(crate) fn seen(world: &World, noise: Noise, now_s: f64) -> Seen {
    let update = (now_s / UPDATE_S).floor();
    let truth = world.electrical((update - 0.5).max(0.0) * UPDATE_S);
    let meter = &world.room().document().powermeter;
    let [first, second] = noise.normal_pair(update as u64, 0);
    let [third, _] = noise.normal_pair(update as u64, 1);
    let with = |value: f64, gain: f64, draw: f64| value * (1.0 + gain + meter.noise_rel * draw);
    let voltage_v = with(truth.voltage_v, 0.5 * meter.gain_error_rel, first);
    let current_a = with(truth.current_a, 0.5 * meter.gain_error_rel, second);
    Seen {
        voltage_v,
        current_a,
        power_w: with(truth.power_w, meter.gain_error_rel, third).min(voltage_v * current_a),
        over_range: truth.current_a > meter.range_a,
    }
}

/// The functions of one update, in the order of [`FUNCTIONS`]; as text.
fn values(world: &World, noise: Noise, now_s: f64) -> [String; FUNCTIONS.len()] {
    let seen = seen(world, noise, now_s);
    let voltage = engineering(seen.voltage_v);
    if seen.over_range {
        let [i, p, s, q, factor] = ["INF", "INF", "INF", "INF", "NAN"].map(str::to_owned);
        return [voltage, i, p, s, q, factor];
    }
    let apparent = seen.voltage_v * seen.current_a;
    let reactive = (apparent * apparent - seen.power_w * seen.power_w).max(0.0).sqrt();
    let factor = if apparent > 0.0 {
        format!("{:.4}E+00", seen.power_w / apparent)
    } else {
        "NAN".to_owned()
    };
    let [i, p, s, q] = [seen.current_a, seen.power_w, apparent, reactive].map(engineering);
    [voltage, i, p, s, q, factor]
}

/// Five digits, an exponent that is a multiple of three: `240.02E-03`.
fn engineering(value: f64) -> String {
    if value == 0.0 {
        return "0.0000E+00".to_owned();
    }
    let digits = format!("{:.4e}", value.abs());
    let exponent: i32 = digits
        .split_once('e')
        .and_then(|(_, text)| text.parse().ok())
        .unwrap_or(0);
    let power = exponent.div_euclid(3) * 3;
    let mantissa = value / 10_f64.powi(power);
    let places = 4 - exponent.rem_euclid(3) as usize;
    let sign = if power < 0 { '-' } else { '+' };
    format!("{mantissa:.places$}E{sign}{:02}", power.abs())
}

impl Meter {
    fn run(&mut self, unit: &Unit, world: &World, now_s: f64) -> Result<Option<String>, (i32, &'static str)> {
        if unit.is("NUMeric:NORMal:NUMBer").is_some() {
            if unit.query {
                return Ok(Some(format!(":NUM:NORM:NUMB {}", self.items.len())));
            }
            let count = unit.parameter().and_then(|text| text.parse::<usize>().ok());
            let count = count
                .filter(|count| (1..=MOST_ITEMS).contains(count))
                .ok_or(ILLEGAL_VALUE)?;
            self.items.resize(count, 0);
            return Ok(None);
        }
        if let Some(numbers) = unit.is("NUMeric:NORMal:ITEM#") {
            let place = numbers
                .first()
                .and_then(|number| number.checked_sub(1))
                .ok_or(ILLEGAL_VALUE)?;
            if unit.query {
                let (name, _) = FUNCTIONS[*self.items.get(place).ok_or(ILLEGAL_VALUE)?];
                return Ok(Some(format!(":NUM:NORM:ITEM{} {name}", place + 1)));
            }
            let named = |text: &str| {
                FUNCTIONS
                    .iter()
                    .position(|(name, _)| *name == text || (text.len() >= 4 && name.starts_with(text)))
            };
            let function = unit
                .parameters
                .first()
                .and_then(|text| named(text))
                .ok_or(ILLEGAL_VALUE)?;
            *self.items.get_mut(place).ok_or(ILLEGAL_VALUE)? = function;
            return Ok(None);
        }
        if unit.query && unit.is("NUMeric:NORMal:HEADer").is_some() {
            let names: Vec<&str> = self.items.iter().map(|item| FUNCTIONS[*item].1).collect();
            return Ok(Some(names.join(",")));
        }
        if unit.query && unit.is("NUMeric:NORMal:VALue").is_some() {
            let values = values(world, self.noise, now_s);
            let shown: Vec<&str> = self.items.iter().map(|item| values[*item].as_str()).collect();
            return match unit.parameters.first() {
                None => Ok(Some(shown.join(","))),
                Some(text) => {
                    let place = text.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
                    let one = place.and_then(|place| shown.get(place)).ok_or(ILLEGAL_VALUE)?;
                    Ok(Some((*one).to_owned()))
                }
            };
        }
        Err(UNDEFINED_HEADER)
    }
}

impl Twin for Meter {
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
    use crate::world::Switches;
    use isolux_darkroom::Darkroom;

    fn say(meter: &mut Meter, world: &mut World, now_s: f64, text: &str) -> String {
        match meter.receive(&mut format!("{text}\r\n").into_bytes(), world, now_s) {
            Some(Answer::At(_, bytes)) => String::from_utf8(bytes).unwrap(),
            _ => panic!("a line is answered or not, at once"),
        }
    }

    fn illuminated(world: &mut World) {
        let lamp = Switches {
            lamp: true,
            ..Switches::default()
        };
        world.set_switches(lamp, 0.0);
    }

    #[test]
    fn numbers_look_as_in_the_captures() {
        assert_eq!(engineering(127.58), "127.58E+00");
        assert_eq!(engineering(0.240_02), "240.02E-03");
        assert_eq!(engineering(17.688), "17.688E+00");
        assert_eq!(engineering(-9.5985), "-9.5985E+00");
        assert_eq!(engineering(0.999_999_9), "1.0000E+00");
        assert_eq!(engineering(1234.5), "1.2345E+03");
    }

    #[test]
    fn items_are_chosen_and_named_and_the_lamp_decides_what_they_are() {
        let mut document = Darkroom::default();
        document.lamp.power_factor = 0.9;
        document.powermeter.noise_rel = 0.0;
        document.powermeter.gain_error_rel = 0.0;
        let mut world = World::new(document);
        let mut meter = Meter::new(&world);
        assert_eq!(say(&mut meter, &mut world, 1.0, ":NUM:NORM:NUMB 4;ITEM4 LAMB"), "");
        assert_eq!(
            say(&mut meter, &mut world, 1.0, ":NUM:NORM:NUMBER?;HEAD?"),
            ":NUM:NORM:NUMB 4;Urms,Irms,P,PF\r\n"
        );
        let off = say(&mut meter, &mut world, 1.0, ":NUM:NORM:VAL?");
        assert_eq!(off, "24.000E+00,0.0000E+00,0.0000E+00,NAN\r\n");
        illuminated(&mut world);
        let on = say(&mut meter, &mut world, 5.0, ":numeric:normal:value?");
        assert_eq!(on, "24.000E+00,194.44E-03,4.2000E+00,0.9000E+00\r\n");
        assert_eq!(say(&mut meter, &mut world, 5.0, ":NUM:NORM:VAL? 3"), "4.2000E+00\r\n");
    }

    #[test]
    fn beyond_its_range_there_is_no_number_and_what_it_does_not_know_is_an_error() {
        let mut document = Darkroom::default();
        document.powermeter.range_a = 0.1;
        let mut world = World::new(document);
        let mut meter = Meter::new(&world);
        illuminated(&mut world);
        let answer = say(&mut meter, &mut world, 5.0, ":NUM:NORM:VAL?");
        assert!(
            answer.starts_with("24.0") && answer.ends_with(",INF,INF,INF,NAN\r\n"),
            "{answer}"
        );
        assert_eq!(
            say(&mut meter, &mut world, 5.0, ":NUM:NORM:NUMB 99;:SYST:ERR?"),
            "-224,\"Illegal parameter value\"\r\n"
        );
        assert_eq!(say(&mut meter, &mut world, 5.0, "MEAS?"), "");
        assert_eq!(
            say(&mut meter, &mut world, 5.0, "SYST:ERR?"),
            "-113,\"Undefined header\"\r\n"
        );
    }
}
