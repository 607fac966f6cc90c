//! Pictures of a diagnosis: residuals before and after on one fixed scale, along one coordinate, and the gap.

use crate::axes::{Frame, Scale};
use crate::svg::{Anchor, Stroke, Svg, WIDTH, colour};

/// Residuals of one half-plane set or one sensor map, in σ; NaN where nothing was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Its name: a distance, a map.
    pub name: String,
    /// Number of columns (γ, or pixels along x).
    pub columns: usize,
    /// Number of rows (half-planes, or pixels along y); row 0 is drawn at the bottom.
    pub rows: usize,
    /// `[row * columns + column]`, σ.
    pub before: Vec<f64>,
    /// As `before`, with the effects.
    pub after: Vec<f64>,
    /// Coordinate of every column, left to right.
    pub x: Vec<f64>,
    /// Coordinate of every row, from below.
    pub y: Vec<f64>,
}

/// The scale of every residual map, in σ.
const LIMIT_SIGMA: f64 = 5.0;

/// Two figures of one row, before and after: panel under panel, all on one fixed ±5 σ scale. `x` and `y` say what runs
/// along the axes.
pub fn residual_maps(panels: &[Panel], x: &str, y: &str) -> [String; 2] {
    ["before", "after"].map(|side| residual_map(panels, side, x, y))
}

fn residual_map(panels: &[Panel], side: &str, x: &str, y: &str) -> String {
    const LEFT: f64 = 52.0;
    const GAP: f64 = 24.0;
    let wide = panels.iter().all(|panel| panel.columns > 2 * panel.rows);
    // Maps are square and many: two side by side; half-planes are wide and few: one under the other.
    let per_line = if wide { 1 } else { 2 };
    let width = (WIDTH - LEFT - 78.0) / per_line as f64 - GAP;
    let height_of = |panel: &Panel| {
        if wide {
            (14.0 * panel.rows as f64).clamp(24.0, 240.0)
        } else {
            width
        }
    };
    let lines: Vec<&[Panel]> = panels.chunks(per_line).collect();
    let line_height = |line: &[Panel]| line.iter().map(height_of).fold(0.0, f64::max) + 46.0;
    let total: f64 = lines.iter().map(|line| line_height(line)).sum();
    // High enough for the scale beside it.
    let height = (total + 66.0).max(230.0);
    let mut svg = Svg::new(WIDTH, height, &format!("Residuals {side}"));
    let words = if side == "before" { "as given" } else { side };
    svg.text((LEFT, 18.0), Anchor::Start, colour::INK, words);
    let mut top = 28.0;
    for line in &lines {
        for (place, panel) in line.iter().enumerate() {
            let values = if side == "before" { &panel.before } else { &panel.after };
            let corner = (LEFT + place as f64 * (width + GAP), top + 18.0);
            let size = (width, height_of(panel));
            draw(&mut svg, panel, values, corner, size);
            ticks(&mut svg, panel, corner, size, place == 0);
        }
        top += line_height(line);
    }
    svg.text(
        (10.0, height - 12.0),
        Anchor::Start,
        colour::MUTED,
        &format!("→ {x},  ↑ {y}"),
    );
    scale_bar(&mut svg, WIDTH - 64.0, 46.0, 160.0);
    svg.finish()
}

fn draw(svg: &mut Svg, panel: &Panel, values: &[f64], (left, top): (f64, f64), (width, height): (f64, f64)) {
    svg.text((left, top - 5.0), Anchor::Start, colour::MUTED, &panel.name);
    let (cell_w, cell_h) = (width / panel.columns.max(1) as f64, height / panel.rows.max(1) as f64);
    svg.rectangle(left, top, width, height, "#eef0f2", None);
    for row in 0..panel.rows {
        for column in 0..panel.columns {
            let value = values[row * panel.columns + column];
            if value.is_finite() {
                let y = top + (panel.rows - 1 - row) as f64 * cell_h;
                svg.rectangle(
                    left + column as f64 * cell_w,
                    y,
                    cell_w + 0.3,
                    cell_h + 0.3,
                    &diverging(value / LIMIT_SIGMA),
                    None,
                );
            }
        }
    }
    svg.rectangle(
        left,
        top,
        width,
        height,
        "none",
        Some(Stroke::solid(colour::MUTED, 0.6)),
    );
}

