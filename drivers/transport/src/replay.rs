//! A recorded session, read back and played.

use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::io;
use std::pin::Pin;
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use async_trait::async_trait;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use crate::{LineSettings, Link, LinkError, Links};

/// First line of a trace.
pub(crate) const HEADER: &str = "# isolux-trace/1: seconds, link, direction, bytes";

/// Which way bytes went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The link was opened; the bytes are the line settings as text.
    Opened,
    /// From this program.
    ToDevice,
    /// From the device; no bytes: the device closed the link.
    FromDevice,
}

/// One line of a trace: `1.204500 /dev/ttyUSB0 > /1 1 23 get pos:66\n`, bytes escaped as in a Rust byte string.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Passage {
    /// Time since the recording began.
    pub at: Duration,
    /// Address of the link.
    pub address: String,
    /// Which way.
    pub direction: Direction,
    /// What.
    pub bytes: Vec<u8>,
}

impl fmt::Display for Passage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = match self.direction {
            Direction::Opened => '=',
            Direction::ToDevice => '>',
            Direction::FromDevice => '<',
        };
        write!(
            f,
            "{:.6} {} {sign} {}",
            self.at.as_secs_f64(),
            self.address,
            self.bytes.escape_ascii()
        )
    }
}

/// Why a text is no trace.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct TraceError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub reason: String,
}

/// A recorded session. As [`Links`] it plays every link once: what the program writes must be, byte for byte, what was
/// written when it was recorded, and what the device said follows in its place. Pauses are not replayed.
#[derive(Debug, Clone)]
pub struct Trace {
    passages: Vec<Passage>,
    taken: Arc<Mutex<HashMap<String, usize>>>,
}

impl Trace {
    /// The passages in order.
    pub fn passages(&self) -> &[Passage] {
        &self.passages
    }
}

impl FromStr for Trace {
    type Err = TraceError;

    fn from_str(text: &str) -> Result<Self, TraceError> {
        let mut passages = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let wrong = |reason: &str| TraceError {
                line: index + 1,
                reason: reason.to_owned(),
            };
            if index == 0 {
                if !line.starts_with("# isolux-trace/1") {
                    return Err(wrong("not an isolux-trace/1"));
                }
                continue;
            }
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let mut fields = line.splitn(4, ' ');
            let seconds = fields
                .next()
                .and_then(|field| field.parse().ok())
                .ok_or_else(|| wrong("no time"))?;
            let at = Duration::try_from_secs_f64(seconds).map_err(|_| wrong("no time"))?;
            let address = fields.next().ok_or_else(|| wrong("no link"))?.to_owned();
            let direction = match fields.next() {
                Some("=") => Direction::Opened,
                Some(">") => Direction::ToDevice,
                Some("<") => Direction::FromDevice,
                _ => return Err(wrong("direction is none of = > <")),
            };
            let bytes = unescape(fields.next().unwrap_or("")).ok_or_else(|| wrong("bytes are not escaped ASCII"))?;
            passages.push(Passage {
                at,
                address,
                direction,
                bytes,
            });
        }
        Ok(Self {
            passages,
            taken: Arc::default(),
        })
    }
}

/// Undoes [`slice::escape_ascii`].
fn unescape(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        rest = after;
        if *first != b'\\' {
            bytes.push(*first);
            continue;
        }
        let (code, after) = rest.split_first()?;
        rest = after;
        bytes.push(match code {
            b't' => b'\t',
            b'r' => b'\r',
            b'n' => b'\n',
            b'\'' | b'"' | b'\\' => *code,
            b'x' => {
                let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
                rest = &rest[2..];
                u8::from_str_radix(digits, 16).ok()?
            }
            _ => return None,
        });
    }
    Some(bytes)
}

#[async_trait]
impl Links for Trace {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let failed = |reason: String| LinkError {
            address: address.to_owned(),
            reason,
            advice: None,
        };
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let nth = taken.entry(address.to_owned()).or_insert(0);
        let mut sessions: Vec<VecDeque<Passage>> = Vec::new();
        for passage in self.passages.iter().filter(|passage| passage.address == address) {
            match (passage.direction, sessions.last_mut()) {
                (Direction::Opened, _) => sessions.push(VecDeque::from([passage.clone()])),
                (_, Some(session)) => session.push_back(passage.clone()),
                (_, None) => return Err(failed("bytes before the link was opened".to_owned())),
            }
        }
        let count = sessions.len();
        let mut session = sessions
            .into_iter()
            .nth(*nth)
            .ok_or_else(|| failed(format!("the trace opens it {count} times, this is one more")))?;
        *nth += 1;
        let recorded = session.pop_front().map(|opened| opened.bytes).unwrap_or_default();
        if recorded != line.to_string().as_bytes() {
            return Err(failed(format!(
                "opened with {line}, recorded with {}",
                recorded.escape_ascii()
            )));
        }
        Ok(Box::new(Replayed { session, reader: None }))
    }
}

