//! Waveforms whose numbers are known: closed forms, and the amplitudes that IEC TR 61547-1 gives for PstLM = 1.

use std::f64::consts::{PI, TAU};

use isolux_modulation::{Camera, Modulation, Waveform, evaluate};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

fn record(rate_hz: f64, duration_s: f64, light: impl Fn(f64) -> f64) -> Waveform {
    let count = (rate_hz * duration_s).round() as usize;
    let samples = (0..count).map(|k| light(k as f64 / rate_hz)).collect();
    Waveform::new(samples, rate_hz, "V", None, Some(0.0)).unwrap()
}

fn seen(waveform: &Waveform) -> Modulation {
    evaluate(waveform, &Camera::default()).unwrap()
}

fn sine(amplitude: f64, frequency_hz: f64) -> impl Fn(f64) -> f64 {
    move |t_s| 1.0 + amplitude * (TAU * frequency_hz * t_s).sin()
}

/// Not symmetric about samples, so that no edge lies on one.
fn square(frequency_hz: f64, duty: f64, low: f64) -> impl Fn(f64) -> f64 {
    move |t_s| {
        if (frequency_hz * t_s + 0.0013).fract() < duty {
            1.0
        } else {
            low
        }
    }
}

#[test]
fn svm_of_full_modulation() {
    for (what, waveform, expected) in [
        ("sine 100 Hz", record(20e3, 1.0, sine(1.0, 100.0)), 3.902),
        ("sine 120 Hz", record(20e3, 1.0, sine(1.0, 120.0)), 3.627),
        ("sine 500 Hz", record(20e3, 1.0, sine(1.0, 500.0)), 1.367),
        (
            "|sin| 100 Hz",
            record(20e3, 1.0, |t| (PI * 100.0 * t).sin().abs()),
            2.602,
        ),
        (
            "|sin| 120 Hz",
            record(20e3, 1.0, |t| (PI * 120.0 * t).sin().abs()),
            2.419,
        ),
        ("square 100 Hz", record(20e3, 1.0, square(100.0, 0.5, 0.0)), 4.970),
        // Not whole periods, and at the least rate and length.
        ("sine 100.4 Hz", record(4e3, 1.0, sine(1.0, 100.4)), 3.895),
    ] {
        let svm = seen(&waveform).svm.quantity.unwrap();
        assert!(
            (svm.value / expected - 1.0).abs() < 1e-3,
            "{what}: {}, {expected}",
            svm.value
        );
        assert!(
            (svm.value - expected).abs() <= 3.0 * svm.u.unwrap() + 5e-4,
            "{what}: {svm:?}"
        );
    }
}

/// The chain as SciPy 1.17 computes it (`tests/peers/flicker.py`), at 2 kHz over 180 s.
#[test]
fn pst_is_that_of_another_implementation() {
    for (amplitude, frequency_hz, expected) in [
        (0.0746, 0.5, 1.172_21),
        (0.00448, 8.8, 1.012_12),
        (0.00683, 20.0, 1.005_24),
        (0.0127, 33.3, 0.999_33),
    ] {
        let pst = seen(&record(2e3, 180.0, sine(amplitude, frequency_hz)))
            .pst_lm
            .quantity
            .unwrap();
        assert!((pst.value - expected).abs() < 2e-5, "{frequency_hz} Hz: {}", pst.value);
        let faster = seen(&record(5e3, 180.0, sine(amplitude, frequency_hz)))
            .pst_lm
            .quantity
            .unwrap();
        assert!(
            (faster.value - pst.value).abs() < 2.0 * pst.u.unwrap() + 2e-5,
            "{frequency_hz} Hz: {faster:?}, {pst:?}"
        );
    }
}

#[test]
fn depth_index_and_frequency_have_closed_forms() {
    for (what, waveform, depth_percent, index, frequency_hz) in [
        ("sine", record(20e3, 1.0, sine(0.4, 100.0)), 40.0, 0.4 / PI, 100.0),
        (
            "square",
            record(20e3, 2.0, square(97.3, 0.3, 0.25)),
            60.0,
            0.3 * 0.7 * 0.75 / (0.25 + 0.75 * 0.3),
            97.3,
        ),
        (
            "|sin|",
            record(20e3, 1.0, |t| (PI * 120.0 * t).sin().abs()),
            100.0,
            0.210_5,
            120.0,
        ),
    ] {
        let seen = seen(&waveform);
        let frequency = seen.dominant_frequency.quantity.unwrap();
        for (name, quantity, expected) in [
            ("depth", &seen.modulation_depth, depth_percent),
            ("index", &seen.flicker_index, index),
            ("frequency", &frequency, frequency_hz),
        ] {
            let off = (quantity.value - expected).abs();
            assert!(
                off <= 3.0 * quantity.u.unwrap() + 2e-4 * expected,
                "{what}, {name}: {quantity:?}, {expected}"
            );
            assert!(quantity.u.unwrap() < 0.01 * expected, "{what}, {name}: {quantity:?}");
        }
    }
}

/// Of noisy records of one light, the true value lies within U of at least nine in ten, for every quantity.
#[test]
fn the_uncertainty_covers_what_noise_does() {
    let (rate_hz, draws) = (8e3, 60);
    let soft = |t_s: f64| sine(0.3, 100.3)(t_s) + 0.05 * (TAU * 310.0 * t_s).sin();
    // Its turns at the bottom are sharp.
    let sharp = |t_s: f64| 0.6 + 0.7 * (PI * 100.3 * t_s).sin().abs();
    covered(rate_hz, draws, soft);
    covered(rate_hz, draws, sharp);
}

