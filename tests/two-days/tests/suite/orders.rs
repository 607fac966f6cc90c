//! What days there are: lamps, plans, faults, their strengths and the orders of the whole benchmark.

use std::collections::BTreeSet;

use isolux_darkroom::{Darkroom, Room};
use isolux_hidden_effects::random::Draws;
use isolux_two_days::faults::{FAULTS, Kind, of};
use isolux_two_days::lamps::Lamp;
use isolux_two_days::plans::Grid;
use isolux_two_days::strength::reaching;
use isolux_two_days::suite::{FAULTLESS, SEEDS, SIGMAS, Wanted, orders};

#[test]
fn a_lamp_is_the_same_on_every_day_and_its_kind_has_others() {
    for lamp in Lamp::ALL {
        let peak = |seed, day| Room::new(lamp.room(seed, day)).intensity_cd(10.0, 20.0);
        assert_eq!(peak(1, 5), peak(1, 6), "{lamp:?}");
        if lamp != Lamp::Spot {
            assert_ne!(peak(1, 5), peak(2, 5), "{lamp:?}");
        }
    }
}

#[test]
fn the_spot_is_as_narrow_as_its_page_says() {
    let room = Room::new(Lamp::Spot.room(1, 1));
    let half = room.intensity_cd(0.0, 10.0) / room.intensity_cd(0.0, 0.0);
    assert!((half - 0.5).abs() < 0.01, "{half}");
}

#[test]
fn every_plan_is_one() {
    for grid in Grid::ALL {
        let plan = grid.plan().unwrap();
        assert!(
            plan.blocks().iter().all(|block| block.distance_mm == Some(3700.0)),
            "{grid:?}"
        );
    }
}

#[test]
fn strengths_are_found_on_lines_roots_and_steps_within_reach() {
    for law in [
        (|s| 20.0 * s) as fn(f64) -> f64,
        |s| 300.0 * s * s,
        |s| 14.0 * s.sqrt(),
        |s| (s - 0.4).max(0.0) * 40.0,
    ] {
        let found = reaching(10.0, 1.0, law).unwrap();
        assert!((law(found) / 10.0 - 1.0).abs() < 0.02, "{found}");
    }
    assert!(reaching(10.0, 1.0, |s| 9.0 * s).is_none());
    assert!(reaching(10.0, 1.0, |s| if s > 0.5 { 20.0 } else { 0.0 }).is_none());
}

#[test]
fn there_are_as_many_as_the_table_says_and_each_changes_the_room() {
    assert!(of(Kind::Readings).count() >= 25 && of(Kind::Maps).count() >= 20);
    let labels: BTreeSet<_> = FAULTS.iter().map(|fault| (fault.kind, fault.label)).collect();
    assert_eq!(labels.len(), FAULTS.len());
    let room = Darkroom::built_in().unwrap();
    for fault in FAULTS {
        let drawn = fault.draw(&mut Draws::new(1, 1));
        let small = drawn.within(room.clone(), 0.1 * fault.plausible);
        assert_ne!(small, room, "{}", fault.label);
        assert_ne!(small, drawn.within(room.clone(), fault.plausible), "{}", fault.label);
        if let Some(effect) = fault.effect {
            let known = isolux_model::catalogue().iter().any(|spec| spec.name == effect);
            assert!(known, "{effect}");
        }
    }
}

#[test]
fn every_day_is_its_own_and_every_fault_meets_grids_and_lamps() {
    let all = orders(&Wanted::default());
    let faults = FAULTS.len() as u64;
    assert_eq!(all.len() as u64, faults * 3 * SEEDS + FAULTLESS);
    let mut days: Vec<u64> = all.iter().map(|order| order.day).collect();
    days.dedup();
    assert_eq!(days.len(), all.len());
    for fault in FAULTS {
        let of_fault = all
            .iter()
            .filter(|order| order.fault.is_some_and(|(of, _)| std::ptr::eq(of, fault)));
        let mut met: Vec<(Lamp, Grid)> = of_fault.map(|order| (order.lamp, order.grid)).collect();
        met.sort_unstable();
        met.dedup();
        assert_eq!(met.len(), 9, "{}", fault.label);
    }
}

#[test]
fn a_share_is_a_share_of_everything() {
    let some = orders(&Wanted {
        share: Some(0.2),
        ..Wanted::default()
    });
    let all = orders(&Wanted::default());
    let share = some.len() as f64 / all.len() as f64;
    assert!((share - 0.2).abs() < 0.01, "{share}");
    for sigma in SIGMAS {
        assert!(
            some.iter().any(|order| order.fault.is_some_and(|(_, of)| of == sigma)),
            "{sigma}"
        );
    }
}
