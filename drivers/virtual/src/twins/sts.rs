//! The spectroradiometer as an Ocean Optics STS: the Ocean Binary Protocol, 1024 pixels of 14 bits.
//!
//! Its optics are those of the room's spectrometer; each of its pixels is the mean of two of that one's, in a quarter
//! of its counts. A message is a header of 44 bytes, a payload, 16 bytes of MD5 or zeros, and a footer.

use std::sync::Arc;

use isolux_darkroom::spectrograph::{PIXELS as FINE_PIXELS, linearity_coefficients};
use isolux_darkroom::{Instrument, Room};
use isolux_transport::{LineSettings, Parity};
use md5::{Digest, Md5};

use super::exposed::{detector_c, exposure, seen, window_s};
use super::spectrometer::{AS_LIGHT_METER, IN_MOTION, noise_lx};
use crate::twin::{Answer, Twin, TwinKind};
use crate::world::World;

/// In the table of twins. The line is that of its RS-232 connector.
pub(crate) const TWIN: TwinKind = TwinKind {
    instrument: Instrument::Spectroradiometer,
    driver: "ocean-obp",
    line: LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    },
    opens: &[("spectroradiometer", "")],
    sweeps: None,
    noise_lx: None,
    calibration: None,
    start: |world| Box::new(Sts::new(world, Instrument::Spectroradiometer)),
};

/// In the place of the lux meter, in the table of twins.
pub(crate) const LIGHT_METER: TwinKind = TwinKind {
    instrument: Instrument::Luxmeter,
    opens: &[("luxmeter", AS_LIGHT_METER)],
    sweeps: Some(IN_MOTION),
    noise_lx: Some(noise_lx),
    start: |world| Box::new(Sts::new(world, Instrument::Luxmeter)),
    ..TWIN
};

const PIXELS: usize = FINE_PIXELS / 2;
/// Counts of the room's spectrometer in one of its own.
const COUNTS: f64 = 4.0;
const FULL_SCALE: u16 = 16_383;
const HEADER: usize = 44;
const TAIL: usize = 20;
/// More follows no header: its longest request carries a few numbers.
const LONGEST_REST: u32 = 256;
const READ_OUT_S: f64 = 0.005;
const INTEGRATION_US: std::ops::RangeInclusive<u32> = 10..=85_000_000;
/// Area of the entrance, cm².
const AREA_CM2: f32 = 0.1;

const RESPONSE: u16 = 1;
const ACK: u16 = 2;
const ACK_REQUESTED: u16 = 4;
const NACK: u16 = 8;
const UNKNOWN_MESSAGE: u16 = 2;
const BAD_CHECKSUM: u16 = 3;
const WRONG_LENGTH: u16 = 5;
const INVALID: u16 = 6;
const MISSING: u16 = 12;

/// The spectrometer.
pub struct Sts {
    /// In whose place it stands.
    instrument: Instrument,
    /// Shared with exposures that are under way.
    room: Arc<Room>,
    integration_us: u32,
    /// The integration time under which the next spectrum is still taken.
    stale_us: Option<u32>,
    exposures: u64,
}

/// A request of the host.
struct Request {
    flags: u16,
    kind: u32,
    regarding: u32,
    md5: bool,
    data: Vec<u8>,
}

impl Request {
    /// The request at the front of `inbox` and its length; an error number where its sum is wrong.
    fn read(inbox: &[u8]) -> Option<(Self, usize, u16)> {
        let header = inbox.get(..HEADER)?;
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let rest = word(40) as usize;
        let whole = inbox.get(..HEADER + rest)?;
        let end = (HEADER + rest).checked_sub(TAIL)?;
        let immediate = usize::from(header[23]).min(16);
        let data = if end > HEADER {
            whole[HEADER..end].to_vec()
        } else {
            header[24..24 + immediate].to_vec()
        };
        let md5 = header[22] == 1;
        let sum: [u8; 16] = Md5::digest(&whole[..end]).into();
        let error = if md5 && whole[end..end + 16] != sum {
            BAD_CHECKSUM
        } else {
            0
        };
        let request = Self {
            flags: u16::from_le_bytes([header[4], header[5]]),
            kind: word(8),
            regarding: word(12),
            md5,
            data,
        };
        Some((request, HEADER + rest, error))
    }

    /// The message that answers it: with a sum where it had one.
    fn reply(&self, flags: u16, error: u16, data: &[u8]) -> Vec<u8> {
        let inside = data.len() <= 16;
        let mut bytes = vec![0xC1, 0xC0, 0x00, 0x11];
        bytes.extend(flags.to_le_bytes());
        bytes.extend(error.to_le_bytes());
        bytes.extend(self.kind.to_le_bytes());
        bytes.extend(self.regarding.to_le_bytes());
        bytes.extend([
            0,
            0,
            0,
            0,
            0,
            0,
            u8::from(self.md5),
            if inside { data.len() as u8 } else { 0 },
        ]);
        if inside {
            bytes.extend(data);
        }
        bytes.resize(40, 0);
        bytes.extend((if inside { TAIL } else { TAIL + data.len() } as u32).to_le_bytes());
        if !inside {
            bytes.extend(data);
        }
        let sum: [u8; 16] = if self.md5 { Md5::digest(&bytes).into() } else { [0; 16] };
        bytes.extend(sum);
        bytes.extend([0xC5, 0xC4, 0xC3, 0xC2]);
        bytes
    }
}

impl Sts {
    /// The spectrometer in the place of `instrument` at power-up: 10 ms.
    pub fn new(world: &World, instrument: Instrument) -> Self {
        Self {
            instrument,
            room: Arc::new(seen(world, instrument)),
            integration_us: 10_000,
            stale_us: None,
            exposures: 0,
        }
    }

