//! Against the crate rmodbus: it makes the same requests, and its server's answers are understood.
//!
//! Its client is not used: it panics on an empty answer with a good CRC, takes one register for two, and any write for
//! the one that was asked (`docs/decisions`, Modbus frames).

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event};
use isolux_protocol_modbus::{Ask, Data, Exception, Mbap, Reply, Request, Rtu};
use proptest::prelude::*;
use rmodbus::ModbusProto;
use rmodbus::client::ModbusRequest;
use rmodbus::server::ModbusFrame;
use rmodbus::server::context::ModbusContext;
use rmodbus::server::storage::ModbusStorageFull;

fn ask() -> impl Strategy<Value = Ask> {
    let from = 0..12_000_u16;
    prop_oneof![
        (from.clone(), 1..=2000_u16).prop_map(|(from, count)| Ask::ReadCoils { from, count }),
        (from.clone(), 1..=2000_u16).prop_map(|(from, count)| Ask::ReadDiscreteInputs { from, count }),
        (from.clone(), 1..=125_u16).prop_map(|(from, count)| Ask::ReadHoldingRegisters { from, count }),
        (from.clone(), 1..=125_u16).prop_map(|(from, count)| Ask::ReadInputRegisters { from, count }),
        (from.clone(), any::<bool>()).prop_map(|(at, on)| Ask::WriteCoil { at, on }),
        (from.clone(), any::<u16>()).prop_map(|(at, value)| Ask::WriteRegister { at, value }),
        (from.clone(), proptest::collection::vec(any::<bool>(), 1..300))
            .prop_map(|(from, on)| Ask::WriteCoils { from, on }),
        (from, proptest::collection::vec(any::<u16>(), 1..=121))
            .prop_map(|(from, values)| Ask::WriteRegisters { from, values }),
    ]
}

fn theirs(request: &Request, proto: ModbusProto) -> Vec<u8> {
    let mut client = ModbusRequest::new(request.unit(), proto);
    let mut frame = Vec::new();
    match request.ask() {
        Ask::ReadCoils { from, count } => client.generate_get_coils(*from, *count, &mut frame),
        Ask::ReadDiscreteInputs { from, count } => client.generate_get_discretes(*from, *count, &mut frame),
        Ask::ReadHoldingRegisters { from, count } => client.generate_get_holdings(*from, *count, &mut frame),
        Ask::ReadInputRegisters { from, count } => client.generate_get_inputs(*from, *count, &mut frame),
        Ask::WriteCoil { at, on } => client.generate_set_coil(*at, *on, &mut frame),
        Ask::WriteRegister { at, value } => client.generate_set_holding(*at, *value, &mut frame),
        Ask::WriteCoils { from, on } => client.generate_set_coils_bulk(*from, on, &mut frame),
        Ask::WriteRegisters { from, values } => client.generate_set_holdings_bulk(*from, values, &mut frame),
    }
    .unwrap();
    frame
}

/// What rmodbus' server answers, its registers holding three times their number.
fn answer(frame: &[u8], unit: u8, proto: ModbusProto, store: &mut ModbusStorageFull) -> Vec<u8> {
    let mut buffer = [0; 256];
    buffer[..frame.len()].copy_from_slice(frame);
    let mut response = Vec::new();
    let mut server = ModbusFrame::new(unit, &buffer, proto, &mut response);
    server.parse().unwrap();
    if server.processing_required {
        if server.readonly {
            server.process_read(store).unwrap();
        } else {
            server.process_write(store).unwrap();
        }
    }
    assert!(server.response_required);
    server.finalize_response().unwrap();
    response
}

fn check(
    codec: &mut impl Conversation<Request = Request, Answer = Reply>,
    request: Request,
    proto: ModbusProto,
) -> Result<(), TestCaseError> {
    let mut store = ModbusStorageFull::new();
    for n in 0..10_000_u16 {
        store.set_holding(n, n.wrapping_mul(3)).unwrap();
        store.set_input(n, n.wrapping_mul(5)).unwrap();
        store.set_coil(n, n % 3 == 0).unwrap();
        store.set_discrete(n, n % 7 == 0).unwrap();
    }
    let ask = request.ask().clone();
    let expected = theirs(&request, proto);
    let unit = request.unit();
    let frame = codec.start(Instant::now(), request).frame;
    prop_assert_eq!(&frame, &expected);
    let answer = answer(&frame, unit, proto, &mut store);
    let events = codec.handle_input(Instant::now(), &answer);
    let [Event::Answer(reply)] = &events[..] else {
        return Err(TestCaseError::fail(format!("{ask:?}: {events:?}")));
    };
    let (from, count) = match &ask {
        Ask::ReadCoils { from, count }
        | Ask::ReadDiscreteInputs { from, count }
        | Ask::ReadHoldingRegisters { from, count }
        | Ask::ReadInputRegisters { from, count } => (*from, *count),
        Ask::WriteCoil { at, .. } | Ask::WriteRegister { at, .. } => (*at, 1),
        Ask::WriteCoils { from, on } => (*from, on.len() as u16),
        Ask::WriteRegisters { from, values } => (*from, values.len() as u16),
    };
    let places = from..from + count;
    let truth = if from + count > 10_000 {
        Err(Exception(2))
    } else {
        Ok(match &ask {
            Ask::ReadCoils { .. } => Data::Bits(places.map(|n| n % 3 == 0).collect()),
            Ask::ReadDiscreteInputs { .. } => Data::Bits(places.map(|n| n % 7 == 0).collect()),
            Ask::ReadHoldingRegisters { .. } => Data::Registers(places.map(|n| n.wrapping_mul(3)).collect()),
            Ask::ReadInputRegisters { .. } => Data::Registers(places.map(|n| n.wrapping_mul(5)).collect()),
            _ => Data::Written,
        })
    };
    prop_assert_eq!(&reply.outcome, &truth);
    // What was to be written is there.
    if truth.is_ok() {
        match &ask {
            Ask::WriteRegister { at, value } => prop_assert_eq!(store.get_holding(*at).unwrap(), *value),
            Ask::WriteRegisters { from, values } => {
                for (n, value) in values.iter().enumerate() {
                    prop_assert_eq!(store.get_holding(from + n as u16).unwrap(), *value);
                }
            }
            Ask::WriteCoil { at, on } => prop_assert_eq!(store.get_coil(*at).unwrap(), *on),
            Ask::WriteCoils { from, on } => {
                for (n, on) in on.iter().enumerate() {
                    prop_assert_eq!(store.get_coil(from + n as u16).unwrap(), *on);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn both_frames(unit in 1..=247_u8, ask in ask()) {
        let request = Request::new(unit, ask).unwrap();
        let mut rtu = Rtu::new(Duration::from_millis(4), Duration::from_secs(1));
        check(&mut rtu, request.clone(), ModbusProto::Rtu)?;
        check(&mut Mbap::new(Duration::from_secs(1)), request, ModbusProto::TcpUdp)?;
    }
}
