//! The software's own share of a spectrum: from the request to 1024 typed counts, the MD5 sum of 2 kB included.
//! Full-speed USB takes 1.7 ms for the 2112 bytes at best, RS-232 at 9600 baud 2.2 s.

use std::hint::black_box;
use std::time::Instant;

use isolux_conversation::{Conversation, Event};
use isolux_protocol_obp::{Flags, Host, Message, PIXELS, Request, Value};

fn main() {
    divan::main();
}

#[divan::bench]
fn spectrum(bencher: divan::Bencher<'_, '_>) {
    let now = Instant::now();
    // An instrument that sends no numbers back: the same bytes answer every request.
    let message = Message {
        flags: Flags::RESPONSE,
        error: 0,
        kind: Request::Spectrum.kind(),
        regarding: 0,
        checked: true,
        data: vec![0x21; 2 * PIXELS],
    };
    let answer = message.encode();
    let mut host = Host::default();
    bencher.bench_local(|| {
        black_box(host.start(now, Request::Spectrum));
        let events = host.handle_input(now, black_box(&answer));
        let Some(Event::Answer(answer)) = events.into_iter().next() else {
            panic!("no spectrum");
        };
        assert!(matches!(&answer.value, Value::Spectrum(counts) if counts.len() == PIXELS));
    });
}
