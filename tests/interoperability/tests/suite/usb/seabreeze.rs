//! Ocean's own compiled library reads the twins through libusb, and every field that it reads is seen to matter: with
//! the same bytes changed on their way it must read another value, or nothing.
//!
//! Needs umockdev and `tests/peers/python.sh`. Two instruments agree here that no code is shared with: the twin and the
//! library.

use std::process::Stdio;

use super::bridge::{below, bridge, offered};
use super::illuminated;
use crate::peers::python;
use isolux_usbip::Twin;
use isolux_virtual::Instrument;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};

/// What becomes of an answer on its way: the bytes of a frame (OOI) or message (OBP).
type Change = fn(&mut Vec<u8>);

/// What the library reads of the spectroradiometer that `driver` reaches, with every answer changed by `change`.
async fn read(driver: &str, microseconds: u32, change: Change) -> Option<Value> {
    let (bridge, python) = (bridge()?, python()?);
    let room = illuminated(driver);
    let model = isolux_virtual::usb::device(&room, Instrument::Spectroradiometer)
        .unwrap()
        .model()
        .clone();
    let twin = Twin::new(model, move || {
        let (host, outer) = tokio::io::duplex(1 << 16);
        let (inner, stream) = tokio::io::duplex(1 << 16);
        let room = room.clone();
        tokio::spawn(async move { room.serve(Instrument::Spectroradiometer, stream).await });
        tokio::spawn(pass(outer, inner, change));
        host
    });
    let port = offered(vec![twin]).await;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/seabreeze_peer.py");
    let mut command = below(&bridge, port, 1, &python);
    command.arg(script).arg(microseconds.to_string()).stdout(Stdio::piped());
    let output = command.output().await.expect("the bridge starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_else(|| panic!("{output:?}"));
    Some(serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {output:?}")))
}

/// Passes bytes on; what the twin writes at once is one answer.
async fn pass(outer: DuplexStream, inner: DuplexStream, change: Change) {
    let (mut from_host, mut to_host) = tokio::io::split(outer);
    let (mut from_twin, mut to_twin) = tokio::io::split(inner);
    let there = tokio::io::copy(&mut from_host, &mut to_twin);
    let back = async {
        let mut buffer = vec![0; 1 << 16];
        while let Ok(count @ 1..) = from_twin.read(&mut buffer).await {
            let mut answer = buffer[..count].to_vec();
            change(&mut answer);
            if to_host.write_all(&answer).await.is_err() {
                return;
            }
        }
    };
    tokio::select! {
        _ = there => {}
        () = back => {}
    }
}

fn unchanged(_: &mut Vec<u8>) {}

/// Changes the text of an EEPROM slot of OOI.
fn slot(answer: &mut [u8], slot: u8, at: usize, byte: u8) {
    if answer.starts_with(&[0x81, 17, 0, 5, slot]) {
        answer[5 + at] = byte;
    }
}

/// Whether a message of OBP is of this kind.
fn is(answer: &[u8], kind: u32) -> bool {
    answer.get(8..12) == Some(&kind.to_le_bytes()[..])
}

fn peak(found: &Value) -> f64 {
    let counts = found["counts"].as_array().unwrap_or_else(|| panic!("{found}"));
    counts.iter().filter_map(Value::as_f64).fold(0.0, f64::max)
}

pub async fn the_makers_library_reads_a_usb2000_and_sees_each_field_changed() {
    let Some(found) = read("ocean-ooi", 50_000, unchanged).await else {
        return;
    };
    assert_eq!(found["error"], Value::Null, "{found}");
    assert_eq!(
        (&found["model"], &found["serial"]),
        (&"USB2000PLUS".into(), &"USB2+V00001".into())
    );
    assert_eq!(found["pixels"], 2048);
    let [first, last] = ["first_nm", "last_nm"].map(|key| found[key].as_f64().unwrap());
    assert!(
        (first - 339.26).abs() < 0.01 && (1000.0..1200.0).contains(&last),
        "{first} {last}"
    );
    assert!(peak(&found) > 3000.0, "{}", peak(&found));

    let longer = read("ocean-ooi", 100_000, unchanged).await.unwrap();
    let ratio = (peak(&longer) - 1500.0) / (peak(&found) - 1500.0);
    assert!((1.8..2.2).contains(&ratio), "the integration time: {ratio}");

    let other = read("ocean-ooi", 50_000, |answer| slot(answer, 0, 6, b'9'))
        .await
        .unwrap();
    assert_eq!(other["serial"], "USB2+V90001", "{other}");
    let other = read("ocean-ooi", 50_000, |answer| slot(answer, 1, 0, b'4'))
        .await
        .unwrap();
    assert!(
        (other["first_nm"].as_f64().unwrap() - first - 100.0).abs() < 0.01,
        "{other}"
    );
    let other = read("ocean-ooi", 50_000, |answer| slot(answer, 6, 0, b'5'))
        .await
        .unwrap();
    let coefficient = |found: &Value| found["nonlinearity"][0].as_f64().unwrap();
    assert!(
        (4.5..6.0).contains(&coefficient(&other)) && coefficient(&found) < 1.5,
        "{other}"
    );
    let other = read("ocean-ooi", 50_000, |answer| {
        if answer[0] == 0x82 {
            answer[3 + 2 * 1000] = 0xFF;
            answer[4 + 2 * 1000] = 0xFF;
        }
    });
    assert!(other.await.unwrap()["counts"][1000].as_f64().unwrap() > 60_000.0);
    let other = read("ocean-ooi", 50_000, |answer| {
        if let [0x82, .., last] = &mut answer[..] {
            *last = 0x68;
        }
    });
    let other = other.await.unwrap();
    assert!(other["error"].is_string(), "the end mark: {other}");
}

pub async fn the_makers_library_reads_an_sts_and_sees_each_field_changed() {
    let Some(found) = read("ocean-obp", 50_000, unchanged).await else {
        return;
    };
    assert_eq!(found["error"], Value::Null, "{found}");
    assert_eq!((&found["model"], &found["serial"]), (&"STS".into(), &"S00001".into()));
    assert_eq!(found["pixels"], 1024);
    let first = found["first_nm"].as_f64().unwrap();
    assert!((first - 339.45).abs() < 0.05, "{first}");
    assert!(peak(&found) > 700.0, "{}", peak(&found));
    let longer = read("ocean-obp", 100_000, unchanged).await.unwrap();
    let ratio = (peak(&longer) - 375.0) / (peak(&found) - 375.0);
    assert!((1.8..2.2).contains(&ratio), "the integration time: {ratio}");

    let other = read("ocean-obp", 50_000, |answer| {
        if is(answer, 0x0100) {
            answer[25] = b'9';
        }
    });
    assert_eq!(other.await.unwrap()["serial"], "S90001");
    let other = read("ocean-obp", 50_000, |answer| {
        let value = f32::from_le_bytes(answer[24..28].try_into().unwrap());
        if is(answer, 0x0018_0101) && value > 300.0 {
            answer[24..28].copy_from_slice(&(value + 100.0).to_le_bytes());
        }
    });
    assert!((other.await.unwrap()["first_nm"].as_f64().unwrap() - first - 100.0).abs() < 0.01);
    let other = read("ocean-obp", 50_000, |answer| {
        if is(answer, 0x0018_1101) {
            answer[24..28].copy_from_slice(&0.5_f32.to_le_bytes());
        }
    });
    let other = other.await.unwrap();
    assert!(
        other["nonlinearity"] != found["nonlinearity"] && other["nonlinearity"][0] == 0.5,
        "{other}"
    );
    let other = read("ocean-obp", 50_000, |answer| {
        if answer.len() > 2000 {
            answer[44 + 2 * 500..46 + 2 * 500].copy_from_slice(&16_000_u16.to_le_bytes());
        }
    });
    assert_eq!(other.await.unwrap()["counts"][500], 16_000.0);
    for change in [
        |answer: &mut Vec<u8>| answer[0] = 0xC0,
        |answer: &mut Vec<u8>| answer[8] ^= 0x40,
        |answer: &mut Vec<u8>| answer[4] |= 0x08,
        |answer: &mut Vec<u8>| *answer.last_mut().unwrap() = 0,
    ] {
        let other = read("ocean-obp", 50_000, change).await.unwrap();
        assert!(other["error"].is_string(), "start, type, NACK, footer: {other}");
    }
    // What it does not read proves nothing about the twin: sums and the number of the request.
    for change in [
        |answer: &mut Vec<u8>| answer.iter_mut().rev().skip(4).take(16).for_each(|byte| *byte = 0xAA),
        |answer: &mut Vec<u8>| answer[12] = 0xAA,
    ] {
        let other = read("ocean-obp", 50_000, change).await.unwrap();
        assert_eq!(
            (&other["error"], &other["serial"]),
            (&Value::Null, &"S00001".into()),
            "{other}"
        );
    }
}
