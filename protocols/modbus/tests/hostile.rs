//! Late, doubled, torn, damaged, mixed and echoed answers: never the wrong value.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event};
use isolux_protocol_modbus::{Ask, Data, Mbap, Reply, Request, Rtu, crc};
use proptest::prelude::*;

const SLOWEST: Duration = Duration::from_secs(1);

fn rtu() -> Rtu {
    Rtu::new(Duration::from_millis(4), SLOWEST)
}

fn mbap() -> Mbap {
    Mbap::new(SLOWEST)
}

/// A request, and the PDU of the true answer to it.
#[derive(Debug, Clone)]
struct Case {
    unit: u8,
    ask: Ask,
    pdu: Vec<u8>,
    says: Data,
}

impl Case {
    fn request(&self) -> Request {
        Request::new(self.unit, self.ask.clone()).unwrap()
    }

    fn rtu(&self) -> Vec<u8> {
        let mut frame = vec![self.unit];
        frame.extend(&self.pdu);
        frame.extend(crc(&frame).to_le_bytes());
        frame
    }

    fn mbap(&self, transaction: u16) -> Vec<u8> {
        let mut frame = transaction.to_be_bytes().to_vec();
        frame.extend([0, 0, 0, self.pdu.len() as u8 + 1, self.unit]);
        frame.extend(&self.pdu);
        frame
    }
}

fn registers(unit: u8, from: u16, values: Vec<u16>) -> Case {
    let mut pdu = vec![3, values.len() as u8 * 2];
    pdu.extend(values.iter().flat_map(|value| value.to_be_bytes()));
    let count = values.len() as u16;
    Case {
        unit,
        ask: Ask::ReadHoldingRegisters { from, count },
        pdu,
        says: Data::Registers(values),
    }
}

fn case() -> impl Strategy<Value = Case> {
    let values = proptest::collection::vec(any::<u16>(), 1..20);
    let bits = proptest::collection::vec(any::<bool>(), 1..70);
    let read =
        (1..=247_u8, 0..60_000_u16, values.clone()).prop_map(|(unit, from, values)| registers(unit, from, values));
    let input = (1..=247_u8, 0..60_000_u16, values.clone()).prop_map(|(unit, from, values)| {
        let mut case = registers(unit, from, values);
        let count = case.pdu[1] as u16 / 2;
        case.pdu[0] = 4;
        case.ask = Ask::ReadInputRegisters { from, count };
        case
    });
    let coils = (1..=247_u8, 0..60_000_u16, bits).prop_map(|(unit, from, bits)| {
        let mut packed = vec![0_u8; bits.len().div_ceil(8)];
        for (n, bit) in bits.iter().enumerate() {
            packed[n / 8] |= u8::from(*bit) << (n % 8);
        }
        Case {
            unit,
            ask: Ask::ReadCoils {
                from,
                count: bits.len() as u16,
            },
            pdu: [vec![1, packed.len() as u8], packed].concat(),
            says: Data::Bits(bits),
        }
    });
    let write = (1..=247_u8, 0..60_000_u16, values).prop_map(|(unit, from, values)| {
        let mut pdu = vec![0x10];
        pdu.extend(from.to_be_bytes());
        pdu.extend((values.len() as u16).to_be_bytes());
        let ask = Ask::WriteRegisters { from, values };
        let says = Data::Written;
        Case { unit, ask, pdu, says }
    });
    prop_oneof![read, input, coils, write]
}

/// What the codec made of it: every value that it gave.
fn values(events: &[Event<Reply>]) -> Vec<Data> {
    let given = events.iter().filter_map(|event| match event {
        Event::Answer(Reply { outcome: Ok(data), .. }) => Some(data.clone()),
        _ => None,
    });
    given.collect()
}

fn is_malformed(events: &[Event<Reply>]) -> bool {
    matches!(events, [Event::Malformed { .. }])
}

/// Feeds `bytes` cut at `cuts`.
fn feed<C: Conversation<Request = Request, Answer = Reply>>(
    codec: &mut C,
    bytes: &[u8],
    cuts: &[usize],
) -> Vec<Event<Reply>> {
    let mut places: Vec<usize> = cuts.iter().map(|cut| cut % (bytes.len() + 1)).collect();
    places.extend([0, bytes.len()]);
    places.sort_unstable();
    let pieces = places.windows(2).map(|ends| &bytes[ends[0]..ends[1]]);
    let mut events = Vec::new();
    for piece in pieces.filter(|piece| !piece.is_empty()) {
        events.extend(codec.handle_input(Instant::now(), piece));
    }
    events
}

