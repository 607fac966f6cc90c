//! A function of an angle whose cosine is known.

/// Values at even steps of sin(γ/2): a root finds the place where an arc cosine would.
#[derive(Debug, Clone)]
pub(crate) struct AngleTable(Vec<f64>);

impl AngleTable {
    /// `at` of γ in degrees, from 0° to 180° in `steps` steps.
    pub fn of(steps: usize, at: impl Fn(f64) -> f64) -> Self {
        let gamma_deg = |step: usize| 2.0 * (step as f64 / steps as f64).asin().to_degrees();
        Self((0..=steps).map(|step| at(gamma_deg(step))).collect())
    }

    /// The value at the angle of this cosine.
    pub fn at_cosine(&self, cosine: f64) -> f64 {
        linear(
            &self.0,
            (0.5 - 0.5 * cosine).clamp(0.0, 1.0).sqrt() * (self.0.len() - 1) as f64,
        )
    }

    /// The value at 0°.
    pub fn first(&self) -> f64 {
        self.0[0]
    }
}

/// Linear between the entries of a table, `place` in steps.
pub(crate) fn linear(table: &[f64], place: f64) -> f64 {
    let cell = (place as usize).min(table.len() - 2);
    table[cell] + (place - cell as f64) * (table[cell + 1] - table[cell])
}
