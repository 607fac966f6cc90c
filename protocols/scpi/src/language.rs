//! Program messages and their responses.

use std::time::Duration;

use isolux_protocol_ascii::{Judgement, Language, Line, line};

/// How a program message ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Terminator {
    /// LF
    Lf,
    /// CR LF
    CrLf,
}

/// What answers a program message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expect {
    /// Nothing: it holds no query.
    Nothing,
    /// One line.
    Text,
    /// One block of definite length (IEEE 488.2, section 8.7.9).
    Block,
}

/// One program message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// The message without its terminator.
    pub message: String,
    /// What answers it.
    pub expect: Expect,
}

impl Request {
    /// A message with a query, answered by a line.
    pub fn query(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            expect: Expect::Text,
        }
    }

    /// A message without a query.
    pub fn command(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            expect: Expect::Nothing,
        }
    }
}

/// A response.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// The message was sent, and nobody answers.
    Sent,
    /// A line, without its end and without blanks at its ends.
    Text(String),
    /// The bytes of a block.
    Block(Vec<u8>),
}

/// The host's side of the line.
#[derive(Debug, Clone)]
pub struct Scpi {
    terminator: Terminator,
    quiet: Duration,
    expect: Expect,
    longest_block: usize,
}

/// Most bytes of a block, where nothing else is said.
const LONGEST_BLOCK: usize = 4096;

impl Scpi {
    /// Messages that end in `terminator`; an answer that was given up may come within `quiet`.
    pub const fn new(terminator: Terminator, quiet: Duration) -> Self {
        Self {
            terminator,
            quiet,
            expect: Expect::Nothing,
            longest_block: LONGEST_BLOCK,
        }
    }

    /// The same, for blocks of up to so many bytes.
    #[must_use]
    pub const fn with_blocks_up_to(self, longest_block: usize) -> Self {
        Self { longest_block, ..self }
    }
}

impl Language for Scpi {
    type Request = Request;
    type Answer = Answer;

    fn quiet(&self) -> Duration {
        self.quiet
    }

    fn longest(&self) -> usize {
        // With `#`, nine digits of the length and the line end.
        match self.expect {
            Expect::Block => LONGEST_BLOCK.max(self.longest_block + 13),
            Expect::Nothing | Expect::Text => LONGEST_BLOCK,
        }
    }

    fn start(&mut self, request: Request) -> (Vec<u8>, Option<Answer>) {
        self.expect = request.expect;
        let end = match self.terminator {
            Terminator::Lf => "\n",
            Terminator::CrLf => "\r\n",
        };
        let frame = format!("{}{end}", request.message).into_bytes();
        (frame, (request.expect == Expect::Nothing).then_some(Answer::Sent))
    }

    fn judge(&self, received: &[u8]) -> Judgement<Answer> {
        match self.expect {
            Expect::Block => block(received, self.longest_block),
            Expect::Nothing | Expect::Text => match line(received) {
                Line::More => Judgement::More,
                Line::Whole(text) if text.trim().is_empty() => Judgement::Damaged("an empty line".to_owned()),
                Line::Whole(text) => Judgement::Answer(Answer::Text(text.trim().to_owned())),
                Line::Damaged(reason) => Judgement::Damaged(reason),
            },
        }
    }
}