/// The coordinates of the first, middle and last column below, of the rows at the left of a line's first panel.
fn ticks(svg: &mut Svg, panel: &Panel, (left, top): (f64, f64), (width, height): (f64, f64), first: bool) {
    let few = |n: usize, room: f64| -> Vec<usize> {
        let count = ((room / 48.0) as usize + 1).clamp(2, 7).min(n);
        let mut places: Vec<usize> = (0..count)
            .map(|k| k * n.saturating_sub(1) / count.saturating_sub(1).max(1))
            .collect();
        places.dedup();
        places
    };
    let word = |value: f64| {
        let text = format!("{value:.1}");
        text.strip_suffix(".0")
            .map_or_else(|| text.clone(), str::to_owned)
            .replace('-', "−")
    };
    for place in few(panel.x.len(), width) {
        let x = left + (place as f64 + 0.5) * width / panel.columns.max(1) as f64;
        svg.text(
            (x, top + height + 15.0),
            Anchor::Middle,
            colour::MUTED,
            &word(panel.x[place]),
        );
    }
    if first {
        for place in few(panel.y.len(), 2.0 * height) {
            let y = top + height - (place as f64 + 0.5) * height / panel.rows.max(1) as f64;
            svg.text((left - 5.0, y + 4.5), Anchor::End, colour::MUTED, &word(panel.y[place]));
        }
    }
}

fn scale_bar(svg: &mut Svg, left: f64, top: f64, height: f64) {
    let steps = 50;
    for k in 0..steps {
        let t = 1.0 - 2.0 * (k as f64 + 0.5) / steps as f64;
        let step = height / steps as f64;
        svg.rectangle(left, top + k as f64 * step, 14.0, step + 0.3, &diverging(t), None);
    }
    for (place, label) in [(0.0, "+5 σ"), (0.5, "0"), (1.0, "−5 σ")] {
        svg.text(
            (left + 18.0, top + place * height + 4.5),
            Anchor::Start,
            colour::INK,
            label,
        );
    }
}

