//! The OOI driver against a scripted USB2000+ on an in-memory link, with the clock paused.
//!
//! The instrument below has its own framing; each spectrum says in its counts when its exposure began and how long it was.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{DeviceError, ErrorKind, OpenError, Spectroradiometer, SpectroradiometerFactory, Target};
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::MemoryLinks;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    NoEndMark,
    Short,
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
    spectra: u32,
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
                [0x05, slot] => (transfer(0x81, &now.slot(slot)), now.control_faults.pop_front()),
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
                    counts[100] = begun as u16;
                    counts[101] = (us / 1000) as u16;
                    counts[102] = 62_040;
                    let mut bytes: Vec<u8> = counts.iter().flat_map(|count| count.to_le_bytes()).collect();
                    bytes.push(0x69);
                    let fault = now.spectrum_faults.pop_front();
                    match fault {
                        Some(Fault::NoEndMark) => bytes[4096] = 0,
                        Some(Fault::Short) => bytes.truncate(4000),
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
        spectra: 0,
    }));
    let twin = Arc::clone(&instrument);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    (OceanOoiDriver::new(Arc::new(links)), instrument)
}

async fn open(driver: &OceanOoiDriver) -> Result<Box<dyn Spectroradiometer>, OpenError> {
    driver
        .open_spectroradiometer(&Target::parse("ocean-ooi:memory:spectro").unwrap())
        .await
}

fn deadline() -> Instant {
    Instant::now() + Duration::from_secs(60)
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
        assert_eq!(u64::from(raw.counts[101]), milliseconds, "taken with the old time");
        let begun = power_on + Duration::from_millis(u64::from(raw.counts[100]));
        assert!(begun >= called, "its exposure began before it was asked for");
        assert!(
            raw.began <= begun && begun + time <= raw.ended,
            "the stated interval holds the true one"
        );
        assert_eq!(raw.integration_time, time);
        assert_eq!(spectro.properties().saturated(&raw), [102]);
        let linear = spectro.properties().linear_counts(&raw, None).unwrap();
        assert_eq!(linear[500], 0.0);
        let net = (62_040.0 - 1000.0) * 65_535.0 / 62_040.0;
        assert!((linear[102] - net / (0.99 + 1.5e-6 * net)).abs() < 1e-6);
    }
}

#[tokio::test(start_paused = true)]
async fn damaged_spectra_are_taken_again_and_late_ones_never_mistaken() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.set_integration_time(Duration::from_millis(50)).await.unwrap();
    for fault in [Fault::NoEndMark, Fault::Short] {
        instrument.lock().unwrap().spectrum_faults.extend([fault, fault]);
        spectro.acquire(deadline()).await.unwrap();
        instrument.lock().unwrap().spectrum_faults.extend([fault; 3]);
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
                    power_on + Duration::from_millis(u64::from(raw.counts[100])) >= called,
                    "late by {late} ms"
                );
            }
            // Later than any patience: told, not used.
            Err(error) => assert_eq!(error.kind(), ErrorKind::Timeout),
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
