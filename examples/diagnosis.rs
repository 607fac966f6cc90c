//! Diagnoses readings: which effect a model lacks, and what that leaves of the gap on readings that no fit has seen.
//!
//!     cargo run --release -p isolux-examples --example diagnosis

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;

use camino::Utf8Path;
use isolux_diagnose::diagnosis::{Diagnosis, diagnose};
use isolux_diagnose::search::Settings;
use isolux_model::Model;
use isolux_record::observation::{Need, open};

/// What the model in `folder` lacks, by its `readings.csv` and `held-out.csv`.
fn diagnosed(folder: &Utf8Path) -> Result<Diagnosis, Box<dyn Error>> {
    let model = Model::load(&folder.join("model.toml"))?;
    let readings = open(&folder.join("readings.csv"), Need::Values)?;
    let held_out = open(&folder.join("held-out.csv"), Need::Values)?;
    // The fingerprint would stand in the evidence of the effects that are added to the model.
    let sha256 = "";
    Ok(diagnose(
        &model,
        &[readings],
        Some(&held_out),
        sha256,
        &Settings::default(),
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let found = diagnosed(Utf8Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/hidden-effect")))?;
    println!("{}", found.document.plain);
    for effect in &found.document.effects {
        for (key, parameter) in &effect.parameters {
            println!(
                "{} {key} = {} ± {} {} (k = 1)",
                effect.name, parameter.value, parameter.u, parameter.unit
            );
        }
    }
    if let Some(gap) = &found.document.gap.held_out {
        println!(
            "held out: {:.3} → {:.3}, noise floor {:.3}",
            gap.before, gap.after, gap.floor
        );
    }
    print!("{}", found.after.to_toml());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hidden_warm_up_is_found_and_closes_the_gap() {
        let found = diagnosed(Utf8Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/hidden-effect"))).unwrap();
        let [effect] = found.document.effects.as_slice() else {
            panic!("{}", found.document.sentence);
        };
        let time = &effect.parameters["time_constant_s"];
        assert_eq!(effect.name, "lamp_warmup");
        assert!((time.value - 360.0).abs() < 3.0 * time.u, "{time:?}");
        let gap = found.document.gap.held_out.as_ref().unwrap();
        assert!(gap.removed > 0.9 && gap.after < gap.before, "{gap:?}");
    }
}
