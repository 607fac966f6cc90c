//! Writes one case: `cargo run -p isolux-hidden-effects --example write_case -- FOLDER SEED gonio|sensor NAME SIGMA
//! [NAME SIGMA …]`.
//!
//! With `--common` the plan is a common one: one distance, one way, no darks; with `--correlated` the noise is. With
//! `--truth` the held-out truth is written too, as `truth.csv` (value, standard deviation).

use std::fmt::Write as _;

use isolux_hidden_effects::case::{self, Order};
use isolux_hidden_effects::plan::Plan;

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let common = std::env::args().any(|word| word == "--common");
    let with_truth = std::env::args().any(|word| word == "--truth");
    let [folder, seed, kind, hidden @ ..] = words.as_slice() else {
        panic!("FOLDER SEED gonio|sensor NAME SIGMA …");
    };
    let hidden = hidden
        .chunks(2)
        .map(|pair| {
            let name: &'static str = Box::leak(pair[0].clone().into_boxed_str());
            (name, pair[1].parse().expect("σ is a number"))
        })
        .collect();
    let order = Order {
        sensor: kind == "sensor",
        plan: if common { Plan::Common } else { Plan::Designed },
        hidden,
        rho: if std::env::args().any(|word| word == "--correlated") {
            0.5
        } else {
            0.0
        },
        outliers: 0.0,
        seed: seed.parse().expect("the seed is a number"),
    };
    let case = case::make(&order).expect("the effect cannot be that strong");
    case.write(std::path::Path::new(folder))
        .expect("the folder can be written");
    if with_truth {
        let truth = case
            .truth
            .iter()
            .fold("value,sigma\n".to_owned(), |mut text, (value, sigma)| {
                let _ = writeln!(text, "{value},{sigma}");
                text
            });
        std::fs::write(std::path::Path::new(folder).join("truth.csv"), truth).expect("the folder can be written");
    }
}
