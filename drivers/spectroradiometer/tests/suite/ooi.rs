//! The OOI driver against a scripted USB2000+ on an in-memory link, with the clock paused.
//!
//! The instrument below has its own framing; each spectrum says in the last bits of its counts when its exposure began
//! and how long it was, so that two exposures of the same light differ by no more than one count.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{DeviceError, ErrorKind, OpenError, Spectroradiometer, SpectroradiometerFactory, Target};
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::{MemoryLinks, Ports, TRIES, worth_another_try};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    NoEndMark,
    Short,
    FlipBit(usize, u8),
    Disconnect,
}

struct Instrument {
    began: Instant,
    integration_us: u32,
    trigger: u8,
    /// The exposure that is buffered: begun when, with which time.
    buffered: (u64, u32),
    wavelength: [&'static str; 4],
    order: &'static str,
    irradiance: bool,
    spectrum_faults: VecDeque<Fault>,
    control_faults: VecDeque<Fault>,
    /// By slot: what is done to the bytes of the next readings of it.
    slot_faults: VecDeque<(u8, Fault)>,
    spectra: u32,
    /// First bytes of the commands.
    heard: Vec<u8>,
    /// Counts of the light above 1000.
    light: u16,
}

/// `bits` of `number`, one a pixel from `pixel` on.
fn write_bits(counts: &mut [u16], pixel: usize, bits: usize, number: u64) {
    for bit in 0..bits {
        counts[pixel + bit] += (number >> bit & 1) as u16;
    }
}

fn read_bits(counts: &[u16], pixel: usize, bits: usize) -> u64 {
    (0..bits).map(|bit| u64::from(counts[pixel + bit] & 1) << bit).sum()
}

/// When the exposure began, ms since power-on, and how long it was, ms.
fn exposure(counts: &[u16]) -> (u64, u64) {
    (read_bits(counts, 100, 32), read_bits(counts, 140, 20))
}

fn transfer(endpoint: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![endpoint, (payload.len() & 0xFF) as u8, (payload.len() >> 8) as u8];
    bytes.extend_from_slice(payload);
    bytes
}

impl Instrument {
    fn slot(&self, slot: u8) -> Vec<u8> {
        let mut data = match slot {
            0 => b"USB2+H16355".to_vec(),
            1..=4 => self.wavelength[usize::from(slot) - 1].as_bytes().to_vec(),
            6 => b"9.9e-01".to_vec(),
            7 => b"1.5e-06".to_vec(),
            8..=13 => b"0.0".to_vec(),
            14 => self.order.as_bytes().to_vec(),
            17 => vec![0, 0, 0, 0, 0x58, 0xF2],
            _ => vec![],
        };
        data.resize(15, 0);
        [vec![0x05, slot], data].concat()
    }

