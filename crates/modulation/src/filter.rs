//! Filters of second order in a row, from their transfer function in s.
//!
//! A filter of fourth order with corners far below the sample rate loses its digits as one recursion; second orders
//! keep them.

/// One second order: b₀ + b₁ z⁻¹ + b₂ z⁻² over 1 + a₁ z⁻¹ + a₂ z⁻².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Section {
    b: [f64; 3],
    a: [f64; 2],
    state: [f64; 2],
}

impl Section {
    /// Of (n₂ s² + n₁ s + n₀)/(d₂ s² + d₁ s + d₀), highest power first, by the bilinear transform at `rate_hz`.
    pub(crate) fn bilinear(numerator: [f64; 3], denominator: [f64; 3], rate_hz: f64) -> Self {
        // s = c (1 − z⁻¹)/(1 + z⁻¹).
        let c = 2.0 * rate_hz;
        let of = |[p2, p1, p0]: [f64; 3]| {
            [
                p2 * c * c + p1 * c + p0,
                2.0 * (p0 - p2 * c * c),
                p2 * c * c - p1 * c + p0,
            ]
        };
        let (n, d) = (of(numerator), of(denominator));
        Self {
            b: n.map(|value| value / d[0]),
            a: [d[1] / d[0], d[2] / d[0]],
            state: [0.0, 0.0],
        }
    }

    /// The next sample (transposed direct form II).
    pub(crate) fn next(&mut self, x: f64) -> f64 {
        let y = self.b[0] * x + self.state[0];
        self.state[0] = self.b[1] * x - self.a[0] * y + self.state[1];
        self.state[1] = self.b[2] * x - self.a[1] * y;
        y
    }
}

/// First order: s/(s + ω) or ω/(s + ω).
pub(crate) fn high_pass(corner_hz: f64, rate_hz: f64) -> Section {
    let omega = std::f64::consts::TAU * corner_hz;
    Section::bilinear([0.0, 1.0, 0.0], [0.0, 1.0, omega], rate_hz)
}

/// First order of a time constant in s.
pub(crate) fn smoothing(time_constant_s: f64, rate_hz: f64) -> Section {
    Section::bilinear([0.0, 0.0, 1.0], [0.0, time_constant_s, 1.0], rate_hz)
}

/// Butterworth low-pass of even `order`, −3 dB at `corner_hz`.
pub(crate) fn butterworth(order: usize, corner_hz: f64, rate_hz: f64) -> Vec<Section> {
    let omega = std::f64::consts::TAU * corner_hz;
    (0..order / 2)
        .map(|k| {
            let angle = std::f64::consts::PI * (2 * k + 1) as f64 / (2 * order) as f64;
            let denominator = [1.0, 2.0 * omega * angle.sin(), omega * omega];
            Section::bilinear([0.0, 0.0, omega * omega], denominator, rate_hz)
        })
        .collect()
}
