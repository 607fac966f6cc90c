//! The attack on lux meters.

use std::time::Duration;

use isolux_darkroom::{Kind, Observation};
use isolux_device::{LuxMeter, LuxOutcome, LuxRange, LuxReading};
use isolux_virtual::twins::{Choice, TwinKind};
use isolux_virtual::{AxisName, VirtualRoom};
use tokio::time::{Instant, sleep};

use super::{Tally, address, bench_of, factories, illuminated, opened, put, soon, switch_to};

/// Reads the light of many places and switches.
pub async fn attack(twin: &TwinKind, choice: &Choice, salt: u64) {
    let meter_at = address(twin, "luxmeter");
    let mut bench = bench_of(illuminated(), choice, salt, 4000);
    let mut tally = Tally::new(meter_at.to_string(), bench.seed);
    switch_to(&bench.room, true, false);
    let middle = bench.middle.clone();
    let open = async || {
        let factory = factories(twin, &middle).lux_meter.unwrap();
        factory.open_lux_meter(&meter_at).await
    };
    let mut meter = opened(&mut tally, open).await;
    // The last range shows all of the light.
    let ranges = meter.properties().range_full_scale.len() as u8;
    while bench.middle.exchanges() < bench.wanted {
        let dice = &mut bench.dice;
        if dice.chance(0.01) {
            drop(meter);
            meter = opened(&mut tally, open).await;
        }
        if ranges > 1 && dice.chance(0.02) {
            let range = if dice.chance(0.5) {
                LuxRange::Auto
            } else {
                LuxRange::Fixed(ranges)
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
                Ok(reading) => {
                    let indistinct_lx = indistinct_lx(twin, meter.as_ref(), reading.range);
                    lux(&mut tally, &bench.room, &reading, indistinct_lx);
                }
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

/// What a meter's manual says that its readings of one range may differ from each other, whatever the light.
fn indistinct_lx(twin: &TwinKind, meter: &dyn LuxMeter, range: u8) -> f64 {
    if twin.driver != "gigahertz-p9710" {
        return 0.0;
    }
    // Gigahertz-Optik, P-9710 Operating Manual, section 12.2: offset errors as shares of the ranges.
    let share = match range {
        1 => 1e-2,
        2 => 1e-3,
        _ => 5e-4,
    };
    share * meter.properties().range_full_scale[usize::from(range) - 1].value()
}

fn lux(tally: &mut Tally, room: &VirtualRoom, reading: &LuxReading, indistinct_lx: f64) {
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
            let allowed = 0.501 * reading.digit.value() + 6.0 * (0.0008 * truth).hypot(0.0008) + indistinct_lx;
            let right = (lux.value() - truth).abs() <= allowed && reading.confirmed_by.is_some();
            tally.value(right, || format!("{reading:?} instead of {truth} lx"));
        }
        LuxOutcome::Unsteady => tally.errors += 1,
        other => tally.value(false, || format!("{other:?} at {truth} lx")),
    }
}