    /// Milliseconds since power-on.
    fn now(&self) -> u64 {
        self.began.elapsed().as_millis() as u64
    }
}

async fn serve(instrument: Arc<Mutex<Instrument>>, mut stream: DuplexStream) {
    let mut head = [0; 3];
    while stream.read_exact(&mut head).await.is_ok() {
        assert_eq!(head[0], 0x01, "commands go to endpoint 1");
        let mut payload = vec![0; usize::from(u16::from_le_bytes([head[1], head[2]]))];
        stream.read_exact(&mut payload).await.unwrap();
        let mut wait = 1;
        let (mut answer, fault) = {
            let mut now = instrument.lock().unwrap();
            now.heard.push(payload[0]);
            match payload[..] {
                [0x01] => continue,
                [0x0A, mode, _] => {
                    now.trigger = mode;
                    continue;
                }
                [0x02, a, b, c, d] => {
                    now.integration_us = u32::from_le_bytes([a, b, c, d]);
                    continue;
                }
                [0x05, slot] => {
                    let next = now.slot_faults.front().is_some_and(|(at, _)| *at == slot);
                    let fault = next
                        .then(|| now.slot_faults.pop_front())
                        .flatten()
                        .map(|(_, fault)| fault);
                    (
                        transfer(0x81, &now.slot(slot)),
                        fault.or_else(|| now.control_faults.pop_front()),
                    )
                }
                [0x6D, low, high] => {
                    let address = usize::from(u16::from_le_bytes([low, high]));
                    assert_eq!(address % 60, 0, "byte addresses in steps of a block");
                    if !now.irradiance {
                        continue;
                    }
                    let floats = (address / 4..address / 4 + 15).flat_map(|pixel| (pixel as f32 * 1e-6).to_be_bytes());
                    (transfer(0x81, &floats.collect::<Vec<u8>>()), None)
                }
                [0xFE] => {
                    let mut status = vec![0x00, 0x08];
                    status.extend(now.integration_us.to_le_bytes());
                    status.extend([0, now.trigger, 0, 15, 0, 0, 0, 0, 0x80, 0]);
                    (transfer(0x81, &status), now.control_faults.pop_front())
                }
                [0x09] => {
                    // What was buffered is sent; the next exposure begins as this request is served.
                    let (begun, us) = now.buffered;
                    let end = begun + u64::from(us) / 1000;
                    wait = end.saturating_sub(now.now()) + 2;
                    now.buffered = (now.now() + wait, now.integration_us);
                    now.spectra += 1;
                    let mut counts = vec![1000_u16; 2048];
                    counts[30..1000].fill(1000 + now.light);
                    write_bits(&mut counts, 100, 32, begun);
                    write_bits(&mut counts, 140, 20, u64::from(us / 1000));
                    counts[99] = 62_040;
                    let mut bytes: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
                    bytes.push(0x69);
                    let fault = now.spectrum_faults.pop_front();
                    match fault {
                        Some(Fault::NoEndMark) => bytes[4096] = 0,
                        Some(Fault::Short) => bytes.truncate(4000),
                        Some(Fault::FlipBit(at, bit)) => bytes[at] ^= 1 << bit,
                        _ => {}
                    }
                    (transfer(0x82, &bytes), fault)
                }
                _ => panic!("{payload:?}"),
            }
        };
        tokio::time::sleep(Duration::from_millis(wait)).await;
        match fault {
            Some(Fault::Silent) => continue,
            Some(Fault::Disconnect) => return,
            Some(Fault::Late(milliseconds)) => tokio::time::sleep(Duration::from_millis(milliseconds)).await,
            Some(Fault::NoEndMark) if answer[0] == 0x81 => answer[4] ^= 0x40,
            Some(Fault::FlipBit(at, bit)) if answer[0] == 0x81 => answer[5 + at] ^= 1 << bit,
            _ => {}
        }
        if stream.write_all(&answer).await.is_err() {
            return;
        }
    }
}

fn bench() -> (OceanOoiDriver, Arc<Mutex<Instrument>>) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("spectro").unwrap();
    let instrument = Arc::new(Mutex::new(Instrument {
        began: Instant::now(),
        integration_us: 100_000,
        trigger: 3,
        buffered: (0, 100_000),
        wavelength: ["3.3926E+02", "3.8E-01", "-1.5E-05", "-2.6E-09"],
        order: "7",
        irradiance: true,
        spectrum_faults: VecDeque::new(),
        control_faults: VecDeque::new(),
        slot_faults: VecDeque::new(),
        spectra: 0,
        heard: vec![],
        light: 0,
    }));
    let twin = Arc::clone(&instrument);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    (OceanOoiDriver::new(Ports::new(Arc::new(links))), instrument)
}

async fn open(driver: &OceanOoiDriver) -> Result<Box<dyn Spectroradiometer>, OpenError> {
    driver
        .open_spectroradiometer(&Target::parse("ocean-ooi:memory:spectro").unwrap())
        .await
}

fn deadline() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

#[tokio::test(start_paused = true)]
async fn opens_with_the_calibration_of_the_eeprom() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    assert_eq!(spectro.identity().serial.as_deref(), Some("USB2+H16355"));
    assert_eq!(instrument.lock().unwrap().trigger, 0, "free run again");
    let properties = spectro.properties();
    assert_eq!(properties.wavelength_nm.len(), 2048);
    let at = |pixel: f64| 339.26 + pixel * (0.38 + pixel * (-1.5e-5 + pixel * -2.6e-9));
    for pixel in [0, 6, 1024, 2047] {
        assert!((properties.wavelength_nm[pixel] - at(pixel as f64)).abs() < 1e-9);
    }
    assert_eq!(properties.nonlinearity, [0.99, 1.5e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        (properties.saturation_counts, properties.full_scale_counts),
        (62_040, 65_535)
    );
    assert_eq!(properties.dark_pixels, 6..21);
    let factors = properties.irradiance_factor.as_ref().unwrap();
    assert_eq!((factors.len(), factors[2047]), (2048, f64::from(2047.0_f32 * 1e-6)));
}

