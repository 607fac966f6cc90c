//! Languages that a profile describes: a message, and the forms that its answer may have.

use std::time::Duration;

use crate::{Fields, Judgement, Language, Number, Pattern};

/// What ends a message or an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// CR
    Cr,
    /// LF; in an answer a CR may stand before it.
    Lf,
    /// CR LF
    CrLf,
}

impl End {
    const fn bytes(self) -> &'static [u8] {
        match self {
            Self::Cr => b"\r",
            Self::Lf => b"\n",
            Self::CrLf => b"\r\n",
        }
    }
}

/// One form of an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// What the line looks like.
    pub pattern: Pattern,
    /// The field that holds a number ([`Number`]); a line with anything else there has another form.
    pub number: Option<&'static str>,
}

impl Form {
    /// The fields of `line`, if it has this form.
    pub fn read(&self, line: &str) -> Option<Fields> {
        let fields = self.pattern.read(line)?;
        let whole = |name: &str| {
            fields
                .get(name)
                .is_some_and(|text| Number::parse(text.trim()).is_some())
        };
        self.number.is_none_or(whole).then_some(fields)
    }
}

/// One message. All that differs from instrument to instrument is in it, so that several share a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// The message without its end.
    pub text: String,
    /// What ends it.
    pub end: End,
    /// What ends the answer.
    pub answer_end: End,
    /// The instrument sends the message back before it answers.
    pub echo: bool,
    /// The forms that an answer may have, and it must have exactly one of them. None: nothing answers.
    pub forms: Vec<Form>,
    /// Forms that an answer must not have: those of the answers to other messages.
    pub unlike: Vec<Form>,
    /// How long the line must be silent after a failure: longer than the slowest answer takes to begin.
    pub quiet: Duration,
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Received {
    /// Which of [`Message::forms`] it has.
    pub form: usize,
    /// Its fields.
    pub fields: Fields,
}

/// The host's side of a line on which such instruments are.
#[derive(Debug, Clone, Default)]
pub struct Plain {
    current: Option<Message>,
}

impl Plain {
    fn form(message: &Message, line: &str) -> Result<Received, String> {
        let mut read = (message.forms.iter().enumerate()).filter_map(|(form, known)| Some((form, known.read(line)?)));
        let Some((form, fields)) = read.next() else {
            return Err(if line == message.text {
                format!("\"{line}\" is the message itself: the instrument echoes, set echo = true")
            } else {
                format!("\"{line}\" has no form that an answer to \"{}\" has", message.text)
            });
        };
        if read.next().is_some() {
            return Err(format!(
                "\"{line}\" has two of the forms of an answer: which one counts?"
            ));
        }
        if message.unlike.iter().any(|other| other.read(line).is_some()) {
            return Err(format!("\"{line}\" may be the answer to another message"));
        }
        Ok(Received { form, fields })
    }
}

impl Language for Plain {
    type Request = Message;
    type Answer = Received;

    fn quiet(&self) -> Duration {
        self.current.as_ref().map_or(Duration::ZERO, |message| message.quiet)
    }

    fn start(&mut self, message: Message) -> (Vec<u8>, Option<Received>) {
        let bytes = [message.text.as_bytes(), message.end.bytes()].concat();
        let nobody = message.forms.is_empty() && !message.echo;
        self.current = Some(message);
        let at_once = nobody.then(|| Received {
            form: 0,
            fields: Fields::new(),
        });
        (bytes, at_once)
    }

