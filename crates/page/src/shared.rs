//! What every route needs.

use std::sync::Arc;

use crate::desk::Desk;
use crate::guard::Guard;

/// What every route needs.
pub struct Shared {
    /// Who may ask.
    pub guard: Guard,
    /// Who does what is asked.
    pub desk: Arc<Desk>,
    /// Says the next address on the terminal after one was used.
    pub say: Box<dyn Fn(&str) + Send + Sync>,
}
