//! Requests and their answers, echoes included.

use std::time::Duration;

use isolux_protocol_ascii::{Judgement, Language};

/// One request to the drive with an address, 1 to 255: a command, a report (`R(PA)`, `V`), or a command and a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    address: u8,
    command: Option<String>,
    report: Option<String>,
}

impl Request {
    /// A report alone.
    pub fn report(address: u8, report: &str) -> Self {
        Self {
            address,
            command: None,
            report: Some(report.to_owned()),
        }
    }

    /// A command, and the user faults since the last look at them, which this look clears.
    pub fn command(address: u8, command: &str) -> Self {
        Self {
            command: Some(command.to_owned()),
            ..Self::report(address, "R(UF)")
        }
    }

    /// A command to which no answer is awaited: before it is known whether the drive echoes.
    pub fn blind(address: u8, command: &str) -> Self {
        Self {
            address,
            command: Some(command.to_owned()),
            report: None,
        }
    }
}

/// The end of an exchange.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// What the drive reports, without the asterisk; empty after a [`Request::blind`].
    pub value: String,
    /// The drive said `*E` to the command.
    pub refused: bool,
}

/// The host's side of the line, to one drive or to several.
#[derive(Debug, Clone, Default)]
pub struct Easi {
    /// The echoes to come before the value.
    echoes: Vec<String>,
}

impl Language for Easi {
    type Request = Request;
    type Answer = Answer;

    /// The longest exchange has some 90 characters, 0.1 s at 9600 baud; the drive answers at once.
    fn quiet(&self) -> Duration {
        Duration::from_millis(500)
    }

    fn start(&mut self, request: Request) -> (Vec<u8>, Option<Answer>) {
        let outcome = request.report.is_none().then(|| Answer {
            value: String::new(),
            refused: false,
        });
        let parts = request.command.iter().chain(&request.report);
        let lines: Vec<String> = parts.map(|text| format!("{}{text}", request.address)).collect();
        let frame = lines
            .iter()
            .flat_map(|line| [line.as_bytes(), b"\r"])
            .flatten()
            .copied()
            .collect();
        self.echoes = lines;
        (frame, outcome)
    }