/// The instrument counts whole microseconds: what it holds is the time, not a fraction more that looks like a restart.
#[tokio::test(start_paused = true)]
async fn a_fraction_of_a_microsecond_is_no_other_time() {
    let (driver, _instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    let set = spectro
        .set_integration_time(Duration::from_nanos(40_230_186))
        .await
        .unwrap();
    assert_eq!(set, Duration::from_micros(40_230));
    for _ in 0..3 {
        tokio::time::sleep(Duration::from_secs(3)).await;
        assert_eq!(spectro.acquire(deadline()).await.unwrap().integration_time, set);
    }
}

#[tokio::test(start_paused = true)]
async fn no_stale_spectrum_after_a_pause_or_a_change_of_time() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    let power_on = instrument.lock().unwrap().began;
    for milliseconds in [20, 400, 5] {
        let time = Duration::from_millis(milliseconds);
        assert_eq!(spectro.set_integration_time(time).await.unwrap(), time);
        tokio::time::sleep(Duration::from_secs(3)).await;
        let called = Instant::now();
        let raw = spectro.acquire(deadline()).await.unwrap();
        let (begun_ms, time_ms) = exposure(&raw.counts);
        assert_eq!(time_ms, milliseconds, "taken with the old time");
        let begun = power_on + Duration::from_millis(begun_ms);
        assert!(begun >= called, "its exposure began before it was asked for");
        assert!(
            raw.began <= begun && begun + time <= raw.ended,
            "the stated interval holds the true one"
        );
        assert_eq!(raw.integration_time, time);
        assert_eq!(spectro.properties().saturated(&raw), [99]);
        let linear = spectro.properties().linear_counts(&raw, None).unwrap();
        assert_eq!(linear[500], 0.0);
        let net = (62_040.0 - 1000.0) * 65_535.0 / 62_040.0;
        assert!((linear[99] - net / (0.99 + 1.5e-6 * net)).abs() < 1e-6);
    }
}

#[tokio::test(start_paused = true)]
async fn in_motion_each_spectrum_says_when_its_light_was() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    let power_on = instrument.lock().unwrap().began;
    let time = Duration::from_millis(100);
    spectro.set_integration_time(time).await.unwrap();
    tokio::time::sleep(Duration::from_secs(3)).await;
    // The one that was stored has no moment; nor has one after a pause of more than half an exposure.
    let stored = spectro.sample(deadline()).await.unwrap_err();
    assert!(stored.to_string().contains("was ready before"), "{stored}");
    for pause_ms in [0, 0, 3, 30, 70, 0] {
        tokio::time::sleep(Duration::from_millis(pause_ms)).await;
        let sampled = spectro.sample(deadline()).await;
        if pause_ms == 70 {
            sampled.unwrap_err();
            continue;
        }
        let raw = sampled.unwrap();
        let begun = power_on + Duration::from_millis(exposure(&raw.counts).0);
        let off = raw.began.max(begun) - raw.began.min(begun);
        assert!(off <= Duration::from_millis(2), "after {pause_ms} ms: {off:?}");
    }
    // A lost one is given up soon.
    instrument.lock().unwrap().spectrum_faults.push_back(Fault::Silent);
    let called = Instant::now();
    spectro.sample(deadline()).await.unwrap_err();
    assert!(called.elapsed() < Duration::from_millis(600), "{:?}", called.elapsed());
}

