//! A man in the middle between every driver and its twin (see `middle`): whatever he does to the bytes, each value that
//! comes out is the truth of its own moment within the twin's noise and digit, or there is an error in its place.
//!
//! Short by itself. By hand: `ISOLUX_ATTACK_ROUNDS=200000 ISOLUX_ATTACK_SEED=7 cargo test --release -p isolux-virtual
//! --test suite man_in_the_middle -- --nocapture` (a round is at least one request to each instrument).
//!
//! The table of twins says who is attacked, so that no twin is left out.

#![expect(clippy::print_stdout, reason = "the figures of a long run")]

mod axes;
mod light;
mod middle;
mod power;
mod spectra;
mod waveform;

use std::sync::Arc;
use std::time::Duration;

use isolux_darkroom::Darkroom;
use isolux_darkroom::motion::Motion;
use isolux_device::{Factories, OpenError, Target};
use isolux_transport::{MemoryLinks, Ports};
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use isolux_virtual::{AxisName, Instrument, Serving, Switches, VirtualRoom};
use middle::{Dice, Middle};
use tokio::time::{Instant, sleep};

/// Of the answers this share meets a fault, and of those this share another one, and so on.
const RATE: f64 = 0.08;

fn environment(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")),
        Err(_) => default,
    }
}

/// What came of it.
struct Tally {
    instrument: String,
    seed: u64,
    values: u64,
    errors: u64,
    wrong: Vec<String>,
}

impl Tally {
    fn new(instrument: impl Into<String>, seed: u64) -> Self {
        let (values, errors, wrong) = (0, 0, Vec::new());
        Self {
            instrument: instrument.into(),
            seed,
            values,
            errors,
            wrong,
        }
    }

    fn value(&mut self, right: bool, what: impl FnOnce() -> String) {
        self.values += 1;
        if !right {
            self.wrong.push(what());
        }
    }

    /// Prints the figures; nothing may be wrong, and the faults must not have stopped everything.
    fn end(&self, middle: &Middle) {
        let faults = middle.faults();
        println!(
            "man in the middle, {}, seed {}: {} exchanges, {} faults, {} values, {} errors, {} wrong values",
            self.instrument,
            self.seed,
            middle.exchanges(),
            faults.values().sum::<u64>(),
            self.values,
            self.errors,
            self.wrong.len()
        );
        for (fault, count) in &faults {
            println!("  {count:7}  {fault}");
        }
        let name = &self.instrument;
        assert!(
            self.wrong.is_empty(),
            "{name}: {:#?}",
            &self.wrong[..self.wrong.len().min(10)]
        );
        assert!(
            self.values > 3 * self.errors,
            "{name}: {} values, {} errors",
            self.values,
            self.errors
        );
    }
}

struct Bench {
    room: VirtualRoom,
    middle: Middle,
    dice: Dice,
    seed: u64,
    /// Requests to be made.
    wanted: u64,
    _serving: Serving,
}

/// A room whose lamp burns, and everything between it and the drivers.
fn bench(document: Darkroom, salt: u64, requests: u64) -> Bench {
    bench_of(document, &Choice::default(), salt, requests)
}

/// The same with the twins of `choice`.
fn bench_of(document: Darkroom, choice: &Choice, salt: u64, requests: u64) -> Bench {
    let seed = environment("ISOLUX_ATTACK_SEED", 1);
    let room = VirtualRoom::open_with(document, choice);
    let links = MemoryLinks::default();
    let serving = room.listen(&links).unwrap();
    Bench {
        room,
        middle: Middle::new(links, seed.wrapping_mul(1009).wrapping_add(salt), RATE),
        dice: Dice::new(seed.wrapping_mul(7919).wrapping_add(salt)),
        seed,
        wanted: environment("ISOLUX_ATTACK_ROUNDS", requests),
        _serving: serving,
    }
}

fn illuminated() -> Darkroom {
    let mut document = Darkroom::default();
    document.lamp.on_at_start = true;
    document.injected_effects.floor_reflection.albedo = 0.0;
    document
}

/// What opens the part `part` of a station that `twin` plays.
fn address(twin: &TwinKind, part: &str) -> Target {
    let rest = twin.open(part).unwrap();
    let pipe = VirtualRoom::pipe(twin.instrument);
    target(&format!("{}:memory:{pipe}{rest}", twin.driver))
}

/// The factories of the twin's driver behind `middle`. A registry keeps its links: only another one opens them again.
fn factories(twin: &TwinKind, middle: &Middle) -> Factories {
    let drivers = [
        isolux_axes::DRIVERS,
        isolux_electrical::DRIVERS,
        isolux_luxmeter::DRIVERS,
        isolux_spectroradiometer::DRIVERS,
    ];
    let mut drivers = drivers.into_iter().flatten();
    let driver = drivers.find(|driver| driver.name == twin.driver).unwrap();
    (driver.factories)(Ports::new(Arc::new(middle.clone())))
}

#[tokio::test(start_paused = true)]
async fn no_twin_is_made_to_lie() {
    for (twin, salt) in TWINS.iter().zip(11..) {
        let mut choice = Choice::default();
        choice.choose(twin.instrument, twin.driver).unwrap();
        // A kind of instrument that has no attack yet does not compile: write it.
        match twin.instrument {
            Instrument::Axes | Instrument::Outputs => axes::attack(twin, &choice, salt).await,
            // A spectrometer in the place of the lux meter has the driver of one, which is attacked below.
            Instrument::Luxmeter if is_spectrometer(twin) => {}
            Instrument::Luxmeter => light::attack(twin, &choice, salt).await,
            Instrument::Spectroradiometer => spectra::attack(twin, &choice, salt).await,
            Instrument::Powermeter => power::attack_meter(twin, &choice, salt).await,
            Instrument::Supply => power::attack_supply(twin, &choice, salt).await,
            Instrument::Oscilloscope => waveform::attack(twin, &choice, salt).await,
        }
    }
}

/// Whether the driver that speaks to the twin opens spectroradiometers.
fn is_spectrometer(twin: &TwinKind) -> bool {
    isolux_spectroradiometer::DRIVERS
        .iter()
        .any(|driver| driver.name == twin.driver)
}

fn target(text: &str) -> Target {
    Target::parse(text).unwrap()
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(30)
}

/// Puts an axis where it is wanted, as a hand would.
fn put(room: &VirtualRoom, name: AxisName, at: f64) {
    room.with_world(|world, now_s| {
        let axis = world.axis_mut(name);
        let counts = at * axis.counts_per_unit;
        axis.drive(Motion::at_rest(counts), now_s);
    });
}

fn switch_to(room: &VirtualRoom, shutter_open: bool, baffle_in: bool) {
    let switches = Switches {
        lamp: true,
        shutter_open,
        baffle_in,
    };
    room.with_world(|world, now_s| world.set_switches(switches, now_s));
}

async fn opened<T: ?Sized>(tally: &mut Tally, open: impl AsyncFn() -> Result<Box<T>, OpenError>) -> Box<T> {
    for _ in 0..100 {
        match open().await {
            Ok(device) => return device,
            Err(_) => tally.errors += 1,
        }
        sleep(Duration::from_secs(1)).await;
    }
    panic!("{} cannot be opened", tally.instrument)
}
