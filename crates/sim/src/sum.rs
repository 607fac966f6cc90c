//! Sums without loss.

/// Neumaier's compensated sum: exact to rounding, whatever the order of magnitude of the terms.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - next) + term
        } else {
            (term - next) + self.sum
        };
        self.sum = next;
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}
