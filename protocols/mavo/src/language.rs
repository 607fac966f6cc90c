//! Requests and the lines that answer them.

use std::time::Duration;

use isolux_protocol_ascii::{Judgement, Language, Line, line};

use crate::{ErrorCode, Measurement};

/// The long form of the header that measures; three letters of it are enough.
const MEASURE: &str = "PHOTOMETRIC";

/// One request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// `ECHO ON`: the first of all, without which answers have no header.
    Echo,
    /// `*IDN?`
    Identify,
    /// `UNI:PHOT LX`
    Lux,
    /// `PHO?` in one of its spellings: the latest measured value.
    Measure,
    /// `RAN?`: the range in use.
    Range,
    /// `RAN 0` to `RAN 4`. Another number puts the meter into an undefined state without an error.
    SetRange(u8),
    /// `RAN:AUTO ON` or `OFF`.
    SetAuto(bool),
}

/// What a line says.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// A setting was taken.
    Done,
    /// Manufacturer, type, serial number, hardware revision, firmware.
    Identity(String),
    /// A measured value.
    Measurement(Measurement),
    /// The range in use, 0 to 4.
    Range(u8),
    /// An error. It has no echo: whether it belongs to this request is not known.
    Error(ErrorCode),
}

/// The host's side of the line.
#[derive(Debug, Clone, Default)]
pub struct Mavo {
    requested: Option<Request>,
    /// The request as it was written.
    text: String,
    spelling: usize,
}

impl Language for Mavo {
    type Request = Request;
    type Answer = Answer;

    /// A conversion takes 2 s ("0,5 measurements per second"); an answer is never later than that.
    fn quiet(&self) -> Duration {
        Duration::from_millis(2500)
    }

    fn start(&mut self, request: Request) -> (Vec<u8>, Option<Answer>) {
        self.text = match request {
            Request::Echo => "ECHO ON".to_owned(),
            Request::Identify => "*IDN?".to_owned(),
            Request::Lux => "UNI:PHOT LX".to_owned(),
            Request::Measure => {
                self.spelling = (self.spelling + 1) % (MEASURE.len() - 2);
                format!("{}?", &MEASURE[..3 + self.spelling])
            }
            Request::Range => "RAN?".to_owned(),
            Request::SetRange(range) => format!("RAN {}", range.min(4)),
            Request::SetAuto(auto) => format!("RAN:AUTO {}", if auto { "ON" } else { "OFF" }),
        };
        self.requested = Some(request);
        (format!("{}\n", self.text).into_bytes(), None)
    }

