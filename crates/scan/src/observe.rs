//! Who is told what the engine does, while it works.

use isolux_record::Logged;

/// Receives the events of a scan.
pub trait Observer {
    /// Takes one event. Must not block for long.
    fn event(&self, logged: &Logged);
}

/// Discards every event.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &Logged) {}
}
