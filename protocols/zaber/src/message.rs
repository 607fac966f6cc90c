//! What the device says.

use crate::{WarningFlag, verified};

/// Moving or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Not moving.
    Idle,
    /// Moving, homing or executing a stream.
    Busy,
}

/// Why a command was rejected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rejection {
    /// The device's word, for example `BADDATA`.
    pub reason: String,
}

/// `@`: the answer to a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// Address of the device.
    pub device: u8,
    /// Axis number, 0 for the device as a whole.
    pub axis: u8,
    /// Id of the command it answers.
    pub id: Option<u8>,
    /// The data, or why the command was rejected.
    pub outcome: Result<String, Rejection>,
    /// Moving or not.
    pub status: Status,
    /// The most important warning flag, if any.
    pub flag: Option<WarningFlag>,
    /// The frame carried a check, and it held.
    pub checked: bool,
}

/// `!`: something happened that nobody asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Alert {
    /// Address of the device.
    pub device: u8,
    /// Axis number, 0 for the device as a whole.
    pub axis: u8,
    /// Moving or not.
    pub status: Status,
    /// The most important warning flag, if any.
    pub flag: Option<WarningFlag>,
    /// What else it says.
    pub data: String,
}

/// `#`: a line of explanation after a reply.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Info {
    /// Address of the device.
    pub device: u8,
    /// Axis number.
    pub axis: u8,
    /// The text.
    pub data: String,
}

/// One line from a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Message {
    /// An answer.
    Reply(Reply),
    /// An alert.
    Alert(Alert),
    /// A line of information.
    Info(Info),
}

/// Why a line is no message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct NotAMessage {
    /// What is wrong with it.
    pub reason: String,
}

impl Message {
    /// Reads one line without its end.
    ///
    /// # Errors
    /// [`NotAMessage`] with the reason: wrong check, unknown type, missing or impossible field.
    pub fn parse(line: &[u8]) -> Result<Self, NotAMessage> {
        let wrong = |reason: &str| NotAMessage {
            reason: reason.to_owned(),
        };
        if !line.is_ascii() {
            return Err(wrong("not ASCII"));
        }
        let text = std::str::from_utf8(line).map_err(|_| wrong("not ASCII"))?;
        let kind = text.get(..1).ok_or_else(|| wrong("empty line"))?;
        let (body, checked) = verified(&text[1..]).map_err(|failed| NotAMessage {
            reason: failed.to_string(),
        })?;
        let mut words = Words { rest: body };
        let device = words.number(99).ok_or_else(|| wrong("no device address"))?;
        let axis = words.number(9).ok_or_else(|| wrong("no axis number"))?;
        match kind {
            "@" => {
                let id = words.number(99);
                let accepted = match words.word() {
                    Some("OK") => true,
                    Some("RJ") => false,
                    _ => return Err(wrong("neither OK nor RJ")),
                };
                let status = words.status().ok_or_else(|| wrong("neither IDLE nor BUSY"))?;
                let flag = words.flag().ok_or_else(|| wrong("no warning flag"))?;
                // "0" stands for no data; an empty field is none of the language.
                let data = words.rest.to_owned();
                if data.is_empty() {
                    return Err(wrong("no data"));
                }
                let outcome = if accepted {
                    Ok(data)
                } else {
                    Err(Rejection { reason: data })
                };
                Ok(Self::Reply(Reply {
                    device,
                    axis,
                    id,
                    outcome,
                    status,
                    flag,
                    checked,
                }))
            }
            "!" => {
                let status = words.status().ok_or_else(|| wrong("neither IDLE nor BUSY"))?;
                let flag = words.flag().ok_or_else(|| wrong("no warning flag"))?;
                Ok(Self::Alert(Alert {
                    device,
                    axis,
                    status,
                    flag,
                    data: words.rest.to_owned(),
                }))
            }
            "#" => Ok(Self::Info(Info {
                device,
                axis,
                data: words.rest.to_owned(),
            })),
            _ => Err(wrong("does not begin with @, ! or #")),
        }
    }
}

impl Reply {
    /// The frame a device sends: with checksum, ended by CR LF.
    pub fn encode(&self) -> Vec<u8> {
        let mut body = format!("{:02} {}", self.device, self.axis);
        if let Some(id) = self.id {
            body.push_str(&format!(" {id:02}"));
        }
        let (accepted, data) = match &self.outcome {
            Ok(data) => ("OK", data),
            Err(rejection) => ("RJ", &rejection.reason),
        };
        let status = match self.status {
            Status::Idle => "IDLE",
            Status::Busy => "BUSY",
        };
        let flag = self.flag.as_ref().map_or("--", WarningFlag::letters);
        body.push_str(&format!(" {accepted} {status} {flag} {data}"));
        format!("@{body}:{:02X}\r\n", crate::checksum(body.as_bytes())).into_bytes()
    }
}

/// The fields of a line, from the left.
struct Words<'a> {
    rest: &'a str,
}

