//! The loop that the program is for, closed in the virtual darkroom by its own commands: a flaw is switched on in the
//! room, the twins are scanned or photographed, the record is diagnosed against a model from a healthy room, and the model
//! with the named effect is held against what a camera records in the flawed room.
//!
//!     cargo test --release -p isolux --test darkroom_loop -- --ignored --nocapture
//!
//! prints the table of all effects; the test that runs by default takes one of them.

#![expect(clippy::print_stdout, reason = "the table is what a person runs this for")]

mod cases;
mod maps;
mod workshop;

use cases::{CAMERA, READINGS};
use workshop::Workshop;

#[test]
fn a_flawed_bench_is_named_and_its_luminaire_mended() {
    let workshop = Workshop::open();
    workshop.hold(
        &["luminaire_tilt"].map(|name| cases::find(READINGS, name)),
        Workshop::bench,
    );
}

#[test]
#[ignore = "a minute: nine maps a room"]
fn a_flawed_camera_is_named_and_its_pictures_predicted() {
    let workshop = Workshop::open();
    workshop.hold(
        &["sensor_tilt", "vignetting"].map(|name| cases::find(CAMERA, name)),
        Workshop::camera,
    );
}

#[test]
#[ignore = "minutes: every effect"]
fn every_effect_is_named() {
    let workshop = Workshop::open();
    println!("{}", crate::workshop::HEADING);
    let bench: Vec<_> = READINGS.iter().collect();
    let camera: Vec<_> = CAMERA.iter().collect();
    let failures = [
        workshop.table(&bench, Workshop::bench),
        workshop.table(&camera, Workshop::camera),
    ]
    .concat();
    assert!(failures.is_empty(), "{failures:#?}");
}
