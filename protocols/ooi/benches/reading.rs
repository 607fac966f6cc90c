//! The software's own share of a spectrum: from the request to 2048 typed counts. High-speed USB takes 0.1 ms for the
//! 4097 bytes at best, a serial line at 115200 baud 356 ms.

use std::hint::black_box;
use std::time::Instant;

use isolux_conversation::{Conversation, Event};
use isolux_protocol_ooi::{Answer, Endpoint, Frame, Host, PIXELS, Request};

fn main() {
    divan::main();
}

#[divan::bench]
fn spectrum(bencher: divan::Bencher<'_, '_>) {
    let now = Instant::now();
    let mut payload = vec![0x21; 2 * PIXELS];
    payload.push(0x69);
    let endpoint = Endpoint::Spectrum;
    let answer = Frame { endpoint, payload }.encode();
    let mut host = Host::default();
    bencher.bench_local(|| {
        black_box(host.start(now, Request::Spectrum));
        let events = host.handle_input(now, black_box(&answer));
        let Some(Event::Answer(Some(Answer::Spectrum(counts)))) = events.into_iter().next() else {
            panic!("no spectrum");
        };
        assert_eq!(counts.len(), PIXELS);
    });
}
