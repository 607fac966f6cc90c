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
    listeners: Arc<Mutex<HashMap<String, mpsc::UnboundedSender<DuplexStream>>>>,
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
        let mut listeners = self.listeners.lock().unwrap_or_else(PoisonError::into_inner);
        if listeners.get(name).is_some_and(|sender| !sender.is_closed()) {
            return Err(NameTaken { name: name.to_owned() });
        }
        let (sender, incoming) = mpsc::unbounded_channel();
        listeners.insert(name.to_owned(), sender);
        Ok(MemoryListener { incoming })
    }

    fn connect(&self, name: &str) -> Option<DuplexStream> {
        let listeners = self.listeners.lock().unwrap_or_else(PoisonError::into_inner);
        let (host, twin) = tokio::io::duplex(CAPACITY);
        listeners.get(name)?.send(twin).ok()?;
        Some(host)
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
    async fn open(&self, address: &str, _: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let failed = |reason: &str| LinkError {
            address: address.to_owned(),
            reason: reason.to_owned(),
            advice: None,
        };
        let name = address
            .strip_prefix("memory:")
            .ok_or_else(|| failed("not a memory: address"))?;
        let stream = self.connect(name).ok_or_else(|| {
            let advice =
                "memory: links lead to the twins of the virtual darkroom, in the process that runs it".to_owned();
            LinkError {
                advice: Some(advice),
                ..failed("nobody listens there")
            }
        })?;
        Ok(Box::new(stream))
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
        assert!(links.listen("axes").is_ok(), "a dropped listener frees its name");
    }
}