    fn judge(&self, received: &[u8]) -> Judgement<Answer> {
        let damaged = |reason: String| Judgement::Damaged(reason);
        // XON and XOFF: the manual's data format has them on.
        let bytes: Vec<u8> = received
            .iter()
            .copied()
            .filter(|byte| !matches!(byte, 0x11 | 0x13))
            .collect();
        if bytes.contains(&0x07) {
            return damaged("the drive's transmit buffer overflowed (bell)".to_owned());
        }
        if let Some(byte) = bytes.iter().find(|byte| !matches!(byte, b' '..=b'~' | b'\r' | b'\n')) {
            return damaged(format!("byte {byte:02X} is no character of this language"));
        }
        let text = String::from_utf8_lossy(&bytes);
        let ended = text.ends_with(['\r', '\n']);
        let mut lines: Vec<&str> = text.split(['\r', '\n']).filter(|line| !line.is_empty()).collect();
        // The last line is whole once its end is there; a value ends with LF, an echo may end with CR alone.
        let open = if ended { None } else { lines.pop() };
        let mut echoes = self.echoes.iter();
        let mut expected = echoes.next();
        let mut refused = false;
        for (at, line) in lines.iter().enumerate() {
            match expected {
                Some(echo) if line == echo => expected = echoes.next(),
                // An error stands between the echo of the command and that of the report.
                Some(_) if at > 0 && *line == "*E" => refused = true,
                Some(echo) => return damaged(format!("\"{line}\" is not the echo of \"{echo}\"")),
                None => {
                    let last = at + 1 == lines.len() && open.is_none();
                    return match line.strip_prefix('*') {
                        _ if !last => damaged("bytes after the end of the answer".to_owned()),
                        None => damaged(format!("\"{line}\" is no report")),
                        Some("" | "E") => damaged(format!("\"{line}\" is no value")),
                        Some(value) if text.ends_with('\n') => Judgement::Answer(Answer {
                            value: value.to_owned(),
                            refused,
                        }),
                        Some(_) => Judgement::More,
                    };
                }
            }
        }
        Judgement::More
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn requested(request: Request) -> Easi {
        let mut easi = Easi::default();
        easi.start(request);
        easi
    }

    fn value(value: &str) -> Judgement<Answer> {
        Judgement::Answer(Answer {
            value: value.to_owned(),
            refused: false,
        })
    }

    #[test]
    fn frames_have_an_address_no_blanks_and_end_in_cr() {
        // The manual's examples: "1R(PA)", "1D4000"; the address stands before every command.
        let mut easi = Easi::default();
        assert_eq!(easi.start(Request::report(12, "R(PA)")), (b"12R(PA)\r".to_vec(), None));
        assert_eq!(easi.start(Request::command(12, "D4000")).0, b"12D4000\r12R(UF)\r");
        let (frame, outcome) = easi.start(Request::blind(12, "W(EX,2)"));
        assert_eq!((&frame[..], outcome.is_some()), (&b"12W(EX,2)\r"[..], true));
    }

    #[test]
    fn echoes_are_stripped_and_must_be_those_of_the_question() {
        let easi = requested(Request::report(1, "R(PA)"));
        for whole in [
            &b"1R(PA)\r*-450\r\n"[..],
            b"1R(PA)\r\n*-450\r\n",
            b"1R(PA)\r\x13\x11*-450\r\n",
            b"\n1R(PA)\r*-450\n",
        ] {
            assert_eq!(easi.judge(whole), value("-450"), "{}", whole.escape_ascii());
        }
        for damaged in [
            &b"*-450\r\n"[..],
            b"1R(ST)\r*-450\r\n",
            b"2R(PA)\r*-450\r\n",
            b"1R(PA)\r*-450\r\n*-451\r\n",
            b"1R(PA)\r*-450\r\n*",
            b"1R(PA)\r*E\r\n",
            b"1R(PA)\r*\r\n",
            b"1R(PA)\r450\r\n",
            b"1R(PA)\r\x07",
            b"1R(PA)\r*4\xb50\r\n",
            b"*E\r\n1R(PA)\r*450\r\n",
        ] {
            assert!(
                matches!(easi.judge(damaged), Judgement::Damaged(_)),
                "{}",
                damaged.escape_ascii()
            );
        }
    }

    #[test]
    fn a_command_ends_with_its_user_faults_and_may_be_refused() {
        let easi = requested(Request::command(1, "G"));
        let clear = "0000_0000_0000_0000_0000_0000_0000_0000";
        assert_eq!(easi.judge(b"1G\r1R(UF)\r"), Judgement::More);
        assert_eq!(easi.judge(format!("1G\r1R(UF)\r*{clear}\r\n").as_bytes()), value(clear));
        let refused = easi.judge(format!("1G\r*E\r\n1R(UF)\r*{clear}\r\n").as_bytes());
        assert!(matches!(refused, Judgement::Answer(Answer { refused: true, .. })));
    }

    proptest! {
        #[test]
        fn no_beginning_of_an_answer_is_one(steps in any::<i32>(), command: bool) {
            let request = if command { Request::command(1, "S") } else { Request::report(1, "R(PA)") };
            let easi = requested(request);
            let whole = if command { format!("1S\r1R(UF)\r*{steps}\r\n") } else { format!("1R(PA)\r*{steps}\r\n") };
            for cut in 0..whole.len() {
                prop_assert_eq!(easi.judge(&whole.as_bytes()[..cut]), Judgement::More, "{}", cut);
            }
            prop_assert_eq!(easi.judge(whole.as_bytes()), value(&steps.to_string()));
        }

        #[test]
        fn a_lost_byte_is_never_another_value(steps in -99_999..100_000_i32, at in 0..20_usize) {
            let easi = requested(Request::report(1, "R(PA)"));
            let mut bytes = format!("1R(PA)\r*{steps}\r\n").into_bytes();
            prop_assume!(at < bytes.len());
            // Digits alone have no redundancy: there the driver's second look decides.
            prop_assume!(!bytes[at].is_ascii_digit() || at < 7);
            prop_assume!(bytes[at] != b'-');
            bytes.remove(at);
            let judged = easi.judge(&bytes);
            prop_assert!(!matches!(judged, Judgement::Answer(_)) || judged == value(&steps.to_string()), "{:?}", judged);
        }

        #[test]
        fn noise_is_no_answer(bytes in proptest::collection::vec(any::<u8>(), 0..60)) {
            prop_assert!(!matches!(requested(Request::report(1, "R(PA)")).judge(&bytes), Judgement::Answer(_)));
        }
    }
}
