//! Fifty CIE illuminants against two libraries that we did not write (colour-science 0.4.7, luxpy 1.12.5): every
//! quantity must lie within the libraries' own disagreement plus a small tolerance.

#![expect(clippy::print_stdout, reason = "says how far the worst quantity is")]

use isolux_spectrum::{Spectrum, fidelity::fidelity, quantities};
use serde_json::Value;

fn illuminants() -> Vec<(String, Spectrum, Value)> {
    let document: Value = serde_json::from_str(include_str!("data/cie-illuminants.json")).unwrap();
    document["illuminants"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, entry)| {
            let value: Vec<f64> = serde_json::from_value(entry["value"].clone()).unwrap();
            let (start, step) = (entry["start_nm"].as_f64().unwrap(), entry["step_nm"].as_f64().unwrap());
            let nm = (0..value.len()).map(|i| start + step * i as f64).collect();
            (name.clone(), Spectrum::new(nm, value).unwrap(), entry.clone())
        })
        .collect()
}

/// Distance beyond the interval that the two libraries span.
fn beyond(ours: f64, a: f64, b: f64) -> f64 {
    (a.min(b) - ours).max(ours - a.max(b)).max(0.0)
}

#[test]
fn every_quantity_agrees_with_the_libraries() {
    let all = illuminants();
    assert_eq!(all.len(), 50);
    let mut wrong = Vec::new();
    let mut worst: std::collections::BTreeMap<&str, (f64, String)> = std::collections::BTreeMap::new();
    for (name, spectrum, entry) in &all {
        let q = quantities(spectrum);
        let checks = [
            ("x", q.x, 1e-5),
            ("y", q.y, 1e-5),
            ("u_prime", q.u_prime, 1e-5),
            ("v_prime", q.v_prime, 1e-5),
            ("CCT", q.cct_k, 2.0),
            ("Duv", q.duv, 2e-5),
            ("Ra", q.ra, 0.1),
            ("Rf", q.rf, 0.02),
            ("Rg", q.rg, 0.02),
            ("LER", q.ler_lm_per_w, 0.5),
        ];
        for (key, ours, tolerance) in checks {
            let [a, b] = ["colour", "luxpy"].map(|l| entry[l][key].as_f64().unwrap());
            let d = ours.map_or(f64::INFINITY, |v| beyond(v, a, b));
            let w = worst.entry(key).or_insert((0.0, String::new()));
            if d >= w.0 {
                *w = (d, name.clone());
            }
            if d > tolerance {
                wrong.push(format!("{name} {key}: ours {ours:?}, colour {a}, luxpy {b}"));
            }
        }
        let special: Vec<[f64; 2]> = ["colour", "luxpy"]
            .map(|l| serde_json::from_value::<Vec<f64>>(entry[l]["R"].clone()).unwrap())
            .into_iter()
            .reduce(|_, b| b)
            .map(|b| {
                let a: Vec<f64> = serde_json::from_value(entry["colour"]["R"].clone()).unwrap();
                a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
            })
            .unwrap();
        for (i, [a, b]) in special.into_iter().enumerate() {
            let d = beyond(q.r.unwrap()[i], a, b);
            if d > 0.3 {
                wrong.push(format!("{name} R{}: {} vs {a} {b}", i + 1, q.r.unwrap()[i]));
            }
        }
        let f = fidelity(spectrum).unwrap();
        for (key, tolerance, ours) in [
            ("Rf_hue", 0.05, f.bins.map(|b| b.rf)),
            ("Rcs_hue", 0.05, f.bins.map(|b| b.chroma_shift_percent)),
        ] {
            let theirs: Vec<f64> = serde_json::from_value(entry["colour"][key].clone()).unwrap();
            for (bin, (a, b)) in ours.iter().zip(&theirs).enumerate() {
                if (a - b).abs() > tolerance {
                    wrong.push(format!("{name} {key} bin {}: {a} vs {b}", bin + 1));
                }
            }
        }
    }
    for (key, (d, name)) in worst {
        println!("{key}: at most {d:.2e} beyond the libraries ({name})");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