    fn command(&mut self, request: Request, world: &World, now_s: f64) -> Answer {
        let at_s = now_s + 0.001;
        let refuse = |error: u16| Answer::At(at_s, request.reply(NACK, error, &[]));
        let tell = |data: &[u8]| Answer::At(at_s, request.reply(RESPONSE, 0, data));
        let done = || match request.flags & ACK_REQUESTED {
            0 => Answer::At(at_s, Vec::new()),
            _ => Answer::At(at_s, request.reply(ACK, 0, &[])),
        };
        let one_of = |numbers: &[f64]| match request.data[..] {
            [index] => match numbers.get(usize::from(index)) {
                Some(number) => tell(&(*number as f32).to_le_bytes()),
                None => refuse(INVALID),
            },
            _ => refuse(WRONG_LENGTH),
        };
        let document = world.room().document();
        let instrument = &document.spectroradiometer;
        match request.kind {
            0x0000_0010 | 0x0010_0000 | 0x0011_0110 => done(),
            0x0000_0100 => tell(format!("S{:05}", document.seed % 100_000).as_bytes()),
            0x0000_0101 => tell(&[16]),
            0x0010_1000 | 0x0010_1100 => self.expose(request, world, now_s),
            0x0010_10A0 => tell(&FULL_SCALE.to_le_bytes()),
            0x0011_0000 => tell(&self.integration_us.to_le_bytes()),
            0x0011_0010 => match request.data[..] {
                [a, b, c, d] => {
                    let wanted = u32::from_le_bytes([a, b, c, d]);
                    if !INTEGRATION_US.contains(&wanted) {
                        return refuse(INVALID);
                    }
                    // The exposure under way was begun with the old time.
                    self.stale_us.get_or_insert(self.integration_us);
                    self.integration_us = wanted;
                    done()
                }
                _ => refuse(WRONG_LENGTH),
            },
            0x0018_0100 | 0x0018_1100 => tell(&[if request.kind == 0x0018_0100 { 4 } else { 8 }]),
            0x0018_0101 => one_of(&wavelengths(instrument.wavelength_nm)),
            0x0018_1101 => one_of(&linearity(&linearity_coefficients(instrument))),
            0x0018_2001 => tell(&irradiance(&self.room)),
            0x0018_2003 => tell(&AREA_CM2.to_le_bytes()),
            0x0018_3100 => tell(&[0]),
            0x0018_3101 => refuse(MISSING),
            0x0040_0000 => tell(&[1]),
            0x0040_0001 => one_of(&[detector_c(world, now_s)]),
            _ => refuse(UNKNOWN_MESSAGE),
        }
    }

    fn expose(&mut self, request: Request, world: &World, now_s: f64) -> Answer {
        let integration_s = f64::from(self.stale_us.take().unwrap_or(self.integration_us)) / 1e6;
        let (instrument, room, index) = (self.instrument, Arc::clone(&self.room), self.exposures);
        self.exposures += 1;
        let window = window_s(world, instrument, now_s, integration_s, index);
        Answer::When(
            window.1 + READ_OUT_S,
            Box::new(move |world| {
                let exposure = exposure(world, instrument, window, index);
                let fine = room.exposure_counts(&exposure);
                let counts = fine.chunks_exact(2).flat_map(|pair| {
                    let mean = 0.5 * (f64::from(pair[0]) + f64::from(pair[1])) / COUNTS;
                    (mean.round() as u16).min(FULL_SCALE).to_le_bytes()
                });
                request.reply(RESPONSE, 0, &counts.collect::<Vec<u8>>())
            }),
        )
    }
}

/// The polynomial of the fine pixel 2p + ½, in powers of p.
fn wavelengths([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let (m, n) = (2.0, 0.5);
    [
        a + n * (b + n * (c + n * d)),
        m * (b + n * (2.0 * c + 3.0 * n * d)),
        m * m * (c + 3.0 * n * d),
        m * m * m * d,
    ]
}

/// The polynomial of counts that are four times as large, in powers of its own.
fn linearity(fine: &[f64]) -> Vec<f64> {
    let powers = std::iter::successors(Some(1.0), |power| Some(power * COUNTS));
    fine.iter()
        .zip(powers)
        .map(|(coefficient, power)| coefficient * power)
        .collect()
}

/// µJ a count: W/(m²·nm) for one count a second, times area and width of the pixel.
fn irradiance(room: &Room) -> Vec<u8> {
    let instrument = &room.document().spectroradiometer;
    let factors = (0..PIXELS).flat_map(|pixel| {
        let (left, right) = (2 * pixel, 2 * pixel + 1);
        let factor = 0.5 * (room.calibration(left) + room.calibration(right)) * COUNTS;
        let width_nm = 2.0 * (instrument.nm_at(right as f64) - instrument.nm_at(left as f64));
        ((100.0 * factor * f64::from(AREA_CM2) * width_nm) as f32).to_le_bytes()
    });
    factors.collect()
}

impl Twin for Sts {
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer> {
        // What does not begin a message is thrown away until something does.
        let Some(start) = inbox.windows(2).position(|pair| pair == [0xC1, 0xC0]) else {
            let kept = usize::from(inbox.last() == Some(&0xC1));
            inbox.drain(..inbox.len() - kept);
            return None;
        };
        inbox.drain(..start);
        if inbox.len() >= HEADER && u32::from_le_bytes([inbox[40], inbox[41], inbox[42], inbox[43]]) > LONGEST_REST {
            inbox.drain(..2);
            return self.receive(inbox, world, now_s);
        }
        let (request, length, error) = Request::read(inbox)?;
        inbox.drain(..length);
        if error != 0 {
            return Some(Answer::At(now_s + 0.001, request.reply(NACK, error, &[])));
        }
        Some(self.command(request, world, now_s))
    }
}
