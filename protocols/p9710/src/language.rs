//! Requests and the lines that answer them.

use std::time::Duration;

use isolux_protocol_ascii::{Judgement, Language, Line, line};

use crate::measurement::scientific;
use crate::{ErrorCode, Measurement};

/// What may stand between two commands, section 15.3.8.
const SPACERS: [char; 4] = [';', ',', ' ', '\t'];

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// The meter chooses.
    Auto,
    /// 0 (2 mA) to 7 (200 pA).
    Fixed(u8),
}

/// One request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Software version, serial number, unit: `GI;TT;GU`.
    Identify,
    /// Measures one integration time, from now on: `MV;GR;GP` with spacers by turns.
    Measure,
    /// Chooses the range and reads it back.
    SetRange(Range),
    /// Integration time in 0.1 ms, 1 to 59999, read back.
    SetIntegration(u16),
}

/// What a line says.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// The setting reads back as it was sent.
    Done,
    /// Who the meter is, and in which unit it answers.
    Identity {
        /// `P-9710 4.7`
        software: String,
        /// Serial number.
        serial: String,
        /// Unit of the selected calibration data, such as `lx`.
        unit: String,
    },
    /// A measured value.
    Measurement(Measurement),
    /// An error. It carries no mark: whether it belongs to this request is not known.
    Error(ErrorCode),
}

/// The host's side of the line.
#[derive(Debug, Clone, Default)]
pub struct P9710 {
    requested: Option<Request>,
    turn: usize,
    /// What was set last: a range that is held, and the integration time in 0.1 ms.
    held: bool,
    tenths: Option<u16>,
}

impl P9710 {
    fn spacers(&self) -> [char; 2] {
        [SPACERS[self.turn % 4], SPACERS[self.turn / 4]]
    }

    /// The fields of an answer to this request.
    fn read(&self, text: &str) -> Option<Answer> {
        match self.requested? {
            Request::Identify => {
                let mut fields = text.splitn(3, ';').map(|field| field.trim_matches(['"', ' ']));
                let mut next = || fields.next().filter(|field| !field.is_empty()).map(str::to_owned);
                let (software, serial, unit) = (next()?, next()?, next()?);
                software
                    .starts_with("P-9710")
                    .then_some(Answer::Identity { software, serial, unit })
            }
            Request::Measure => {
                let [first, second] = self.spacers();
                let (value, rest) = text.split_once(first)?;
                let (range, percent) = rest.split_once(second)?;
                let [range @ b'0'..=b'7'] = range.as_bytes() else {
                    return None;
                };
                let percent = isolux_protocol_ascii::Number::parse(percent)?;
                Some(Answer::Measurement(Measurement {
                    value: scientific(value)?,
                    range: range - b'0',
                    percent: percent.value,
                }))
            }
            Request::SetRange(Range::Auto) => (text == "1").then_some(Answer::Done),
            Request::SetRange(Range::Fixed(range)) => (text == format!("0;{range}")).then_some(Answer::Done),
            Request::SetIntegration(tenths) => {
                let read = (1..=5).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
                (read && text.parse() == Ok(tenths)).then_some(Answer::Done)
            }
        }
    }
}

impl Language for P9710 {
    type Request = Request;
    type Answer = Answer;

    /// The longest measurement takes 6 s; [`Request::SetIntegration`] of the driver leaves 0.5 s, and a range may be
    /// changed up to seven times.
    /// In a range that is held one integration is all that an answer waits for.
    fn quiet(&self) -> Duration {
        match self.tenths {
            Some(tenths) if self.held => {
                Duration::from_millis(200) + 2 * Duration::from_micros(100) * u32::from(tenths)
            }
            _ => Duration::from_secs(2),
        }
    }

    fn start(&mut self, request: Request) -> (Vec<u8>, Option<Answer>) {
        self.requested = Some(request);
        match request {
            Request::SetRange(range) => self.held = range != Range::Auto,
            Request::SetIntegration(tenths) => self.tenths = Some(tenths),
            Request::Identify | Request::Measure => {}
        }
        let text = match request {
            Request::Identify => "GI;TT;GU".to_owned(),
            Request::Measure => {
                self.turn = (self.turn + 1) % 16;
                let [first, second] = self.spacers();
                format!("MV{first}GR{second}GP")
            }
            Request::SetRange(Range::Auto) => "SB1GS0".to_owned(),
            Request::SetRange(Range::Fixed(range)) => format!("SB0SR{range}GS0;GS1"),
            Request::SetIntegration(tenths) => format!("SN{tenths}GS3"),
        };
        (format!("{text}\n").into_bytes(), None)
    }

