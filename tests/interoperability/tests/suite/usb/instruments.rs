//! The drivers through the real libusb: calibration and spectrum of a twin behind USB/IP.
//!
//! What the twin must have said is taken from the room, not from the driver.

use super::bridge::{Below, bridge, offered};
use super::illuminated;
use isolux_usbip::Twin;
use isolux_virtual::{Instrument, VirtualRoom};

/// Serial number, first and last wavelength in nm, counts.
fn parsed(answer: &str) -> (String, f64, f64, Vec<f64>) {
    let (words, counts) = answer.split_once('[').unwrap_or_else(|| panic!("{answer}"));
    let words: Vec<&str> = words.split_whitespace().collect();
    let counts = counts
        .trim_end_matches(']')
        .split(", ")
        .map(|count| count.parse().unwrap());
    (
        words[0].to_owned(),
        words[1].parse().unwrap(),
        words[2].parse().unwrap(),
        counts.collect(),
    )
}

/// A lit room in which `driver` reaches the spectroradiometer, offered over USB/IP.
async fn lit_room(driver: &str) -> (VirtualRoom, Twin, u16) {
    let room = illuminated(driver);
    let twin = isolux_virtual::usb::device(&room, Instrument::Spectroradiometer).unwrap();
    let port = offered(vec![twin.clone()]).await;
    (room, twin, port)
}

/// Wavelength of a pixel of the room's own spectrometer, nm.
fn nm(room: &VirtualRoom, pixel: f64) -> f64 {
    let [a, b, c, d] = room.with_world(|world, _| world.room().document().spectroradiometer.wavelength_nm);
    ((d * pixel + c) * pixel + b) * pixel + a
}

pub async fn ocean_ooi_reads_calibration_and_spectrum_over_usb() {
    let Some(bridge) = bridge() else { return };
    let (room, _, port) = lit_room("ocean-ooi").await;
    let mut program = Below::start(&bridge, port);
    let answer = program.ask("read ocean-ooi:usb:serial=USB2+V00001 50").await;
    let (serial, first_nm, last_nm, counts) = parsed(&answer);
    assert_eq!(serial, "USB2+V00001");
    assert!((first_nm - nm(&room, 0.0)).abs() < 1e-3 && (last_nm - nm(&room, 2047.0)).abs() < 1e-3);
    assert_eq!(counts.len(), 2048);
    let dark = counts[6..21].iter().sum::<f64>() / 15.0;
    let peak = counts.iter().copied().fold(0.0, f64::max);
    assert!(
        (1000.0..2000.0).contains(&dark) && peak > dark + 1000.0,
        "dark {dark}, peak {peak}"
    );

    let other = program.ask("read ocean-ooi:usb:serial=USB2+V00002 50").await;
    assert!(other.contains("no such USB device"), "{other}");
    let unknown = program.ask("read ocean-ooi:usb:2457:101e?baud=9600 50").await;
    assert!(unknown.contains("unknown option baud"), "{unknown}");
}

pub async fn ocean_obp_reads_calibration_and_spectrum_over_usb() {
    let Some(bridge) = bridge() else { return };
    let (room, twin, port) = lit_room("ocean-obp").await;
    let mut program = Below::start(&bridge, port);
    let answer = program.ask("read ocean-obp:usb: 50").await;
    let (serial, first_nm, last_nm, counts) = parsed(&answer);
    assert_eq!(serial, "S00001");
    // Single precision on the wire.
    assert!((first_nm - nm(&room, 0.5)).abs() < 1e-2 && (last_nm - nm(&room, 2046.5)).abs() < 1e-2);
    assert_eq!(counts.len(), 1024);
    let peak = counts.iter().copied().fold(0.0, f64::max);
    assert!(
        counts[..10].iter().all(|dark| (200.0..600.0).contains(dark)) && peak > 700.0,
        "{peak}: {counts:?}"
    );
    // A packet that was lost, or whose endpoint halted, is asked for again; the value is right or there is none.
    twin.stall(0x81);
    let (again, ..) = parsed(&program.ask("read ocean-obp:usb:serial=S00001 50").await);
    assert_eq!(again, "S00001");
}

pub async fn an_instrument_that_is_unplugged_says_so() {
    let Some(bridge) = bridge() else { return };
    let (_, twin, port) = lit_room("ocean-obp").await;
    let mut program = Below::start(&bridge, port);
    let unplug = async {
        // In the middle of an exposure of ten seconds.
        tokio::time::sleep(std::time::Duration::from_secs(2)).await;
        twin.unplug();
    };
    let (answer, ()) = tokio::join!(program.ask("read ocean-obp:usb: 10000"), unplug);
    assert!(answer.contains("unplugged"), "{answer}");
}
