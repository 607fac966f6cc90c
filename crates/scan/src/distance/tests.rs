use camino::Utf8Path;

use super::*;
use crate::testing::STATION;

const DISPLAY: [DisplayRange; 3] = [
    DisplayRange {
        full_scale_lx: 29.99,
        digit_lx: 0.01,
    },
    DisplayRange {
        full_scale_lx: 299.9,
        digit_lx: 0.1,
    },
    DisplayRange {
        full_scale_lx: 2999.0,
        digit_lx: 1.0,
    },
];

const RAIL: &str = "[rail]\nopen = \"fake:rail\"\ncounts_per_mm = \"100/1\"\nzero_mm = 0.0\nlimit_mm = [200.0, 12000.0]\n\
                    speed_mm_s = 100.0\naccel_mm_s2 = 100.0\n";

/// The bench of fakes with estimates of the published lamp, and with a driven rail.
fn known() -> String {
    let noise = "u_rel = 0.01\nnoise_rel = 0.0008\nnoise_lx = 0.0008\n";
    let lamp = "diameter_mm = 73.0\nflux_lm = 340.0\npeak_cd = 340.0\n";
    STATION
        .replace("u_rel = 0.01\n", noise)
        .replace("diameter_mm = 70.0\n", lamp)
        + RAIL
}

fn of(station: &str) -> Distances {
    let station = Station::parse(Utf8Path::new("s.toml"), station).unwrap();
    let plan = "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, 360, 15]\ngamma_range = [0, 180, 2]\n\
                [[block]]\nname = \"axis\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 9\n\
                [[block]]\nname = \"baffled\"\nkind = \"baffled\"\nc_deg = 0\ngamma_deg = [0, 90]\nrepeats = 3\n";
    let plan = Plan::parse(Utf8Path::new("p.toml"), plan).unwrap();
    distances(&station, &plan, &DISPLAY).unwrap()
}

fn close(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-9, "{value} {expected}");
}

#[test]
fn at_ten_metres_the_digit_costs_more_than_everything_else() {
    let found = of(&known());
    assert_eq!((found.block.as_str(), found.by_hand), ("lit", false));
    let far = found.costs.iter().find(|cost| cost.planned).unwrap();
    assert_eq!((far.distance_mm, far.digit_lx), (10_000.0, Some(0.01)));
    close(far.illuminance_lx.unwrap(), 3.4);
    // The rounding of what is subtracted, 3.63 lm, as the budget of a reduction has it; and of the readings behind the
    // lamp.
    let one = 0.01 / 12f64.sqrt() * 100.0;
    close(far.rounding_lm, one * 4.0 * PI * 1.25_f64.sqrt());
    close(far.rounding_cd.unwrap(), one * 2f64.sqrt());
    close(far.distance_rel.unwrap(), 4e-4);
    assert!(
        far.rounding_lm > 5.0 * far.noise_lm.unwrap() && far.flux_rel.unwrap() > 0.01,
        "{far:?}"
    );
    // The best distance is in the far field of a narrow beam, and its largest reading stays in the finest range.
    let best = found
        .costs
        .iter()
        .find(|cost| Some(cost.distance_mm) == found.best_mm)
        .unwrap();
    assert!(
        best.distance_mm >= 15.0 * 73.0 && best.distance_mm < 5_000.0,
        "{best:?}"
    );
    assert_eq!(best.digit_lx, Some(0.01));
    assert!(best.flux_rel.unwrap() < 0.2 * far.flux_rel.unwrap(), "{best:?}");
    assert!(best.i_max_rel.unwrap() <= far.i_max_rel.unwrap(), "{best:?}");
    for pair in found.costs.windows(2) {
        assert!(pair[1].rounding_lm > pair[0].rounding_lm && pair[1].noise_lm > pair[0].noise_lm);
        assert!(pair[1].near_field_rel < pair[0].near_field_rel && pair[1].distance_rel < pair[0].distance_rel);
    }
}

#[test]
fn the_near_field_is_at_least_that_of_the_disc_of_the_textbook() {
    // A Lambertian disc of radius a gives π·L·a²/(a² + d²) on its axis (Walsh, Photometry): short of I/d² by a²/(a² +
    // d²).
    let lambertian = known()
        .replace("peak_cd = 340.0", "peak_cd = 108.23")
        .replace("[200.0, 1", "[300.0, 1");
    let found = of(&lambertian);
    assert!(
        found.costs[0].distance_mm < 8.0 * 73.0,
        "5 D is enough for it: {:?}",
        found.costs[0]
    );
    for cost in found.costs {
        let disc = 36.5_f64.powi(2) / (36.5_f64.powi(2) + cost.distance_mm.powi(2));
        let stated = cost.near_field_rel.unwrap();
        assert!(
            stated > disc && stated < 2.0 * disc,
            "{} mm: {stated} {disc}",
            cost.distance_mm
        );
    }
}

#[test]
fn what_is_not_known_is_named_and_nothing_is_proposed() {
    let found = of(&(STATION.to_owned() + RAIL));
    assert_eq!(found.best_mm, None);
    for key in ["lamp.flux_lm", "lamp.peak_cd", "luxmeter.noise_rel"] {
        assert!(
            found.unknown.iter().any(|text| text.contains(key)),
            "{key}: {:?}",
            found.unknown
        );
    }
    let far = found.costs.iter().find(|cost| cost.planned).unwrap();
    // The rounding of the flux is known in lumens all the same.
    assert!(
        far.rounding_lm > 3.6 && far.flux_rel.is_none() && far.rounding_cd.is_none() && far.near_field_rel.is_none()
    );
}

#[test]
fn without_a_rail_distances_are_set_by_hand_and_end_at_the_stations_own() {
    let by_hand = known().replace(RAIL, "");
    let found = of(&by_hand);
    assert!(found.by_hand);
    assert!(found.costs.iter().all(|cost| cost.distance_mm <= 10_000.0));
    assert!(found.best_mm.is_some_and(|best| best < 10_000.0));
}
