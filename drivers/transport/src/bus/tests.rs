use isolux_conversation::{Event, Start};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};

use super::*;

/// A toy language: one byte asks, the byte after it answers, 0xFF is damage; quiet for 100 ms after a timeout.
#[derive(Default)]
struct Successor {
    waiting: Option<u8>,
    quiet_until: Option<std::time::Instant>,
}

impl Conversation for Successor {
    type Request = u8;
    type Answer = u8;

    fn ready_at(&self, now: std::time::Instant) -> std::time::Instant {
        self.quiet_until.unwrap_or(now)
    }

    fn start(&mut self, _: std::time::Instant, request: u8) -> Start<u8> {
        self.waiting = Some(request);
        Start::answered(vec![request])
    }

    fn handle_input(&mut self, now: std::time::Instant, bytes: &[u8]) -> Vec<Event<u8>> {
        if self.waiting.take().is_none() {
            self.quiet_until = Some(now + Duration::from_millis(100));
            return vec![];
        }
        vec![match bytes[0] {
            0xFF => Event::Malformed {
                reason: "damage".into(),
                frame: bytes.to_vec(),
            },
            byte => Event::Answer(byte),
        }]
    }

    fn abandon(&mut self, now: std::time::Instant) -> Vec<u8> {
        self.waiting = None;
        self.quiet_until = Some(now + Duration::from_millis(100));
        Vec::new()
    }
}

/// Another language on the same line: a letter asks, the same letter answers; never quiet, as one with numbered
/// messages.
#[derive(Default)]
struct Echo(Option<char>);

impl Conversation for Echo {
    type Request = char;
    type Answer = char;

    fn start(&mut self, _: std::time::Instant, request: char) -> Start<char> {
        self.0 = Some(request);
        Start::answered(vec![request as u8])
    }

    fn handle_input(&mut self, _: std::time::Instant, bytes: &[u8]) -> Vec<Event<char>> {
        let mut events = Vec::new();
        for byte in bytes {
            match self.0.take_if(|requested| *requested == char::from(*byte)) {
                Some(answer) => events.push(Event::Answer(answer)),
                None => events.push(Event::Remark(format!("{byte:02X} is no answer"))),
            }
        }
        events
    }

    fn abandon(&mut self, _: std::time::Instant) -> Vec<u8> {
        self.0 = None;
        Vec::new()
    }
}

fn port() -> (Port, DuplexStream) {
    let (host, twin) = tokio::io::duplex(64);
    (Port::spawn(Box::new(host), "memory:x"), twin)
}

async fn bus() -> (Bus<Successor>, DuplexStream) {
    let (port, twin) = port();
    (Bus::on(port.clone(), Successor::default).await, twin)
}

fn soon() -> Instant {
    Instant::now() + Duration::from_millis(50)
}

#[tokio::test(start_paused = true)]
async fn many_callers_each_get_their_own_answer() {
    let (bus, mut twin) = bus().await;
    tokio::spawn(async move {
        while let Ok(byte) = twin.read_u8().await {
            tokio::time::sleep(Duration::from_millis(1)).await;
            let _ = twin.write_u8(byte + 1).await;
        }
    });
    let askers: Vec<_> = (0..20_u8)
        .map(|n| {
            let bus = bus.clone();
            tokio::spawn(async move { (n, bus.ask(n, soon()).await) })
        })
        .collect();
    for asker in askers {
        let (n, answer) = asker.await.unwrap();
        assert_eq!(answer, Ok(n + 1));
    }
}

#[tokio::test(start_paused = true)]
async fn a_late_answer_is_drained_and_a_caller_who_leaves_takes_his_answer_along() {
    let (bus, mut twin) = bus().await;
    let began = Instant::now();
    let error = bus.ask(1, soon()).await.unwrap_err();
    assert_eq!(
        error,
        BusError::Timeout {
            waited: Duration::from_millis(50),
            received: vec![]
        }
    );
    twin.write_u8(2).await.unwrap();
    let next = bus.ask(10, Instant::now() + Duration::from_secs(1));
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        assert_eq!(twin.read_u8().await.unwrap(), 10);
        assert!(
            began.elapsed() >= Duration::from_millis(150),
            "the line was silent first"
        );
        twin.write_u8(11).await.unwrap();
    };
    assert_eq!(tokio::join!(next, answer).0, Ok(11));

    let left = tokio::time::timeout(Duration::from_millis(5), bus.ask(20, soon())).await;
    assert!(left.is_err());
    let next = bus.ask(30, Instant::now() + Duration::from_secs(1));
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 20);
        twin.write_u8(21).await.unwrap();
        assert_eq!(twin.read_u8().await.unwrap(), 30);
        twin.write_u8(31).await.unwrap();
    };
    assert_eq!(tokio::join!(next, answer).0, Ok(31));
}

