//! The OBP driver against a scripted STS without checksums on an in-memory link, with the clock paused.
//!
//! The instrument below has its own framing, after the data sheet of the STS, rev. 201612.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{ErrorKind, OpenError, Spectroradiometer, SpectroradiometerFactory, Target};
use isolux_spectroradiometer::OceanObpDriver;
use isolux_transport::{MemoryLinks, Ports, TRIES};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

const SERIAL: u32 = 0x0000_0100;
const CHECKSUM: u32 = 0x0000_0010;
const SPECTRUM: u32 = 0x0010_1100;
const SET_INTEGRATION: u32 = 0x0011_0010;

#[derive(Default)]
struct Instrument {
    dead: bool,
    /// Types of the messages.
    heard: Vec<u32>,
}

/// What it says to a request: flags and data.
fn answer(kind: u32, flags: u16, data: &[u8]) -> (u16, Vec<u8>) {
    const RESPONSE: u16 = 1;
    match kind {
        SERIAL => (RESPONSE, b"S01234".to_vec()),
        SPECTRUM => (RESPONSE, [0xD0, 0x07].repeat(1024)),
        // Two coefficients of the wavelength, at 350 nm and 0.45 nm a pixel.
        0x0018_0100 => (RESPONSE, vec![2]),
        0x0018_0101 => (RESPONSE, [350.0_f32, 0.45][usize::from(data[0])].to_le_bytes().to_vec()),
        _ if flags & 4 != 0 => (2, Vec::new()),
        // Nothing else is there.
        _ => (8, Vec::new()),
    }
}

fn message(kind: u32, number: &[u8], flags: u16, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0xC1, 0xC0, 0x00, 0x11];
    bytes.extend(flags.to_le_bytes());
    bytes.extend([if flags == 8 { 2 } else { 0 }, 0]);
    bytes.extend(kind.to_le_bytes());
    bytes.extend(number);
    bytes.resize(23, 0);
    let (inside, behind) = if data.len() <= 16 {
        (data, &[][..])
    } else {
        (&[][..], data)
    };
    bytes.push(inside.len() as u8);
    bytes.extend(inside);
    bytes.resize(40, 0);
    bytes.extend((behind.len() as u32 + 20).to_le_bytes());
    bytes.extend(behind);
    bytes.extend([0; 16]);
    bytes.extend([0xC5, 0xC4, 0xC3, 0xC2]);
    bytes
}

async fn serve(instrument: Arc<Mutex<Instrument>>, mut stream: DuplexStream) {
    loop {
        let mut header = [0; 44];
        if stream.read_exact(&mut header).await.is_err() {
            return;
        }
        let mut rest = vec![0; usize::from(u16::from_le_bytes([header[40], header[41]]))];
        if stream.read_exact(&mut rest).await.is_err() {
            return;
        }
        let kind = u32::from_le_bytes([header[8], header[9], header[10], header[11]]);
        let dead = {
            let mut now = instrument.lock().unwrap();
            now.heard.push(kind);
            now.dead
        };
        if dead {
            continue;
        }
        let data = &header[24..24 + usize::from(header[23])];
        let (flags, data) = answer(kind, u16::from(header[4]), data);
        tokio::time::sleep(Duration::from_millis(15)).await;
        let bytes = message(kind, &header[12..16], flags, &data);
        if stream.write_all(&bytes).await.is_err() {
            return;
        }
    }
}

fn bench() -> (OceanObpDriver, Arc<Mutex<Instrument>>) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("spectro").unwrap();
    let instrument = Arc::new(Mutex::new(Instrument::default()));
    let twin = Arc::clone(&instrument);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    (OceanObpDriver::new(Ports::new(Arc::new(links))), instrument)
}

async fn open(driver: &OceanObpDriver) -> Result<Box<dyn Spectroradiometer>, OpenError> {
    let target = Target::parse("ocean-obp:memory:spectro").unwrap();
    driver.open_spectroradiometer(&target).await
}

fn deadline() -> Instant {
    Instant::now() + Duration::from_mins(2)
}

#[tokio::test(start_paused = true)]
async fn an_instrument_without_sums_is_opened_and_read_twice() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    assert_eq!(spectro.identity().serial.as_deref(), Some("S01234"));
    assert!((spectro.properties().wavelength_nm[1000] - 800.0).abs() < 1e-4);
    assert!(spectro.properties().irradiance_factor.is_none());
    instrument.lock().unwrap().heard.clear();
    let raw = spectro.acquire(deadline()).await.unwrap();
    assert_eq!(raw.counts, [2000; 1024]);
    let spectra = |kind: &&u32| **kind == SPECTRUM;
    assert_eq!(instrument.lock().unwrap().heard.iter().filter(spectra).count(), 2);
}

/// The one above has its answer after 15 ms, whatever its integration time is.
#[tokio::test(start_paused = true)]
async fn in_motion_a_spectrum_is_asked_for_once_and_one_that_was_ready_has_no_moment() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    spectro.sample(deadline()).await.unwrap();
    for (milliseconds, since_ms) in [(10, Some(15)), (20, Some(20)), (40, None)] {
        let time = Duration::from_millis(milliseconds);
        spectro.set_integration_time(time).await.unwrap();
        instrument.lock().unwrap().heard.clear();
        let sampled = spectro.sample(deadline()).await;
        assert_eq!(instrument.lock().unwrap().heard, [SPECTRUM]);
        match (sampled, since_ms) {
            (Ok(raw), Some(since_ms)) => assert_eq!((raw.ended - raw.began).as_millis(), since_ms),
            (Err(error), None) => assert!(error.to_string().contains("was ready before"), "{error}"),
            (other, _) => panic!("{time:?}: {other:?}"),
        }
    }
    // What failed is followed by a proof, here the serial number, as the time cannot be asked for.
    instrument.lock().unwrap().heard.clear();
    spectro.sample(deadline()).await.unwrap_err();
    assert_eq!(instrument.lock().unwrap().heard, [SERIAL, SPECTRUM]);
    // One that is lost is given up soon: twice its time and read-out, and 200 ms.
    instrument.lock().unwrap().dead = true;
    spectro
        .set_integration_time(Duration::from_millis(10))
        .await
        .unwrap_err();
    let called = Instant::now();
    spectro.sample(deadline()).await.unwrap_err();
    assert!(called.elapsed() < Duration::from_millis(1200), "{:?}", called.elapsed());
}

#[tokio::test(start_paused = true)]
async fn a_dead_instrument_is_asked_as_often_as_is_stated() {
    let (driver, instrument) = bench();
    let spectro = open(&driver).await.unwrap();
    let kill = || {
        let mut now = instrument.lock().unwrap();
        now.heard.clear();
        now.dead = true;
    };
    let heard = || instrument.lock().unwrap().heard.clone();
    kill();
    let error = spectro.acquire(deadline()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert_eq!(heard(), [SPECTRUM; TRIES as usize]);
    // After the first silence the serial number must be told before the same is asked again.
    kill();
    let time = Duration::from_millis(20);
    let error = spectro.set_integration_time(time).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    let again = [SERIAL; TRIES as usize - 1];
    assert_eq!(heard(), [&[SET_INTEGRATION], &again[..]].concat());
    kill();
    assert!(open(&driver).await.is_err());
    assert_eq!(heard(), [&[CHECKSUM], &again[..]].concat());
}
