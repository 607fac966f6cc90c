//! Uncertainty over wavelength, cause by cause, each with what neighbours share of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One cause of uncertainty of a factor over wavelength: relative standard uncertainties (k = 1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// The cause.
    pub name: String,
    /// Each is fully correlated over wavelength and independent of the others: their products summed are the covariance
    /// of the cause.
    pub correlated_rel: Vec<Vec<f64>>,
    /// What is independent from wavelength to wavelength; empty: nothing.
    pub independent_rel: Vec<f64>,
}

impl Component {
    /// A cause that all wavelengths share as `rel` says.
    pub(super) fn shared(name: &str, rel: Vec<f64>) -> Self {
        Self {
            name: name.to_owned(),
            correlated_rel: vec![rel],
            independent_rel: Vec::new(),
        }
    }

    /// A cause that is independent from wavelength to wavelength.
    pub(super) fn independent(name: &str, rel: Vec<f64>) -> Self {
        Self {
            name: name.to_owned(),
            correlated_rel: Vec::new(),
            independent_rel: rel,
        }
    }

    /// Its relative standard uncertainty at a wavelength.
    pub fn u_rel(&self, place: usize) -> f64 {
        self.covariance_rel(place, place).sqrt()
    }

    /// Its relative covariance between two wavelengths.
    pub fn covariance_rel(&self, one: usize, other: usize) -> f64 {
        let shared: f64 = self.correlated_rel.iter().map(|rel| rel[one] * rel[other]).sum();
        let own = match self.independent_rel.get(one) {
            Some(u) if one == other => u * u,
            _ => 0.0,
        };
        shared + own
    }
}

/// An uncertainty of which it is not known what wavelengths share: a third each of it goes to a common factor, and to
/// the two phases of a wave over the whole range. At every wavelength they give the uncertainty itself (after the
/// method of base functions, Kärhä et al., Metrologia 54, 2017).
pub(super) fn unknown_correlation(wavelength_nm: &[f64], u_rel: &[f64]) -> Vec<Vec<f64>> {
    let (first, last) = match wavelength_nm {
        [first, .., last] => (*first, *last),
        _ => return vec![u_rel.to_vec()],
    };
    let turn = |nm: f64| std::f64::consts::TAU * (nm - first) / (last - first);
    let shares: [&dyn Fn(f64) -> f64; 3] = [
        &|_| (1.0f64 / 3.0).sqrt(),
        &|nm| (2.0f64 / 3.0).sqrt() * turn(nm).sin(),
        &|nm| (2.0f64 / 3.0).sqrt() * turn(nm).cos(),
    ];
    let of = |share: &&dyn Fn(f64) -> f64| wavelength_nm.iter().zip(u_rel).map(|(nm, u)| share(*nm) * u).collect();
    shares.iter().map(of).collect()
}