#[tokio::test(start_paused = true)]
async fn damage_and_a_lost_link_are_told_apart() {
    let (bus, mut twin) = bus().await;
    let damage = async {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        twin.write_u8(0xFF).await.unwrap();
    };
    let (answer, ()) = tokio::join!(bus.ask(1, soon()), damage);
    assert!(matches!(answer, Err(BusError::Malformed { .. })));
    drop(twin);
    let Err(BusError::Disconnected { reason }) = bus.ask(1, soon()).await else {
        panic!("the link is gone");
    };
    assert!(bus.is_closed());
    // Later requests fail with the same reason.
    assert_eq!(bus.ask(1, soon()).await, Err(BusError::Disconnected { reason }));
}

#[tokio::test(start_paused = true)]
async fn what_arrived_before_a_request_never_answers_it_and_is_counted() {
    let (bus, mut twin) = bus().await;
    // The request is queued and the bytes lie in the link before the owner of the link runs at all.
    twin.write_u8(99).await.unwrap();
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        twin.write_u8(2).await.unwrap();
    };
    let deadline = Instant::now() + Duration::from_secs(1);
    assert_eq!(tokio::join!(bus.ask(1, deadline), answer).0, Ok(2));
    assert_eq!(bus.unsolicited(), 1);
    twin.write_u8(3).await.unwrap();
    tokio::time::sleep(Duration::from_millis(1)).await;
    assert_eq!(bus.unsolicited(), 2);
}

#[tokio::test(start_paused = true)]
async fn a_deadline_inside_the_quarantine_is_kept() {
    let (bus, _twin) = bus().await;
    bus.ask(1, soon()).await.unwrap_err();
    let began = Instant::now();
    assert!(matches!(bus.ask(2, soon()).await, Err(BusError::Timeout { .. })));
    assert_eq!(began.elapsed(), Duration::from_millis(50));
}

#[tokio::test(start_paused = true)]
async fn two_languages_take_turns_and_neither_hears_the_answers_of_the_other() {
    let (port, mut twin) = port();
    let (numbers, letters) = (
        Bus::on(port.clone(), Successor::default).await,
        Bus::on(port.clone(), Echo::default).await,
    );
    tokio::spawn(async move {
        while let Ok(byte) = twin.read_u8().await {
            tokio::time::sleep(Duration::from_millis(3)).await;
            let _ = twin.write_u8(if byte >= b'a' { byte } else { byte + 1 }).await;
        }
    });
    for round in 0..10 {
        let letter = char::from(b'a' + round);
        let (number, stated) = tokio::join!(numbers.ask(round, soon()), letters.ask(letter, soon()));
        assert_eq!((number, stated), (Ok(round + 1), Ok(letter)));
    }
    assert_eq!(port.unsolicited(), 0);
}

#[tokio::test(start_paused = true)]
async fn a_request_waits_until_every_conversation_of_the_port_is_ready() {
    let (port, mut twin) = port();
    let (numbers, letters) = (
        Bus::on(port.clone(), Successor::default).await,
        Bus::on(port.clone(), Echo::default).await,
    );
    numbers.ask(1, soon()).await.unwrap_err();
    assert_eq!(twin.read_u8().await.unwrap(), 1);
    let began = Instant::now();
    // The late answer of one language arrives between the requests: all hear it, and the silence begins anew.
    tokio::time::sleep(Duration::from_millis(60)).await;
    twin.write_u8(2).await.unwrap();
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), b'a');
        assert!(began.elapsed() >= Duration::from_millis(160), "{:?}", began.elapsed());
        twin.write_u8(b'a').await.unwrap();
    };
    let deadline = Instant::now() + Duration::from_secs(2);
    assert_eq!(tokio::join!(letters.ask('a', deadline), answer).0, Ok('a'));
    assert_eq!(port.unsolicited(), 1);
}

#[tokio::test(start_paused = true)]
async fn a_language_that_needs_no_silence_keeps_it_for_the_others() {
    let (port, mut twin) = port();
    let (numbers, letters) = (
        Bus::on(port.clone(), Successor::default).await,
        Bus::on(port.clone(), Echo::default).await,
    );
    letters.ask('a', soon()).await.unwrap_err();
    assert_eq!(twin.read_u8().await.unwrap(), b'a');
    tokio::time::sleep(Duration::from_millis(40)).await;
    // Sent at once, the next request of the other language would have been answered by this.
    twin.write_u8(b'a').await.unwrap();
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 5);
        twin.write_u8(6).await.unwrap();
    };
    let deadline = Instant::now() + Duration::from_secs(2);
    assert_eq!(tokio::join!(numbers.ask(5, deadline), answer).0, Ok(6));
}

