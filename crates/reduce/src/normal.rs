//! Random numbers that depend on their seed alone.

/// Standard normal numbers, the same for the same seed: SplitMix64 and Box–Muller.
pub struct Normal {
    state: u64,
    spare: Option<f64>,
}

impl Normal {
    /// The numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self {
            state: seed ^ 0x5851_F42D_4C95_7F2D,
            spare: None,
        }
    }

    /// Even between 0 and 1, neither of them.
    pub fn unit(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// The next one.
    pub fn next(&mut self) -> f64 {
        self.spare.take().unwrap_or_else(|| {
            let (radius, turn) = ((-2.0 * self.unit().ln()).sqrt(), std::f64::consts::TAU * self.unit());
            self.spare = Some(radius * turn.sin());
            radius * turn.cos()
        })
    }
}
