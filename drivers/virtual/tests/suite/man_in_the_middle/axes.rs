//! The attacks on axes, and on a controller with outputs and inputs.

use std::sync::Arc;
use std::time::Duration;

use isolux_axes::ZaberDriver;
use isolux_device::{
    Axis, AxisFactory, AxisPosition, AxisScale, AxisSettings, ErrorKind, Sense, Switch, SwitchFactory, Thermometer,
    ThermometerFactory,
};
use isolux_transport::Ports;
use isolux_units::AxisAngle;
use isolux_virtual::twins::{Choice, TwinKind};
use isolux_virtual::{AxisName, VirtualRoom};
use tokio::time::sleep;

use super::middle::Middle;
use super::{Tally, address, bench, bench_of, factories, illuminated, opened, soon, switch_to, target};

fn angle(deg: f64) -> AxisAngle {
    AxisAngle::new(deg).unwrap()
}

fn settings() -> AxisSettings {
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    AxisSettings::new(scale, (angle(-180.0), angle(180.0)), 20.0, 40.0).unwrap()
}

/// Homes, moves and stops the γ axis, and asks where it is.
pub async fn attack(twin: &TwinKind, choice: &Choice, salt: u64) {
    let gamma_at = address(twin, "axis.gamma");
    let mut bench = bench_of(illuminated(), choice, salt, 6000);
    let mut tally = Tally::new(gamma_at.to_string(), bench.seed);
    let middle = bench.middle.clone();
    let open = async || {
        let factory = factories(twin, &middle).axis.unwrap();
        factory.open_axis(&gamma_at, settings()).await
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
            .is_err_and(|error| error.kind() == ErrorKind::Disconnected)
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

/// The axes' controller with what hangs on it.
struct Controller {
    gamma: Box<dyn Axis>,
    baffle: Box<dyn Switch>,
    thermometer: Box<dyn Thermometer>,
}

async fn controller(tally: &mut Tally, driver: &ZaberDriver) -> Controller {
    let (gamma_at, baffle_at) = (target("zaber:memory:axes?axis=2"), target("zaber:memory:axes?do=3"));
    let thermometer_at = target("zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100");
    Controller {
        gamma: opened(tally, async || driver.open_axis(&gamma_at, settings()).await).await,
        baffle: opened(tally, async || driver.open_switch(&baffle_at).await).await,
        thermometer: opened(tally, async || driver.open_thermometer(&thermometer_at).await).await,
    }
}

#[tokio::test(start_paused = true)]
async fn axes_outputs_and_thermometer_say_what_is() {
    let mut document = illuminated();
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
                let to = angle(dice.between(-30.0, 30.0));
                if let Ok(position) = open.gamma.move_to(to).await {
                    let (now, _) = true_gamma(room);
                    place(&mut tally, room, now, &position, "after a move");
                } else {
                    tally.errors += 1;
                    homed = false;
                }
            }
            1 => {
                let to = angle(dice.between(-30.0, 30.0));
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