proptest! {
    #[test]
    fn the_pieces_do_not_matter(case in case(), cuts in proptest::collection::vec(any::<usize>(), 0..40)) {
        let (mut line, mut stream) = (rtu(), mbap());
        line.start(Instant::now(), case.request());
        prop_assert_eq!(values(&feed(&mut line, &case.rtu(), &cuts)), vec![case.says.clone()]);
        stream.start(Instant::now(), case.request());
        prop_assert_eq!(values(&feed(&mut stream, &case.mbap(1), &cuts)), vec![case.says]);
    }

    #[test]
    fn every_single_flipped_bit_is_seen(case in case(), cuts in proptest::collection::vec(any::<usize>(), 0..3)) {
        let frame = case.rtu();
        for bit in 0..frame.len() * 8 {
            let mut flipped = frame.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let mut line = rtu();
            line.start(Instant::now(), case.request());
            prop_assert_eq!(values(&feed(&mut line, &flipped, &cuts)), vec![], "bit {}", bit);
        }
    }

    #[test]
    fn a_flipped_bit_in_the_header_of_a_tcp_answer_is_seen(case in case()) {
        let frame = case.mbap(1);
        // Transaction, protocol, length, unit, function and byte count: all that says whose answer it is.
        for bit in 0..9 * 8 {
            let mut flipped = frame.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let mut stream = mbap();
            stream.start(Instant::now(), case.request());
            prop_assert_eq!(values(&feed(&mut stream, &flipped, &[])), vec![], "bit {}", bit);
        }
    }

    #[test]
    fn garbage_before_and_after_is_no_value(
        case in case(), before in proptest::collection::vec(any::<u8>(), 0..40), after in proptest::collection::vec(any::<u8>(), 1..40),
        cuts in proptest::collection::vec(any::<usize>(), 0..4),
    ) {
        let frame = case.rtu();
        prop_assume!(!before.is_empty());
        for bytes in [[before.clone(), frame.clone()].concat(), [before, frame.clone(), after.clone()].concat()] {
            let mut line = rtu();
            line.start(Instant::now(), case.request());
            let given = values(&feed(&mut line, &bytes, &cuts));
            prop_assert!(given.is_empty() || given == [case.says.clone()], "{:?}", given);
        }
        // In one piece with what follows it, an answer is in doubt; in a piece of its own it is one, and the rest is
        // counted by the owner of the link.
        let mut line = rtu();
        line.start(Instant::now(), case.request());
        prop_assert!(is_malformed(&line.handle_input(Instant::now(), &[frame, after].concat())));
    }

    #[test]
    fn noise_is_never_a_value(case in case(), noise in proptest::collection::vec(any::<u8>(), 0..400)) {
        let (mut line, mut stream) = (rtu(), mbap());
        line.start(Instant::now(), case.request());
        prop_assert_eq!(values(&feed(&mut line, &noise, &[3, 7, 20])), vec![]);
        stream.start(Instant::now(), case.request());
        prop_assert_eq!(values(&feed(&mut stream, &noise, &[3, 7, 20])), vec![]);
    }

    /// Cut anywhere, given up, and the rest of it comes before, with or after the next true answer.
    #[test]
    fn a_torn_answer_never_joins_the_next_one(case in case(), next in case(), cut in any::<proptest::sample::Index>()) {
        let now = Instant::now();
        let frame = case.rtu();
        let cut_at = cut.index(frame.len());
        let mut line = rtu();
        line.start(now, case.request());
        feed(&mut line, &frame[..cut_at], &[]);
        prop_assert_eq!(line.abandon(now), &frame[..cut_at]);
        prop_assert!(line.ready_at(now) > now + SLOWEST);
        line.handle_input(now + SLOWEST, &frame[cut_at..]);
        let ready = line.ready_at(now + SLOWEST);
        prop_assert!(ready > now + 2 * SLOWEST);
        line.start(ready, next.request());
        prop_assert_eq!(values(&line.handle_input(ready, &next.rtu())), vec![next.says.clone()]);

        let frame = case.mbap(1);
        let cut_at = cut.index(frame.len());
        let mut stream = mbap();
        stream.start(now, case.request());
        feed(&mut stream, &frame[..cut_at], &[]);
        stream.abandon(now);
        prop_assert_eq!(stream.ready_at(now) > now, cut_at > 0);
        stream.handle_input(now, &frame[cut_at..]);
        let ready = stream.ready_at(now);
        stream.start(ready, next.request());
        prop_assert_eq!(values(&stream.handle_input(ready, &next.mbap(2))), vec![next.says]);
    }

    #[test]
    fn a_late_answer_on_tcp_is_told_apart_by_its_number(case in case(), second in proptest::collection::vec(any::<u16>(), 1..4)) {
        let now = Instant::now();
        let mut stream = mbap();
        let (first, second) = (case, second);
        let second = registers(first.unit, 1, second);
        stream.start(now, first.request());
        stream.abandon(now);
        prop_assert_eq!(stream.ready_at(now), now, "the number decides: no silence is needed");
        stream.start(now, second.request());
        let both = [first.mbap(1), second.mbap(2), second.mbap(2)].concat();
        prop_assert_eq!(values(&feed(&mut stream, &both, &[5, 17])), vec![second.says]);
        prop_assert_eq!(stream.surplus(), 1, "the second answer to one request is counted");
    }
}

