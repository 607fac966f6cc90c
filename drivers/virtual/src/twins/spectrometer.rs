//! The spectroradiometer: an Ocean Optics USB2000+ that speaks OOI, one frame a USB transfer.
//!
//! A frame on a byte link is `endpoint u8, length u16 little-endian, payload`: 0x01 host to device, 0x81 control
//! answers, 0x82 spectra. The irradiance calibration in the instrument (command 6D) is W/(m² nm) for one linear count
//! per second.

use std::sync::Arc;

use isolux_darkroom::spectrograph::{PIXELS, dark_noise_lx, linearity_coefficients};
use isolux_darkroom::{Darkroom, Instrument, Room};
use isolux_transport::{LineSettings, Parity};

use super::exposed::{LENS, exposure, seen, window_s};
use crate::twin::{Answer, InMotion, Twin, TwinKind};
use crate::world::World;

/// In the table of twins. A serial adapter that carries the frames has this line; the instrument itself has none.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Spectroradiometer,
    driver: "ocean-ooi",
    line: LineSettings {
        baud: 115_200,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("spectroradiometer", "")],
    sweeps: None,
    noise_lx: None,
    calibration: Some(calibration),
    start: |world| Box::new(Usb2000::new(world, Instrument::Spectroradiometer)),
};

/// In the place of the lux meter, in the table of twins.
pub(crate) const LIGHT_METER: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    opens: &[("luxmeter", AS_LIGHT_METER)],
    sweeps: Some(IN_MOTION),
    noise_lx: Some(noise_lx),
    calibration: None,
    start: |world| Box::new(Usb2000::new(world, Instrument::Luxmeter)),
    ..TWIN
};

/// Behind the address of a spectrometer in the place of the lux meter. The lamp's blue peak is full at 295 lx.
pub(super) const AS_LIGHT_METER: &str = "?calibration=device&integration_ms=100&full_scale_lx=285";

/// How it takes part in sweeps.
pub(super) const IN_MOTION: InMotion = InMotion::OnRequest {
    open: "",
    integration_ms: 100,
};

/// Its noise without light at the integration time of its address.
pub(super) fn noise_lx(document: &Darkroom) -> f64 {
    dark_noise_lx(&document.spectroradiometer, 0.1) / LENS
}

/// The pixels that have a responsivity.
fn calibration(room: &Room) -> String {
    let instrument = &room.document().spectroradiometer;
    let mut text = String::from("wavelength_nm,factor\n");
    for pixel in 0..PIXELS {
        let factor = room.calibration(pixel);
        if factor > 0.0 {
            text.push_str(&format!("{:.4},{factor:.6e}\n", instrument.nm_at(pixel as f64)));
        }
    }
    text
}

const CONTROL: u8 = 0x81;
const SPECTRA: u8 = 0x82;
const END_OF_SPECTRUM: u8 = 0x69;
/// Time of the detector's read-out, s.
const READ_OUT_S: f64 = 0.002;
/// Shortest and longest integration time, µs.
const INTEGRATION_US: std::ops::RangeInclusive<u32> = 1_000..=655_350_000;

/// The spectrometer.
pub struct Usb2000 {
    /// In whose place it stands.
    instrument: Instrument,
    /// Shared with exposures that are under way.
    room: Arc<Room>,
    integration_us: u32,
    /// The integration time under which the next spectrum is still taken.
    stale_us: Option<u32>,
    exposures: u64,
}

impl Usb2000 {
    /// The spectrometer in the place of `instrument` at power-up: 100 ms.
    pub fn new(world: &World, instrument: Instrument) -> Self {
        Self {
            instrument,
            room: Arc::new(seen(world, instrument)),
            integration_us: 100_000,
            stale_us: None,
            exposures: 0,
        }
    }