/// A cusp at 20 kHz loses its tip with the components that fold into the noise.
#[test]
fn the_tip_of_a_sharp_turn_is_in_the_uncertainty() {
    for seed in 0..5 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let samples = (0..100_000).map(|k| {
            let normal: f64 = StandardNormal.sample(&mut random);
            0.35 + 0.65 * (PI * 100.02 * f64::from(k) / 20e3).sin().abs() + 0.002 * normal
        });
        let depth = seen(&Waveform::new(samples.collect(), 20e3, "V", None, Some(0.0)).unwrap()).modulation_depth;
        let off = (depth.value - 100.0 * 0.65 / 1.35).abs();
        assert!(off < 2.0 * depth.u.unwrap() && depth.u.unwrap() < 0.3, "{depth:?}");
    }
}

fn covered(rate_hz: f64, draws: u64, light: impl Fn(f64) -> f64) {
    let truth = seen(&record(rate_hz, 3.0, &light));
    let of = |seen: &Modulation| {
        [
            seen.modulation_depth.clone(),
            seen.flicker_index.clone(),
            seen.dominant_frequency.quantity.clone().unwrap(),
            seen.svm.quantity.clone().unwrap(),
        ]
    };
    let mut covered = [0; 4];
    let mut largest = [0.0_f64; 4];
    for draw in 0..draws {
        let mut random = ChaCha8Rng::seed_from_u64(draw);
        let samples = (0..24_000).map(|k| {
            let normal: f64 = StandardNormal.sample(&mut random);
            light(f64::from(k) / rate_hz) + 0.02 * normal
        });
        let noisy = seen(&Waveform::new(samples.collect(), rate_hz, "V", None, Some(0.0)).unwrap());
        assert!((noisy.noise_rel / 0.02 - 1.0).abs() < 0.1, "{}", noisy.noise_rel);
        for (k, (quantity, truth)) in of(&noisy).iter().zip(of(&truth)).enumerate() {
            let off = (quantity.value - truth.value).abs() / quantity.u.unwrap();
            covered[k] += usize::from(off <= 2.0);
            largest[k] = largest[k].max(off);
        }
    }
    assert!(
        covered.iter().all(|covered| *covered >= 54),
        "{covered:?} of {draws}, {largest:?}"
    );
    // An uncertainty ten times too large would cover too.
    assert!(largest.iter().all(|off| *off > 0.3), "{largest:?}");
}

#[test]
fn what_a_record_does_not_hold_is_not_given_and_says_why() {
    let short = seen(&record(20e3, 0.5, sine(0.4, 100.0)));
    assert!(short.svm.why_not.unwrap().contains("1 s") && short.pst_lm.why_not.unwrap().contains("180 s"));
    let slow = seen(&record(1e3, 200.0, sine(0.4, 100.0)));
    assert!(slow.svm.why_not.unwrap().contains("4000 Hz") && slow.pst_lm.why_not.unwrap().contains("2000 Hz"));
    let steady = seen(&record(20e3, 1.0, |_| 1.0));
    assert!(steady.dominant_frequency.quantity.is_none());
    assert!(steady.modulation_depth.value < 1e-9 && steady.svm.quantity.unwrap().value < 1e-9);
    let few = evaluate(&record(1e3, 1.0, sine(0.4, 3.0)), &Camera::default())
        .unwrap_err()
        .to_string();
    assert!(few.contains("3.0 periods"), "{few}");
    let undark = Waveform::new(
        record(20e3, 1.0, sine(0.4, 100.0)).samples().to_vec(),
        20e3,
        "",
        None,
        None,
    )
    .unwrap();
    let depth = seen(&undark).modulation_depth;
    assert!(depth.u.is_none() && depth.missing[0].contains("dark"));
}

/// Means over the exposure of the waveform itself, at many phases.
#[test]
fn exposures_and_bands_agree_with_a_direct_integral() {
    let light = |t_s: f64| (PI * 100.0 * t_s).sin().abs() + 0.2;
    let waveform = record(20e3, 1.0, light);
    for (exposure_ms, line_time_us) in [(2.0, 20.0), (7.3, 15.0), (10.0, 20.0), (1.0, 6000.0)] {
        let camera = Camera {
            exposures_s: vec![1e-3 * exposure_ms],
            line_time_s: Some(1e-6 * line_time_us),
        };
        let exposed = evaluate(&waveform, &camera).unwrap().exposures.remove(0);
        let phases = 400;
        let means: Vec<f64> = (0..phases)
            .map(|phase| {
                let from_s = 0.01 * f64::from(phase) / f64::from(phases);
                let parts = 2000;
                let at = |part| light(from_s + 1e-3 * exposure_ms * (f64::from(part) + 0.5) / f64::from(parts));
                (0..parts).map(at).sum::<f64>() / f64::from(parts)
            })
            .collect();
        let mean = means.iter().sum::<f64>() / means.len() as f64;
        let high = means.iter().copied().fold(0.0, f64::max);
        let low = means.iter().copied().fold(f64::INFINITY, f64::min);
        let rms = (means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / means.len() as f64).sqrt() / mean;
        assert!(
            (exposed.peak_to_peak_rel - (high - low) / mean).abs() < 2e-3,
            "{exposed:?}, {low}, {high}"
        );
        assert!((exposed.rms_rel - rms).abs() < 5e-4, "{exposed:?}, {rms}");
        let bands = exposed.banding.unwrap();
        assert!(
            (bands.amplitude_rel - (high - low) / (high + low)).abs() < 1e-3,
            "{bands:?}"
        );
        if exposure_ms < 10.0 {
            // 100 Hz: a band of 10 ms; of rows that are 6 ms apart each second and a half, an alias.
            let rows = if line_time_us == 6000.0 {
                2.5
            } else {
                1e4 / line_time_us
            };
            assert!((bands.period_rows.unwrap() / rows - 1.0).abs() < 1e-6, "{bands:?}");
        }
    }
}
