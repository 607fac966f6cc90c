//! Asking a scan to end: from a signal, from a page, from a test.

use tokio::sync::watch;

/// A handle that can be cloned and asked from anywhere to end what runs under it.
#[derive(Debug, Clone)]
pub struct Cancel(watch::Sender<Option<String>>);

impl Cancel {
    /// A handle that nobody has used yet.
    pub fn new() -> Self {
        Self(watch::Sender::new(None))
    }

    /// Asks for the end. The first reason stands.
    pub fn cancel(&self, reason: &str) {
        self.0.send_if_modified(|state| {
            let first = state.is_none();
            if first {
                *state = Some(reason.to_owned());
            }
            first
        });
    }

    /// Waits until the end is asked for; the reason.
    pub async fn cancelled(&self) -> String {
        let mut receiver = self.0.subscribe();
        loop {
            if let Some(reason) = receiver.borrow_and_update().clone() {
                return reason;
            }
            if receiver.changed().await.is_err() {
                // The sender lives as long as this handle does.
                std::future::pending::<()>().await;
            }
        }
    }

    /// The reason, if the end was asked for.
    pub fn reason(&self) -> Option<String> {
        self.0.borrow().clone()
    }
}

impl Default for Cancel {
    fn default() -> Self {
        Self::new()
    }
}
