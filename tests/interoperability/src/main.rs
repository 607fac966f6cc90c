//! A program that uses a USB link as the lines of its standard input say: `open ADDRESS FRAMING`, `send HEX`, `receive
//! MILLISECONDS`, `close`; or as an instrument, `read OPEN MILLISECONDS`: serial number, first and last wavelength, raw
//! counts; or the whole scan of a station, `scan STATION PLAN RUN`. One line of answer each. It runs below the bridge,
//! where libusb sees the twin.
#![allow(clippy::print_stdout, reason = "its answers")]

use std::sync::Arc;
use std::time::Duration;

use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::scan::{self, Place, ScanJob};
use isolux_device::Target;
use isolux_transport::{Link, Ports, SystemLinks, UsbAddress, UsbFraming, UsbProfile, find_usb};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};

const OOI: UsbProfile = UsbProfile {
    ids: &[(0x2457, 0x101E)],
    command: 0x01,
    answers: &[0x81, 0x82],
    framing: UsbFraming::Transfers,
};

const OBP: UsbProfile = UsbProfile {
    ids: &[(0x2457, 0x4000)],
    command: 0x01,
    answers: &[0x81],
    framing: UsbFraming::Bytes,
};

#[tokio::main(flavor = "current_thread")]
async fn main() {
    let mut lines = BufReader::new(tokio::io::stdin()).lines();
    let mut link = None;
    while let Ok(Some(line)) = lines.next_line().await {
        let words: Vec<&str> = line.split(' ').collect();
        let answer = match (&words[..], &mut link) {
            (["open", address, language], _) => {
                let profile = if *language == "obp" { OBP } else { OOI };
                match open(address, profile) {
                    Ok(opened) => {
                        link = Some(opened);
                        "opened".to_owned()
                    }
                    Err(error) => format!("error: {error}"),
                }
            }
            (["read", open, milliseconds], _) => {
                let time = Duration::from_millis(milliseconds.parse().unwrap_or(0));
                read(open, time).await.unwrap_or_else(|error| format!("error: {error}"))
            }
            (["scan", station, plan, run], _) => match scan(station, plan, run) {
                Ok(()) => "scanned".to_owned(),
                Err(error) => format!("error: {error}"),
            },
            (["close"], _) => {
                link = None;
                "closed".to_owned()
            }
            (["send", bytes], Some(link)) => match link.write_all(&from_hex(bytes)).await {
                Ok(()) => "sent".to_owned(),
                Err(error) => format!("error: {error}"),
            },
            (["receive", milliseconds], Some(link)) => receive(link, milliseconds.parse().unwrap_or(0)).await,
            _ => format!("error: not understood, or nothing is open: {line}"),
        };
        println!("{answer}");
    }
}

fn open(address: &str, profile: UsbProfile) -> Result<Box<dyn Link>, String> {
    let address = UsbAddress::parse(address).map_err(|error| error.to_string())?;
    let address = address.ok_or("no USB address")?;
    let opened = find_usb(&address, &profile).and_then(isolux_transport::FoundUsb::open);
    opened.map_err(|error| format!("{error} ({})", error.advice.clone().unwrap_or_default()))
}

/// Opens an instrument by its driver and takes one spectrum.
async fn read(open: &str, time: Duration) -> Result<String, String> {
    let target = Target::parse(open).map_err(|error| error.to_string())?;
    let ports = Ports::new(Arc::new(SystemLinks::beside_their_owner()));
    let driver = isolux_spectroradiometer::DRIVERS
        .iter()
        .find(|driver| driver.name == target.driver());
    let factory = driver
        .and_then(|driver| (driver.factories)(ports).spectroradiometer)
        .ok_or("no such driver")?;
    let instrument = factory
        .open_spectroradiometer(&target)
        .await
        .map_err(|error| error.to_string())?;
    instrument
        .set_integration_time(time)
        .await
        .map_err(|error| error.to_string())?;
    let deadline = tokio::time::Instant::now() + Duration::from_secs(30);
    let spectrum = instrument.acquire(deadline).await.map_err(|error| error.to_string())?;
    let nm = &instrument.properties().wavelength_nm;
    let (first, last) = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
    let serial = instrument.identity().serial.clone().unwrap_or_default();
    Ok(format!("{serial} {first:.3} {last:.3} {:?}", spectrum.counts))
}

/// Scans as the command does, in a thread of its own: it makes its own runtime.
fn scan(station: &str, plan: &str, run: &str) -> Result<(), String> {
    std::thread::scope(|scope| {
        let scan = scope.spawn(|| {
            let (source, plan, _) = scan::checked(station.into(), plan.into(), false)?;
            ScanJob {
                source: &source,
                plan: &plan,
                place: Place::take(scan::Target::New(run.into()), false)?,
                force: None,
                operator: None,
                control: &Control::default(),
                progress: &Silent,
            }
            .execute()
        });
        match scan.join() {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(failure)) => Err(failure.to_string().replace('\n', " ")),
            Err(_) => Err("panicked".to_owned()),
        }
    })
}

async fn receive(link: &mut Box<dyn Link>, milliseconds: u64) -> String {
    let mut buffer = vec![0; 65_536];
    let wait = Duration::from_millis(milliseconds);
    match tokio::time::timeout(wait, link.read(&mut buffer)).await {
        Err(_) => "timeout".to_owned(),
        Ok(Ok(0)) => "end".to_owned(),
        Ok(Ok(count)) => buffer[..count]
            .iter()
            .fold(String::new(), |text, byte| text + &format!("{byte:02x}")),
        Ok(Err(error)) => format!("error: {error}"),
    }
}

fn from_hex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text
        .chars()
        .filter_map(|digit| digit.to_digit(16))
        .map(|digit| digit as u8)
        .collect();
    digits
        .chunks(2)
        .map(|pair| pair.iter().fold(0, |byte, digit| byte << 4 | digit))
        .collect()
}
