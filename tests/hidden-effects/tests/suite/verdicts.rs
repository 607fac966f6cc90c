//! A small suite of hidden effects with fixed seeds: every kind of verdict, judged by what is claimed, never by a
//! tolerance.
//!
//! The whole suite is the benchmark: `cargo bench -p isolux-hidden-effects --bench diagnosis`.

use camino::Utf8PathBuf;
use isolux_diagnose::diagnosis::diagnose;
use isolux_diagnose::document::{Document, Verdict};
use isolux_diagnose::search::Settings;
use isolux_hidden_effects::case::{self, Order};
use isolux_hidden_effects::plan::Plan;
use isolux_hidden_effects::suite::{self, Class};
use isolux_model::Model;
use isolux_record::observation::{Need, open};
use rayon::prelude::*;

fn answer(order: &Order) -> Option<Document> {
    let case = case::make(order)?;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).expect("a UTF-8 path");
    case.write(folder.path()).expect("the case on disk");
    let observations = path.join(if order.sensor { "maps.toml" } else { "readings.csv" });
    let model = Model::load(&path.join("model.toml")).expect("a model");
    let observed = open(&observations, Need::Values).expect("observations");
    let settings = Settings {
        nulls: 300,
        ..Settings::default()
    };
    Some(
        diagnose(&model, &[observed], None, "", &settings)
            .expect("a diagnosis")
            .document,
    )
}

fn answers(class: Class, count: u64) -> Vec<(Order, Document)> {
    of_kind(class, false, count)
}

fn of_kind(class: Class, sensor: bool, count: u64) -> Vec<(Order, Document)> {
    suite::orders(class, sensor, count, 4711)
        .into_par_iter()
        .filter_map(|order| answer(&order).map(|document| (order, document)))
        .collect()
}

fn holds(document: &Document, name: &str) -> bool {
    document
        .effects
        .iter()
        .any(|effect| effect.name == name || effect.equivalents.iter().any(|other| other == name))
}

fn surely_wrong(order: &Order, document: &Document) -> bool {
    document
        .effects
        .iter()
        .any(|effect| effect.evidence.posterior > 0.95 && order.hidden.iter().all(|(name, _)| *name != effect.name))
}

#[test]
fn clean_data_are_consistent() {
    for class in [Class::CleanWhite, Class::CleanCorrelated] {
        for (order, document) in answers(class, 3) {
            assert_eq!(
                document.verdict,
                Verdict::Consistent,
                "{order:?}: {}",
                document.sentence
            );
        }
    }
}

#[test]
fn every_effect_is_inside_its_set() {
    let answers = answers(Class::Single(30), 22);
    assert!(answers.len() >= 18, "{} effects reach 30 σ", answers.len());
    for (order, document) in answers {
        let name = order.hidden[0].0;
        assert!(holds(&document, name), "{name}: {}", document.sentence);
        assert!(!surely_wrong(&order, &document), "{name}: {}", document.sentence);
        assert!(
            matches!(document.verdict, Verdict::Named | Verdict::Ambiguous),
            "{name}: {}",
            document.sentence
        );
    }
}

#[test]
fn what_no_catalogue_has_gets_no_name() {
    for (order, document) in answers(Class::Outside(20), 12) {
        let name = order.hidden[0].0;
        assert_eq!(document.verdict, Verdict::Unexplained, "{name}: {}", document.sentence);
    }
}

/// Periods, patches and loud blocks were taken into a larger, correlated noise with outliers, and the data called
/// consistent.
#[test]
fn what_only_looks_like_noise_is_unexplained() {
    for (order, document) in answers(Class::Developed(30), 4) {
        let name = order.hidden[0].0;
        assert_eq!(document.verdict, Verdict::Unexplained, "{name}: {}", document.sentence);
        assert!(!surely_wrong(&order, &document), "{name}: {}", document.sentence);
    }
}

/// Six records that were called consistent, or a modulated light: a chirp and a telegraph as a correlated noise of 1.5
/// times the stated scatter, readings that keep a part of the one before as outliers, spokes.
#[test]
fn a_chirp_spokes_and_a_sticky_meter_are_no_noise() {
    let silent = [
        ("sticky_readings", 396_829_014),
        ("sticky_readings", 396_829_038),
        ("chirp", 396_829_015),
        ("chirp", 396_829_031),
        ("spokes", 396_829_024),
        ("telegraph", 396_829_015),
    ];
    for (name, seed) in silent {
        let order = Order {
            sensor: false,
            plan: Plan::Designed,
            hidden: vec![(name, 30.0)],
            rho: 0.0,
            outliers: 0.0,
            seed,
        };
        let document = answer(&order).expect("a case");
        assert_eq!(document.verdict, Verdict::Unexplained, "{name}: {}", document.sentence);
    }
}

#[test]
fn two_effects_are_both_found() {
    for (order, document) in answers(Class::Pair, 2) {
        for (name, _) in &order.hidden {
            assert!(holds(&document, name), "{:?}: {}", order.hidden, document.sentence);
        }
    }
}

#[test]
fn a_plan_without_darks_or_distances_makes_no_false_claim() {
    for (order, document) in answers(Class::Common, 4) {
        assert!(
            !surely_wrong(&order, &document),
            "{:?}: {}",
            order.hidden,
            document.sentence
        );
    }
}

#[test]
fn clean_maps_are_consistent() {
    for (order, document) in of_kind(Class::CleanWhite, true, 1) {
        assert_eq!(
            document.verdict,
            Verdict::Consistent,
            "{order:?}: {}",
            document.sentence
        );
    }
}

#[test]
fn what_maps_show_is_inside_its_set() {
    for (order, document) in of_kind(Class::Single(30), true, 4) {
        let name = order.hidden[0].0;
        assert!(holds(&document, name), "{name}: {}", document.sentence);
        assert!(!surely_wrong(&order, &document), "{name}: {}", document.sentence);
    }
}

#[test]
fn what_no_catalogue_has_gets_no_name_from_maps() {
    for (order, document) in of_kind(Class::Outside(20), true, 3) {
        let name = order.hidden[0].0;
        assert_eq!(document.verdict, Verdict::Unexplained, "{name}: {}", document.sentence);
    }
}

#[test]
fn maps_of_a_common_plan_make_no_false_claim() {
    for (order, document) in of_kind(Class::Common, true, 2) {
        assert!(
            !surely_wrong(&order, &document),
            "{:?}: {}",
            order.hidden,
            document.sentence
        );
    }
}
