//! A control chart: values in the order of time with limits of warning and of action.

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// One value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ControlPoint {
    /// Its day.
    pub label: String,
    /// The value.
    pub value: f64,
    /// Its expanded uncertainty (k = 2).
    pub expanded: f64,
}

/// What a chart shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ControlChart {
    /// Text above the picture.
    pub title: String,
    /// Unit of the values.
    pub unit: String,
    /// In the order of time.
    pub points: Vec<ControlPoint>,
    /// Mean and standard deviation of the process; none: no limits yet.
    pub mean_and_s: Option<(f64, f64)>,
}

/// Values with U (k = 2), the mean, warning at two (dashed) and action at three standard deviations (solid).
pub fn control_chart(chart: &ControlChart) -> String {
    let mut svg = Svg::figure(&chart.title);
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &chart.title);
    let limits = chart
        .mean_and_s
        .map(|(mean, s)| [-3.0, -2.0, 0.0, 2.0, 3.0].map(|k| mean + k * s));
    let ends = chart
        .points
        .iter()
        .flat_map(|point| [point.value - point.expanded, point.value + point.expanded]);
    let frame = Frame::of_figure(
        Scale::linear(0.0, chart.points.len() as f64 + 1.0),
        Scale::around(ends.chain(limits.into_iter().flatten()), false),
    );
    let label = if chart.unit.is_empty() { "value" } else { &chart.unit };
    let days = match chart.points.as_slice() {
        [first, .., last] => format!("number, {} to {}", first.label, last.label),
        _ => "number".to_owned(),
    };
    frame.draw(&mut svg, &days, label);
    let (left, right) = frame.x.range();
    for (place, limit) in limits.into_iter().flatten().enumerate() {
        let stroke = match place {
            0 | 4 => Stroke::solid(colour::BAD, 1.2),
            2 => Stroke::solid(colour::MUTED, 1.2),
            _ => Stroke::dashed(colour::MODEL, 1.2),
        };
        svg.line(frame.at(left, limit), frame.at(right, limit), stroke);
    }
    let at = |place: usize, value: f64| frame.at(place as f64 + 1.0, value);
    svg.polyline(
        chart
            .points
            .iter()
            .enumerate()
            .map(|(place, point)| at(place, point.value)),
        Stroke::solid(colour::DATA, 1.2),
    );
    for (place, point) in chart.points.iter().enumerate() {
        let bar = Stroke::solid(colour::DATA, 1.0);
        svg.line(
            at(place, point.value - point.expanded),
            at(place, point.value + point.expanded),
            bar,
        );
        svg.circle(at(place, point.value), 3.0, colour::DATA, None);
    }
    let words = "mean, warning ± 2 s (dashed), action ± 3 s; bars: U (k = 2)";
    svg.text((frame.left, HEIGHT - 10.0), Anchor::Start, colour::INK, words);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_drawn_where_there_are_any() {
        let point = |value: f64| ControlPoint {
            label: "2026-01-01".to_owned(),
            value,
            expanded: 0.01,
        };
        let mut chart = ControlChart {
            points: vec![point(1.0), point(1.01)],
            ..ControlChart::default()
        };
        let without = control_chart(&chart);
        chart.mean_and_s = Some((1.0, 0.002));
        let with = control_chart(&chart);
        assert_eq!(without.matches(colour::BAD).count(), 0);
        assert_eq!(with.matches(colour::BAD).count(), 2);
        assert_eq!(with.matches("r=\"3\"").count(), 2);
        assert!(!control_chart(&ControlChart::default()).contains("NaN"));
    }
}