#[test]
fn an_answer_of_another_unit_function_or_place_is_none() {
    let now = Instant::now();
    let requested = registers(1, 7, vec![0, 1]);
    for wrong in [
        registers(2, 7, vec![0, 1]),
        registers(1, 7, vec![1]),
        registers(1, 7, vec![0, 1, 2]),
        Case {
            pdu: vec![4, 4, 0, 0, 0, 1],
            ..requested.clone()
        },
    ] {
        let mut line = rtu();
        line.start(now, requested.request());
        assert!(is_malformed(&line.handle_input(now, &wrong.rtu())), "{wrong:?}");
        assert!(line.ready_at(now) > now + SLOWEST);
        let mut stream = mbap();
        stream.start(now, requested.request());
        assert!(is_malformed(&stream.handle_input(now, &wrong.mbap(1))), "{wrong:?}");
    }
    // A write that is acknowledged for another register, or with another value or count.
    for (ask, pdu) in [
        (Ask::WriteRegister { at: 0x7D, value: 0x20 }, [6, 0, 0x7C, 0, 0x20]),
        (Ask::WriteRegister { at: 0x7D, value: 0x20 }, [6, 0, 0x7D, 0, 0]),
        (
            Ask::WriteRegisters {
                from: 0x58,
                values: vec![0; 16],
            },
            [16, 0, 0x58, 0, 15],
        ),
        (
            Ask::WriteCoils {
                from: 3,
                on: vec![true],
            },
            [15, 0, 4, 0, 1],
        ),
    ] {
        let case = Case {
            unit: 1,
            ask,
            pdu: pdu.to_vec(),
            says: Data::Written,
        };
        let mut line = rtu();
        line.start(now, case.request());
        assert!(is_malformed(&line.handle_input(now, &case.rtu())), "{case:?}");
    }
}

#[test]
fn two_answers_at_once_are_none_and_mixed_ones_neither() {
    let now = Instant::now();
    let case = registers(1, 7, vec![2, 0x6F6]);
    let mut line = rtu();
    line.start(now, case.request());
    assert!(is_malformed(
        &line.handle_input(now, &[case.rtu(), case.rtu()].concat())
    ));
    // Two units answer at the same time: bytes of both, in turn.
    let other = registers(1, 9, vec![3, 0x123]).rtu();
    let mixed: Vec<u8> = case.rtu().iter().zip(&other).flat_map(|(a, b)| [*a, *b]).collect();
    let mut line = rtu();
    line.start(now, case.request());
    assert!(is_malformed(&line.handle_input(now, &mixed)));
}

#[test]
fn an_echo_is_named() {
    let now = Instant::now();
    for ask in [
        Ask::ReadHoldingRegisters { from: 7, count: 2 },
        Ask::ReadCoils { from: 0, count: 9 },
        Ask::WriteRegisters {
            from: 0x58,
            values: vec![0; 16],
        },
    ] {
        let sent = rtu().start(now, Request::new(1, ask.clone()).unwrap()).frame;
        for pieces in [1, sent.len()] {
            let mut line = rtu();
            line.start(now, Request::new(1, ask.clone()).unwrap());
            let events: Vec<_> = sent
                .chunks(pieces)
                .flat_map(|piece| line.handle_input(now, piece))
                .collect();
            assert!(
                matches!(&events[..], [Event::Malformed { reason, .. }] if reason.contains("switch off the echo")),
                "{ask:?}: {events:?}"
            );
        }
    }
}