struct Replayed {
    session: VecDeque<Passage>,
    reader: Option<Waker>,
}

impl AsyncRead for Replayed {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        match self.session.front_mut() {
            Some(next) if next.direction == Direction::FromDevice => {
                let count = buf.remaining().min(next.bytes.len());
                buf.put_slice(&next.bytes[..count]);
                next.bytes.drain(..count);
                if next.bytes.is_empty() {
                    self.session.pop_front();
                }
                Poll::Ready(Ok(()))
            }
            _ => {
                self.reader = Some(cx.waker().clone());
                Poll::Pending
            }
        }
    }
}

impl AsyncWrite for Replayed {
    fn poll_write(mut self: Pin<&mut Self>, _: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        let mut rest = buf;
        while !rest.is_empty() {
            let differs = |recorded: &str| {
                let stated = format!("the program says \"{}\", the trace has {recorded}", rest.escape_ascii());
                io::Error::new(io::ErrorKind::InvalidData, stated)
            };
            match self.session.front_mut() {
                Some(next) if next.direction == Direction::ToDevice => {
                    let count = rest.len().min(next.bytes.len());
                    if rest[..count] != next.bytes[..count] {
                        let error = differs(&format!("\"{}\"", next.bytes.escape_ascii()));
                        return Poll::Ready(Err(error));
                    }
                    rest = &rest[count..];
                    next.bytes.drain(..count);
                    if next.bytes.is_empty() {
                        self.session.pop_front();
                    }
                }
                Some(_) => return Poll::Ready(Err(differs("the device speaking"))),
                None => return Poll::Ready(Err(differs("ended"))),
            }
        }
        if let Some(waker) = self.reader.take() {
            waker.wake();
        }
        Poll::Ready(Ok(buf.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MemoryLinks, Parity, Recorder};
    use proptest::prelude::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    const LINE: LineSettings = LineSettings {
        baud: 9600,
        data_bits: 7,
        parity: Parity::Even,
        stop_bits: 1,
    };

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Shared {
        fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
            io::Write::write(&mut *self.0.lock().unwrap(), buf)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[tokio::test(start_paused = true)]
    async fn what_was_recorded_plays_back_and_nothing_else() {
        let memory = MemoryLinks::default();
        let mut listener = memory.listen("meter").unwrap();
        tokio::spawn(async move {
            let mut twin = listener.accept().await.unwrap();
            let mut ask = [0; 4];
            while twin.read_exact(&mut ask).await.is_ok() {
                tokio::time::sleep(Duration::from_millis(20)).await;
                twin.write_all(b"\x02say\r\n").await.unwrap();
            }
        });
        let written = Shared::default();
        let recorder = Recorder::new(memory, Box::new(written.clone())).unwrap();
        let mut answer = [0; 6];
        let mut link = recorder.open("memory:meter", LINE).await.unwrap();
        link.write_all(b"ask\n").await.unwrap();
        link.read_exact(&mut answer).await.unwrap();
        assert_eq!(recorder.failure(), None);
        let text = String::from_utf8(written.0.lock().unwrap().clone()).unwrap();
        assert!(
            text.contains("0.000000 memory:meter > ask\\n\n0.020000 memory:meter < \\x02say\\r\\n\n"),
            "{text}"
        );

        let trace: Trace = text.parse().unwrap();
        let mut link = trace.open("memory:meter", LINE).await.unwrap();
        link.write_all(b"ask\n").await.unwrap();
        link.read_exact(&mut answer).await.unwrap();
        assert_eq!(&answer, b"\x02say\r\n");
        assert!(link.write_all(b"more").await.unwrap_err().to_string().contains("ended"));

        let again: Trace = text.parse().unwrap();
        let mut link = again.open("memory:meter", LINE).await.unwrap();
        assert!(
            link.write_all(b"xsk\n")
                .await
                .unwrap_err()
                .to_string()
                .contains("the trace has")
        );
        let other = LineSettings {
            parity: Parity::None,
            ..LINE
        };
        let third: Trace = text.parse().unwrap();
        assert!(
            third
                .open("memory:meter", other)
                .await
                .err()
                .unwrap()
                .reason
                .contains("7E1")
        );
    }

    proptest! {
        #[test]
        fn bytes_survive_the_text(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
            let passage = Passage { at: Duration::from_micros(17), address: "a".into(), direction: Direction::ToDevice, bytes };
            let trace: Trace = format!("{HEADER}\n{passage}\n").parse().unwrap();
            prop_assert_eq!(trace.passages(), &[passage]);
        }

        #[test]
        fn noise_is_no_trace_and_no_panic(text in "\\PC{0,80}") {
            let _ = format!("{HEADER}\n{text}").parse::<Trace>();
        }
    }
}
