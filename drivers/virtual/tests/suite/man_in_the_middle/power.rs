//! The attacks on power meters and on supplies.

use std::time::Duration;

use isolux_device::{ErrorKind, PowerReading, Quantity};
use isolux_virtual::twins::{Choice, TwinKind};
use isolux_virtual::{Switches, VirtualRoom};
use tokio::time::{Instant, sleep};

use super::{Tally, address, bench_of, factories, illuminated, opened, soon};

/// Two exchanges agree within this share: a damaged low digit may pass in one of them.
const AGREEMENT: f64 = 0.005;

/// Reads the supply line of a lamp whose voltage changes and that is off at times.
pub async fn attack_meter(twin: &TwinKind, choice: &Choice, salt: u64) {
    let meter_at = address(twin, "powermeter");
    let mut bench = bench_of(illuminated(), choice, salt, 2000);
    let mut tally = Tally::new(meter_at.to_string(), bench.seed);
    let middle = bench.middle.clone();
    let open = async || {
        let factory = factories(twin, &middle).power_meter.unwrap();
        factory.open_power_meter(&meter_at).await
    };
    let mut meter = opened(&mut tally, open).await;
    while bench.middle.exchanges() < bench.wanted {
        let dice = &mut bench.dice;
        if dice.chance(0.01) {
            drop(meter);
            meter = opened(&mut tally, open).await;
        }
        if dice.chance(0.7) {
            let (lamp, volts) = (dice.chance(0.8), dice.between(20.0, 28.0));
            bench.room.with_world(|world, now_s| {
                let switches = world.switches();
                world.set_switches(Switches { lamp, ..switches }, now_s);
                world.set_supply_v(volts);
            });
            // The lamp follows its switch late.
            sleep(Duration::from_secs_f64(dice.between(0.1, 3.0))).await;
        }
        match meter.read(Instant::now(), soon()).await {
            Ok(reading) if reading.steady => judge(&mut tally, &bench.room, &reading),
            Ok(_) => tally.errors += 1,
            Err(error) => {
                tally.errors += 1;
                if error.kind() == ErrorKind::Disconnected {
                    meter = opened(&mut tally, open).await;
                }
            }
        }
    }
    tally.end(&bench.middle);
}

fn judge(tally: &mut Tally, room: &VirtualRoom, reading: &PowerReading) {
    let (line, meter) = room.with_world(|world, now_s| {
        let meter = world.room().document().powermeter.clone();
        (world.electrical(now_s), meter)
    });
    let allowed = AGREEMENT + meter.gain_error_rel.abs() + 6.0 * meter.noise_rel;
    let near = |quantity: Quantity, truth: f64| match quantity {
        Quantity::Measured(value) => (value - truth).abs() <= allowed * truth + 1e-9,
        _ => false,
    };
    let factor = match reading.power_factor {
        Quantity::NoData => line.current_a == 0.0,
        other => near(other, 1.0) && line.current_a > 0.0,
    };
    let right = near(reading.voltage, line.voltage_v)
        && near(reading.current, line.current_a)
        && near(reading.power, line.power_w)
        && factor;
    tally.value(right, || format!("{reading:?} instead of {line:?}"));
}

/// Switches the output, and asks how it is.
pub async fn attack_supply(twin: &TwinKind, choice: &Choice, salt: u64) {
    let supply_at = address(twin, "supply");
    let mut bench = bench_of(illuminated(), choice, salt, 2000);
    let mut tally = Tally::new(supply_at.to_string(), bench.seed);
    let middle = bench.middle.clone();
    let open = async || factories(twin, &middle).switch.unwrap().open_switch(&supply_at).await;
    let mut supply = opened(&mut tally, open).await;
    while bench.middle.exchanges() < bench.wanted {
        let lamp = |room: &VirtualRoom| room.with_world(|world, _| world.switches().lamp);
        // Switching takes a dozen exchanges, and a command that was damaged is refused and not repeated.
        let outcome = if bench.dice.chance(0.2) {
            let on = bench.dice.chance(0.5);
            supply.set(on).await.map(|()| on)
        } else {
            supply.state().await
        };
        match outcome {
            Ok(stated) => {
                let truth = lamp(&bench.room);
                tally.value(stated == truth, || format!("{stated} instead of {truth}"));
            }
            Err(error) => {
                tally.errors += 1;
                if error.kind() == ErrorKind::Disconnected {
                    supply = opened(&mut tally, open).await;
                }
            }
        }
    }
    tally.end(&bench.middle);
}
