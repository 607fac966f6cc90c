//! The loop that the program is for, closed in the virtual darkroom by its own commands: an injected effect is
//! switched on in the room, the twins are scanned or photographed, the record is diagnosed against a model from a
//! healthy room, and the model with the named effect is held against what a camera records in the disturbed room.
//!
//!     cargo test --release -p isolux --test suite darkroom_loop -- --ignored --nocapture
//!
//! prints the table of all effects; the test that runs by default takes one of them.

#![expect(clippy::print_stdout, reason = "the table is what a person runs this for")]

mod cases;
mod maps;
mod workshop;

use cases::{CAMERA, Case, READINGS};
use workshop::{Thoroughness, Workshop};

#[test]
fn a_disturbed_bench_is_named_and_its_luminaire_corrected() {
    let workshop = Workshop::open(Thoroughness::Quick);
    workshop.hold(
        &["luminaire_tilt", "distance_offset"].map(|name| cases::find(READINGS, name)),
        Workshop::bench,
    );
}

#[test]
fn a_disturbed_camera_is_named_and_its_pictures_predicted() {
    let workshop = Workshop::open(Thoroughness::Quick);
    workshop.hold(&["sensor_tilt"].map(|name| cases::find(CAMERA, name)), Workshop::camera);
}

#[test]
#[ignore = "six minutes and more: every effect"]
fn every_effect_is_named() {
    let workshop = Workshop::open(Thoroughness::Full);
    println!("{}", workshop::HEADING);
    // ISOLUX_LOOP_ONLY="gamma_zero ghost" takes some of them.
    let only = std::env::var("ISOLUX_LOOP_ONLY").ok();
    let taken = |case: &&Case| {
        only.as_ref()
            .is_none_or(|names| names.split_whitespace().any(|name| name == case.name))
    };
    let bench: Vec<_> = READINGS.iter().filter(taken).collect();
    let camera: Vec<_> = CAMERA.iter().filter(taken).collect();
    let failures = [
        workshop.table(&bench, Workshop::bench),
        workshop.table(&camera, Workshop::camera),
    ]
    .concat();
    let all = bench.len() + camera.len();
    println!("{} of {all} effects hold", all - failures.len());
    for failure in &failures {
        println!("  {failure}");
    }
    assert!(only.is_some() || all - failures.len() >= 10, "fewer than ten effects");
}
