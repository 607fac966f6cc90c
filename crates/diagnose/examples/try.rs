//! Prints what the search finds in a case.
#![allow(clippy::print_stdout)]
use isolux_diagnose::{believed::*, forward::Forward, observe::*, search::*};
use isolux_record::observation::{Need, open};
fn main() {
    for arg in std::env::args().skip(1) {
        let dir = camino::Utf8PathBuf::from(&arg);
        let model = isolux_model::Model::load(&dir.join("model.toml")).unwrap();
        let obs = if dir.join("maps.toml").exists() {
            dir.join("maps.toml")
        } else {
            dir.join("readings.csv")
        };
        let obs = open(&obs, Need::Values).unwrap();
        let start = std::time::Instant::now();
        let (seen, _) = observed(&obs, 0);
        let believed = Believed::new(model, vec![seen.part]);
        let out = search(&believed, &seen.rows, &Settings::default()).unwrap();
        let names: Vec<String> = out
            .after
            .hypotheses
            .iter()
            .map(|h| {
                let spec = believed.spec(h.effect);
                let v = believed.values(h);
                format!(
                    "{}({})",
                    spec.name,
                    spec.parameters
                        .iter()
                        .zip(v)
                        .map(|(p, v)| format!("{}={v:.4}", p.key))
                        .collect::<Vec<_>>()
                        .join(",")
                )
            })
            .collect();
        println!(
            "{arg}: p={:.4} s={:.3} rho={:.2} {:?} unexplained={:?} {:.2?}",
            out.p_global,
            out.noise.scale,
            out.noise.rho,
            names,
            out.unexplained.as_ref().map(|u| (
                u.rival.coordinate.name(),
                u.rival.family,
                u.rival.range,
                u.rival.note.clone(),
                u.sigma
            )),
            start.elapsed()
        );
        for r in &out.rivalries {
            let list: Vec<String> = r
                .ranked
                .iter()
                .take(4)
                .map(|x| match x.label {
                    Label::Named(e) => format!("{} {:.3} ({:.1}σ)", believed.effects()[e].name, x.posterior, x.sigma),
                    Label::Unnamed(c) => format!("unnamed:{} {:.3} ({:.1}σ)", c.name(), x.posterior, x.sigma),
                })
                .collect();
            println!("    {}", list.join(" | "));
        }
        if out.rivalries.is_empty() {
            println!(
                "    places: {:?}",
                out.places
                    .iter()
                    .take(2)
                    .map(|p| (p.coordinate.name(), p.sigma, p.note.clone()))
                    .collect::<Vec<_>>()
            );
        }
    }
}
