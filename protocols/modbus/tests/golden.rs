//! Frames of manuals and specifications.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event};
use isolux_protocol_modbus::{Ask, Data, Encoding, Exception, Mbap, NumberType, Reply, Request, Rtu, WordOrder};

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// The frame of `ask`, and what `answer` says to it.
fn exchange(
    codec: &mut impl Conversation<Request = Request, Answer = Reply>,
    request: Request,
    answer: &str,
) -> (Vec<u8>, Vec<Event<Reply>>) {
    let now = Instant::now();
    let start = codec.start(now, request);
    assert_eq!(start.at_once, None);
    (start.frame, codec.handle_input(now, &bytes(answer)))
}

fn outcome(events: &[Event<Reply>]) -> &Result<Data, Exception> {
    match events {
        [Event::Answer(reply)] => &reply.outcome,
        other => panic!("{other:?}"),
    }
}

fn rtu() -> Rtu {
    Rtu::new(Duration::from_millis(4), Duration::from_secs(1))
}

/// What is asked, of which unit; the request; the answer; what it says.
fn on_the_line(unit: u8, ask: Ask, request: &str, answer: &str, says: Result<Data, Exception>) {
    let (frame, events) = exchange(&mut rtu(), Request::new(unit, ask.clone()).unwrap(), answer);
    assert_eq!(frame, bytes(request), "{ask:?}");
    assert_eq!(outcome(&events), &says, "{ask:?}");
}

#[test]
fn an_rs_485_lux_transmitter_says_132854_lx() {
    // RS485_Illuminance_Sensor.md of Isuromu/Telemetry-Weather-station-system: request and answer.
    let ask = Ask::ReadHoldingRegisters { from: 7, count: 2 };
    let says = Ok(Data::Registers(vec![0x0002, 0x06F6]));
    on_the_line(1, ask, "01 03 00 07 00 02 75 CA", "01 03 04 00 02 06 F6 D8 15", says);
    let encoding = Encoding {
        number: NumberType::U32,
        order: WordOrder::HighFirst,
    };
    assert_eq!(encoding.decode(&[0x0002, 0x06F6]), Some(132_854.0));
}

#[test]
fn oriental_motor_az_frames() {
    // FAQ 0331 of orientalmotor.eu: position −1000 of operation data 0.
    let ask = Ask::WriteRegisters {
        from: 0x1802,
        values: vec![0xFFFF, 0xFC18],
    };
    let request = "01 10 18 02 00 02 04 FF FF FC 18 99 58";
    on_the_line(1, ask, request, "01 10 18 02 00 02 E6 A8", Ok(Data::Written));
    // Direct data operation to step 9000, STOP and the feedback position, by the register map of HM-60262E.
    let ask = Ask::WriteRegisters {
        from: 0x0058,
        values: [0_u32, 1, 9000, 2000, 10_000, 10_000, 1000, 1]
            .iter()
            .flat_map(|long| [(long >> 16) as u16, *long as u16])
            .collect(),
    };
    let frame = rtu().start(Instant::now(), Request::new(1, ask).unwrap()).frame;
    let expected = "01 10 00 58 00 10 20 00 00 00 00 00 00 00 01 00 00 23 28 00 00 07 D0 00 00 27 10 00 00 27 10 \
                    00 00 03 E8 00 00 00 01 09 8D";
    assert_eq!(frame, bytes(expected));
    let stop = Ask::WriteRegister { at: 0x7D, value: 0x20 };
    on_the_line(
        1,
        stop,
        "01 06 00 7D 00 20 18 0A",
        "01 06 00 7D 00 20 18 0A",
        Ok(Data::Written),
    );
    let feedback = Ask::ReadHoldingRegisters { from: 0x120, count: 2 };
    let frame = rtu().start(Instant::now(), Request::new(1, feedback).unwrap()).frame;
    assert_eq!(frame, bytes("01 03 01 20 00 02 C4 3D"));
}

/// The examples of the Application Protocol Specification V1.1b3, 6.1 to 6.12, as MBAP frames of transaction 1.
#[test]
fn examples_of_the_specification() {
    let bits = |text: &str| Data::Bits(text.bytes().map(|byte| byte == b'1').collect());
    for (ask, request, answer, says) in [
        (
            Ask::ReadCoils {
                from: 0x13,
                count: 0x13,
            },
            "01 00 13 00 13",
            "01 03 CD 6B 05",
            bits("1011001111010110101"),
        ),
        (
            Ask::ReadDiscreteInputs {
                from: 0xC4,
                count: 0x16,
            },
            "02 00 C4 00 16",
            "02 03 AC DB 35",
            bits("0011010111011011101011"),
        ),
        (
            Ask::ReadHoldingRegisters { from: 0x6B, count: 3 },
            "03 00 6B 00 03",
            "03 06 02 2B 00 00 00 64",
            Data::Registers(vec![555, 0, 100]),
        ),
        (
            Ask::ReadInputRegisters { from: 8, count: 1 },
            "04 00 08 00 01",
            "04 02 00 0A",
            Data::Registers(vec![10]),
        ),
        (
            Ask::WriteCoil { at: 0xAC, on: true },
            "05 00 AC FF 00",
            "05 00 AC FF 00",
            Data::Written,
        ),
        (
            Ask::WriteRegister { at: 1, value: 3 },
            "06 00 01 00 03",
            "06 00 01 00 03",
            Data::Written,
        ),
        (
            Ask::WriteCoils {
                from: 0x13,
                on: "1011001110".bytes().map(|byte| byte == b'1').collect(),
            },
            "0F 00 13 00 0A 02 CD 01",
            "0F 00 13 00 0A",
            Data::Written,
        ),
        (
            Ask::WriteRegisters {
                from: 1,
                values: vec![0x000A, 0x0102],
            },
            "10 00 01 00 02 04 00 0A 01 02",
            "10 00 01 00 02",
            Data::Written,
        ),
    ] {
        let framed = |pdu: &str| format!("00 01 00 00 00 {:02X} FF {pdu}", bytes(pdu).len() + 1);
        let mut codec = Mbap::new(Duration::from_secs(1));
        let (frame, events) = exchange(&mut codec, Request::new(0xFF, ask.clone()).unwrap(), &framed(answer));
        assert_eq!(frame, bytes(&framed(request)), "{ask:?}");
        assert_eq!(outcome(&events), &Ok(says), "{ask:?}");
    }
}

#[test]
fn exceptions_have_names() {
    let ask = Ask::ReadHoldingRegisters { from: 7, count: 2 };
    on_the_line(
        1,
        ask.clone(),
        "01 03 00 07 00 02 75 CA",
        "01 83 02 C0 F1",
        Err(Exception(2)),
    );
    assert_eq!(Exception(2).to_string(), "exception 02h (illegal data address)");
    let mut codec = Mbap::new(Duration::from_secs(1));
    let (_, events) = exchange(&mut codec, Request::new(9, ask).unwrap(), "00 01 00 00 00 03 09 83 0B");
    let stated = outcome(&events).as_ref().unwrap_err().to_string();
    assert_eq!(stated, "exception 0Bh (gateway target device failed to respond)");
}