    fn judge(&self, received: &[u8]) -> Judgement<Answer> {
        let text = match line(received) {
            Line::More => return Judgement::More,
            Line::Whole(text) => text,
            Line::Damaged(reason) => return Judgement::Damaged(reason),
        };
        if let Some((_, code)) = text.rsplit_once('?') {
            return match code.parse() {
                Ok(code) if code > 0 => Judgement::Answer(Answer::Error(ErrorCode(code))),
                _ => Judgement::Damaged(format!("\"{text}\" is no error number")),
            };
        }
        match self.read(text) {
            Some(answer) => Judgement::Answer(answer),
            None => Judgement::Damaged(format!(
                "\"{}\" does not answer {:?}",
                text.escape_debug(),
                self.requested
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn requested(request: Request) -> P9710 {
        let mut meter = P9710::default();
        meter.start(request);
        meter
    }

    #[test]
    fn requests_are_those_of_the_manual() {
        let frame = |request| String::from_utf8(P9710::default().start(request).0).unwrap();
        assert_eq!(frame(Request::SetIntegration(5000)), "SN5000GS3\n");
        assert_eq!(frame(Request::SetRange(Range::Auto)), "SB1GS0\n");
        assert_eq!(frame(Request::SetRange(Range::Fixed(3))), "SB0SR3GS0;GS1\n");
        assert_eq!(frame(Request::Measure), "MV,GR;GP\n");
    }

    #[test]
    fn answers_of_the_manuals_forms() {
        let answer = requested(Request::Identify).judge(b"P-9710 4.7;1234;\"lx\"\n");
        let (software, serial, unit) = ("P-9710 4.7".to_owned(), "1234".to_owned(), "lx".to_owned());
        assert_eq!(answer, Judgement::Answer(Answer::Identity { software, serial, unit }));
        let Judgement::Answer(Answer::Measurement(measured)) =
            requested(Request::Measure).judge(b"+1.2345E+02,3;+61.7\n")
        else {
            panic!()
        };
        assert_eq!(
            (measured.value.value, measured.range, measured.percent),
            (123.45, 3, 61.7)
        );
        let error = requested(Request::Measure).judge(b"?16\n");
        assert_eq!(error, Judgement::Answer(Answer::Error(ErrorCode(16))));
        assert_eq!(
            requested(Request::SetIntegration(5000)).judge(b"5000\n"),
            Judgement::Answer(Answer::Done)
        );
        assert_eq!(
            requested(Request::SetRange(Range::Fixed(3))).judge(b"0;3\n"),
            Judgement::Answer(Answer::Done)
        );
    }

    #[test]
    fn what_answers_something_else_is_damage() {
        for (request, text) in [
            (Request::Measure, "+1.2345E+02"),
            (Request::Measure, "+1.2345E+02;3;+61.7"),
            (Request::Measure, "+1.2345E+02,8;+61.7"),
            (Request::Measure, "5000"),
            (Request::Measure, ""),
            (Request::Measure, "?"),
            (Request::Measure, "?0"),
            (Request::SetRange(Range::Fixed(3)), "0;4"),
            (Request::SetRange(Range::Auto), "0"),
            (Request::SetIntegration(5000), "500"),
            (Request::SetIntegration(5000), "+5000"),
            (Request::Identify, "GOSSEN;1;lx"),
            (Request::Identify, "P-9710 4.7;1234"),
        ] {
            let judged = requested(request).judge(format!("{text}\n").as_bytes());
            assert!(
                matches!(judged, Judgement::Damaged(_)),
                "{request:?} {text}: {judged:?}"
            );
        }
    }

    #[test]
    fn the_answer_to_another_of_the_last_fifteen_requests_is_none() {
        let mut meter = P9710::default();
        let answers: Vec<String> = (0..16)
            .map(|_| {
                let frame = String::from_utf8(meter.start(Request::Measure).0).unwrap();
                frame
                    .replace("MV", "+1.2345E+02")
                    .replace("GR", "3")
                    .replace("GP", "+61.7")
            })
            .collect();
        for late in &answers[..15] {
            assert!(
                matches!(meter.judge(late.as_bytes()), Judgement::Damaged(_)),
                "{late:?}"
            );
        }
        assert!(matches!(meter.judge(answers[15].as_bytes()), Judgement::Answer(_)));
    }

    proptest! {
        #[test]
        fn no_beginning_and_no_lost_byte_is_an_answer(digits in 0..100_000_u32, range in 0..8_u8, at in 0..20_usize) {
            let meter = requested(Request::Measure);
            let whole = format!("+{}.{:04}E+02,{range};+61.7\n", digits / 10_000, digits % 10_000).into_bytes();
            for cut in 0..whole.len() {
                prop_assert_eq!(meter.judge(&whole[..cut]), Judgement::More);
            }
            // The value and the range have fixed places; of the percentage a digit may be missing.
            prop_assume!(at < 14);
            let mut torn = whole;
            torn.remove(at);
            prop_assert!(!matches!(meter.judge(&torn), Judgement::Answer(_)));
        }

        #[test]
        fn noise_is_no_measurement(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let judged = requested(Request::Measure).judge(&bytes);
            prop_assert!(!matches!(judged, Judgement::Answer(Answer::Measurement(_))));
        }
    }
}
