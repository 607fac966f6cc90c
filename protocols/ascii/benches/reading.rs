//! The software's own share of a reading in the languages of text lines: from the request to the typed value, the
//! answer in one piece and byte by byte. On the wire, request and answer take 25 ms to 40 ms at 9600 baud.

use std::hint::black_box;
use std::time::Instant;

use isolux_conversation::{Conversation, Event};
use isolux_protocol_ascii::{End, Form, Language, Lines, Message, Number, Pattern, Plain, Reply};
use isolux_protocol_easi::{Bits, Easi, Request as Ask};
use isolux_protocol_mavo::{Answer as MavoAnswer, Mavo, Request as MavoRequest};
use isolux_protocol_p9710::{Answer as P9710Answer, P9710, Request as P9710Request};
use isolux_protocol_scpi::{Answer as ScpiAnswer, Reading, Request as ScpiRequest, Scpi, Terminator};

fn main() {
    divan::main();
}

/// One exchange: request formed, answered in pieces of `piece` bytes, judged.
fn exchange<L: Language>(
    line: &mut Lines<L>,
    now: Instant,
    request: L::Request,
    answer: impl Fn(&[u8]) -> Vec<u8>,
    piece: usize,
) -> Option<L::Answer> {
    let frame = line.start(now, request).frame;
    let answer = black_box(answer(&frame));
    for bytes in answer.chunks(piece) {
        if let Some(Event::Answer(Reply { answer, .. })) = line.handle_input(now, bytes).pop() {
            return Some(answer);
        }
    }
    None
}

#[divan::bench(args = [64, 1])]
fn mavo(bencher: divan::Bencher<'_, '_>, piece: usize) {
    let (now, mut line) = (Instant::now(), Lines::<Mavo>::default());
    let answer = |frame: &[u8]| [frame.trim_ascii_end(), b" 1234E-01 LX\n"].concat();
    bencher.bench_local(|| match exchange(&mut line, now, MavoRequest::Measure, answer, piece) {
        Some(MavoAnswer::Measurement(measurement)) => assert_eq!(measurement.lux.value, 123.4),
        other => panic!("{other:?}"),
    });
}

#[divan::bench(args = [64, 1])]
fn p9710(bencher: divan::Bencher<'_, '_>, piece: usize) {
    let (now, mut line) = (Instant::now(), Lines::<P9710>::default());
    let answer = |frame: &[u8]| [b"+1.2345E+02", &frame[2..3], b"3", &frame[5..6], b"+61.7\n"].concat();
    bencher.bench_local(
        || match exchange(&mut line, now, P9710Request::Measure, answer, piece) {
            Some(P9710Answer::Measurement(measurement)) => assert_eq!(measurement.value.value, 123.45),
            other => panic!("{other:?}"),
        },
    );
}

#[divan::bench(args = [64, 1])]
fn by_a_profile(bencher: divan::Bencher<'_, '_>, piece: usize) {
    let (now, mut line) = (Instant::now(), Lines::<Plain>::default());
    let form = |text: &str, number| Form {
        pattern: Pattern::parse(text).unwrap(),
        number,
    };
    let message = Message {
        text: "E?".to_owned(),
        end: End::CrLf,
        answer_end: End::CrLf,
        echo: false,
        forms: vec![
            form("E {value} lx", Some("value")),
            form("E OVER", None),
            form("E UNDER", None),
            form("ERR {code}", None),
        ],
        unlike: Vec::new(),
        quiet: std::time::Duration::from_secs(1),
    };
    let answer = |_: &[u8]| b"E 123.45 lx\r\n".to_vec();
    bencher.bench_local(|| {
        let stated = exchange(&mut line, now, black_box(message.clone()), answer, piece).unwrap();
        assert_eq!(Number::parse(&stated.fields["value"]).unwrap().value, 123.45);
    });
}

#[divan::bench(args = [64, 1])]
fn scpi_four_quantities(bencher: divan::Bencher<'_, '_>, piece: usize) {
    let (now, mut line) = (
        Instant::now(),
        Lines::new(Scpi::new(Terminator::CrLf, std::time::Duration::from_secs(1))),
    );
    let answer = |_: &[u8]| b"127.58E+00,240.02E-03,17.688E+00,0.5776E+00\r\n".to_vec();
    bencher.bench_local(|| {
        let Some(ScpiAnswer::Text(text)) =
            exchange(&mut line, now, ScpiRequest::query(":NUM:NORM:VAL?"), answer, piece)
        else {
            panic!()
        };
        let values: Vec<Reading> = text.split(',').map(|field| Reading::parse(field, "V")).collect();
        assert_eq!(
            values[2],
            Reading::Value(Number {
                value: 17.688,
                step: 0.001
            })
        );
    });
}

#[divan::bench(args = [64, 1])]
fn easi_status(bencher: divan::Bencher<'_, '_>, piece: usize) {
    let (now, mut line) = (Instant::now(), Lines::<Easi>::default());
    let answer = |frame: &[u8]| [frame, b"*0000_0000_1000_0000_0001_0000_0000_0000\r\n"].concat();
    bencher.bench_local(|| {
        let answer = exchange(&mut line, now, Ask::report(1, "R(ST)"), answer, piece).unwrap();
        assert!(Bits::parse(&answer.value).unwrap().has(9));
    });
}