/// `#`, the number of digits of the length, the length, the bytes, the line end. The bytes may hold a line end of their
/// own.
fn block(received: &[u8], longest: usize) -> Judgement<Answer> {
    let damaged = |reason: &str| Judgement::Damaged(reason.to_owned());
    match received {
        [] | [b'#'] => return Judgement::More,
        [b'#', b'1'..=b'9', ..] => {}
        _ => return damaged("no block of definite length (#, 1 to 9)"),
    }
    let digits = usize::from(received[1] - b'0');
    let Some(length) = received.get(2..2 + digits) else {
        let begun = received[2..].iter().all(u8::is_ascii_digit);
        return if begun {
            Judgement::More
        } else {
            damaged("the length of the block is no number")
        };
    };
    let length = std::str::from_utf8(length)
        .ok()
        .filter(|text| text.bytes().all(|byte| byte.is_ascii_digit()));
    let Some(length) = length.and_then(|text| text.parse::<usize>().ok()) else {
        return damaged("the length of the block is no number");
    };
    if length > longest {
        return Judgement::Damaged(format!("a block of more than {longest} bytes"));
    }
    let body = 2 + digits;
    match received.get(body..body + length) {
        None => Judgement::More,
        Some(bytes) => match &received[body + length..] {
            [] | [b'\r'] => Judgement::More,
            b"\n" | b"\r\n" => Judgement::Answer(Answer::Block(bytes.to_vec())),
            _ => damaged("bytes after the end of the block"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn requested(expect: Expect) -> Scpi {
        let mut scpi = Scpi::new(Terminator::Lf, Duration::from_secs(1));
        let message = "X?".to_owned();
        scpi.start(Request { message, expect });
        scpi
    }

    #[test]
    fn messages_end_as_the_instrument_wants() {
        let mut scpi = Scpi::new(Terminator::CrLf, Duration::from_secs(1));
        assert_eq!(scpi.start(Request::query("*IDN?")), (b"*IDN?\r\n".to_vec(), None));
        assert_eq!(
            scpi.start(Request::command("*CLS")),
            (b"*CLS\r\n".to_vec(), Some(Answer::Sent))
        );
        assert_eq!(
            requested(Expect::Text).judge(b"YOKOGAWA,WT310,C2PH13047V,F1.03\n"),
            Judgement::Answer(Answer::Text("YOKOGAWA,WT310,C2PH13047V,F1.03".to_owned()))
        );
        assert!(matches!(requested(Expect::Text).judge(b"\r\n"), Judgement::Damaged(_)));
    }

    #[test]
    fn a_block_is_counted_and_not_split_at_its_line_ends() {
        // FLOAT of a WT: 230.0, 0.1834, 40.15 (built from the rule of the manual); 0x0A inside is no end.
        let bytes = b"#40012\x43\x66\x00\x00\x3E\x3B\xCD\x36\x42\x20\x99\x9A\n";
        let Judgement::Answer(Answer::Block(block)) = requested(Expect::Block).judge(bytes) else {
            panic!()
        };
        assert_eq!(f32::from_be_bytes(block[..4].try_into().unwrap()), 230.0);
        let inner = requested(Expect::Block).judge(b"#13\n\n\n\r\n");
        assert_eq!(inner, Judgement::Answer(Answer::Block(b"\n\n\n".to_vec())));
        for damaged in [
            &b"1.5\n"[..],
            b"#0abc\n",
            b"#1x",
            b"#2 3abc\n",
            b"#13abcd",
            b"#45000",
            b"#13abc\nx",
        ] {
            assert!(
                matches!(requested(Expect::Block).judge(damaged), Judgement::Damaged(_)),
                "{}",
                damaged.escape_ascii()
            );
        }
    }

    #[test]
    fn a_record_of_an_oscilloscope_is_a_longer_block() {
        let whole = [b"#9000050000".to_vec(), vec![b'\n'; 50_000], b"\n".to_vec()].concat();
        assert!(matches!(requested(Expect::Block).judge(&whole), Judgement::Damaged(_)));
        let longer = requested(Expect::Block).with_blocks_up_to(50_000);
        assert!(longer.longest() >= whole.len());
        assert_eq!(longer.judge(&whole[..50_000]), Judgement::More);
        assert_eq!(
            longer.judge(&whole),
            Judgement::Answer(Answer::Block(vec![b'\n'; 50_000]))
        );
    }

    proptest! {
        #[test]
        fn no_beginning_of_a_block_is_one(body in proptest::collection::vec(any::<u8>(), 0..40)) {
            let whole = [format!("#2{:02}", body.len()).as_bytes(), &body, b"\n"].concat();
            let scpi = requested(Expect::Block);
            for cut in 0..whole.len() {
                prop_assert_eq!(scpi.judge(&whole[..cut]), Judgement::More);
            }
            prop_assert_eq!(scpi.judge(&whole), Judgement::Answer(Answer::Block(body)));
        }

        #[test]
        fn noise_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            let _ = requested(Expect::Block).judge(&bytes);
            let _ = requested(Expect::Text).judge(&bytes);
        }
    }
}
