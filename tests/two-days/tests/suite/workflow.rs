//! A few cases of the two days, as a test: the workflow runs from the first scan to the answer, and a day without a
//! fault on directions of the first agrees with its model.

use camino::Utf8PathBuf;
use isolux_two_days::case::{Order, Outcome};
use isolux_two_days::faults::{self, Kind};
use isolux_two_days::lamps::Lamp;
use isolux_two_days::plans::Grid;
use isolux_two_days::suite::play_all;
use isolux_two_days::tables::report;

fn order(kind: Kind, fault: Option<(&str, f64)>, day: u64) -> Order {
    let find = |label: &str| faults::of(kind).find(|fault| fault.label == label).expect("a fault");
    Order {
        kind,
        fault: fault.map(|(label, sigma)| (find(label), sigma)),
        lamp: Lamp::Ring,
        grid: Grid::Equal,
        seed: 1,
        day,
    }
}

#[test]
fn the_workflow_runs_and_a_day_without_a_fault_agrees() {
    let orders = [
        // The longest first: two at a time.
        Order {
            seed: 5,
            ..order(Kind::Maps, Some(("near_field", 10.0)), 565)
        },
        order(Kind::Readings, None, 1),
        order(Kind::Readings, None, 2),
        order(Kind::Readings, Some(("gamma_zero", 30.0)), 3),
        order(Kind::Maps, Some(("exposure_offset", 10.0)), 4),
        order(Kind::Maps, Some(("quantization", 30.0)), 5),
    ];
    let folder = tempfile::tempdir().unwrap();
    let root = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
    let played = play_all(&orders, &root, 2, false, |_, _, _| {});
    let text = report(&played);
    let mut strong = 0;
    for (order, outcome) in &played {
        match outcome {
            Ok(Outcome::Answered(case)) if order.fault.is_none() => {
                assert_eq!(case.stated.verdict, "consistent", "{}", case.line());
            }
            Ok(Outcome::Answered(case)) => {
                let (_, wanted) = order.fault.unwrap();
                // Steps of the search for it: what grows with a square is met less closely.
                assert!((case.sigma / wanted - 1.0).abs() < 0.15, "{}", case.line());
                // What every value shows: the model's own uncertainty takes away, and so does what is refitted.
                assert!(case.stated.gap[0] > 1.0, "{}", case.line());
                // Steps of 1.4 times the noise, at a level that is known to ten steps.
                if order.fault.is_some_and(|(fault, _)| fault.label == "quantization") {
                    assert!(case.line().contains("named quantization"), "{}", case.line());
                }
                // Rings much wider than the luminous area of which the model has a disc.
                if order.fault.is_some_and(|(fault, _)| fault.label == "near_field") {
                    assert_eq!(case.stated.effects[0].0, "near_field", "{}", case.line());
                }
                strong += 1;
            }
            other => panic!("{order:?}: {other:?}"),
        }
    }
    assert_eq!(strong, 4, "{text}");
    assert!(
        text.contains("| gamma_zero |") && text.contains("| exposure_offset |"),
        "{text}"
    );
}
