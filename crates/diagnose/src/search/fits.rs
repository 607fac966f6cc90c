//! Fits that were made under one estimate of the noise: the stages of a search ask for the same effects again and again.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use crate::fit::Fit;
use crate::forward::Hypothesis;

/// Values that are kept at most: a quarter of a gigabyte.
const KEPT_VALUES: usize = 1 << 25;

/// Fits by the effects from which they began; none where the model refuses them.
#[derive(Default)]
pub(super) struct Fits(Mutex<Kept>);

#[derive(Default)]
struct Kept {
    fits: HashMap<Vec<u64>, Option<Fit>>,
    values: usize,
}

impl Fits {
    /// The fit that began from `members`, made where there is none yet.
    pub(super) fn get_or(&self, members: &[Hypothesis], make: impl FnOnce() -> Option<Fit>) -> Option<Fit> {
        let key = key(members);
        if let Some(known) = self.kept().fits.get(&key) {
            return known.clone();
        }
        let made = make();
        let values = made
            .as_ref()
            .map_or(0, |fit| fit.jacobian.len() + 3 * fit.prediction.len());
        let mut kept = self.kept();
        if kept.values + values <= KEPT_VALUES {
            kept.values += values;
            kept.fits.insert(key, made.clone());
        }
        made
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Every effect with its values to the bit; the number of values ends each list.
fn key(members: &[Hypothesis]) -> Vec<u64> {
    let mut key = Vec::new();
    for member in members {
        key.push(member.effect as u64);
        for values in [&member.linear, &member.shape] {
            key.push(values.len() as u64);
            key.extend(values.iter().map(|value| value.to_bits()));
        }
    }
    key
}