    fn judge(&self, received: &[u8]) -> Judgement<Received> {
        let Some(message) = &self.current else {
            return Judgement::Damaged("nothing was asked".to_owned());
        };
        let mut rest = received;
        if message.echo {
            let echo = [message.text.as_bytes(), message.end.bytes()].concat();
            let arrived = rest.len().min(echo.len());
            if rest[..arrived] != echo[..arrived] {
                return Judgement::Damaged(format!("the echo is not that of \"{}\"", message.text));
            }
            rest = &rest[arrived..];
            if message.forms.is_empty() && arrived == echo.len() {
                return if rest.is_empty() {
                    let (form, fields) = (0, Fields::new());
                    Judgement::Answer(Received { form, fields })
                } else {
                    Judgement::Damaged("bytes after the echo of a message that nothing answers".to_owned())
                };
            }
        }
        let end = message.answer_end.bytes();
        let at = rest.windows(end.len()).position(|bytes| bytes == end);
        let mut line = &rest[..at.unwrap_or(rest.len())];
        if at.is_none() && end.len() == 2 {
            // The first half of the end may be there already.
            line = line.strip_suffix(b"\r").unwrap_or(line);
        }
        if message.answer_end == End::Lf {
            line = line.strip_suffix(b"\r").unwrap_or(line);
        }
        if let Some(byte) = line.iter().find(|byte| !matches!(byte, b' '..=b'~' | b'\t')) {
            let reason = format!(
                "byte {byte:02X} is no character of an answer that ends in {:?}",
                message.answer_end
            );
            return Judgement::Damaged(reason);
        }
        match at {
            None => Judgement::More,
            Some(at) if at + end.len() < rest.len() => {
                Judgement::Damaged("bytes after the end of the answer".to_owned())
            }
            // All bytes are ASCII.
            Some(_) => match Self::form(message, &String::from_utf8_lossy(line)) {
                Ok(stated) => Judgement::Answer(stated),
                Err(reason) => Judgement::Damaged(reason),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn form(pattern: &str, number: Option<&'static str>) -> Form {
        let pattern = Pattern::parse(pattern).unwrap();
        Form { pattern, number }
    }

    fn message() -> Message {
        Message {
            text: "E?".to_owned(),
            end: End::Cr,
            answer_end: End::CrLf,
            echo: false,
            forms: vec![
                form("E {value} lx", Some("value")),
                form("E OVER", None),
                form("ERR {code}", None),
            ],
            unlike: Vec::new(),
            quiet: Duration::from_secs(1),
        }
    }

    fn judged(message: Message, received: &[u8]) -> Judgement<Received> {
        let mut plain = Plain::default();
        assert_eq!(plain.start(message).0, b"E?\r");
        plain.judge(received)
    }

    fn stated(message: Message, received: &[u8]) -> Option<(usize, Vec<String>)> {
        match judged(message, received) {
            Judgement::Answer(stated) => Some((stated.form, stated.fields.into_values().collect())),
            _ => None,
        }
    }

    #[test]
    fn an_answer_has_one_of_its_forms_and_a_number_where_one_belongs() {
        let one = |text: &str| vec![text.to_owned()];
        assert_eq!(stated(message(), b"E 12.5 lx\r\n"), Some((0, one("12.5"))));
        assert_eq!(stated(message(), b"E OVER\r\n"), Some((1, vec![])));
        assert_eq!(stated(message(), b"ERR 7\r\n"), Some((2, one("7"))));
        for (received, reason) in [
            (&b"E NAN lx\r\n"[..], "has no form"),
            (b"E 12.5 lx\n", "byte 0A"),
            (b"E 12.5 lx\r\nE", "after the end"),
            (b"E 12\x00", "byte 00"),
            (b"E?\r\n", "set echo = true"),
        ] {
            let Judgement::Damaged(found) = judged(message(), received) else {
                panic!("{received:?}")
            };
            assert!(found.contains(reason), "{found}");
        }
        let mut both = message();
        both.forms.push(form("E {word}", None));
        assert!(
            matches!(judged(both, b"E OVER\r\n"), Judgement::Damaged(reason) if reason.contains("which one counts"))
        );
        let mut proof = message();
        (proof.forms, proof.unlike) = (vec![form("{id}", None)], message().forms);
        assert!(
            matches!(judged(proof.clone(), b"E 1 lx\r\n"), Judgement::Damaged(reason) if reason.contains("another"))
        );
        assert!(stated(proof, b"LUX-1\r\n").is_some());
    }

    #[test]
    fn an_echo_is_that_of_the_message_and_is_awaited_where_nothing_else_comes() {
        let echo = || Message {
            echo: true,
            ..message()
        };
        assert_eq!(stated(echo(), b"E?\rE 1.5 lx\r\n"), Some((0, vec!["1.5".to_owned()])));
        assert_eq!(stated(echo(), b"E 1.5 lx\r\n"), None);
        assert_eq!(judged(echo(), b"E"), Judgement::More);
        let blind = || Message {
            forms: vec![],
            ..echo()
        };
        assert_eq!(judged(blind(), b"E?"), Judgement::More);
        assert_eq!(stated(blind(), b"E?\r"), Some((0, vec![])));
        assert_eq!(stated(blind(), b"E?\rE"), None);
        let mut plain = Plain::default();
        assert!(
            plain
                .start(Message {
                    forms: vec![],
                    ..message()
                })
                .1
                .is_some()
        );
        assert_eq!(plain.quiet(), Duration::from_secs(1));
    }

    proptest! {
        #[test]
        fn every_beginning_of_an_answer_is_one(cut in 0..11_usize, end in 0..3_usize) {
            let (end, bytes) = [(End::Cr, &b"E 12.5 lx\r"[..]), (End::Lf, b"E 12.5 lx\r\n"), (End::CrLf, b"E 12.5 lx\r\n")][end];
            let message = Message { answer_end: end, ..message() };
            prop_assert_eq!(judged(message.clone(), &bytes[..cut.min(bytes.len() - 1)]), Judgement::More);
            prop_assert!(stated(message, bytes).is_some());
        }

        #[test]
        fn noise_is_no_answer(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            prop_assume!(!bytes.starts_with(b"E") && !bytes.trim_ascii_start().starts_with(b"E"));
            prop_assert!(stated(message(), &bytes).is_none());
        }
    }
}