    fn command(&mut self, payload: &[u8], world: &World, now_s: f64) -> Answer {
        let silent = Answer::At(now_s, Vec::new());
        let control = |bytes: Vec<u8>| Answer::At(now_s + 0.001, transfer(CONTROL, &bytes));
        match *payload {
            [0x02, a, b, c, d] => {
                let wanted = u32::from_le_bytes([a, b, c, d]);
                if INTEGRATION_US.contains(&wanted) {
                    // The exposure under way was begun with the old time.
                    self.stale_us.get_or_insert(self.integration_us);
                    self.integration_us = wanted;
                }
                silent
            }
            [0x05, slot] => {
                let mut answer = vec![0x05, slot];
                answer.extend(self.slot(slot));
                control(answer)
            }
            [0x09] => self.expose(world, now_s),
            [0x6B, register] => {
                let value: u16 = match register {
                    // FPGA 2.01.0: a USB2000+, not a Flame.
                    0x04 => 0x2010,
                    0x48 => 1,
                    _ => 0,
                };
                let mut answer = vec![register];
                answer.extend(value.to_le_bytes());
                control(answer)
            }
            [0x6D, low, high] => control(irradiance_bytes(
                usize::from(u16::from_le_bytes([low, high])),
                &self.room,
            )),
            [0xFE] => {
                let mut answer = (PIXELS as u16).to_le_bytes().to_vec();
                answer.extend(self.integration_us.to_le_bytes());
                answer.extend([0, 0, 0, 15, 0, 0, 0, 0, 0x80, 0]);
                control(answer)
            }
            // 01 initialise, 03 strobe, 0A trigger, 6A write register, and what it does not know: no answer.
            _ => silent,
        }
    }

    fn slot(&self, slot: u8) -> [u8; 15] {
        let instrument = &self.room.document().spectroradiometer;
        let linearity = linearity_coefficients(instrument);
        let text = match slot {
            0 => format!("USB2+V{:05}", self.room.document().seed % 100_000),
            1..=4 => exponential(instrument.wavelength_nm[usize::from(slot) - 1]),
            5 => exponential(0.0),
            6..=13 => exponential(linearity[usize::from(slot) - 6]),
            14 => "7".to_owned(),
            15 => "gr 2 slit 25".to_owned(),
            _ => String::new(),
        };
        let mut data = [0; 15];
        for (place, byte) in data.iter_mut().zip(text.bytes()) {
            *place = byte;
        }
        if slot == 17 {
            data[4..6].copy_from_slice(&instrument.saturation_counts.to_le_bytes());
        }
        data
    }

    fn expose(&mut self, world: &World, now_s: f64) -> Answer {
        let integration_s = f64::from(self.stale_us.take().unwrap_or(self.integration_us)) / 1e6;
        let (instrument, room, index) = (self.instrument, Arc::clone(&self.room), self.exposures);
        self.exposures += 1;
        let window = window_s(world, instrument, now_s, integration_s, index);
        Answer::When(
            window.1 + READ_OUT_S,
            Box::new(move |world| {
                let exposure = exposure(world, instrument, window, index);
                let mut bytes: Vec<u8> = room
                    .exposure_counts(&exposure)
                    .iter()
                    .flat_map(|counts| counts.to_le_bytes())
                    .collect();
                bytes.push(END_OF_SPECTRUM);
                transfer(SPECTRA, &bytes)
            }),
        )
    }
}

/// Sixty bytes of the irradiance calibration from byte `address` on: 2048 big-endian floats.
fn irradiance_bytes(address: usize, room: &Room) -> Vec<u8> {
    (address..address + 60)
        .map(|place| {
            let factor = if place / 4 < PIXELS {
                room.calibration(place / 4) as f32
            } else {
                0.0
            };
            factor.to_be_bytes()[place % 4]
        })
        .collect()
}

fn transfer(endpoint: u8, payload: &[u8]) -> Vec<u8> {
    let mut frame = vec![endpoint];
    frame.extend((payload.len() as u16).to_le_bytes());
    frame.extend(payload);
    frame
}