#[tokio::test(start_paused = true)]
async fn who_has_the_port_alone_keeps_all_others_waiting() {
    let (port, mut twin) = port();
    let (numbers, letters) = (
        Bus::on(port.clone(), Successor::default).await,
        Bus::on(port.clone(), Echo::default).await,
    );
    let script = tokio::spawn(async move {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        twin.write_u8(9).await.unwrap();
        tokio::time::sleep(Duration::from_millis(20)).await;
        // The true answer comes after the one that was believed, while the other language waits for its turn.
        twin.write_u8(2).await.unwrap();
        while let Ok(byte) = twin.read_u8().await {
            let _ = twin.write_u8(byte).await;
        }
    });
    let later = Instant::now() + Duration::from_secs(2);
    let line = numbers.exclusive(later).await.unwrap();
    assert_eq!(
        line.exchange(1, Duration::from_millis(50), later).await.unwrap().answer,
        9
    );
    let waiting = tokio::spawn(async move { letters.ask('a', later).await });
    tokio::time::sleep(Duration::from_millis(30)).await;
    assert_eq!(
        numbers.unsolicited(),
        1,
        "the surplus is seen, and not swallowed by the other language"
    );
    drop(line);
    assert_eq!(waiting.await.unwrap(), Ok('a'));
    script.abort();
    let kept = numbers.exclusive(later).await.unwrap();
    assert!(matches!(numbers.ask(1, soon()).await, Err(BusError::Timeout { .. })));
    drop(kept);
}

#[tokio::test(start_paused = true)]
async fn a_dead_device_is_asked_as_often_as_is_stated_and_the_proof_counts_too() {
    for prove in [None, Some(7)] {
        let (bus, mut twin) = bus().await;
        let deadline = Instant::now() + Duration::from_secs(5);
        let requested = bus.ask_again(1, prove, Duration::from_millis(50), deadline).await;
        assert!(matches!(requested, Err(BusError::Timeout { .. })));
        drop(bus);
        let mut heard = Vec::new();
        twin.read_to_end(&mut heard).await.unwrap();
        assert_eq!(heard.len(), crate::TRIES as usize);
        assert!(heard[1..].iter().all(|byte| *byte == prove.unwrap_or(1)), "{heard:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_lost_answer_is_asked_for_again_once_the_line_is_in_step() {
    let (bus, mut twin) = bus().await;
    let script = async {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        assert_eq!(twin.read_u8().await.unwrap(), 7, "first the proof");
        twin.write_u8(8).await.unwrap();
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        twin.write_u8(2).await.unwrap();
    };
    let deadline = Instant::now() + Duration::from_secs(5);
    let requested = bus.ask_again(1, Some(7), Duration::from_millis(50), deadline);
    assert_eq!(tokio::join!(requested, script).0, Ok(2));
}

#[tokio::test(start_paused = true)]
async fn a_deadline_that_passed_while_the_program_was_stopped_is_no_timeout() {
    let (bus, mut twin) = bus().await;
    // The answer comes after the program runs again, and the deadline is long over.
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 1);
        tokio::time::advance(Duration::from_secs(45)).await;
        tokio::time::sleep(Duration::from_millis(20)).await;
        twin.write_u8(2).await.unwrap();
    };
    assert_eq!(tokio::join!(bus.ask(1, soon()), answer).0, Ok(2));
    // Without an answer it is asked again, although the deadline of all tries is over.
    let answer = async {
        assert_eq!(twin.read_u8().await.unwrap(), 3);
        tokio::time::advance(Duration::from_secs(45)).await;
        assert_eq!(twin.read_u8().await.unwrap(), 3);
        twin.write_u8(4).await.unwrap();
    };
    let patience = Duration::from_millis(50);
    let requested = bus.ask_again(3, None, patience, Instant::now() + Duration::from_secs(1));
    assert_eq!(tokio::join!(requested, answer).0, Ok(4));
    // And a twin that is silent is silent.
    let began = Instant::now();
    assert!(matches!(bus.ask(5, soon()).await, Err(BusError::Timeout { .. })));
    assert!(began.elapsed() < Duration::from_millis(500));
}
