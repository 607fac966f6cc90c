//! The driver of oscilloscopes over the bytes of its twin.

use std::sync::Arc;
use std::time::Duration;

use isolux_darkroom::Darkroom;
use isolux_device::{ErrorKind, Target, VoltageRecord, WaveformRecorder};
use isolux_transport::{MemoryLinks, Ports};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Serving, VirtualRoom};

async fn scope(document: Darkroom) -> (Box<dyn WaveformRecorder>, VirtualRoom, Serving) {
    let mut choice = Choice::default();
    choice.add(Instrument::Oscilloscope);
    let room = VirtualRoom::open_with(document, &choice);
    let links = MemoryLinks::default();
    let serving = room.listen(&links).unwrap();
    let factories = (isolux_electrical::SCPI_SCOPE.factories)(Ports::new(Arc::new(links)));
    let target = Target::parse("scpi-scope:memory:oscilloscope?profile=ds1000z&channel=1").unwrap();
    let scope = factories
        .waveform_recorder
        .unwrap()
        .open_waveform_recorder(&target)
        .await
        .unwrap();
    (scope, room, serving)
}

fn lit() -> Darkroom {
    let mut document = Darkroom::default();
    document.lamp.on_at_start = true;
    document.injected_effects.lamp_warmup.amplitude_rel = 0.0;
    document.injected_effects.lamp_drift.rate_per_h = 0.0;
    document.injected_effects.flicker_alias.amplitude_rel = 0.0;
    document
}

fn mean(record: &VoltageRecord) -> f64 {
    record.voltage_v.iter().sum::<f64>() / record.voltage_v.len() as f64
}

#[tokio::test(start_paused = true)]
async fn a_record_has_the_shape_of_the_light_sample_by_sample() {
    let mut document = lit();
    document.lamp.flicker_rel = 0.4;
    let (scope, _room, _serving) = scope(document).await;
    assert_eq!(scope.identity().model, "RIGOL TECHNOLOGIES DS1054Z");
    let record = scope.record(Duration::from_secs(2), 20e3).await.unwrap();
    // 0.2 s a division and 120 000 points, of which two seconds are read in three blocks.
    assert!((record.rate_hz / 50e3 - 1.0).abs() < 1e-9, "{}", record.rate_hz);
    assert_eq!(record.voltage_v.len(), 100_000);
    assert!((record.range_v.0 + 0.8).abs() < 1e-9 && (record.range_v.1 - 4.3).abs() < 1e-9);
    // The phase is that of the moment at which it was forced: fitted, then every sample is the sine to 6 σ and half a
    // step.
    let turn = |k: usize| std::f64::consts::TAU * 100.0 * k as f64 / record.rate_hz;
    let fit = |of: fn(f64) -> f64| {
        let sum: f64 = record
            .voltage_v
            .iter()
            .enumerate()
            .map(|(k, value)| value * of(turn(k)))
            .sum();
        2.0 * sum / record.voltage_v.len() as f64
    };
    let (cos, sin, dc) = (fit(f64::cos), fit(f64::sin), mean(&record));
    assert!(
        (dc - 1.004).abs() < 1e-3 && (cos.hypot(sin) - 0.4).abs() < 1e-3,
        "{dc}, {cos}, {sin}"
    );
    for (k, value) in record.voltage_v.iter().enumerate() {
        let truth = dc + cos * turn(k).cos() + sin * turn(k).sin();
        assert!(
            (value - truth).abs() < 6.0 * 0.006 + 0.01 + 2e-3,
            "sample {k}: {value}, {truth}"
        );
    }
    let again = scope.record(Duration::from_secs(2), 20e3).await.unwrap();
    assert_ne!(record.voltage_v, again.voltage_v, "a new record");
}

#[tokio::test(start_paused = true)]
async fn pulses_are_on_for_their_share_and_the_dark_is_its_offset() {
    let mut document = lit();
    (document.lamp.pwm_hz, document.lamp.pwm_duty) = (500.0, 0.3);
    let (scope, room, _serving) = scope(document).await;
    let record = scope.record(Duration::from_millis(100), 20e3).await.unwrap();
    let on = record.voltage_v.iter().filter(|value| **value > 1.0).count();
    assert!((on as f64 / record.voltage_v.len() as f64 - 0.3).abs() < 0.01, "{on}");
    assert!((mean(&record) - 1.004).abs() < 0.02, "{}", mean(&record));
    room.with_world(|world, now_s| world.set_switches(isolux_virtual::Switches::default(), now_s));
    tokio::time::sleep(Duration::from_secs(1)).await;
    let dark = scope.record(Duration::from_millis(100), 20e3).await.unwrap();
    assert!((mean(&dark) - 0.004).abs() < 2e-3, "{}", mean(&dark));
}

#[tokio::test(start_paused = true)]
async fn what_the_memory_does_not_hold_is_refused_with_the_remedy() {
    let (scope, _room, _serving) = scope(lit()).await;
    let long = scope.record(Duration::from_secs(700), 20e3).await.unwrap_err();
    assert_eq!(long.kind(), ErrorKind::Unsupported);
    let fast = scope.record(Duration::from_mins(3), 1e6).await.unwrap_err();
    assert!(
        fast.to_string().contains("24000000 points") && fast.to_string().contains("lower rate"),
        "{fast}"
    );
}
