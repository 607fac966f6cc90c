//! The drivers through the real libusb: calibration and spectrum of a twin behind USB/IP.
//!
//! What the twin must have said is taken from the room, not from the driver.

mod bridge;

use bridge::{Below, bridge, offered};
use isolux_darkroom::Darkroom;
use isolux_virtual::VirtualRoom;

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

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ocean_ooi_reads_calibration_and_spectrum_over_usb() {
    let Some(bridge) = bridge() else { return };
    let room = VirtualRoom::open(Darkroom::default());
    room.with_world(|world, now_s| {
        let mut switches = world.switches();
        switches.lamp = true;
        switches.shutter_open = true;
        switches.baffle_in = false;
        world.set_switches(switches, now_s);
    });
    let port = offered(vec![isolux_virtual::usb::usb2000_plus(&room)]).await;
    let mut program = Below::start(&bridge, port);
    let answer = program.ask("read ocean-ooi:usb:serial=USB2+V00001 50").await;
    let (serial, first_nm, last_nm, counts) = parsed(&answer);
    assert_eq!(serial, "USB2+V00001");
    let [a, b, c, d] = room.with_world(|world, _| world.room().document().spectroradiometer.wavelength_nm);
    let at = |pixel: f64| ((d * pixel + c) * pixel + b) * pixel + a;
    assert!(
        (first_nm - at(0.0)).abs() < 1e-3 && (last_nm - at(2047.0)).abs() < 1e-3,
        "{first_nm} {last_nm}"
    );
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
