//! USB instruments through the real libusb, against twins behind USB/IP: no hardware, no root, no USB in the kernel.

mod bridge;
pub mod instruments;
pub mod libusb;
pub mod scan;
pub mod seabreeze;

use isolux_darkroom::Darkroom;
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Switches, VirtualRoom};

/// A lit room in which `driver` reaches the spectroradiometer.
fn illuminated(driver: &str) -> VirtualRoom {
    let mut choice = Choice::default();
    choice.choose(Instrument::Spectroradiometer, driver).unwrap();
    let room = VirtualRoom::open_with(Darkroom::default(), &choice);
    room.with_world(|world, now_s| {
        let illuminated = Switches {
            lamp: true,
            shutter_open: true,
            baffle_in: false,
        };
        world.set_switches(illuminated, now_s);
    });
    room
}
