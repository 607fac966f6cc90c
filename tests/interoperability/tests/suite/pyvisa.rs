//! pyvisa-py as a client of our SCPI twins, over TCP and on ptys; and what it says when a twin answers wrongly.

use std::time::Duration;

use isolux_darkroom::Darkroom;
use isolux_virtual::outlet::{Offer, Outlet, offer};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Serving, VirtualRoom};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use crate::peers;

/// A room with a power meter and a supply, the meter without noise; the supply feeds the lamp, or is off.
fn room(lamp: bool) -> VirtualRoom {
    let mut document = Darkroom::default();
    document.lamp.on_at_start = lamp;
    document.powermeter.noise_rel = 0.0;
    document.powermeter.gain_error_rel = 0.0;
    let mut choice = Choice::default();
    choice.choose(Instrument::Powermeter, "scpi-meter").unwrap();
    choice.choose(Instrument::Supply, "scpi-supply").unwrap();
    VirtualRoom::open_with(document, &choice)
}

async fn served(room: &VirtualRoom, instrument: Instrument, by: Offer) -> (String, Serving) {
    let (outlets, serving) = offer(room, &[instrument], by).await.unwrap();
    let Outlet { address, .. } = outlets.into_iter().next().unwrap();
    (address, serving)
}

fn port(address: &str) -> &str {
    address.rsplit(':').next().unwrap()
}

/// What `scpi.py` says of the instrument at `place`; its failure as text.
async fn pyvisa(what: &str, place: &str) -> Option<Result<Value, String>> {
    let stated = peers::python_says("scpi.py", &[what, place]).await?;
    Some(stated.and_then(|text| serde_json::from_str(&text).map_err(|error| format!("{error}: {text}"))))
}

/// What is wrong with what pyvisa read from the meter, if something is.
fn meter_errors(room: &VirtualRoom, stated: &Value) -> Vec<String> {
    let truth = room.with_world(|world, now_s| world.electrical(now_s));
    let factor = truth.power_w / (truth.voltage_v * truth.current_a);
    let mut wrong = Vec::new();
    for (key, expected) in [
        ("maker", json!("GWInstek")),
        ("model", json!("GPM-8213")),
        ("serial", json!("GES000001")),
        ("firmware", json!("V1.05")),
        ("empty", json!([0, "No error"])),
        ("header", json!(["Urms", "Irms", "P", "PF"])),
        ("undefined", json!([[-113, "Undefined header"], [0, "No error"]])),
        ("illegal", json!([[-224, "Illegal parameter value"], [0, "No error"]])),
    ] {
        if stated[key] != expected {
            wrong.push(format!("{key}: {}", stated[key]));
        }
    }
    let expected = [truth.voltage_v, truth.current_a, truth.power_w, factor];
    let values: Vec<f64> = (stated["values"].as_array().into_iter().flatten())
        .filter_map(Value::as_f64)
        .collect();
    // Five digits, and what the lamp drifts in the seconds between.
    let near = |value: f64, truth: f64| (value - truth).abs() <= 2e-3 * truth.abs();
    if values.len() != 4 || !values.iter().zip(expected).all(|(value, truth)| near(*value, truth)) {
        wrong.push(format!("values: {values:?} instead of {expected:?}"));
    }
    if !stated["one"].as_f64().is_some_and(|value| near(value, truth.power_w)) {
        wrong.push(format!("one: {}", stated["one"]));
    }
    wrong
}

pub async fn pyvisa_reads_our_power_meter_over_tcp_and_on_a_line() {
    let room = room(true);
    // The lamp draws what it draws once it burns.
    tokio::time::sleep(Duration::from_secs(3)).await;
    let (tcp, _serving) = served(&room, Instrument::Powermeter, Offer::Tcp { port: 0 }).await;
    let (pty, _line) = served(&room, Instrument::Powermeter, Offer::Pty).await;
    for place in [format!("tcp:{}", port(&tcp)), pty] {
        let Some(stated) = pyvisa("meter", &place).await else {
            return;
        };
        let stated = stated.unwrap();
        assert_eq!(meter_errors(&room, &stated), Vec::<String>::new(), "{place}: {stated}");
    }
}

