//! The host's side of every language. The input is a session: which request, in which pieces the bytes arrive, the
//! bytes.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event};
use isolux_protocol_ascii::{End, Form, Lines, Message as PlainMessage, Pattern, Plain};
use isolux_protocol_easi::{Bits, Easi, Request as EasiRequest};
use isolux_protocol_mavo::{Mavo, Request as MavoRequest};
use isolux_protocol_modbus::{Ask, Mbap, Request as ModbusRequest, Rtu};
use isolux_protocol_obp::{Flags, Host as ObpHost, Message, PIXELS, Request as ObpRequest};
use isolux_protocol_ooi::{Endpoint, Frame, Host as OoiHost, PIXELS as OOI_PIXELS, Request as OoiRequest};
use isolux_protocol_p9710::{P9710, Range as P9710Range, Request as P9710Request};
use isolux_protocol_scpi::{
    Answer as ScpiAnswer, Expect, QueuedError, Reading, Request as ScpiRequest, Scpi, Terminator,
};
use isolux_protocol_t10a::{Host as T10aHost, Range as T10aRange, Request as T10aRequest};
use isolux_protocol_zaber::{Command, Host as ZaberHost};

use crate::Target;

/// Every language that an instrument answers in.
pub const TARGETS: &[Target] = &[
    Target {
        name: "easi",
        run: easi,
        seeds: easi_seeds,
    },
    Target {
        name: "mavo",
        run: mavo,
        seeds: mavo_seeds,
    },
    Target {
        name: "modbus_rtu",
        run: modbus_rtu,
        seeds: modbus_rtu_seeds,
    },
    Target {
        name: "modbus_tcp",
        run: modbus_tcp,
        seeds: modbus_tcp_seeds,
    },
    Target {
        name: "obp",
        run: obp,
        seeds: obp_seeds,
    },
    Target {
        name: "ooi",
        run: ooi,
        seeds: ooi_seeds,
    },
    Target {
        name: "p9710",
        run: p9710,
        seeds: p9710_seeds,
    },
    Target {
        name: "plain",
        run: plain,
        seeds: plain_seeds,
    },
    Target {
        name: "scpi",
        run: scpi,
        seeds: scpi_seeds,
    },
    Target {
        name: "t10a",
        run: t10a,
        seeds: t10a_seeds,
    },
    Target {
        name: "zaber",
        run: zaber,
        seeds: zaber_seeds,
    },
];

/// Asks one request after the other; the bytes arrive in pieces between them. A request that got no end is given up.
fn session<C: Conversation>(codec: &mut C, data: &[u8], request: impl Fn(u8) -> C::Request, typed: impl Fn(C::Answer)) {
    let [which, piece, bytes @ ..] = data else { return };
    let mut now = Instant::now();
    let mut pieces = bytes.chunks(usize::from(*piece).max(1));
    for k in 0..8 {
        now = codec.ready_at(now);
        let start = codec.start(now, request(which.wrapping_add(k)));
        assert!(!start.frame.is_empty(), "a request without bytes");
        let mut over = start.at_once.is_some();
        while !over {
            let Some(piece) = pieces.next() else { break };
            now += Duration::from_millis(1);
            let mut ends = 0;
            for event in codec.handle_input(now, piece) {
                ends += usize::from(!matches!(event, Event::Remark(_)));
                if let Event::Answer(answer) = event {
                    typed(answer);
                }
            }
            assert!(ends <= 1, "{ends} ends of one request");
            over = ends == 1;
        }
        if !over {
            now += Duration::from_secs(1);
            codec.abandon(now);
        }
    }
}

/// A session of one request: `which`, in pieces of 7 bytes.
fn seed(which: u8, answer: impl AsRef<[u8]>) -> Vec<u8> {
    [&[which, 7], answer.as_ref()].concat()
}

fn easi(data: &[u8]) {
    let request = |which| match which % 4 {
        0 => EasiRequest::report(1, "R(ST)"),
        1 => EasiRequest::report(1, "R(PA)"),
        2 => EasiRequest::command(1, "MA"),
        _ => EasiRequest::blind(1, "S"),
    };
    session(&mut Lines::<Easi>::default(), data, request, |reply| {
        let _ = Bits::parse(&reply.answer.value);
    });
}

fn easi_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, "1R(ST)\r*0000_0000_1000_0000_0001_0000_0000_0000\r\n"),
        seed(1, "1R(PA)\r*-51200\r\n"),
        seed(2, "1MA\r1R(UF)\r*0000_0000_0000_0000_0000_0000_0000_0000\r\n"),
    ]
}

