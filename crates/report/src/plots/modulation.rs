//! Light over time, and its components over frequency.

use isolux_modulation::{Modulation, threshold};

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// Lowest amplitude of the picture, % of the mean.
const LEAST_PERCENT: f64 = 1e-3;
/// Range of frequencies of the threshold in Hz: below, flicker is seen directly; above, SVM counts nothing.
const THRESHOLD_HZ: (f64, f64) = (40.0, 2000.0);

/// The first periods of the light relative to its mean.
pub fn light_over_time(modulation: &Modulation, title: &str) -> String {
    let mut svg = Svg::figure("Light over time");
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    let last_ms = modulation.waveform.last().map_or(1.0, |point| 1e3 * point[0]);
    let frame = Frame::of_figure(
        Scale::linear(0.0, last_ms),
        Scale::around(modulation.waveform.iter().map(|point| point[1]), true),
    );
    frame.draw(&mut svg, "time in ms", "light relative to its mean");
    let mean = Stroke::dashed(colour::MUTED, 1.0);
    svg.line(frame.at(0.0, 1.0), frame.at(last_ms, 1.0), mean);
    let points = modulation.waveform.iter();
    svg.polyline(
        points.map(|[time_s, value]| frame.at(1e3 * time_s, *value)),
        Stroke::solid(colour::DATA, 1.6),
    );
    let (x, y) = (frame.left, HEIGHT - 10.0);
    svg.line((x, y - 4.5), (x + 34.0, y - 4.5), mean);
    svg.text((x + 42.0, y), Anchor::Start, colour::INK, "mean");
    svg.finish()
}

/// Amplitudes of its components in per cent of its mean, with the amplitude at which the stroboscopic effect of a sine
/// is just visible.
pub fn light_over_frequency(modulation: &Modulation, title: &str) -> String {
    let mut svg = Svg::figure("Components of the light");
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, title);
    let ends = modulation.spectrum.first().zip(modulation.spectrum.last());
    let (first_hz, last_hz) = ends.map_or((1.0, 1000.0), |(first, last)| (first[0], last[0]));
    let frame = Frame::of_figure(
        Scale::logarithmic(first_hz.max(1.0), last_hz),
        Scale::logarithmic(LEAST_PERCENT, 200.0),
    );
    frame.draw(&mut svg, "frequency in Hz", "amplitude in % of the mean");
    let points = modulation.spectrum.iter().filter(|point| point[0] >= 1.0);
    svg.polyline(
        points
            .map(|[frequency_hz, amplitude]| frame.at(*frequency_hz, (100.0 * amplitude).clamp(LEAST_PERCENT, 200.0))),
        Stroke::solid(colour::DATA, 1.4),
    );
    let visible = Stroke::dashed(colour::BAD, 1.6);
    let steps = 160;
    let (from, to) = (THRESHOLD_HZ.0.max(first_hz.max(1.0)), THRESHOLD_HZ.1.min(last_hz));
    let curve = (0..=steps).map(|k| {
        let frequency_hz = from * (to / from).powf(f64::from(k) / f64::from(steps));
        frame.at(frequency_hz, (100.0 * threshold(frequency_hz)).min(200.0))
    });
    svg.polyline(curve, visible);
    for (k, (stroke, name)) in [
        (Stroke::solid(colour::DATA, 1.4), "light"),
        (visible, "stroboscopic effect of a sine just visible"),
    ]
    .into_iter()
    .enumerate()
    {
        let (x, y) = (frame.left + 110.0 * k as f64, HEIGHT - 10.0);
        svg.line((x, y - 4.5), (x + 34.0, y - 4.5), stroke);
        svg.text((x + 42.0, y), Anchor::Start, colour::INK, name);
    }
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_modulation::{Camera, Waveform, evaluate};

    #[test]
    fn modulated_and_steady_light_both_draw() {
        for amplitude in [0.5, 0.0] {
            let samples = (0..8000)
                .map(|k| 1.0 + amplitude * (0.1 * f64::from(k)).sin())
                .collect();
            let waveform = Waveform::new(samples, 8000.0, "V", None, Some(0.0)).unwrap();
            let modulation = evaluate(&waveform, &Camera::default()).unwrap();
            for figure in [
                light_over_time(&modulation, "a"),
                light_over_frequency(&modulation, "b"),
            ] {
                assert!(figure.contains("viewBox=\"0 0 500 400\"") && !figure.contains("NaN"));
            }
        }
    }
}
