//! One direction of a generic pattern: its law is kept, its values are computed where they are asked for.
//!
//! Thousands of patterns of 10⁵ readings are gigabytes; their laws are nothing.

use std::fmt;
use std::sync::Arc;

use crate::table::{Light, ObservationKind, Row};

/// Whether a pattern multiplies the expected signal or adds to it, and on which records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Acts {
    /// × expected signal.
    Relative,
    /// + on every record that sees the room (not capped).
    Light,
    /// + on every record.
    Everywhere,
}

/// A function of a row and its number.
type Law = dyn Fn(usize, &Row) -> f64 + Send + Sync;

/// The change of every row for a unit amplitude.
#[derive(Clone)]
pub struct Pattern {
    source: ObservationKind,
    acts: Acts,
    level: Arc<[f64]>,
    law: Arc<Law>,
}

impl Pattern {
    /// `law` of the rows of `source`, where `level` is the model's expectation of every row.
    pub(crate) fn new(
        source: ObservationKind,
        acts: Acts,
        level: &Arc<[f64]>,
        law: impl Fn(usize, &Row) -> f64 + Send + Sync + 'static,
    ) -> Self {
        Self {
            source,
            acts,
            level: Arc::clone(level),
            law: Arc::new(law),
        }
    }

    /// Its value at row number `i`; 0 on other sources and where the law is no number.
    fn at(&self, i: usize, row: &Row) -> f64 {
        if row.source != self.source {
            return 0.0;
        }
        let strength = match self.acts {
            Acts::Relative => self.level[i],
            Acts::Light if row.light == Light::Capped => 0.0,
            Acts::Light | Acts::Everywhere => 1.0,
        };
        let value = strength * (self.law)(i, row);
        if value.is_finite() { value } else { 0.0 }
    }

    /// Its values at all rows.
    pub fn values<'a>(&'a self, rows: &'a [Row]) -> impl Iterator<Item = f64> + 'a {
        rows.iter().enumerate().map(|(i, row)| self.at(i, row))
    }
}

impl fmt::Debug for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pattern")
            .field("source", &self.source)
            .field("acts", &self.acts)
            .finish_non_exhaustive()
    }
}