/// Blue below, white at nothing, red above; clipped at ±1. Reads the same for red–green blindness.
fn diverging(t: f64) -> String {
    let t = t.clamp(-1.0, 1.0);
    let end = if t < 0.0 {
        [5.0, 80.0, 160.0]
    } else {
        [178.0, 24.0, 30.0]
    };
    let strength = t.abs().powf(0.8);
    let mix = |k: usize| (250.0 + (end[k] - 250.0) * strength).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

/// Residuals (σ) against a coordinate, with their mean in equal-count bins and, where there is one, the fit through them
/// (x, σ), rising in x. Beside a fit what lies far out is drawn at the edge; without one everything is in its place.
pub fn residuals_along(label: &str, points: &[(f64, f64)], fit: Option<&[(f64, f64)]>) -> String {
    let mut svg = Svg::figure("Residuals along a coordinate");
    let xs = points.iter().map(|(x, _)| *x);
    let most = if fit.is_some() {
        4.0 * LIMIT_SIGMA
    } else {
        f64::INFINITY
    };
    let reach = points
        .iter()
        .map(|(_, y)| y.abs())
        .filter(|y| y.is_finite())
        .fold(LIMIT_SIGMA, f64::max)
        .min(most);
    let frame = Frame::of_figure(Scale::around(xs, false), Scale::linear(-reach, reach));
    frame.draw(&mut svg, label, "(measured − predicted) / (s·u), σ");
    let inside = |y: f64| y.clamp(-reach, reach);
    for &(x, y) in points.iter().take(6000) {
        svg.circle(frame.at(x, inside(y)), 1.6, "#9fb4c0", None);
    }
    for (x, mean, u) in binned(points, 24) {
        let (low, high) = (frame.at(x, inside(mean - u)), frame.at(x, inside(mean + u)));
        svg.line(low, high, Stroke::solid(colour::DATA, 1.4));
        svg.circle(frame.at(x, inside(mean)), 3.2, colour::DATA, None);
    }
    if let Some(fit) = fit {
        let mean_fit: Vec<(f64, f64)> = binned(fit, 60)
            .into_iter()
            .map(|(x, mean, _)| frame.at(x, inside(mean)))
            .collect();
        svg.polyline(mean_fit, Stroke::solid(colour::MODEL, 2.2));
        svg.text((WIDTH - 16.0, 20.0), Anchor::End, colour::MODEL, "— what was found");
    }
    svg.text(
        (frame.left, 20.0),
        Anchor::Start,
        colour::DATA,
        "● mean ± standard error",
    );
    svg.finish()
}

/// Mean and its standard error (unit σ) in bins of equal count; ties in x stay together.
fn binned(points: &[(f64, f64)], bins: usize) -> Vec<(f64, f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let size = sorted.len().div_ceil(bins.max(1)).max(1);
    let mut result = Vec::new();
    let mut start = 0;
    while start < sorted.len() {
        let mut end = (start + size).min(sorted.len());
        while end < sorted.len() && sorted[end].0 == sorted[end - 1].0 {
            end += 1;
        }
        let bin = &sorted[start..end];
        let n = bin.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| bin.iter().map(f).sum::<f64>() / n;
        result.push((mean(|p| p.0), mean(|p| p.1), 1.0 / n.sqrt()));
        start = end;
    }
    result
}

/// The gap as bars: each entry a name with before, after and the noise floor, in σ rms.
pub fn gap_bars(entries: &[(&str, f64, f64, f64)]) -> String {
    let mut svg = Svg::new(WIDTH, 60.0 + 74.0 * entries.len() as f64, "Gap before and after");
    let top = entries
        .iter()
        .map(|(_, before, after, floor)| before.max(*after).max(*floor))
        .fold(0.1, f64::max);
    let scale = |value: f64| 300.0 * value / (1.1 * top);
    for (k, (name, before, after, floor)) in entries.iter().enumerate() {
        let y = 20.0 + 74.0 * k as f64;
        svg.text((10.0, y), Anchor::Start, colour::INK, name);
        for (place, value, fill, word) in [
            (0.0, before, colour::BAD, "before"),
            (1.0, after, colour::GOOD, "after"),
        ] {
            let y = y + 8.0 + 24.0 * place;
            svg.rectangle(60.0, y, scale(*value), 18.0, fill, None);
            svg.text((54.0, y + 13.0), Anchor::End, colour::MUTED, word);
            // Beyond the dashed line where that would cross the number.
            let (end, floor) = (60.0 + scale(*value), 60.0 + scale(*floor));
            let crossed = (end - 4.0..end + 62.0).contains(&floor);
            svg.text(
                (if crossed { floor } else { end } + 6.0, y + 13.0),
                Anchor::Start,
                colour::INK,
                &format!("{value:.3} σ"),
            );
        }
        let x = 60.0 + scale(*floor);
        svg.line((x, y + 2.0), (x, y + 56.0), Stroke::dashed(colour::INK, 1.2));
    }
    let bottom = 36.0 + 74.0 * entries.len() as f64;
    svg.text(
        (10.0, bottom),
        Anchor::Start,
        colour::MUTED,
        "dashed: what noise alone would leave",
    );
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_clipped_and_white_at_nothing() {
        assert_eq!(diverging(0.0), "#fafafa");
        assert_eq!(diverging(7.0), diverging(1.0));
        assert_ne!(diverging(-1.0), diverging(1.0));
    }

    #[test]
    fn bins_keep_equal_coordinates_together() {
        let points: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k / 50), f64::from(k % 2))).collect();
        let bins = binned(&points, 10);
        assert_eq!(bins.len(), 2);
        assert!(
            bins.iter()
                .all(|(_, mean, u)| (mean - 0.5).abs() < 1e-12 && (u - 50f64.sqrt().recip()).abs() < 1e-12)
        );
    }
}