#[tokio::test(start_paused = true)]
async fn damaged_spectra_are_taken_again_and_late_ones_never_mistaken() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.set_integration_time(Duration::from_millis(50)).await.unwrap();
    for fault in [Fault::NoEndMark, Fault::Short] {
        instrument.lock().unwrap().spectrum_faults.extend([fault, fault]);
        spectro.acquire(deadline()).await.unwrap();
        instrument
            .lock()
            .unwrap()
            .spectrum_faults
            .extend([fault; TRIES as usize]);
        assert_eq!(
            spectro.acquire(deadline()).await.unwrap_err().kind(),
            ErrorKind::Malformed,
            "{fault:?}"
        );
    }
    for late in [1500, 2500, 4000] {
        instrument.lock().unwrap().spectrum_faults.push_back(Fault::Late(late));
        let error = spectro.acquire(deadline()).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Timeout);
        let called = Instant::now();
        match spectro.acquire(deadline()).await {
            Ok(raw) => {
                let power_on = instrument.lock().unwrap().began;
                assert!(
                    power_on + Duration::from_millis(exposure(&raw.counts).0) >= called,
                    "late by {late} ms"
                );
            }
            // Later than any patience: told, not used.
            Err(error) => assert!(worth_another_try(error.kind()), "{error}"),
        }
        tokio::time::sleep(Duration::from_secs(10)).await;
    }
    instrument
        .lock()
        .unwrap()
        .control_faults
        .extend([Fault::NoEndMark, Fault::Silent]);
    spectro.set_integration_time(Duration::from_millis(60)).await.unwrap();
    instrument.lock().unwrap().spectrum_faults.push_back(Fault::Disconnect);
    assert_eq!(
        spectro.acquire(deadline()).await.unwrap_err().kind(),
        ErrorKind::Disconnected
    );
}

#[tokio::test(start_paused = true)]
async fn deadlines_and_limits_are_kept() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    for time in [Duration::from_micros(999), Duration::from_secs(656)] {
        assert_eq!(
            spectro.set_integration_time(time).await.unwrap_err().kind(),
            ErrorKind::Unsupported
        );
    }
    spectro.set_integration_time(Duration::from_secs(10)).await.unwrap();
    let spectra = instrument.lock().unwrap().spectra;
    let soon = Instant::now() + Duration::from_secs(5);
    assert_eq!(spectro.acquire(soon).await.unwrap_err().kind(), ErrorKind::Timeout);
    assert_eq!(Instant::now(), soon);
    assert_eq!(instrument.lock().unwrap().spectra, spectra + 1);
}

#[tokio::test(start_paused = true)]
async fn an_instrument_without_calibration_is_refused_or_says_so() {
    let (driver, instrument) = bench();
    instrument.lock().unwrap().irradiance = false;
    assert_eq!(open(&driver).await.unwrap().properties().irradiance_factor, None);
    for (slot, text) in [(0, ""), (1, "-3.8E-01"), (2, "nan")] {
        let (driver, instrument) = bench();
        instrument.lock().unwrap().wavelength[slot] = text;
        let Err(OpenError::Device(error)) = open(&driver).await else {
            panic!("opened with {text:?}")
        };
        assert!(matches!(error, DeviceError::Fault { .. }), "{error}");
    }
    let (driver, instrument) = bench();
    instrument.lock().unwrap().order = "8";
    assert!(open(&driver).await.is_err());
}

/// Issue 10, B8: one flipped bit made 339 nm into 379 nm, and the colour temperature 3407 K instead of 5897 K.
#[tokio::test(start_paused = true)]
async fn a_bit_that_flips_in_a_coefficient_changes_nothing_or_is_a_fault() {
    // "3.3926E+02": byte 2 is the second 3; with bit 2 flipped it is a 7.
    let flip = Fault::FlipBit(2, 2);
    for faults in [vec![(1, flip)], vec![(1, Fault::Silent), (1, flip)]] {
        let (driver, instrument) = bench();
        instrument.lock().unwrap().slot_faults.extend(faults);
        let spectro = open(&driver).await.unwrap();
        assert!(instrument.lock().unwrap().slot_faults.is_empty(), "it happened");
        assert_eq!(spectro.properties().wavelength_nm[0], 339.26);
    }
    for (slot, at) in [(0, 7), (3, 3), (6, 0), (17, 5)] {
        let (driver, instrument) = bench();
        instrument
            .lock()
            .unwrap()
            .slot_faults
            .push_back((slot, Fault::FlipBit(at, 1)));
        let spectro = open(&driver).await.unwrap();
        let properties = spectro.properties();
        assert_eq!(
            (
                spectro.identity().serial.as_deref(),
                properties.wavelength_nm[2047].round()
            ),
            (Some("USB2+H16355"), 1032.0)
        );
        assert_eq!(
            (properties.nonlinearity[0], properties.saturation_counts),
            (0.99, 62_040)
        );
    }
    // Three readings, three texts.
    let (driver, instrument) = bench();
    let faults = [flip, Fault::FlipBit(3, 1), Fault::FlipBit(3, 0)];
    instrument
        .lock()
        .unwrap()
        .slot_faults
        .extend(faults.map(|fault| (1, fault)));
    let Err(OpenError::Device(error)) = open(&driver).await else {
        panic!("opened")
    };
    assert!(matches!(error, DeviceError::Fault { .. }), "{error}");
    for part in ["EEPROM slot 1", "3.7926E+02", "3.3;26E+02", "3.3826E+02"] {
        assert!(error.to_string().contains(part), "{part}: {error}");
    }
}