type OnItsWay = VecDeque<(Instant, Vec<u8>)>;

fn arrived(on_its_way: &mut OnItsWay, by: Instant) -> Option<(Instant, Vec<u8>)> {
    on_its_way
        .front()
        .is_some_and(|(at, _)| *at <= by)
        .then(|| on_its_way.pop_front())?
}

/// Four requests to a server on a virtual clock, which answers in order and takes 350 ms for the first answer, 20 ms
/// for the others. The host gives up after 200 ms; one that `waits` keeps to [`Conversation::ready_at`], another goes
/// on after 40 ms. Which answer came to which request.
fn four_requests(
    mut codec: impl Conversation<Request = Request, Answer = Reply>,
    waits: bool,
    frame: impl Fn(&Case, u16) -> Vec<u8>,
) -> Vec<Option<u16>> {
    let ms = Duration::from_millis;
    let mut now = Instant::now();
    let mut on_its_way = OnItsWay::new();
    let mut free = now;
    let mut got = Vec::new();
    for requested in 1..=4_u16 {
        // What comes before the codec is ready is handed to it, and may make it wait for longer.
        while waits && let Some((at, bytes)) = arrived(&mut on_its_way, codec.ready_at(now)) {
            now = now.max(at);
            codec.handle_input(now, &bytes);
        }
        now = if waits { codec.ready_at(now) } else { now + ms(40) };
        let case = registers(1, 7, vec![requested]);
        codec.start(now, case.request());
        free = free.max(now) + ms(if requested == 1 { 350 } else { 20 });
        on_its_way.push_back((free, frame(&case, requested)));
        let deadline = now + ms(200);
        let mut value = None;
        while value.is_none()
            && let Some((at, bytes)) = arrived(&mut on_its_way, deadline)
        {
            now = now.max(at);
            value = match &values(&codec.handle_input(now, &bytes))[..] {
                [Data::Registers(words)] => Some(words[0]),
                _ => None,
            };
        }
        if value.is_none() {
            now = deadline;
            codec.abandon(now);
        }
        got.push(value);
    }
    got
}

/// One slow answer shifts a whole curve where the client does not keep silent after a timeout (tokio-modbus 0.17.0 as
/// it ships, pull request 2636 of pymodbus): each later request gets the answer to the one before.
#[test]
fn one_slow_answer_does_not_shift_the_others() {
    let frame = |case: &Case, _| case.rtu();
    assert_eq!(four_requests(rtu(), true, frame), [None, Some(2), Some(3), Some(4)]);
    let hasty = four_requests(rtu(), false, frame);
    assert_eq!(hasty, [None, Some(1), Some(2), Some(3)], "the scene shows the fault");
    // On TCP the number decides, and nobody needs to wait.
    for waits in [true, false] {
        assert_eq!(
            four_requests(mbap(), waits, Case::mbap),
            [None, Some(2), Some(3), Some(4)]
        );
    }
}

#[test]
fn a_stray_byte_between_requests_prolongs_the_silence() {
    let now = Instant::now();
    let mut line = rtu();
    assert_eq!(line.ready_at(now), now);
    line.handle_input(now, &[0xFF]);
    assert!(line.ready_at(now) > now + SLOWEST);
    let later = now + SLOWEST / 2;
    line.handle_input(later, &[0xFF]);
    assert!(line.ready_at(later) > later + SLOWEST);
    // After an answer the interval of SL 2.5.1.1 is enough.
    let case = registers(1, 7, vec![1]);
    line.start(now, case.request());
    assert_eq!(values(&line.handle_input(now, &case.rtu())), vec![case.says]);
    assert_eq!(line.ready_at(now), now + Duration::from_millis(4));
}

#[test]
fn a_tcp_stream_out_of_step_is_thrown_away_until_it_is_silent() {
    let now = Instant::now();
    let case = registers(1, 7, vec![1]);
    let mut stream = mbap();
    stream.start(now, case.request());
    assert!(is_malformed(&stream.handle_input(now, b"HTTP/1.1 400 Bad Request\r\n")));
    let later = now + SLOWEST / 2;
    assert_eq!(stream.handle_input(later, &case.mbap(1)), vec![]);
    assert_eq!(stream.ready_at(later), later + SLOWEST);
    let ready = stream.ready_at(later);
    stream.start(ready, case.request());
    assert_eq!(values(&stream.handle_input(ready, &case.mbap(2))), vec![case.says]);
}
