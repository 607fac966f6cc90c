//! How far a rule's estimate of its own error is trusted, and what each accuracy asks of it.

use isolux_model::Accuracy;

use crate::rules::Estimate;

/// What a rule's estimate of its own error is worth. Estimates are differences of rules, and two rules can agree by
/// chance; the stated bound is `safety` times the estimate, and `slack` of the value for what an estimate does not see.
/// Both are set by the largest errors of thousands of pixels against far tighter solutions, with a margin (decision
/// 0023).
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    /// Relative error, by its own estimate, that the rule aims at.
    pub aim: f64,
    safety: f64,
    slack: f64,
}

/// The rules under one accuracy.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerances {
    /// Product rules over pixel and emitter.
    pub product: Tolerance,
    /// Lines across a pixel, cut at every bend, for points.
    pub lines: Tolerance,
    /// Outlines of emitters, and an adaptive rule over the pixel.
    pub outlines: Tolerance,
    /// Chords of pixel and emitter, and an adaptive rule across them: where an emitter is small against a coarse pixel,
    /// its kinks can lie between all nodes.
    pub chords: Tolerance,
    /// Relative error of a polynomial over a tile, by its own estimate.
    pub polynomial: f64,
    /// Relative error that no pixel exceeds.
    pub allowed: f64,
}

impl Tolerances {
    pub fn of(accuracy: Accuracy) -> &'static Self {
        match accuracy {
            Accuracy::Standard => &STANDARD,
            Accuracy::Reference => &REFERENCE,
        }
    }
}

const REFERENCE: Tolerances = Tolerances {
    product: Tolerance {
        aim: 0.8e-7,
        safety: 5.0,
        slack: 1e-7,
    },
    lines: Tolerance {
        aim: 9e-8,
        safety: 4.0,
        slack: 2e-7,
    },
    outlines: Tolerance {
        aim: 6.5e-8,
        safety: 8.0,
        slack: 1e-7,
    },
    chords: Tolerance {
        aim: 2.2e-7,
        safety: 25.0,
        slack: 1e-7,
    },
    polynomial: 2e-7,
    allowed: 1e-6,
};

/// Nodes and polynomial share what is allowed.
const STANDARD: Tolerances = Tolerances {
    product: Tolerance {
        aim: 2e-6,
        safety: 2.0,
        slack: 1e-7,
    },
    lines: Tolerance {
        aim: 1e-6,
        ..REFERENCE.lines
    },
    outlines: Tolerance {
        aim: 5e-7,
        ..REFERENCE.outlines
    },
    chords: Tolerance {
        aim: 3e-7,
        ..REFERENCE.chords
    },
    polynomial: 2e-6,
    allowed: 1e-5,
};

/// What the rules inside a rule may miss of the value, however little is aimed at.
const INNER: f64 = 2e-9;

impl Tolerance {
    /// The estimate as a bound, where `scale` times the aim was asked for: no error is smaller than `unseen` (lx),
    /// light that no node may have met.
    pub fn stated(self, found: Estimate, scale: f64, unseen: f64) -> Estimate {
        let slack = (self.slack * scale).max(INNER);
        Estimate {
            value: found.value,
            error: self.safety * found.error + slack * found.value.abs() + unseen,
        }
    }
}

/// Share of the brightest light that could reach a pixel below which a pixel's error is no longer relative to itself.
pub(super) const DARK: f64 = 1e-7;
/// Share of the same that adaptive rules may not meet at all: a sliver in a corner of a dark pixel.
pub(super) const UNSEEN: f64 = 1e-10;
