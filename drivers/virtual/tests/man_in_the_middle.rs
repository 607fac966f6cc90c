//! A man in the middle between every driver and its twin (see `middle`): whatever he does to the bytes, each value that comes
//! out is the truth of its own moment within the twin's noise and digit, or there is an error in its place.
//!
//! Short by itself. By hand: `ISOLUX_ATTACK_ROUNDS=200000 ISOLUX_ATTACK_SEED=7 cargo test --release -p isolux-virtual --test
//! man_in_the_middle -- --nocapture` (a round is at least one request to each instrument).

#![expect(clippy::print_stdout, reason = "the figures of a long run")]

mod middle;

use std::sync::Arc;
use std::time::Duration;

use isolux_axes::ZaberDriver;
use isolux_darkroom::motion::Motion;
use isolux_darkroom::spectrograph::{Exposure, linearity_coefficients, wavelength_nm};
use isolux_darkroom::{Darkroom, Kind, Observation, Room};
use isolux_device::{
    Axis, AxisFactory, AxisPosition, AxisScale, AxisSettings, LuxOutcome, LuxRange, LuxReading, OpenError, Sense,
    Spectroradiometer, SpectroradiometerFactory, Switch, SwitchFactory, Target, Thermometer, ThermometerFactory,
};
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::{MemoryLinks, Ports};
use isolux_units::AxisAngle;
use isolux_virtual::twins::Choice;
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
    instrument: &'static str,
    seed: u64,
    values: u64,
    errors: u64,
    wrong: Vec<String>,
}