/// As C prints `%.7E`, which is how the maker stores coefficients: 14 characters at most.
fn exponential(value: f64) -> String {
    let text = format!("{value:.7e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    // Fifteen places hold a sign, eight digits, a point and a four-place exponent.
    format!(
        "{mantissa}E{}{:02}",
        if exponent < 0 { '-' } else { '+' },
        exponent.abs()
    )
}

impl Twin for Usb2000 {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        let header: [u8; 3] = inbox.get(..3)?.try_into().ok()?;
        let length = usize::from(u16::from_le_bytes([header[1], header[2]]));
        if header[0] != 0x01 || length > 512 {
            // Not a frame of ours: a byte of noise, or a host that has lost its place.
            inbox.remove(0);
            return Some(Answer::At(now_s, Vec::new()));
        }
        if inbox.len() < 3 + length {
            return None;
        }
        let payload: Vec<u8> = inbox.drain(..3 + length).skip(3).collect();
        Some(self.command(&payload, world, now_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Switches;
    use isolux_darkroom::Darkroom;

    fn send(twin: &mut Usb2000, world: &mut World, now_s: f64, payload: &[u8]) -> (f64, Vec<u8>) {
        let mut inbox = transfer(0x01, payload);
        match twin.receive(&mut inbox, world, now_s).unwrap() {
            Answer::At(at, bytes) => (at, bytes),
            Answer::When(at, make) => (at, make(world)),
        }
    }

    #[test]
    fn it_tells_its_calibration_as_the_maker_stores_it() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Usb2000::new(&world, Instrument::Spectroradiometer);
        let mut slot = |slot: u8| {
            let (_, bytes) = send(&mut twin, &mut world, 0.0, &[0x05, slot]);
            assert_eq!(&bytes[..5], &[0x81, 17, 0, 0x05, slot]);
            bytes[5..].to_vec()
        };
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().trim_end_matches('\0').to_owned();
        assert_eq!(text(slot(1)), "3.3926000E+02");
        assert_eq!(text(slot(3)), "-1.5320000E-05");
        assert!(text(slot(13)).parse::<f64>().unwrap() < 0.0);
        assert_eq!(text(slot(14)), "7");
        assert_eq!(slot(17)[4..6], [0xFF, 0xFF]);
    }

    #[test]
    fn a_spectrum_has_4097_bytes_and_the_first_after_a_change_is_stale() {
        let mut world = World::new(Darkroom::default());
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            0.0,
        );
        let mut twin = Usb2000::new(&world, Instrument::Spectroradiometer);
        send(&mut twin, &mut world, 1.0, &[0x02, 0x40, 0x0D, 0x03, 0x00]); // 200 ms
        let (at, stale) = send(&mut twin, &mut world, 1.0, &[0x09]);
        assert!((at - 1.102).abs() < 1e-9);
        assert_eq!(stale.len(), 3 + 4097);
        assert_eq!(stale[..3], [0x82, 0x01, 0x10]);
        assert_eq!(*stale.last().unwrap(), 0x69);
        let (at, fresh) = send(&mut twin, &mut world, 2.0, &[0x09]);
        assert!((at - 2.202).abs() < 1e-9);
        let peak = |bytes: &[u8]| {
            bytes[3..4099]
                .chunks(2)
                .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
                .max()
                .unwrap()
        };
        let ratio = f64::from(peak(&fresh) - 1500) / f64::from(peak(&stale) - 1500);
        assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
    }

    #[test]
    fn the_irradiance_calibration_comes_in_sixty_bytes_of_big_endian_floats() {
        let mut world = World::new(Darkroom::default());
        let mut twin = Usb2000::new(&world, Instrument::Spectroradiometer);
        let (_, bytes) = send(&mut twin, &mut world, 0.0, &[0x6D, 0x60, 0x09]);
        assert_eq!(bytes.len(), 3 + 60);
        let factor = f32::from_be_bytes(bytes[3..7].try_into().unwrap());
        assert_eq!(factor, world.room().calibration(600) as f32);
        assert!(factor > 0.0);
    }
}
