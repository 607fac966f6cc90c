//! A Rigol DS1054Z with a photodiode that sees the lamp at its first input.
//!
//! Commands after the MSO1000Z/DS1000Z programming guide. One channel, DC-coupled; the record begins when it is forced
//! and is then at rest.

use isolux_darkroom::Instrument;
use isolux_darkroom::noise::{Noise, Stream};
use isolux_transport::{LineSettings, Parity};

use crate::scpi::{Errors, ILLEGAL_VALUE, UNDEFINED_HEADER, Unit, line, run_line, units};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Oscilloscope,
    driver: "scpi-scope",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("oscilloscope", "?profile=ds1000z&channel=1")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |_| Box::new(Oscilloscope::default()),
};

const IDENTITY: &str = "RIGOL TECHNOLOGIES,DS1054Z,DS1ZA000000001,00.04.04.SP4";
/// The photodiode's amplifier: V of the warm, steady lamp, V in the dark, and noise of a sample, V.
pub const LIT_V: f64 = 1.0;
/// In the dark, V.
pub const DARK_V: f64 = 0.004;
const NOISE_V: f64 = 0.006;
/// The converter: V a code, and the codes of zero volts.
const STEP_V: f64 = 0.02;
const ORIGIN: f64 = -87.0;
const REFERENCE: f64 = 127.0;
/// Divisions of a record.
const DIVISIONS: f64 = 12.0;
/// Depths of memory with one channel.
const DEPTHS: [u64; 5] = [12_000, 120_000, 1_200_000, 12_000_000, 24_000_000];
/// Most points of a read, and time that one takes, s.
const MOST_POINTS: u64 = 250_000;
const POINT_S: f64 = 1e-6;
const THINKING_S: f64 = 0.01;

/// The oscilloscope.
pub(crate) struct Oscilloscope {
    errors: Errors,
    scale_s: f64,
    depth: u64,
    /// When the record began; none while it runs on.
    began_s: Option<f64>,
    /// Records so far.
    number: u64,
    from: u64,
    to: u64,
}

impl Default for Oscilloscope {
    fn default() -> Self {
        Self {
            errors: Errors::default(),
            scale_s: 1e-6,
            depth: DEPTHS[0],
            began_s: None,
            number: 0,
            from: 1,
            to: 1200,
        }
    }
}

impl Oscilloscope {
    fn interval_s(&self) -> f64 {
        DIVISIONS * self.scale_s / self.depth as f64
    }

    fn stopped(&self, now_s: f64) -> bool {
        self.began_s
            .is_some_and(|began_s| now_s >= began_s + DIVISIONS * self.scale_s)
    }

    /// The codes of a stretch of the record.
    fn codes(&self, world: &World, began_s: f64) -> Vec<u8> {
        let noise = Noise::new(world.room().document().seed, Stream::Oscilloscope);
        (self.from..=self.to)
            .map(|point| {
                let at_s = began_s + (point - 1) as f64 * self.interval_s();
                let voltage_v =
                    DARK_V + LIT_V * world.lamp_output(at_s) + NOISE_V * noise.normal(point, self.number as u32);
                (voltage_v / STEP_V + ORIGIN + REFERENCE).round().clamp(0.0, 255.0) as u8
            })
            .collect()
    }

    fn run(&mut self, unit: &Unit, now_s: f64) -> Result<Option<String>, (i32, &'static str)> {
        let number = || unit.parameter().and_then(|text| text.parse::<f64>().ok());
        let whole = |most: u64| {
            let value = number().filter(|value| value.fract() == 0.0 && *value >= 1.0);
            value
                .map(|value| value as u64)
                .filter(|value| *value <= most)
                .ok_or(ILLEGAL_VALUE)
        };
        if unit.query {
            return if unit.is("CHANnel#:COUPling").is_some() {
                Ok(Some("DC".to_owned()))
            } else if unit.is("TRIGger:STATus").is_some() {
                Ok(Some(if self.stopped(now_s) { "STOP" } else { "RUN" }.to_owned()))
            } else if unit.is("WAVeform:PREamble").is_some() {
                let interval_s = self.interval_s();
                Ok(Some(format!(
                    "0,2,{},1,{interval_s:.6e},{:.6e},0,{STEP_V:.6e},{ORIGIN},{REFERENCE}",
                    self.depth,
                    -0.5 * DIVISIONS * self.scale_s
                )))
            } else {
                Err(UNDEFINED_HEADER)
            };
        }
        if unit.is("RUN").is_some() {
            self.began_s = None;
        } else if unit.is("SINGle").is_some() {
            self.began_s = None;
            self.number += 1;
        } else if unit.is("TFORce").is_some() {
            self.began_s = Some(now_s);
        } else if unit.is("TIMebase:MAIN:SCALe").is_some() {
            self.scale_s = number()
                .filter(|value| (5e-9..=50.0).contains(value))
                .ok_or(ILLEGAL_VALUE)?;
        } else if unit.is("ACQuire:MDEPth").is_some() {
            let depth = whole(u64::MAX)?;
            // The memory cannot be divided otherwise while the record stands.
            if self.began_s.is_some() || !DEPTHS.contains(&depth) {
                return Err(ILLEGAL_VALUE);
            }
            self.depth = depth;
        } else if unit.is("WAVeform:STARt").is_some() {
            self.from = whole(self.depth)?;
        } else if unit.is("WAVeform:STOP").is_some() {
            self.to = whole(self.depth)?;
        } else {
            let known = [
                ("WAVeform:MODE", "RAW"),
                ("WAVeform:FORMat", "BYTE"),
                ("WAVeform:SOURce", "CHAN1"),
            ];
            let known = known.iter().find(|(header, _)| unit.is(header).is_some());
            let (_, only) = known.ok_or(UNDEFINED_HEADER)?;
            if unit.parameter() != Some(only) {
                return Err(ILLEGAL_VALUE);
            }
        }
        Ok(None)
    }
}

impl Twin for Oscilloscope {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let requested = line(inbox)?;
        let wants_data = units(&requested)
            .iter()
            .any(|unit| unit.query && unit.is("WAVeform:DATA").is_some());
        let bytes = if wants_data {
            match self.began_s {
                Some(began_s) if self.stopped(now_s) && (self.from..self.from + MOST_POINTS).contains(&self.to) => {
                    let codes = self.codes(world, began_s);
                    [format!("#9{:09}", codes.len()).as_bytes(), &codes, b"\n"].concat()
                }
                _ => b"#9000000000\n".to_vec(),
            }
        } else {
            let mut errors = std::mem::take(&mut self.errors);
            let answer = run_line(&requested, IDENTITY, &mut errors, |unit| self.run(unit, now_s));
            self.errors = errors;
            if answer.is_empty() {
                Vec::new()
            } else {
                format!("{answer}\n").into_bytes()
            }
        };
        Some(Answer::At(now_s + THINKING_S + POINT_S * bytes.len() as f64, bytes))
    }
}
