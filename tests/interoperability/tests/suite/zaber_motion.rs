//! Zaber's own library `zaber-motion` (`tests/peers/zaber.py`) homes, moves, stops and switches the axes' twin over
//! TCP, and reads what is true. Each field that it reads is changed on its way once: it must then read something else,
//! or fail.

use std::path::Path;
use std::time::Duration;

use isolux_darkroom::Darkroom;
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::{AxisName, Instrument, VirtualRoom};
use serde_json::Value;
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, copy};
use tokio::net::{TcpListener, TcpStream};
use tokio::process::Command;

use crate::peers::python;

/// Axes that are quick.
const ROOM: &str =
    "[injected_effects]\nonly = true\n[axis.c]\nspeed_deg_s = 200.0\naccel_deg_s2 = 4000.0\nstart_deg = 10.0\n";

/// Carries requests as they are, and of the replies what `change` makes of each line.
async fn between(twin: String, change: Change) -> u16 {
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
    let port = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        let (host, _) = listener.accept().await.unwrap();
        let device = TcpStream::connect(twin).await.unwrap();
        let ((mut from_host, mut to_host), (from_device, mut to_device)) = (host.into_split(), device.into_split());
        tokio::spawn(async move { copy(&mut from_host, &mut to_device).await });
        let mut replies = BufReader::new(from_device).lines();
        while let Ok(Some(reply)) = replies.next_line().await {
            let reply = change(reply.trim_end());
            if to_host.write_all(format!("{reply}\r\n").as_bytes()).await.is_err() {
                return;
            }
        }
    });
    port
}

/// What the library reads of a room in which `fault` happens, where replies are changed on their way; and the room.
async fn read(python: &Path, fault: Option<&str>, change: Change) -> (Value, VirtualRoom) {
    let room = VirtualRoom::open(Darkroom::parse(ROOM).unwrap());
    if let Some(fault) = fault {
        assert!(room.order(&fault.parse().unwrap()));
    }
    let (outlets, _serving) = offer(&room, &[Instrument::Axes], Offer::Tcp { port: 0 }).await.unwrap();
    let port = between(outlets[0].address.replace("tcp://", ""), change).await;
    let mut command = Command::new(python);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers/zaber.py");
    command.arg(script).arg(port.to_string()).kill_on_drop(true);
    let output = tokio::time::timeout(Duration::from_secs(90), command.output()).await;
    let output = output.expect("it ends within 90 s").unwrap();
    let stated = String::from_utf8_lossy(&output.stdout);
    let words = String::from_utf8_lossy(&output.stderr);
    (
        serde_json::from_str(&stated).unwrap_or_else(|error| panic!("{error}: {stated}{words}")),
        room,
    )
}

/// What becomes of a reply on its way.
type Change = fn(&str) -> String;

fn as_it_is(reply: &str) -> String {
    reply.to_owned()
}

/// Another number in place of the position that it had after `move abs 128000`.
fn another_position(reply: &str) -> String {
    reply.replace("128000", "128001")
}

fn no_warnings(reply: &str) -> String {
    reply.replace(" 02 WR WH", " 00").replace(" WR ", " -- ")
}

fn accepted(reply: &str) -> String {
    reply.replace(" RJ ", " OK ")
}

fn another_id(reply: &str) -> String {
    let mut words: Vec<&str> = reply.split(' ').collect();
    if words.len() > 2 && words[0] == "@01" {
        words[2] = if words[2] == "98" { "97" } else { "98" };
    }
    words.join(" ")
}

fn another_output(reply: &str) -> String {
    reply.replace(" 1 0 0 0", " 1 1 0 0")
}

pub async fn the_makers_library_reads_what_is_true() {
    let Some(python) = python() else { return };
    let (stated, room) = read(&python, None, as_it_is).await;
    let seed = room.with_world(|world, _| world.room().document().seed);
    assert_eq!(stated["serial"], (900_000 + seed % 100_000).to_string(), "{stated}");
    assert_eq!(stated["flags_before"], serde_json::json!(["WH", "WR"]), "{stated}");
    assert_eq!(
        (&stated["homed_before"], &stated["homed"]),
        (&false.into(), &true.into()),
        "{stated}"
    );
    assert_eq!(stated["flags"], serde_json::json!([]), "{stated}");
    let numbers = ["home", "absolute", "relative"].map(|step| stated[step].as_f64().unwrap_or(f64::NAN));
    assert_eq!(numbers, [0.0, 128_000.0, 123_733.0], "{stated}");
    let stopped = stated["stopped"].as_f64().unwrap();
    assert!(stopped > 123_733.0 && stopped < 400_000.0, "{stated}");
    let (at, lamp) = room.with_world(|world, now_s| {
        let axis = world.axis(AxisName::C);
        (axis.motion.position(now_s), world.switches().lamp)
    });
    assert!((at - stopped).abs() <= 1.0 && lamp, "{at} {lamp} {stated}");
    assert!(stated["refused"].as_str().unwrap().contains("BADDATA"), "{stated}");
    assert_eq!(
        stated["outputs"],
        serde_json::json!([true, false, false, false]),
        "{stated}"
    );
    let volts = room.with_world(|world, now_s| (world.temperature_c(now_s) + 50.0) / 15.0);
    assert!(
        (stated["volts"].as_f64().unwrap() - volts).abs() < 0.05,
        "{volts} {stated}"
    );
}

pub async fn the_makers_library_reports_a_stall_and_an_alarm() {
    let Some(python) = python() else { return };
    for (fault, flag) in [("axes stall", "FS"), ("axes alarm", "FD")] {
        let (stated, _room) = read(&python, Some(fault), as_it_is).await;
        assert!(stated.to_string().contains(flag), "{fault}: {stated}");
        assert_ne!(stated["flags"], serde_json::json!([]), "{fault}: {stated}");
    }
}

pub async fn what_is_changed_on_the_way_is_read_otherwise() {
    let Some(python) = python() else { return };
    let (truth, _room) = read(&python, None, as_it_is).await;
    let changes: [(&str, Change); 5] = [
        ("absolute", another_position),
        ("flags_before", no_warnings),
        ("refused", accepted),
        ("outputs", another_output),
        ("serial", another_id),
    ];
    for (field, change) in changes {
        let (stated, _room) = read(&python, None, change).await;
        assert_ne!(stated[field], truth[field], "{field} was changed on its way: {stated}");
    }
}