impl Tally {
    fn new(instrument: &'static str, seed: u64) -> Self {
        let (values, errors, wrong) = (0, 0, Vec::new());
        Self {
            instrument,
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
        assert!(self.wrong.is_empty(), "{:#?}", &self.wrong[..self.wrong.len().min(10)]);
        assert!(
            self.values > 3 * self.errors,
            "{} values, {} errors",
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

fn lit() -> Darkroom {
    let mut document = Darkroom::default();
    document.lamp.on_at_start = true;
    document.flaws.floor_reflection.albedo = 0.0;
    document
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

#[tokio::test(start_paused = true)]
async fn the_lux_meter_gives_the_light_of_the_moment() {
    attack_lux_meter("konica-t10a:memory:luxmeter?head=0", 1, 4000, 4).await;
}

#[tokio::test(start_paused = true)]
async fn the_mavo_gives_the_light_of_the_moment() {
    attack_lux_meter("gossen-mavo-usb:memory:luxmeter", 11, 4000, 4).await;
}

#[tokio::test(start_paused = true)]
async fn the_p9710_gives_the_light_of_the_moment() {
    attack_lux_meter("gigahertz-p9710:memory:luxmeter?a_per_lx=3e-10", 12, 4000, 8).await;
}

/// Reads the light of many places and switches; `widest` is a range that shows all of it.
async fn attack_lux_meter(at: &'static str, salt: u64, requests: u64, widest: u8) {
    let meter_at = target(at);
    let mut choice = Choice::default();
    choice.choose(Instrument::Luxmeter, meter_at.driver()).unwrap();
    let mut bench = bench_of(lit(), &choice, salt, requests);
    let mut tally = Tally::new(at, bench.seed);
    switch_to(&bench.room, true, false);
    let driver = isolux_luxmeter::DRIVERS
        .iter()
        .find(|driver| driver.name == meter_at.driver())
        .unwrap();
    // A registry keeps its links: only another one opens them again.
    let middle = bench.middle.clone();
    let open = async || {
        let factories = (driver.factories)(Ports::new(Arc::new(middle.clone())));
        factories.lux_meter.unwrap().open_lux_meter(&meter_at).await
    };
    let mut meter = opened(&mut tally, open).await;
    while bench.middle.exchanges() < bench.wanted {
        let dice = &mut bench.dice;
        if dice.chance(0.01) {
            drop(meter);
            meter = opened(&mut tally, open).await;
        }
        if dice.chance(0.02) {
            let range = if dice.chance(0.5) {
                LuxRange::Auto
            } else {
                LuxRange::Fixed(widest)
            };
            // A setting is a question and an answer too, where the meter does not take it with the reading.
            tally.errors += u64::from(meter.set_range(range).await.is_err());
        }
        if dice.chance(0.7) {
            put(&bench.room, AxisName::Gamma, dice.between(0.0, 85.0).round());
            put(
                &bench.room,
                AxisName::Rail,
                [400.0, 1000.0, 3000.0, 9000.0][dice.below(4)],
            );
            let capped = dice.chance(0.1);
            switch_to(&bench.room, !capped, false);
            sleep(Duration::from_secs_f64(dice.between(0.1, 3.0))).await;
        }
        let rest = Instant::now();
        for _ in 0..=dice.below(4) {
            match meter.read(rest, soon()).await {
                Ok(reading) => lux(&mut tally, &bench.room, &reading),
                Err(error) => {
                    tally.errors += 1;
                    if error.kind() == isolux_device::ErrorKind::Disconnected {
                        meter = opened(&mut tally, open).await;
                    }
                }
            }
        }
    }
    tally.end(&bench.middle);
}

fn lux(tally: &mut Tally, room: &VirtualRoom, reading: &LuxReading) {
    let truth = room.with_world(|world, now_s| {
        let kind = if world.switches().shutter_open {
            Kind::Lit
        } else {
            Kind::Capped
        };
        world.room().indicated_lx(&Observation {
            kind,
            time_s: world.lamp_time_s(now_s).unwrap(),
            c_deg: world.axis(AxisName::C).position(now_s),
            gamma_deg: world.axis(AxisName::Gamma).position(now_s),
            distance_mm: world.axis(AxisName::Rail).position(now_s),
            travel: world.axis(AxisName::Gamma).travel(now_s),
            range: 0,
            ambient_c: world.temperature_c(now_s),
        })
    });
    match reading.outcome {
        LuxOutcome::Measured(lux) => {
            // Half a digit, and six standard deviations of the meter.
            let allowed = 0.501 * reading.digit.value() + 6.0 * (0.0008 * truth).hypot(0.0008);
            let right = (lux.value() - truth).abs() <= allowed && reading.confirmed_by.is_some();
            tally.value(right, || format!("{reading:?} instead of {truth} lx"));
        }
        LuxOutcome::Unsteady => tally.errors += 1,
        other => tally.value(false, || format!("{other:?} at {truth} lx")),
    }
}

/// The axes' controller with what hangs on it.
struct Controller {
    gamma: Box<dyn Axis>,
    baffle: Box<dyn Switch>,
    thermometer: Box<dyn Thermometer>,
}

async fn controller(tally: &mut Tally, driver: &ZaberDriver) -> Controller {
    let angle = |deg: f64| AxisAngle::new(deg).unwrap();
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    let settings = AxisSettings::new(scale, (angle(-180.0), angle(180.0)), 20.0, 40.0).unwrap();
    let (gamma_at, baffle_at) = (target("zaber:memory:axes?axis=2"), target("zaber:memory:axes?do=3"));
    let thermometer_at = target("zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100");
    Controller {
        gamma: opened(tally, async || driver.open_axis(&gamma_at, settings).await).await,
        baffle: opened(tally, async || driver.open_switch(&baffle_at).await).await,
        thermometer: opened(tally, async || driver.open_thermometer(&thermometer_at).await).await,
    }
}

#[tokio::test(start_paused = true)]
async fn a_parker_axis_says_where_it_is() {
    let mut choice = Choice::default();
    choice.choose(Instrument::Axes, "parker-easi").unwrap();
    let mut bench = bench_of(lit(), &choice, 13, 6000);
    let mut tally = Tally::new("Parker axis", bench.seed);
    let angle = |deg: f64| AxisAngle::new(deg).unwrap();
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    let settings = AxisSettings::new(scale, (angle(-180.0), angle(180.0)), 20.0, 40.0).unwrap();
    let gamma_at = target("parker-easi:memory:axes?address=2&home=-,0,-10,40,1");
    let driver = isolux_axes::DRIVERS
        .iter()
        .find(|driver| driver.name == gamma_at.driver())
        .unwrap();
    let middle = bench.middle.clone();
    let open = async || {
        let factories = (driver.factories)(Ports::new(Arc::new(middle.clone())));
        factories.axis.unwrap().open_axis(&gamma_at, settings).await
    };
    let mut gamma = opened(&mut tally, open).await;
    let mut homed = false;
    while bench.middle.exchanges() < bench.wanted {
        let (dice, room) = (&mut bench.dice, &bench.room);
        if dice.chance(0.005) {
            drop(gamma);
            gamma = opened(&mut tally, open).await;
        }
        if !homed {
            homed = gamma.home(soon()).await.is_ok();
            continue;
        }
        let to = angle(dice.between(-30.0, 30.0));
        let (before, _) = true_gamma(room);
        match dice.below(4) {
            0 => {
                if let Ok(position) = gamma.move_to(to).await {
                    place(&mut tally, room, true_gamma(room).0, &position, "after a move");
                } else {
                    tally.errors += 1;
                    homed = false;
                }
            }
            1 => {
                if gamma.start_move(to).await.is_ok() {
                    sleep(Duration::from_secs_f64(dice.between(0.0, 0.5))).await;
                    let (before, _) = true_gamma(room);
                    match gamma.position().await {
                        Ok(position) => place(&mut tally, room, before, &position, "on the way"),
                        Err(_) => tally.errors += 1,
                    }
                }
                match gamma.stop().await {
                    Ok(position) => place(&mut tally, room, true_gamma(room).0, &position, "after a stop"),
                    Err(_) => tally.errors += 1,
                }
            }
            _ => match gamma.position().await {
                Ok(position) => place(&mut tally, room, before, &position, "at rest"),
                Err(_) => tally.errors += 1,
            },
        }
        if gamma
            .position()
            .await
            .is_err_and(|error| error.kind() == isolux_device::ErrorKind::Disconnected)
        {
            gamma = opened(&mut tally, open).await;
        }
    }
    tally.end(&bench.middle);
}

/// Where γ truly is, microsteps, and what the air truly has.
fn true_gamma(room: &VirtualRoom) -> (f64, f64) {
    room.with_world(|world, now_s| {
        let axis = world.axis(AxisName::Gamma);
        (axis.motion.position(now_s), world.temperature_c(now_s))
    })
}

/// A position is right if the axis was there, to two microsteps, at some moment of the call.
fn place(tally: &mut Tally, room: &VirtualRoom, before: f64, position: &AxisPosition, what: &str) {
    let (now, _) = true_gamma(room);
    let (low, high) = (before.min(now) - 2.0, before.max(now) + 2.0);
    let right = (low..=high).contains(&(position.steps as f64));
    tally.value(right, || format!("{what}: {position:?}, true {before} to {now}"));
}

#[tokio::test(start_paused = true)]
async fn axes_outputs_and_thermometer_say_what_is() {
    let mut document = lit();
    // So that a temperature of a tenth of a second ago is another one.
    document.room.swing_c = 20.0;
    document.room.swing_period_s = 60.0;
    let mut bench = bench(document, 2, 8000);
    let mut tally = Tally::new("axis, output, thermometer", bench.seed);
    // A registry keeps its links: only another one opens them again.
    let driver = |middle: &Middle| ZaberDriver::new(Ports::new(Arc::new(middle.clone())));
    let mut open = controller(&mut tally, &driver(&bench.middle)).await;
    let mut homed = false;
    while bench.middle.exchanges() < bench.wanted {
        let (dice, room) = (&mut bench.dice, &bench.room);
        if dice.chance(0.005) {
            drop(open);
            open = controller(&mut tally, &driver(&bench.middle)).await;
        }
        if !homed {
            homed = open.gamma.home(soon()).await.is_ok();
            continue;
        }
        let (before, air_before) = true_gamma(room);
        match dice.below(6) {
            0 => {
                let to = AxisAngle::new(dice.between(-30.0, 30.0)).unwrap();
                if let Ok(position) = open.gamma.move_to(to).await {
                    let (now, _) = true_gamma(room);
                    place(&mut tally, room, now, &position, "after a move");
                } else {
                    tally.errors += 1;
                    homed = false;
                }
            }
            1 => {
                let to = AxisAngle::new(dice.between(-30.0, 30.0)).unwrap();
                if open.gamma.start_move(to).await.is_ok() {
                    sleep(Duration::from_secs_f64(dice.between(0.0, 0.5))).await;
                    let (before, _) = true_gamma(room);
                    match open.gamma.position().await {
                        Ok(position) => place(&mut tally, room, before, &position, "on the way"),
                        Err(_) => tally.errors += 1,
                    }
                }
                match open.gamma.stop().await {
                    Ok(position) => {
                        let (now, _) = true_gamma(room);
                        place(&mut tally, room, now, &position, "after a stop");
                    }
                    Err(_) => tally.errors += 1,
                }
            }
            2 => {
                let inside = dice.chance(0.5);
                match open.baffle.set(inside).await {
                    Ok(()) => {
                        let right = room.with_world(|world, _| world.switches().baffle_in) == inside;
                        tally.value(right, || format!("the output is not {inside}"));
                    }
                    Err(_) => tally.errors += 1,
                }
            }
            3 => {
                switch_to(room, true, dice.chance(0.5));
                match open.baffle.state().await {
                    Ok(inside) => {
                        let right = room.with_world(|world, _| world.switches().baffle_in) == inside;
                        tally.value(right, || format!("the output was read as {inside}"));
                    }
                    Err(_) => tally.errors += 1,
                }
            }
            4 => match open.thermometer.read().await {
                Ok(reading) => {
                    let (read, (_, air)) = (reading.temperature.value(), true_gamma(room));
                    // Six standard deviations, half a digit of 15 mK, 0.1 s between the transmitter's samples.
                    let allowed = 6.0 * 0.02 + 0.0075 + 0.21;
                    let right = (air_before.min(air) - allowed..=air_before.max(air) + allowed).contains(&read);
                    tally.value(right, || format!("{read} °C instead of {air_before} to {air}"));
                }
                Err(_) => tally.errors += 1,
            },
            _ => match open.gamma.position().await {
                Ok(position) => place(&mut tally, room, before, &position, "at rest"),
                Err(_) => tally.errors += 1,
            },
        }
    }
    tally.end(&bench.middle);
}

#[tokio::test(start_paused = true)]
async fn the_spectroradiometer_gives_the_spectrum_of_the_moment() {
    let mut bench = bench(lit(), 3, 6000);
    let mut tally = Tally::new("spectroradiometer", bench.seed);
    switch_to(&bench.room, true, false);
    // The same room with electronics that add nothing of their own.
    let mut quiet = lit();
    quiet.spectroradiometer.read_noise_counts = 0.0;
    quiet.spectroradiometer.electrons_per_count = 1e12;
    let quiet = Room::new(quiet);
    let spectro_at = target("ocean-ooi:memory:spectrometer");
    let middle = bench.middle.clone();
    let open = async || {
        let driver = OceanOoiDriver::new(Ports::new(Arc::new(middle.clone())));
        driver.open_spectroradiometer(&spectro_at).await
    };
    let mut spectro = opened(&mut tally, open).await;
    properties(&mut tally, &bench.room, spectro.as_ref());
    while bench.middle.exchanges() < bench.wanted {
        let dice = &mut bench.dice;
        if dice.chance(0.02) {
            drop(spectro);
            spectro = opened(&mut tally, open).await;
            properties(&mut tally, &bench.room, spectro.as_ref());
        }
        let time = Duration::from_millis([5, 20, 60, 150][dice.below(4)]);
        if spectro.set_integration_time(time).await.is_err() {
            tally.errors += 1;
            continue;
        }
        for _ in 0..4 {
            put(&bench.room, AxisName::Gamma, dice.between(0.0, 60.0).round());
            let capped = dice.chance(0.2);
            switch_to(&bench.room, !capped, false);
            for _ in 0..=dice.below(3) {
                match spectro.acquire(soon()).await {
                    Ok(raw) => {
                        let exposure = bench.room.with_world(|world, now_s| Exposure {
                            illuminance_lx: world.spectroradiometer_lx(now_s - 1e-3, now_s),
                            integration_s: time.as_secs_f64(),
                            detector_c: world.temperature_c(now_s) + 4.0,
                            index: 0,
                        });
                        let truth = quiet.exposure_counts(&exposure);
                        let wrong = worst(&quiet, &raw.counts, &truth);
                        tally.value(wrong.is_none() && raw.integration_time == time, || {
                            let (pixel, sigmas) = wrong.unwrap_or_default();
                            let (found, truth) = (raw.counts[pixel], truth[pixel]);
                            format!("pixel {pixel}: {found} counts instead of {truth} ({sigmas:.1} σ) in {time:?}")
                        });
                    }
                    Err(_) => tally.errors += 1,
                }
            }
        }
    }
    tally.end(&bench.middle);
}

/// The pixel furthest from the truth, if it is further than a pair of exposures lets pass: six standard deviations of the
/// difference (8.5 of one exposure), and five of the exposure that it was compared with.
fn worst(room: &Room, counts: &[u16], truth: &[u16]) -> Option<(usize, f64)> {
    let instrument = &room.document().spectroradiometer;
    let sigmas = |pixel: usize| {
        let light = (f64::from(truth[pixel]) - instrument.offset_counts).max(0.0);
        let sigma = 18.0_f64.hypot((light / 1.6).sqrt());
        ((f64::from(counts[pixel]) - f64::from(truth[pixel])).abs() - 3.0) / sigma
    };
    let worst = (0..truth.len()).max_by(|a, b| sigmas(*a).total_cmp(&sigmas(*b)))?;
    (sigmas(worst) > 13.5).then(|| (worst, sigmas(worst)))
}

/// What the instrument stores is what the driver found.
fn properties(tally: &mut Tally, room: &VirtualRoom, spectro: &dyn Spectroradiometer) {
    let found = spectro.properties();
    room.with_world(|world, _| {
        let (room, instrument) = (world.room(), &world.room().document().spectroradiometer);
        let wavelengths = found.wavelength_nm.iter().enumerate().all(|(pixel, nm)| {
            let truth = wavelength_nm(instrument.wavelength_nm, pixel as f64);
            (nm - truth).abs() < 1e-3
        });
        let linearity = found
            .nonlinearity
            .iter()
            .zip(linearity_coefficients(instrument))
            .all(|(found, truth)| (found - truth).abs() <= 1e-6 * truth.abs());
        let factors = found.irradiance_factor.as_ref().is_some_and(|factors| {
            (0..factors.len()).all(|pixel| factors[pixel] == f64::from(room.calibration(pixel) as f32))
        });
        let serial = Some(format!("USB2+V{:05}", room.document().seed)) == spectro.identity().serial;
        let saturation = found.saturation_counts == instrument.saturation_counts;
        let right = wavelengths && linearity && factors && serial && saturation;
        tally.value(right, || {
            format!(
                "{wavelengths} {linearity} {factors} {serial} {saturation}: {:?}",
                spectro.identity()
            )
        });
    });
}