fn mavo(data: &[u8]) {
    let request = |which| match which % 6 {
        0 => MavoRequest::Measure,
        1 => MavoRequest::Identify,
        2 => MavoRequest::Range,
        3 => MavoRequest::SetRange(2),
        4 => MavoRequest::SetAuto(true),
        _ => MavoRequest::Lux,
    };
    session(&mut Lines::<Mavo>::default(), data, request, drop);
}

fn mavo_seeds() -> Vec<Vec<u8>> {
    let mut line = Lines::<Mavo>::default();
    let frame = line.start(Instant::now(), MavoRequest::Measure).frame;
    vec![
        seed(0, [frame.trim_ascii_end(), b" 1234E-01 LX\n"].concat()),
        seed(1, "*IDN? GOSSEN,MAVO-USB,0815,1.0,1.1\n"),
        seed(2, "RAN? 2\n"),
        seed(0, "ERROR = 103\n"),
    ]
}

fn p9710(data: &[u8]) {
    let request = |which| match which % 4 {
        0 => P9710Request::Measure,
        1 => P9710Request::Identify,
        2 => P9710Request::SetRange(P9710Range::Fixed(3)),
        _ => P9710Request::SetIntegration(5000),
    };
    session(&mut Lines::<P9710>::default(), data, request, drop);
}

fn p9710_seeds() -> Vec<Vec<u8>> {
    let mut line = Lines::<P9710>::default();
    let frame = line.start(Instant::now(), P9710Request::Measure).frame;
    vec![
        seed(
            0,
            [b"+1.2345E+02", &frame[2..3], b"3", &frame[5..6], b"+61.7\n"].concat(),
        ),
        seed(1, "P-9710 4.7;\"1234\";\"lx\"\n"),
        seed(2, "0;3\n"),
        seed(3, "5000\n"),
        seed(0, "?16\n"),
    ]
}

/// The first line of the bytes is the form of the reply, the rest answers it.
fn plain(data: &[u8]) {
    let [which, piece, rest @ ..] = data else { return };
    let (pattern, answer) = rest.split_at(rest.iter().position(|byte| *byte == b'\n').unwrap_or(0));
    let Ok(pattern) = Pattern::parse(&String::from_utf8_lossy(pattern)) else {
        return;
    };
    let request = |which: u8| PlainMessage {
        text: "E?".to_owned(),
        end: End::CrLf,
        answer_end: [End::Cr, End::Lf, End::CrLf][usize::from(which % 3)],
        echo: which.is_multiple_of(2),
        forms: vec![
            Form {
                pattern: pattern.with("state", "READY"),
                number: Some("value"),
            },
            Form {
                pattern: pattern.clone(),
                number: None,
            },
        ],
        unlike: Vec::new(),
        quiet: Duration::from_secs(1),
    };
    let answer = answer.get(1..).unwrap_or_default();
    let bytes = [&[*which, *piece], answer].concat();
    session(&mut Lines::<Plain>::default(), &bytes, request, drop);
}

fn plain_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(1, "E {value} lx\nE 12.5 lx\n"),
        seed(5, "STATE {state}\nSTATE READY\r\n"),
        seed(0, "{model},{serial}\nE?\r\nLUX-1,0042\r"),
    ]
}

fn scpi(data: &[u8]) {
    let request = |which| match which % 3 {
        0 => ScpiRequest::query(":NUM:NORM:VAL?"),
        1 => ScpiRequest::query("SYST:ERR?"),
        _ => ScpiRequest {
            message: "CURV?".to_owned(),
            expect: Expect::Block,
        },
    };
    let mut line = Lines::new(Scpi::new(Terminator::Lf, Duration::from_secs(1)));
    session(&mut line, data, request, |reply| {
        let ScpiAnswer::Text(text) = reply.answer else { return };
        let _ = QueuedError::parse(&text);
        for field in text.split(',') {
            if let Reading::Value(number) = Reading::parse(field, "V") {
                assert!(number.value.abs() < 9.9e37, "a sentinel became a number: {field}");
            }
        }
    });
}

fn scpi_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, "127.58E+00,240.02E-03,17.688E+00,0.5776E+00\n"),
        seed(0, "NAN,9.91E37,-9.9E+37,INF\r\n"),
        seed(1, "-113,\"Undefined header;*XYZ\"\n"),
        seed(2, "#14abcd\n"),
    ]
}

fn t10a(data: &[u8]) {
    let request = |which| match which % 4 {
        0 => T10aRequest::Connect,
        1 => T10aRequest::Hold(true),
        2 => T10aRequest::Read {
            head: 0,
            range: T10aRange::Auto,
            hold: false,
        },
        _ => T10aRequest::Read {
            head: 29,
            range: T10aRange::Fixed(3),
            hold: true,
        },
    };
    session(&mut T10aHost::default(), data, request, drop);
}