#[tokio::test(start_paused = true)]
async fn what_no_detector_can_see_is_a_fault() {
    for wavelength in [
        ["3.3926E+03", "3.8E-01", "-1.5E-05", "-2.6E-09"],
        ["3.3926E+02", "3.8E-04", "0", "0"],
        ["3.3926E+02", "3.8E-01", "1.5E-03", "0"],
    ] {
        let (driver, instrument) = bench();
        instrument.lock().unwrap().wavelength = wavelength;
        let Err(OpenError::Device(error)) = open(&driver).await else {
            panic!("opened with {wavelength:?}")
        };
        assert!(error.to_string().contains("EEPROM slots 1 to 4"), "{error}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_bit_that_flips_in_a_spectrum_is_never_given() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.set_integration_time(Duration::from_millis(50)).await.unwrap();
    for skipped in 0..3 {
        for bit in [12, 13, 14, 15] {
            // The high byte of pixel 700, in the first, second or third exposure of an acquisition.
            let fault = Fault::FlipBit(1401, bit - 8);
            let faults = std::iter::repeat_n(Fault::Late(0), skipped).chain([fault]);
            instrument.lock().unwrap().spectrum_faults = faults.collect();
            let raw = spectro.acquire(deadline()).await.unwrap();
            assert_eq!(raw.counts[700], 1000, "bit {bit} of exposure {skipped}");
        }
    }
    instrument.lock().unwrap().spectrum_faults = (0..20).map(|place| Fault::FlipBit(1401 + 2 * place, 6)).collect();
    let error = spectro.acquire(deadline()).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Malformed && error.to_string().contains("17384 and 1000 counts"),
        "{error}"
    );
}

#[tokio::test(start_paused = true)]
async fn light_that_changed_before_the_call_is_not_mixed_in() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.set_integration_time(Duration::from_millis(50)).await.unwrap();
    for light in [20_000, 0, 5_000] {
        instrument.lock().unwrap().light = light;
        let raw = spectro.acquire(deadline()).await.unwrap();
        assert_eq!(raw.counts[700], 1000 + light);
    }
}

#[tokio::test(start_paused = true)]
async fn an_instrument_that_lost_its_integration_time_is_a_fault() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.set_integration_time(Duration::from_millis(50)).await.unwrap();
    instrument.lock().unwrap().integration_us = 100_000;
    let error = spectro.acquire(deadline()).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("100000 µs"),
        "{error}"
    );
}

/// Tries are counted in one place. A spectrum that does not come costs its exposure and is asked for once.
#[tokio::test(start_paused = true)]
async fn a_dead_instrument_is_asked_as_often_as_is_stated() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    let kill = || {
        let mut now = instrument.lock().unwrap();
        now.heard.clear();
        now.spectrum_faults = [Fault::Silent; 40].into();
        now.control_faults = [Fault::Silent; 40].into();
    };
    for expected in [vec![0x09], vec![0xFE; TRIES as usize]] {
        kill();
        let error = spectro.acquire(deadline()).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Timeout);
        assert_eq!(instrument.lock().unwrap().heard, expected);
    }
    kill();
    assert!(open(&driver).await.is_err());
    let opening = [vec![0x01, 0x0A], vec![0xFE; TRIES as usize]].concat();
    assert_eq!(instrument.lock().unwrap().heard, opening);
}