    fn judge(&self, received: &[u8]) -> Judgement<Answer> {
        let text = match line(received) {
            Line::More => return Judgement::More,
            Line::Whole(text) => text.trim_end_matches(' '),
            Line::Damaged(reason) => return Judgement::Damaged(reason),
        };
        if let Some(code) = text.strip_prefix("ERROR = ") {
            return match code.parse() {
                Ok(code) if code > 0 => Judgement::Answer(Answer::Error(ErrorCode(code))),
                _ => Judgement::Damaged(format!("\"{code}\" is no error number")),
            };
        }
        let header = self.text.trim_end_matches('?');
        let data = text
            .strip_prefix(header)
            .map(|rest| rest.strip_prefix('?').unwrap_or(rest));
        let answer = match (self.requested, data) {
            (Some(Request::Echo | Request::Lux | Request::SetRange(_) | Request::SetAuto(_)), Some("")) => {
                Some(Ok(Answer::Done))
            }
            (Some(Request::Identify), Some(data)) => {
                data.strip_prefix(' ').map(|data| Ok(Answer::Identity(data.to_owned())))
            }
            (Some(Request::Measure), Some(data)) => data.strip_prefix(' ').map(|data| {
                Measurement::parse(data)
                    .map(Answer::Measurement)
                    .map_err(|error| error.to_string())
            }),
            (Some(Request::Range), Some(data)) => data.strip_prefix(' ').map(|data| match data.as_bytes() {
                [range @ b'0'..=b'4'] => Ok(Answer::Range(range - b'0')),
                _ => Err(format!("\"{data}\" is no range, 0 to 4")),
            }),
            _ => None,
        };
        match answer {
            Some(Ok(answer)) => Judgement::Answer(answer),
            Some(Err(reason)) => Judgement::Damaged(reason),
            None => Judgement::Damaged(format!("\"{text}\" does not answer \"{}\"", self.text)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn requested(request: Request) -> Mavo {
        let mut mavo = Mavo::default();
        mavo.start(request);
        mavo
    }

    fn answer(request: Request, text: &str) -> Answer {
        match requested(request).judge(format!("{text}\n").as_bytes()) {
            Judgement::Answer(answer) => answer,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn golden_exchanges_of_the_interface_description() {
        let identity = answer(Request::Identify, "*IDN GOSSEN,M 502, 20387,01,V 1.00");
        assert_eq!(identity, Answer::Identity("GOSSEN,M 502, 20387,01,V 1.00".to_owned()));
        assert_eq!(answer(Request::Range, "RAN 3"), Answer::Range(3));
        assert_eq!(answer(Request::SetRange(4), "RAN 4"), Answer::Done);
        assert_eq!(answer(Request::SetAuto(false), "RAN:AUTO OFF"), Answer::Done);
        assert_eq!(answer(Request::Lux, "UNI:PHOT LX"), Answer::Done);
        assert_eq!(answer(Request::Echo, "ECHO ON"), Answer::Done);
        // The first request after PHO? is PHOT?.
        for text in ["PHOT? 123E00 LX", "PHOT 123E00 LX"] {
            let Answer::Measurement(measurement) = answer(Request::Measure, text) else {
                panic!("{text}")
            };
            assert_eq!(measurement.lux.value, 123.0);
        }
        assert_eq!(answer(Request::Measure, "ERROR = 019"), Answer::Error(ErrorCode(19)));
    }

    #[test]
    fn a_request_has_32_characters_at_most_and_nine_spellings() {
        let mut mavo = Mavo::default();
        let spellings: std::collections::BTreeSet<Vec<u8>> = (0..9).map(|_| mavo.start(Request::Measure).0).collect();
        assert_eq!(spellings.len(), 9);
        assert!(
            spellings
                .iter()
                .all(|frame| frame.len() <= 32 && frame.starts_with(b"PHO") && frame.ends_with(b"?\n"))
        );
        assert_eq!(mavo.start(Request::SetRange(200)).0, b"RAN 4\n");
    }

    #[test]
    fn the_answer_to_another_of_the_last_eight_requests_is_none() {
        let mut mavo = Mavo::default();
        let frames: Vec<String> = (0..9)
            .map(|_| String::from_utf8(mavo.start(Request::Measure).0).unwrap())
            .collect();
        for frame in &frames[..8] {
            let late = format!("{} 123E00 LX\n", frame.trim_end());
            assert!(matches!(mavo.judge(late.as_bytes()), Judgement::Damaged(_)), "{late}");
        }
        let due = format!("{} 123E00 LX\n", frames[8].trim_end());
        assert!(matches!(mavo.judge(due.as_bytes()), Judgement::Answer(_)));
    }

    #[test]
    fn what_answers_something_else_is_damage() {
        for (request, text) in [
            (Request::Measure, "1234E-01 LX"),
            (Request::Measure, "RAN 3"),
            (Request::Measure, "PHOT? 1234E-01 FC"),
            (Request::Measure, "PHOT?1234E-01 LX"),
            (Request::Range, "RAN 5"),
            (Request::Range, "RAN -1"),
            (Request::SetRange(3), "RAN 4"),
            (Request::SetRange(3), "RAN 3 "),
            (Request::SetAuto(true), "RAN:AUTO OFF"),
            (Request::Measure, "ERROR = x"),
            (Request::Measure, ""),
        ] {
            let judged = requested(request).judge(format!("{text}\n").as_bytes());
            let settled = request == Request::SetRange(3) && text == "RAN 3 ";
            assert_eq!(matches!(judged, Judgement::Answer(_)), settled, "{text}: {judged:?}");
        }
    }

    proptest! {
        #[test]
        fn no_beginning_of_an_answer_is_one(digits in 0..2000_u16, exponent in 0..6_i32) {
            let mavo = requested(Request::Measure);
            let whole = format!("PHOT? {digits}E{:03} LX\n", exponent - 3);
            for cut in 0..whole.len() {
                prop_assert_eq!(mavo.judge(&whole.as_bytes()[..cut]), Judgement::More);
            }
        }

        #[test]
        fn noise_is_no_answer(bytes in proptest::collection::vec(any::<u8>(), 0..40), prefix: bool) {
            let bytes = if prefix { [b"PHOT? 12E", &bytes[..]].concat() } else { bytes };
            let judged = requested(Request::Measure).judge(&bytes);
            prop_assert!(!matches!(judged, Judgement::Answer(_)) || bytes.ends_with(b" LX\n") || bytes.ends_with(b" LX\r\n"));
        }
    }
}
