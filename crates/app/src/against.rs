//! Whether two simulations differ more than their noise: an earlier `result.json` against a new one.

use camino::Utf8Path;
use isolux_sim::noise;
use isolux_sim::simulation::{Against, Facts};

use crate::{Failure, files};

/// What an earlier simulation's `result.json` says.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
pub struct Earlier {
    unit: String,
    mean: f64,
    u_mean_numeric: f64,
    sampling: Option<String>,
    seed: Option<u64>,
}

/// Reads `result.json` of `folder`.
///
/// # Errors
/// Exit 2 for a folder without a simulation's result.
pub fn read(folder: &Utf8Path) -> Result<Earlier, Failure> {
    let path = folder.join("result.json");
    serde_json::from_slice(&files::read(&path)?).map_err(|error| {
        Failure::bad_input(format!("{path}: {error}")).help("give the folder of an earlier `isolux simulate`")
    })
}

/// The verdict on the means, each with its own numerical uncertainty (quadrature or counted rays; what the model knows
/// of its measurement is common to both and left out).
///
/// # Errors
/// Exit 2 where one is in lx and the other in W/m².
pub fn compare(facts: &Facts, earlier: &Earlier, folder: &Utf8Path) -> Result<Against, Failure> {
    if earlier.unit != facts.unit {
        return Err(Failure::bad_input(format!(
            "{folder}: its map is in {}, this one in {}: they cannot be compared",
            earlier.unit, facts.unit
        ))
        .help("give both a spectrum or ler_lm_per_w, or neither"));
    }
    let difference = noise::difference(
        (facts.mean, facts.u_mean_numeric),
        (earlier.mean, earlier.u_mean_numeric),
    );
    Ok(Against {
        folder: folder.to_string(),
        mean: earlier.mean,
        difference: facts.mean - earlier.mean,
        u_difference: facts.u_mean_numeric.hypot(earlier.u_mean_numeric),
        sigma: difference.sigma,
        p_value: difference.p_value,
        differs: difference.p_value < noise::SIGNIFICANT,
        same_rays: facts.seed.is_some() && facts.seed == earlier.seed && facts.sampling == earlier.sampling.as_deref(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_result_is_read_from_its_own_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8Path::from_path(folder.path()).unwrap();
        assert_eq!(read(path).unwrap_err().kind, crate::FailureKind::BadInput);
        let text = r#"{"unit": "lx", "mean": 2.0, "u_mean_numeric": 0.1, "sampling": null, "seed": null, "more": 1}"#;
        std::fs::write(path.join("result.json"), text).unwrap();
        let earlier = read(path).unwrap();
        assert_eq!((earlier.mean, earlier.u_mean_numeric), (2.0, 0.1));
    }
}
