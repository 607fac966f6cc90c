//! The scale beside a picture in colours.

use super::contour::shade;
use crate::axes::{Scale, number};
use crate::svg::{Anchor, Stroke, Svg, colour};

/// A vertical bar from 0 to `high` beside a picture in the colours of [`shade`].
pub fn scale_bar(svg: &mut Svg, (x, y, width, height): (f64, f64, f64, f64), high: f64, unit: &str) {
    const STEPS: usize = 60;
    for i in 0..STEPS {
        let [r, g, b] = shade((i as f64 + 0.5) / STEPS as f64);
        let step = height / STEPS as f64;
        let top = y + height - (i as f64 + 1.0) * step;
        svg.rectangle(x, top, width, step + 0.5, &format!("#{r:02x}{g:02x}{b:02x}"), None);
    }
    svg.rectangle(x, y, width, height, "none", Some(Stroke::solid(colour::INK, 1.0)));
    svg.text((x, y - 8.0), Anchor::Start, colour::INK, unit);
    if high > 0.0 {
        let scale = Scale::linear(0.0, high);
        for tick in scale.ticks() {
            let at = y + height * (1.0 - scale.fraction(tick));
            svg.line((x + width, at), (x + width + 4.0, at), Stroke::solid(colour::INK, 1.0));
            svg.text((x + width + 7.0, at + 4.5), Anchor::Start, colour::INK, &number(tick));
        }
    }
}
