//! The USB link through the real libusb: reads, timeouts, stall, overflow, unplugging.
//!
//! A twin is offered over USB/IP; `bridge.c`, compiled here, shows it to a program under umockdev. Where umockdev is
//! missing (Debian: libumockdev-dev) the tests say that they were skipped, and fail where `ISOLUX_NO_SKIP` is set.

use std::time::Duration;

use super::bridge::{Below, bridge, offered};
use isolux_darkroom::Darkroom;
use isolux_usbip::Twin;
use isolux_virtual::{Instrument, VirtualRoom};

const OPEN: &str = "open usb: ooi";

async fn usb2000() -> (Twin, u16) {
    let room = VirtualRoom::open(Darkroom::default());
    let twin = isolux_virtual::usb::device(&room, Instrument::Spectroradiometer).expect("it has a connector");
    let port = offered(vec![twin.clone()]).await;
    (twin, port)
}

pub async fn transfers_become_frames_and_a_spectrum_ends_with_its_short_packet() {
    let Some(bridge) = bridge() else { return };
    let (_, port) = usb2000().await;
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(OPEN).await, "opened");
    // Status: 17 bytes less one, of 2048 pixels and 100 ms.
    program.ask("send 010100fe").await;
    let status = program.ask("receive 2000").await;
    assert!(status.starts_with("8110000008a0860100"), "{status}");
    // The integration time to 10 ms, then two spectra.
    program.ask("send 0105000210270000").await;
    for _ in 0..2 {
        program.ask("send 01010009").await;
        let spectrum = program.ask("receive 2000").await;
        assert_eq!(
            spectrum.len(),
            2 * (3 + 4097),
            "{}",
            &spectrum[..spectrum.len().min(80)]
        );
        assert!(spectrum.starts_with("820110") && spectrum.ends_with("69"));
    }
    // Two short answers in a row stay two frames.
    program.ask("send 010100fe0102000500").await;
    let both = program.ask("receive 2000").await + &program.ask("receive 300").await;
    assert!(
        both.contains("811000") && both.contains("8111000500555342322b56"),
        "{both}"
    );
}

pub async fn silence_is_a_timeout_and_nothing_is_lost_by_it() {
    let Some(bridge) = bridge() else { return };
    let (_, port) = usb2000().await;
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(OPEN).await, "opened");
    // Several calls of libusb end without data while this waits.
    assert_eq!(program.ask("receive 350").await, "timeout");
    program.ask("send 010100fe").await;
    assert!(program.ask("receive 2000").await.starts_with("811000"));
}

pub async fn a_stall_is_cleared_and_an_overflow_costs_its_answer_alone() {
    let Some(bridge) = bridge() else { return };
    let (twin, port) = usb2000().await;
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(OPEN).await, "opened");
    twin.stall(0x81);
    program.ask("send 010100fe").await;
    assert!(
        program.ask("receive 2000").await.starts_with("811000"),
        "the endpoint was freed"
    );
    twin.overflow(0x81);
    program.ask("send 010100fe").await;
    assert_eq!(program.ask("receive 500").await, "timeout", "half an answer is none");
    program.ask("send 010100fe").await;
    assert!(program.ask("receive 2000").await.starts_with("811000"));
    // The command endpoint: one command is lost, the next is taken.
    twin.stall(0x01);
    program.ask("send 010100fe").await;
    assert_eq!(program.ask("receive 500").await, "timeout");
    program.ask("send 010100fe").await;
    assert!(program.ask("receive 2000").await.starts_with("811000"));
}

pub async fn unplugged_is_said_and_the_device_is_not_found_again() {
    let Some(bridge) = bridge() else { return };
    let (twin, port) = usb2000().await;
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(OPEN).await, "opened");
    twin.unplug();
    let lost = program.ask("receive 5000").await;
    assert!(lost.contains("unplugged"), "{lost}");
    program.ask("close").await;
    // The removal reaches the program's /sys a moment after its link.
    let mut again = String::new();
    for _ in 0..100 {
        again = program.ask(OPEN).await;
        if again.contains("no such USB device") {
            break;
        }
        program.ask("close").await;
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert!(again.contains("no such USB device (2457:101e)"), "{again}");
}

pub async fn an_address_chooses_by_serial_number_and_a_link_is_opened_again() {
    let Some(bridge) = bridge() else { return };
    let (twin, port) = usb2000().await;
    let serial = &twin.model().strings[2];
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(&format!("open usb:serial={serial} ooi")).await, "opened");
    program.ask("close").await;
    assert_eq!(
        program.ask(&format!("open usb:2457:101e?serial={serial} ooi")).await,
        "opened"
    );
    program.ask("send 010100fe").await;
    assert!(program.ask("receive 2000").await.starts_with("811000"));
    program.ask("close").await;
    let other = program.ask("open usb:serial=OTHER ooi").await;
    assert!(other.contains("no such USB device"), "{other}");
    let wrong = program.ask("open usb:port=1-7 ooi").await;
    assert!(wrong.contains("no such USB device"), "{wrong}");
    let language = program.ask("open usb: obp").await;
    assert!(language.contains("2457:4000"), "{language}");
}

pub async fn an_instrument_that_another_link_has_is_in_use() {
    let Some(bridge) = bridge() else { return };
    let (_, port) = usb2000().await;
    let mut program = Below::start(&bridge, port);
    assert_eq!(program.ask(OPEN).await, "opened");
    // The link that is open still is replaced only once a new one is.
    let refused = program.ask(OPEN).await;
    assert!(
        refused.contains("in use") && refused.contains("2457:101e at port 1-1"),
        "{refused}"
    );
    program.ask("send 010100fe").await;
    assert!(
        program.ask("receive 2000").await.starts_with("811000"),
        "the first is as it was"
    );
}
