//! Every byte of a session, written down as it passes.

use std::io::Write;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, ready};

use async_trait::async_trait;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::Instant;

use crate::replay::{Direction, Passage};
use crate::{LineSettings, Link, LinkError, Links, UsbProfile};

/// Opens links through another [`Links`] and writes what passes to a trace: one line a passage, see
/// [`Trace`](crate::Trace).
pub struct Recorder<L> {
    inner: L,
    sink: Arc<Mutex<Sink>>,
}

struct Sink {
    writer: Box<dyn Write + Send>,
    began: Instant,
    failed: Option<String>,
}

impl Sink {
    fn note(&mut self, address: &str, direction: Direction, bytes: &[u8]) {
        let at = self.began.elapsed();
        let line = Passage {
            at,
            address: address.to_owned(),
            direction,
            bytes: bytes.to_vec(),
        };
        // The measurement goes on when the disk is full, but the trace must not pass for whole.
        if let Err(error) = writeln!(self.writer, "{line}").and_then(|()| self.writer.flush()) {
            self.failed.get_or_insert(error.to_string());
        }
    }
}

impl<L> Recorder<L> {
    /// Records everything that is opened through `inner` to `writer`.
    ///
    /// # Errors
    /// When the first line cannot be written.
    pub fn new(inner: L, mut writer: Box<dyn Write + Send>) -> std::io::Result<Self> {
        writeln!(writer, "{}", crate::replay::HEADER)?;
        let sink = Sink {
            writer,
            began: Instant::now(),
            failed: None,
        };
        Ok(Self {
            inner,
            sink: Arc::new(Mutex::new(sink)),
        })
    }

    /// Why the trace is not whole, if it is not.
    pub fn failure(&self) -> Option<String> {
        self.sink.lock().unwrap_or_else(PoisonError::into_inner).failed.clone()
    }

    fn recorded(&self, link: Box<dyn Link>, address: &str, line: LineSettings) -> Box<dyn Link> {
        let sink = Arc::clone(&self.sink);
        sink.lock().unwrap_or_else(PoisonError::into_inner).note(
            address,
            Direction::Opened,
            line.to_string().as_bytes(),
        );
        Box::new(Recorded {
            link,
            address: address.to_owned(),
            sink,
        })
    }
}

#[async_trait]
impl<L: Links> Links for Recorder<L> {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let link = self.inner.open(address, line).await?;
        Ok(self.recorded(link, address, line))
    }

    async fn open_usb(
        &self,
        address: &str,
        line: LineSettings,
        profile: &'static UsbProfile,
    ) -> Result<Box<dyn Link>, LinkError> {
        let link = self.inner.open_usb(address, line, profile).await?;
        Ok(self.recorded(link, address, line))
    }
}

struct Recorded {
    link: Box<dyn Link>,
    address: String,
    sink: Arc<Mutex<Sink>>,
}

impl Recorded {
    fn note(&self, direction: Direction, bytes: &[u8]) {
        self.sink
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .note(&self.address, direction, bytes);
    }
}

impl AsyncRead for Recorded {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<std::io::Result<()>> {
        let before = buf.filled().len();
        ready!(Pin::new(&mut self.link).poll_read(cx, buf))?;
        self.note(Direction::FromDevice, &buf.filled()[before..]);
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Recorded {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<std::io::Result<usize>> {
        let written = ready!(Pin::new(&mut self.link).poll_write(cx, buf))?;
        self.note(Direction::ToDevice, &buf[..written]);
        Poll::Ready(Ok(written))
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        Pin::new(&mut self.link).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        Pin::new(&mut self.link).poll_shutdown(cx)
    }
}
