//! A rectangular frame with ticks: maps data to pixels and draws grid, numbers and labels.

use crate::svg::{self, Anchor, Stroke, Svg, colour};

/// A data axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
    step: Option<f64>,
}

impl Scale {
    /// A linear axis from `low` to `high`; an empty or non-finite range becomes one unit wide.
    pub fn linear(low: f64, high: f64) -> Self {
        let (low, high) = if low.is_finite() && high.is_finite() {
            (low, high)
        } else {
            (0.0, 1.0)
        };
        let high = if high > low { high } else { low + low.abs().max(1.0) };
        Self {
            low,
            high,
            logarithmic: false,
            step: None,
        }
    }

    /// A linear axis that holds all finite values and ends on ticks; `zero` makes it hold 0 too.
    pub fn around(values: impl IntoIterator<Item = f64>, zero: bool) -> Self {
        let start = if zero {
            (0.0, 0.0)
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        };
        let (low, high) = values
            .into_iter()
            .filter(|v| v.is_finite())
            .fold(start, |(l, h): (f64, f64), v| (l.min(v), h.max(v)));
        let raw = Self::linear(low, high);
        let step = tick_step(raw.high - raw.low);
        Self::linear((raw.low / step).floor() * step, (raw.high / step).ceil() * step)
    }

    /// A logarithmic axis; both ends are made positive.
    pub fn logarithmic(low: f64, high: f64) -> Self {
        let low = if low.is_finite() && low > 0.0 { low } else { 1e-3 };
        let high = if high.is_finite() && high > low {
            high
        } else {
            low * 10.0
        };
        Self {
            low,
            high,
            logarithmic: true,
            step: None,
        }
    }

    /// The same linear axis with a tick every `step`, such as 30 for angles.
    #[must_use]
    pub fn every(mut self, step: f64) -> Self {
        self.step = (step > 0.0 && (self.high - self.low) / step < 100.0).then_some(step);
        self
    }

    /// The axis's ends.
    pub fn range(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Where a value lies, 0 at the low end, 1 at the high end.
    pub fn fraction(&self, value: f64) -> f64 {
        if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Values that deserve a tick.
    pub fn ticks(&self) -> Vec<f64> {
        if self.logarithmic {
            let (from, to) = (self.low.log10().ceil() as i32, self.high.log10().floor() as i32);
            return (from..=to).map(|exponent| 10f64.powi(exponent)).collect();
        }
        let step = self.step.unwrap_or_else(|| tick_step(self.high - self.low));
        let (from, to) = (
            (self.low / step - 1e-9).ceil() as i64,
            (self.high / step + 1e-9).floor() as i64,
        );
        (from..=to).map(|i| i as f64 * step).collect()
    }
}

/// 1, 2 or 5 times a power of ten, so that a range holds five to ten ticks.
pub fn tick_step(range: f64) -> f64 {
    let raw = range / 8.0;
    let decade = 10f64.powf(raw.log10().floor());
    let lead = raw / decade;
    decade
        * if lead <= 1.0 {
            1.0
        } else if lead <= 2.0 {
            2.0
        } else if lead <= 5.0 {
            5.0
        } else {
            10.0
        }
}

/// A number as a person writes it: no float dust, powers of ten where digits would run away.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e6).contains(&magnitude) {
        return format!("{value:.3e}").replace(".000e", "e").replace("00e", "e");
    }
    let digits = (6 - magnitude.log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// The plotting area of a picture and its two axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left edge in pixels.
    pub left: f64,
    /// Upper edge in pixels.
    pub top: f64,
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
}

impl Frame {
    /// The frame of a figure: a title fits above it, the labels of its axes and one line of text below.
    pub const fn of_figure(x: Scale, y: Scale) -> Self {
        let (left, top) = (72.0, 32.0);
        Self {
            left,
            top,
            width: svg::WIDTH - left - 16.0,
            height: svg::HEIGHT - top - 70.0,
            x,
            y,
        }
    }

    /// Pixel position of a point.
    pub fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (
            self.left + self.x.fraction(x) * self.width,
            self.top + (1.0 - self.y.fraction(y)) * self.height,
        )
    }

    /// Draws grid, ticks, border and labels (with units). Draw data afterwards.
    pub fn draw(&self, svg: &mut Svg, x_label: &str, y_label: &str) {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        for tick in self.x.ticks() {
            let x = self.at(tick, self.y.low).0;
            svg.line((x, self.top), (x, bottom), Stroke::solid(colour::GRID, 1.0));
            svg.text((x, bottom + 18.0), Anchor::Middle, colour::INK, &number(tick));
        }
        for tick in self.y.ticks() {
            let y = self.at(self.x.low, tick).1;
            svg.line((self.left, y), (right, y), Stroke::solid(colour::GRID, 1.0));
            svg.text((self.left - 6.0, y + 4.5), Anchor::End, colour::INK, &number(tick));
        }
        svg.rectangle(
            self.left,
            self.top,
            self.width,
            self.height,
            "none",
            Some(Stroke::solid(colour::INK, 1.0)),
        );
        svg.text(
            (self.left + 0.5 * self.width, bottom + 38.0),
            Anchor::Middle,
            colour::INK,
            x_label,
        );
        svg.turned_text(
            (self.left - 56.0, self.top + 0.5 * self.height),
            Anchor::Middle,
            colour::INK,
            -90.0,
            y_label,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(Scale::linear(0.0, 90.0).ticks(), [0.0, 20.0, 40.0, 60.0, 80.0]);
        assert_eq!(Scale::logarithmic(0.5, 2000.0).ticks(), [1.0, 10.0, 100.0, 1000.0]);
        let (low, high) = Scale::around([-0.3, 4.1, f64::NAN], true).range();
        assert!(low <= -0.3 && high >= 4.1);
    }

    #[test]
    fn a_flat_or_empty_range_still_draws() {
        for scale in [
            Scale::around([], false),
            Scale::around([5.0, 5.0], false),
            Scale::linear(f64::NAN, 1.0),
        ] {
            let (low, high) = scale.range();
            assert!(low.is_finite() && high > low);
            assert!(!scale.ticks().is_empty());
        }
    }

    #[test]
    fn numbers_without_dust() {
        assert_eq!(number(0.1 + 0.2), "0.3");
        assert_eq!(number(1348.0), "1348");
        assert_eq!(number(-2.5), "-2.5");
        assert_eq!(number(2e9), "2e9");
        assert_eq!(number(1.25e-7), "1.250e-7");
    }
}
