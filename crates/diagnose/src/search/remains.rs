//! Whether what a fit leaves is noise, and which names a place without one explains better.

use crate::basis::Basis;
use crate::fit::{Fit, derivatives};
use crate::forward::Hypothesis;
use crate::known::Moved;
use crate::noise::{self, NoiseTest, Residuals};
use crate::read_out::ReadOut;
use crate::whitener::Whitener;

use super::candidates::all_but;
use super::estimate::Estimate;

impl Estimate<'_, '_> {
    /// Whether what a fit leaves is noise; none where there is too little of it.
    pub(super) fn noise_test(&self, fitted: &Fit) -> Option<NoiseTest> {
        noise::test(
            &self.residuals(fitted)?,
            self.problem.settings.nulls,
            self.problem.settings.seed,
        )
    }

    /// The members that no single place without a name (a period, a patch, …) explains better. What such a place is,
    /// the test of the noise says of what is left without them.
    pub(super) fn no_places(&self, mut members: Vec<Hypothesis>, fitted: &Fit) -> Option<(Vec<Hypothesis>, Fit)> {
        let mut current = fitted.clone();
        let mut i = 0;
        while i < members.len() {
            let without = self.fit(&all_but(&members, i))?;
            let own = (without.chi2 - current.chi2) / self.noise.scale.powi(2);
            let place = noise::strongest_place(&self.residuals(&without)?);
            let more = own + self.alias_margin(own) + noise::limits::PLACES;
            if place.is_some_and(|place| place.explained > more) {
                members.remove(i);
                current = without;
            } else {
                i += 1;
            }
        }
        Some((members, current))
    }

    fn residuals(&self, fitted: &Fit) -> Option<Residuals<'_>> {
        let rho = noise::noisy_rho(self.noise.rho);
        let row_scale = self.problem.u.map(|u| 1.0 / u);
        let whitener = Whitener::new(
            self.problem.sequence,
            &self.rounding,
            row_scale.clone(),
            rho,
            &self.problem.errors,
        );
        let residuals = &self.problem.measured - &fitted.prediction;
        let raw = &residuals - Moved::of(&self.problem.known, &whitener, &residuals).change;
        let forward = ReadOut {
            forward: self.problem.forward,
            change: &fitted.change,
        };
        let refitted = Basis::spanning(&derivatives(&forward, &whitener, fitted)?, 1e-9);
        let mut whitened = whitener.vector(&residuals);
        refitted.project_out_vector(&mut whitened);
        Some(Residuals {
            rows: self.problem.rows,
            level: fitted.prediction.as_slice().to_vec(),
            plain: raw.component_mul(&row_scale),
            whitened,
            refitted,
            sequence: self.problem.sequence,
            rho,
            rho_found: self.noise.rho,
            u_rho: self.noise.u_rho,
            scale: self.noise.observed,
            freedom: self.freedom,
            unit: self.noise.scale,
        })
    }
}
