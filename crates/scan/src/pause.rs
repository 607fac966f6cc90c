//! Asking a scan to pause and to go on: from a page, from the terminal, from a test.

use tokio::sync::watch;

/// A handle that can be cloned and asked from anywhere to hold what runs under it, and to let it go on.
///
/// A scan pauses where nothing is half done: before the next visit, and in a warm-up after the look that is being
/// taken.
#[derive(Debug, Clone)]
pub struct Pause(watch::Sender<Wish>);

/// What was asked last, and by whom.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Wish {
    paused: bool,
    by: String,
}

impl Pause {
    /// A handle that nobody has used yet.
    pub fn new() -> Self {
        Self(watch::Sender::new(Wish {
            paused: false,
            by: String::new(),
        }))
    }

    /// Asks for a pause. Whether that was new.
    pub fn ask(&self, by: &str) -> bool {
        self.set(true, by)
    }

    /// Asks to go on. Whether a pause had been asked for.
    pub fn end(&self, by: &str) -> bool {
        self.set(false, by)
    }

    /// Asks for a pause, or to go on where one is asked for already; whether a pause is asked for now.
    pub fn toggle(&self, by: &str) -> bool {
        let mut paused = false;
        self.0.send_modify(|wish| {
            paused = !wish.paused;
            *wish = Wish {
                paused,
                by: by.to_owned(),
            };
        });
        paused
    }

    fn set(&self, paused: bool, by: &str) -> bool {
        self.0.send_if_modified(|wish| {
            let new = wish.paused != paused;
            if new {
                *wish = Wish {
                    paused,
                    by: by.to_owned(),
                };
            }
            new
        })
    }

    /// Who asked for a pause, while one is asked for.
    pub fn requested(&self) -> Option<String> {
        let wish = self.0.borrow();
        wish.paused.then(|| wish.by.clone())
    }

    /// Waits until a pause is asked for; by whom.
    pub async fn wait_asked(&self) -> String {
        self.wait(true).await
    }

    /// Waits until no pause is asked for; who ended it.
    pub async fn wait_ended(&self) -> String {
        self.wait(false).await
    }

    async fn wait(&self, paused: bool) -> String {
        let mut receiver = self.0.subscribe();
        let reached = receiver.wait_for(|wish| wish.paused == paused).await;
        match reached {
            Ok(wish) => wish.by.clone(),
            // The sender lives as long as this handle does.
            Err(_) => std::future::pending().await,
        }
    }
}

impl Default for Pause {
    fn default() -> Self {
        Self::new()
    }
}
