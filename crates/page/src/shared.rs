//! What every route needs.

use std::sync::Arc;

use isolux_app::study::what_if::WhatIf;

use crate::controller::Controller;
use crate::guard::Guard;

/// What every route needs.
pub struct Shared {
    /// Who may ask.
    pub guard: Guard,
    /// Who does what is asked.
    pub controller: Arc<Controller>,
    /// Sensors in other poses.
    pub what_if: WhatIf,
    /// Says the next address on the terminal after one was used.
    pub say: Box<dyn Fn(&str) + Send + Sync>,
}
