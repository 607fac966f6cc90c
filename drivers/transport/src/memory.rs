//! Pipes inside the process, for twins and tests.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use async_trait::async_trait;
use tokio::io::DuplexStream;
use tokio::sync::mpsc;

use crate::{LineSettings, Link, LinkError, Links};

/// The pipes of this process, by name. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct MemoryLinks {
    listeners: Arc<Mutex<HashMap<String, Listening>>>,
}

#[derive(Debug)]
struct Listening {
    streams: mpsc::UnboundedSender<DuplexStream>,
    line: Option<LineSettings>,
}

/// The twin's end: hands out one stream each time somebody opens the name, as a TCP listener does.
#[derive(Debug)]
pub struct MemoryListener {
    incoming: mpsc::UnboundedReceiver<DuplexStream>,
}

/// Somebody listens under that name already.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("memory:{name} is taken")]
pub struct NameTaken {
    /// The name.
    pub name: String,
}

/// Bytes a pipe holds before the writer waits: more than one spectrum.
const CAPACITY: usize = 16 * 1024;

impl MemoryLinks {
    /// Listens under `name`: `memory:name` reaches the listener until it is dropped.
    ///
    /// # Errors
    /// [`NameTaken`] while another listener lives.
    pub fn listen(&self, name: &str) -> Result<MemoryListener, NameTaken> {
        self.listen_as(name, None)
    }

    /// The same for an instrument whose line is set so: opened with other settings it would understand nothing, and is
    /// refused.
    ///
    /// # Errors
    /// [`NameTaken`].
    pub fn listen_at(&self, name: &str, line: LineSettings) -> Result<MemoryListener, NameTaken> {
        self.listen_as(name, Some(line))
    }

    fn listen_as(&self, name: &str, line: Option<LineSettings>) -> Result<MemoryListener, NameTaken> {
        let mut listeners = self.listeners.lock().unwrap_or_else(PoisonError::into_inner);
        if listeners.get(name).is_some_and(|known| !known.streams.is_closed()) {
            return Err(NameTaken { name: name.to_owned() });
        }
        let (streams, incoming) = mpsc::unbounded_channel();
        listeners.insert(name.to_owned(), Listening { streams, line });
        Ok(MemoryListener { incoming })
    }
}

impl MemoryListener {
    /// The next stream that somebody opens; `None` when no [`MemoryLinks`] is left to open one.
    pub async fn accept(&mut self) -> Option<DuplexStream> {
        self.incoming.recv().await
    }
}

#[async_trait]
impl Links for MemoryLinks {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let failed = |reason: String, advice: Option<&str>| LinkError {
            address: address.to_owned(),
            reason,
            advice: advice.map(str::to_owned),
        };
        let name = address
            .strip_prefix("memory:")
            .ok_or_else(|| failed("not a memory: address".to_owned(), None))?;
        let nobody = || {
            let advice = "memory: links lead to the twins of the virtual darkroom, in the process that runs it";
            failed("nobody listens there".to_owned(), Some(advice))
        };
        let listeners = self.listeners.lock().unwrap_or_else(PoisonError::into_inner);
        let listening = listeners.get(name).ok_or_else(nobody)?;
        if let Some(expected) = listening.line.filter(|expected| *expected != line) {
            let reason = format!("the line was asked for with {line}, and the instrument is set to {expected}");
            return Err(failed(
                reason,
                Some("correct the options of `open`, as baud=, to the instrument's settings"),
            ));
        }
        let (host, twin) = tokio::io::duplex(CAPACITY);
        listening.streams.send(twin).map_err(|_| nobody())?;
        Ok(Box::new(host))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    const LINE: LineSettings = LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: crate::Parity::None,
        stop_bits: 1,
    };

    #[tokio::test]
    async fn every_opening_is_a_fresh_stream() {
        let links = MemoryLinks::default();
        let mut listener = links.listen("axes").unwrap();
        assert_eq!(links.listen("axes").unwrap_err(), NameTaken { name: "axes".into() });
        for word in [b"one", b"two"] {
            let mut host = links.open("memory:axes", LINE).await.unwrap();
            let mut twin = listener.accept().await.unwrap();
            host.write_all(word).await.unwrap();
            let mut read = [0; 3];
            twin.read_exact(&mut read).await.unwrap();
            assert_eq!(&read, word);
        }
        drop(listener);
        assert!(links.open("memory:axes", LINE).await.is_err());
        let _meter = links.listen_at("meter", LINE).unwrap();
        links
            .open("memory:meter", LINE)
            .await
            .map_err(|error| error.to_string())
            .unwrap();
        let even = LineSettings {
            parity: crate::Parity::Even,
            ..LINE
        };
        let reason = links.open("memory:meter", even).await.err().unwrap().reason;
        assert!(reason.contains("9600 8E1") && reason.contains("9600 8N1"), "{reason}");
        assert!(links.listen("axes").is_ok(), "a dropped listener frees its name");
    }
}
