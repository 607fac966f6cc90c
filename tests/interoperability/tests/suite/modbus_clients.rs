//! pymodbus and mbpoll as clients of our twins, on ptys and over TCP.

use isolux_darkroom::Darkroom;
use isolux_virtual::outlet::{Offer, Outlet, offer};
use isolux_virtual::twins::Choice;
use isolux_virtual::{AxisName, Instrument, Serving, Switches, VirtualRoom};

use crate::peers;

/// A lit room with a Modbus lux meter and Oriental Motor drives, its meter without noise.
fn room() -> VirtualRoom {
    let mut document = Darkroom::default();
    document.luxmeter.noise_rel = 0.0;
    document.luxmeter.noise_lx = 0.0;
    let mut choice = Choice::default();
    choice.choose(Instrument::Luxmeter, "modbus-lux").unwrap();
    choice.choose(Instrument::Axes, "oriental-az").unwrap();
    let room = VirtualRoom::open_with(document, &choice);
    let illuminated = Switches {
        lamp: true,
        shutter_open: true,
        baffle_in: false,
    };
    room.with_world(|world, now_s| world.set_switches(illuminated, now_s));
    room
}

async fn served(room: &VirtualRoom, instrument: Instrument, by: Offer) -> (String, Serving) {
    let (outlets, serving) = offer(room, &[instrument], by).await.unwrap();
    let Outlet { address, .. } = outlets.into_iter().next().unwrap();
    (address, serving)
}

fn port(address: &str) -> &str {
    address.rsplit(':').next().unwrap()
}

/// The light at the head in lx, within what the lamp's start changes in the meantime.
fn truth_lx(room: &VirtualRoom) -> f64 {
    room.with_world(|world, now_s| {
        let light = world.meter_lx(now_s - 0.5, now_s);
        world.room().indicated_for_lx(light, world.temperature_c(now_s), 0)
    })
}

/// The number after `key` in what `modbus.py` prints.
fn number(stated: &str, key: &str) -> f64 {
    let rest = stated
        .split(&format!("\"{key}\": "))
        .nth(1)
        .unwrap_or_else(|| panic!("{key}: {stated}"));
    let end = rest.find([',', '}']).unwrap();
    rest[..end].parse().unwrap()
}

async fn illuminated(room: &VirtualRoom) {
    // The lamp follows its switch, and the meter has a conversion of its light.
    let late = room.with_world(|world, _| world.room().document().lamp.switch_s);
    tokio::time::sleep(std::time::Duration::from_secs_f64(late + 1.5)).await;
}

pub async fn pymodbus_reads_our_meter_in_both_frames() {
    let room = room();
    illuminated(&room).await;
    let (tcp, _serving) = served(&room, Instrument::Luxmeter, Offer::Tcp { port: 0 }).await;
    let (pty, _line) = served(&room, Instrument::Luxmeter, Offer::Pty).await;
    for place in [format!("tcp:{}", port(&tcp)), format!("rtu-tcp:{}", port(&tcp)), pty] {
        let Some(stated) = peers::pymodbus_says(&["read", &place]).await else {
            return;
        };
        let truth = truth_lx(&room);
        assert!(
            (number(&stated, "thousandths") / 1000.0 - truth).abs() < 0.002 * truth + 0.001,
            "{place}: {stated} {truth}"
        );
        assert!(
            (number(&stated, "lx") - truth).abs() < 0.002 * truth + 0.6,
            "{place}: {stated} {truth}"
        );
        assert_eq!(
            (number(&stated, "absent"), number(&stated, "refused")),
            (2.0, 1.0),
            "{stated}"
        );
    }
}

pub async fn mbpoll_reads_our_meter_in_both_frames() {
    let room = room();
    illuminated(&room).await;
    let (tcp, _serving) = served(&room, Instrument::Luxmeter, Offer::Tcp { port: 0 }).await;
    let (pty, _line) = served(&room, Instrument::Luxmeter, Offer::Pty).await;
    let words = ["-1", "-0", "-a", "1", "-r", "2", "-t", "4:int", "-B"];
    let network = ["-m", "tcp", "-p", port(&tcp), "127.0.0.1"];
    let line = ["-m", "rtu", "-b", "9600", "-P", "none", pty.as_str()];
    for way in [&network[..], &line[..]] {
        let Some(stated) = peers::mbpoll(&[&words[..], way].concat()).await else {
            return;
        };
        let truth = truth_lx(&room);
        let shown = stated.split("[2]:").nth(1).unwrap_or_else(|| panic!("{stated}"));
        let shown: f64 = shown.split_whitespace().next().unwrap().parse().unwrap();
        assert!(
            (shown / 1000.0 - truth).abs() < 0.002 * truth + 0.001,
            "{stated} {truth}"
        );
    }
}

pub async fn pymodbus_homes_and_moves_our_drives() {
    let room = room();
    let (tcp, _serving) = served(&room, Instrument::Axes, Offer::Tcp { port: 0 }).await;
    let (pty, _line) = served(&room, Instrument::Axes, Offer::Pty).await;
    let steps = room.with_world(|world, _| world.axis(AxisName::C).counts_per_unit);
    for (place, unit, name, degrees) in [
        (format!("tcp:{}", port(&tcp)), "1", AxisName::C, 10.0),
        (format!("rtu-tcp:{}", port(&tcp)), "2", AxisName::Gamma, -20.0),
        (pty, "1", AxisName::C, -5.0),
    ] {
        let target = (degrees * steps).round();
        let Some(stated) = peers::pymodbus_says(&["drive", &place, unit, &format!("{target:.0}")]).await else {
            return;
        };
        assert!(stated.contains("\"homed\": true"), "{place}: {stated}");
        assert_eq!(number(&stated, "command"), target, "{place}: {stated}");
        // The encoder's noise.
        assert!((number(&stated, "detected") - target).abs() <= 3.0, "{place}: {stated}");
        assert_eq!(number(&stated, "alarm"), 0.0, "{stated}");
        let is = room.with_world(|world, now_s| world.axis(name).position(now_s));
        assert!((is - target / steps).abs() < 1e-9, "{place}: {is}");
    }
}