pub async fn pyvisa_switches_our_supply_over_tcp_and_on_a_line() {
    let room = room(false);
    let (tcp, _serving) = served(&room, Instrument::Supply, Offer::Tcp { port: 0 }).await;
    let (pty, _line) = served(&room, Instrument::Supply, Offer::Pty).await;
    for place in [format!("tcp:{}", port(&tcp)), pty] {
        let Some(stated) = pyvisa("supply", &place).await else {
            return;
        };
        let mut stated = stated.unwrap();
        stated["empty"].take();
        let expected = json!({
            "maker": "RIGOL TECHNOLOGIES", "model": "DP832", "serial": "DP8C000000001", "firmware": "00.01.14", "empty": null,
            "levels": [24.0, 0.35], "on": "ON", "volts": 24.0, "trips": "NO;NO",
            "illegal": [[-224, "Illegal parameter value"], [0, "No error"]], "off": "OFF",
        });
        assert_eq!(stated, expected, "{place}");
        assert!(room.with_world(|world, _| !world.switches().lamp), "{place}");
    }
}

/// Stands before a twin and writes `to` where its answers have `from`. Gives its port.
async fn liar(address: &str, from: &'static [u8], to: &'static [u8]) -> u16 {
    let twin = address.trim_start_matches("tcp://").to_owned();
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
    let at = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        let (client, _) = listener.accept().await.unwrap();
        let twin = TcpStream::connect(twin).await.unwrap();
        let ((mut hears, mut says), (mut answers, mut asks)) = (client.into_split(), twin.into_split());
        tokio::spawn(async move { tokio::io::copy(&mut hears, &mut asks).await });
        let mut buffer = [0; 1024];
        // The twin sends an answer in one piece.
        while let Ok(count @ 1..) = answers.read(&mut buffer).await {
            let mut bytes = buffer[..count].to_vec();
            if let Some(place) = bytes.windows(from.len()).position(|bytes| bytes == from) {
                bytes.splice(place..place + from.len(), to.iter().copied());
            }
            if says.write_all(&bytes).await.is_err() {
                return;
            }
        }
    });
    at
}

/// Without this nobody would know that the tests above can fail: each field is changed on its way once.
pub async fn a_twin_that_answers_wrongly_is_found_out() {
    let room = room(true);
    // The lamp draws what it draws once it burns.
    tokio::time::sleep(Duration::from_secs(3)).await;
    let (tcp, _serving) = served(&room, Instrument::Powermeter, Offer::Tcp { port: 0 }).await;
    for (what, from, to) in [
        ("nothing", &b"\x00"[..], &b"\x00"[..]),
        ("maker", b"GWInstek", b"GW"),
        ("number of fields", b"GPM-8213,", b"GPM-8213;"),
        ("serial number", b"GES000001", b"GES000002"),
        ("firmware", b"V1.05", b"V1.50"),
        ("end of a line", b"\r\n", b"\n\r"),
        ("header", b"Irms,P", b"P,Irms"),
        ("separator", b"E+00,", b"E+00;"),
        ("exponent", b"E+00", b"E+01"),
        ("word for a number", b"E+00", b"V"),
        ("number of an error", b"-113", b"-114"),
        ("empty queue", b"0,\"No error\"", b"1,\"Some error\""),
        ("answer to *OPC?", b"1\r\n", b"0\r\n"),
    ] {
        let place = format!("tcp:{}", liar(&tcp, from, to).await);
        let Some(stated) = pyvisa("meter", &place).await else {
            return;
        };
        let wrong = stated.map_or_else(|failed| vec![failed], |stated| meter_errors(&room, &stated));
        assert_eq!(wrong.is_empty(), what == "nothing", "{what}: {wrong:?}");
    }
}