fn t10a_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, "\x0200541   \x0313\r\n"),
        seed(2, "\x02001020  +  0012+   0+12340\x0302\r\n"),
        seed(2, "\x020010 3 0+12350-    0+    0\x030B\r\n"),
    ]
}

fn zaber(data: &[u8]) {
    let request = |which| {
        let text = ["get pos", "move abs 12800", "", "warnings clear"][usize::from(which % 4)];
        Command::new(1, which % 3, text).expect("a command of the language")
    };
    session(&mut ZaberHost::default(), data, request, drop);
}

fn zaber_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, "@01 0 00 OK IDLE -- 12800 0\r\n"),
        seed(1, "#01 1 an information\r\n@01 1 00 OK BUSY WR 0\r\n!01 1 IDLE --\r\n"),
        seed(2, "@01 2 00 RJ IDLE FF BADDATA\r\n"),
    ]
}

fn ask(which: u8) -> ModbusRequest {
    let ask = match which % 5 {
        0 => Ask::ReadHoldingRegisters { from: 7, count: 2 },
        1 => Ask::ReadCoils { from: 0, count: 10 },
        2 => Ask::WriteRegister { at: 3, value: 500 },
        3 => Ask::WriteRegisters {
            from: 16,
            values: vec![1, 2, 3],
        },
        _ => Ask::WriteCoil { at: 4, on: true },
    };
    ModbusRequest::new(1, ask).expect("a request of the specification")
}

fn modbus_rtu(data: &[u8]) {
    let mut line = Rtu::new(Duration::from_millis(4), Duration::from_secs(1));
    session(&mut line, data, ask, |reply| assert!(!reply.frame.is_empty()));
}

fn modbus_rtu_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, [0x01, 0x03, 0x04, 0x00, 0x02, 0x06, 0xF6, 0xD8, 0x15]),
        seed(0, [0x01, 0x83, 0x02, 0xC0, 0xF1]),
    ]
}

fn modbus_tcp(data: &[u8]) {
    session(&mut Mbap::new(Duration::from_secs(1)), data, ask, |reply| {
        assert!(!reply.frame.is_empty());
    });
}

fn modbus_tcp_seeds() -> Vec<Vec<u8>> {
    vec![
        seed(0, [0, 1, 0, 0, 0, 7, 0x01, 0x03, 0x04, 0x00, 0x02, 0x06, 0xF6]),
        seed(0, [0, 1, 0, 0, 0, 3, 0x01, 0x83, 0x02]),
    ]
}

fn obp(data: &[u8]) {
    let request = |which| match which % 5 {
        0 => ObpRequest::Spectrum,
        1 => ObpRequest::Serial,
        2 => ObpRequest::Saturation,
        3 => ObpRequest::SetIntegration(10_000),
        _ => ObpRequest::Integration,
    };
    session(&mut ObpHost::default(), data, request, drop);
}

fn obp_seeds() -> Vec<Vec<u8>> {
    let message = |request: ObpRequest, checked, data| {
        Message {
            flags: Flags::RESPONSE,
            error: 0,
            kind: request.kind(),
            regarding: 0,
            checked,
            data,
        }
        .encode()
    };
    vec![
        seed(0, message(ObpRequest::Spectrum, true, vec![0x21; 2 * PIXELS])),
        seed(1, message(ObpRequest::Serial, false, b"S01234".to_vec())),
        seed(
            4,
            message(ObpRequest::Integration, true, 10_000_u32.to_le_bytes().to_vec()),
        ),
    ]
}

fn ooi(data: &[u8]) {
    let request = |which| match which % 6 {
        0 => OoiRequest::Spectrum,
        1 => OoiRequest::Eeprom(6),
        2 => OoiRequest::Register(4),
        3 => OoiRequest::Irradiance(0),
        4 => OoiRequest::IntegrationTime(10_000),
        _ => OoiRequest::Trigger(0),
    };
    session(&mut OoiHost::default(), data, request, drop);
}

fn ooi_seeds() -> Vec<Vec<u8>> {
    let mut payload = vec![0x21; 2 * OOI_PIXELS];
    payload.push(0x69);
    let spectrum = Frame {
        endpoint: Endpoint::Spectrum,
        payload,
    };
    vec![
        seed(0, spectrum.encode()),
        seed(1, b"\x81\x11\x00\x05\x061.0000000E+00\x00\x00"),
        seed(2, b"\x81\x03\x00\x04\x0a\x00"),
    ]
}
