//! A request to end a solver that is under way.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request that another thread may make; solvers look at it between pieces of a few milliseconds.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks the solvers that hold a clone of this to end; their results are no results.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