impl<'a> Words<'a> {
    fn word(&mut self) -> Option<&'a str> {
        let (word, rest) = self.rest.split_once(' ').unwrap_or((self.rest, ""));
        self.rest = rest;
        Some(word).filter(|word| !word.is_empty())
    }

    /// The next word as a number up to `largest`; anything else stays unread.
    fn number(&mut self, largest: u8) -> Option<u8> {
        let mut ahead = Words { rest: self.rest };
        let word = ahead
            .word()
            .filter(|word| word.bytes().all(|byte| byte.is_ascii_digit()))?;
        let number = word.parse::<u8>().ok().filter(|number| *number <= largest)?;
        self.rest = ahead.rest;
        Some(number)
    }

    fn status(&mut self) -> Option<Status> {
        match self.word() {
            Some("IDLE") => Some(Status::Idle),
            Some("BUSY") => Some(Status::Busy),
            _ => None,
        }
    }

    /// Outer `None`: the field is not a flag at all.
    #[expect(
        clippy::option_option,
        reason = "a missing field and the field \"--\" are two things"
    )]
    fn flag(&mut self) -> Option<Option<WarningFlag>> {
        match self.word() {
            Some("--") => Some(None),
            Some(word) => WarningFlag::parse(word).map(Some),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn reply(line: &str) -> Reply {
        match Message::parse(line.as_bytes()) {
            Ok(Message::Reply(reply)) => reply,
            other => panic!("{line}: {other:?}"),
        }
    }

    #[test]
    fn reads_the_lines_of_the_manual() {
        let plain = reply("@01 0 OK IDLE -- 0");
        assert_eq!(
            (plain.device, plain.axis, plain.id, plain.status),
            (1, 0, None, Status::Idle)
        );
        assert_eq!(
            (plain.outcome, plain.flag, plain.checked),
            (Ok("0".into()), None, false)
        );
        let rejected = reply("@01 0 RJ IDLE -- BADCOMMAND");
        assert_eq!(
            rejected.outcome,
            Err(Rejection {
                reason: "BADCOMMAND".into()
            })
        );
        let full = reply("@01 1 23 OK BUSY WR 12345:C4");
        assert_eq!(
            (full.id, full.checked, full.flag),
            (Some(23), true, WarningFlag::parse("WR"))
        );
        let several = reply("@01 1 OK IDLE FS 02 FS NI");
        assert_eq!(several.outcome, Ok("02 FS NI".into()));
        assert!(matches!(Message::parse(b"!01 1 IDLE FS"), Ok(Message::Alert(_))));
        assert!(matches!(
            Message::parse(b"#01 0 Visit www.zaber.com"),
            Ok(Message::Info(_))
        ));
    }

    #[test]
    fn a_damaged_line_is_none() {
        for line in [
            "",
            "@",
            "@01",
            "@01 0",
            "@01 0 OK",
            "@01 0 OK IDLE",
            "@01 0 OK IDLE --",
            "@01 0 OK IDLE - 0",
            "@01 0 NO IDLE -- 0",
            "@01 10 OK IDLE -- 0",
            "@1x 0 OK IDLE -- 0",
            "@01 1 23 OK BUSY WR 12345:C5",
            "@01 1 23 OK BUSY WR 12346:C4",
            "?01 0 OK IDLE -- 0",
            "@01 1 23 OK BUSY WR 12345:GG",
            "@01 0 100 OK IDLE -- 0",
        ] {
            assert!(Message::parse(line.as_bytes()).is_err(), "{line}");
        }
    }

    #[test]
    fn zaber_serial_reads_what_we_write() {
        // Lines that the manufacturer's Python package zaber.serial 0.9.1 accepts with its checksum test
        // (AsciiReply(line).encode() gives them back); ours must be the same bytes.
        for (line, axis, id, data, status, flag) in [
            (
                "@01 2 07 OK BUSY WR -12345:94\r\n",
                2_u8,
                7_u8,
                "-12345",
                Status::Busy,
                "WR",
            ),
            ("@01 0 99 OK IDLE -- 1.5:97\r\n", 0_u8, 99_u8, "1.5", Status::Idle, "--"),
            (
                "@01 1 00 OK IDLE WR 02 WR WH:03\r\n",
                1_u8,
                0_u8,
                "02 WR WH",
                Status::Idle,
                "WR",
            ),
        ] {
            let outcome = Ok(data.to_owned());
            let flag = WarningFlag::parse(flag);
            let ours = Reply {
                device: 1,
                axis,
                id: Some(id),
                outcome,
                status,
                flag,
                checked: true,
            };
            assert_eq!(String::from_utf8(ours.encode()).unwrap(), line);
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(device in 1..=99_u8, axis in 0..=9_u8, id in 0..=99_u8, value in any::<i32>(), busy: bool) {
            let reply = Reply {
                device, axis, id: Some(id), outcome: Ok(value.to_string()),
                status: if busy { Status::Busy } else { Status::Idle }, flag: None, checked: true,
            };
            let frame = reply.encode();
            let line = &frame[..frame.len() - 2];
            prop_assert_eq!(Message::parse(line), Ok(Message::Reply(reply)));
        }

        #[test]
        fn one_changed_byte_is_never_read_as_another_answer(id in 0..=99_u8, value in any::<i32>(), at in 0..40_usize, bit in 0..7_u8) {
            let reply = Reply {
                device: 1, axis: 1, id: Some(id), outcome: Ok(value.to_string()), status: Status::Idle, flag: None, checked: true,
            };
            let frame = reply.encode();
            let mut line = frame[..frame.len() - 2].to_vec();
            let at = at % line.len();
            line[at] ^= 1 << bit;
            // A colon that is hit leaves a frame without a check; the conversation refuses those (see there).
            if let Ok(Message::Reply(read)) = Message::parse(&line) {
                prop_assert!(!read.checked || read == reply, "{:?}", read);
            }
        }

        #[test]
        fn noise_never_panics(line in proptest::collection::vec(any::<u8>(), 0..120)) {
            let _ = Message::parse(&line);
            let _ = crate::Command::parse(&line);
        }
    }
}
