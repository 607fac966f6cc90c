//! The attack on recorders of waveforms.

use std::time::Duration;

use isolux_device::ErrorKind;
use isolux_virtual::twins::{Choice, TwinKind};

use super::{Tally, address, bench_of, factories, illuminated, opened};

/// Steps of the converter and noise that a sample may be off by, V.
const ALLOWED_V: f64 = 0.02 + 6.0 * 0.006;
/// The twin's photodiode under the steady lamp, V.
const LIT_V: f64 = 1.004;

/// Records the light of the steady lamp: a sample that is not of it was damaged.
pub async fn attack(twin: &TwinKind, choice: &Choice, salt: u64) {
    let scope_at = address(twin, "oscilloscope");
    let mut bench = bench_of(illuminated(), choice, salt, 6000);
    let mut tally = Tally::new(scope_at.to_string(), bench.seed);
    let middle = bench.middle.clone();
    let open = async || {
        let factory = factories(twin, &middle).waveform_recorder.unwrap();
        factory.open_waveform_recorder(&scope_at).await
    };
    let mut scope = opened(&mut tally, open).await;
    while bench.middle.exchanges() < bench.wanted {
        let duration_s = bench.dice.between(0.01, 0.05);
        match scope.record(Duration::from_secs_f64(duration_s), 2e3).await {
            Ok(record) => {
                let output = bench.room.with_world(|world, now_s| world.lamp_output(now_s));
                let truth = 0.004 + output * (LIT_V - 0.004);
                let wrong = record
                    .voltage_v
                    .iter()
                    .find(|value| (**value - truth).abs() > ALLOWED_V);
                let whole = record.voltage_v.len() as f64 >= duration_s * record.rate_hz;
                tally.value(wrong.is_none() && whole, || {
                    format!("{wrong:?} instead of {truth}, {} samples", record.voltage_v.len())
                });
            }
            Err(error) => {
                tally.errors += 1;
                if error.kind() == ErrorKind::Disconnected {
                    scope = opened(&mut tally, open).await;
                }
            }
        }
    }
    tally.end(&bench.middle);
}
