//! False-colour maps: a sensor's irradiance as a PNG with scale bar, and as a figure with sections.

mod canvas;
mod viridis;

use std::fmt::Write as _;
use std::ops::Range;

use rayon::prelude::*;

use crate::axes::{Frame, Scale, number};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, colour};
use canvas::{Align, Canvas};
pub use viridis::viridis;
use viridis::{SIDE_BY_SIDE, viridis_of};

/// A map as a solver leaves it: row 0 is the smallest y. Pictures show x to the right and y up, as the lamp sees the
/// sensor.
#[derive(Debug, Clone, Copy)]
pub struct Map<'a> {
    /// Values, `[iy * nx + ix]`.
    pub values: &'a [f32],
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
    /// Width and height in mm.
    pub size_mm: [f64; 2],
    /// What the values are (“irradiance”).
    pub quantity: &'a str,
    /// Their unit.
    pub unit: &'a str,
    /// Standard uncertainty of structure in the map: what single directions of the distribution are uncertain by.
    pub u: Option<f64>,
}

/// Pixels of which one thread at a time takes care.
const RUN: usize = 1 << 17;

/// Smallest and largest finite value; infinities the wrong way round where there is none.
fn finite_range(values: &[f32]) -> (f32, f32) {
    // Lanes side by side: maps have millions of pixels.
    let (mut lows, mut highs) = ([f32::INFINITY; 16], [f32::NEG_INFINITY; 16]);
    let mut add = |lane: usize, value: f32| {
        let finite = value.abs() < f32::INFINITY;
        let (low, high) = (
            if finite { value } else { f32::INFINITY },
            if finite { value } else { f32::NEG_INFINITY },
        );
        lows[lane] = if low < lows[lane] { low } else { lows[lane] };
        highs[lane] = if high > highs[lane] { high } else { highs[lane] };
    };
    let (runs, rest) = values.as_chunks::<16>();
    for run in runs {
        for (lane, value) in run.iter().enumerate() {
            add(lane, *value);
        }
    }
    for value in rest {
        add(0, *value);
    }
    (
        lows.into_iter().fold(f32::INFINITY, f32::min),
        highs.into_iter().fold(f32::NEG_INFINITY, f32::max),
    )
}

/// The pixels, of `pixels` along one side, under point `k` of `shown`.
fn span(k: usize, shown: usize, pixels: usize) -> Range<usize> {
    let from = k * pixels / shown;
    from..((k + 1) * pixels / shown).max(from + 1)
}

/// Words beside the hatched part of a scale.
const HATCHED: &str = "hatched: \u{b1}2 u";

impl Map<'_> {
    /// Smallest and largest finite value; a range of a millionth where all are equal.
    pub fn range(&self) -> (f64, f64) {
        let none = (f32::INFINITY, f32::NEG_INFINITY);
        let runs = self.values.par_chunks(RUN).map(finite_range);
        let (low, high) = runs.reduce(|| none, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (low, high) = (f64::from(low), f64::from(high));
        if low > high {
            return (0.0, 1.0);
        }
        let least = 1e-6 * high.abs().max(1e-30);
        if high - low < least {
            (low - 0.5 * least, high + 0.5 * least)
        } else {
            (low, high)
        }
    }

    /// The part of the scale, around its middle, that is as wide as two standard uncertainties to either side: smaller
    /// differences of colour may be no light.
    fn below_uncertainty(&self, (low, high): (f64, f64)) -> Option<(f64, f64)> {
        let (middle, u) = (0.5 * (low + high), self.u.filter(|u| *u > 0.0)?);
        Some(((middle - 2.0 * u).max(low), (middle + 2.0 * u).min(high)))
    }

    /// Mean of the pixels under (x, y) of a picture of `width` × `height`, y counted from the top.
    fn shown(&self, x: usize, y: usize, width: usize, height: usize) -> f64 {
        self.mean_of(span(x, width, self.nx), span(height - 1 - y, height, self.ny))
    }

    fn mean_of(&self, columns: Range<usize>, rows: Range<usize>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for iy in rows {
            let row = &self.values[iy * self.nx..][columns.clone()];
            sum += row.iter().map(|value| f64::from(*value)).sum::<f64>();
            count += row.len() as f64;
        }
        sum / count
    }

    /// Mean of the pixels below the point (`ix`, `iy`) of `width` × `height` points, row 0 being the smallest y.
    pub fn mean_over(&self, ix: usize, iy: usize, width: usize, height: usize) -> f64 {
        self.shown(ix, height - 1 - iy, width, height)
    }

    /// Width and height in picture points that keep the sensor's shape within `most`.
    fn extent(&self, most: usize) -> (usize, usize) {
        let [w, h] = self.size_mm;
        let scale = most as f64 / w.max(h);
        (
            ((w * scale).round() as usize).max(16),
            ((h * scale).round() as usize).max(16),
        )
    }

    /// The bare map in false colour, at most `most` points a side.
    pub fn bare_png(&self, most: usize) -> Vec<u8> {
        let (width, height) = self.extent(most);
        let mut canvas = Canvas::new(width, height);
        self.paint(&mut canvas, [0, 0], [width, height], self.range());
        canvas.png()
    }

    /// Paints `[left, top]` and `[width, height]` of a canvas that has these points.
    fn paint(
        &self,
        canvas: &mut Canvas,
        [left, top]: [usize; 2],
        [width, height]: [usize; 2],
        (low, high): (f64, f64),
    ) {
        /// Lines that one thread paints.
        const BAND: usize = 64;
        let columns: Vec<Range<usize>> = (0..width).map(|x| span(x, width, self.nx)).collect();
        let stride = 3 * canvas.width;
        let lines = &mut canvas.rgb[top * stride..(top + height) * stride];
        lines
            .par_chunks_mut(BAND * stride)
            .enumerate()
            .for_each(|(band, lines)| {
                let mut colours: Vec<u8> = Vec::new();
                let mut painted = 0..0;
                for (line, points) in lines.chunks_exact_mut(stride).enumerate() {
                    let rows = span(height - 1 - (band * BAND + line), height, self.ny);
                    // A pixel that is larger than a point is painted once.
                    if rows != painted {
                        let share =
                            |columns: &Range<usize>| (self.mean_of(columns.clone(), rows.clone()) - low) / (high - low);
                        colours.clear();
                        for columns in columns.chunks(SIDE_BY_SIDE) {
                            let mut shares = [0.0; SIDE_BY_SIDE];
                            for (value, columns) in shares.iter_mut().zip(columns) {
                                *value = share(columns);
                            }
                            colours.extend(viridis_of(shares).into_iter().take(columns.len()).flatten());
                        }
                        painted = rows;
                    }
                    points[3 * left..3 * (left + width)].copy_from_slice(&colours);
                }
            });
    }

    /// The map with its axes in mm and a scale bar with unit, as PNG.
    pub fn png(&self) -> Vec<u8> {
        let (width, height) = self.extent(768);
        let (left, top) = (86, 46);
        let mut canvas = Canvas::new(left + width + 190, (top + height + 70).max(300));
        canvas.text(left, 16, Align::Left, &format!("{} / {}", self.quantity, self.unit));
        let range = self.range();
        self.paint(&mut canvas, [left, top], [width, height], range);
        canvas.frame(left, top, width, height);
        let [w, h] = self.size_mm;
        for (axis, extent) in [(0, w), (1, h)] {
            for tick in Scale::linear(-0.5 * extent, 0.5 * extent).ticks() {
                if tick.abs() > 0.5 * extent * (1.0 + 1e-9) {
                    continue;
                }
                let share = tick / extent + 0.5;
                if axis == 0 {
                    let x = left + (share * width as f64) as usize;
                    canvas.vertical(x, top + height, 6);
                    canvas.text(x, top + height + 12, Align::Centre, &number(tick));
                } else {
                    let y = top + ((1.0 - share) * height as f64) as usize;
                    canvas.horizontal(left - 6, y, 6);
                    canvas.text(left - 10, y.saturating_sub(7), Align::Right, &number(tick));
                }
            }
        }
        canvas.text(left + width / 2, top + height + 40, Align::Centre, "x / mm");
        canvas.text(8, top + height / 2 - 24, Align::Left, "y");
        canvas.text(8, top + height / 2 - 6, Align::Left, "/mm");
        self.bar(&mut canvas, [left + width + 24, top], height, range);
        canvas.png()
    }

    fn bar(&self, canvas: &mut Canvas, [left, top]: [usize; 2], height: usize, (low, high): (f64, f64)) {
        for y in 0..height {
            let colour = viridis(1.0 - (y as f64 + 0.5) / height as f64);
            for x in 0..22 {
                canvas.set(left + x, top + y, colour);
            }
        }
        canvas.frame(left, top, 22, height);
        let digits = digits(low, high);
        if let Some((from, to)) = self.below_uncertainty((low, high)) {
            let row = |value: f64| top + ((high - value) / (high - low) * (height - 1) as f64) as usize;
            for y in row(to)..=row(from) {
                for x in (0..22).filter(|x| (x + y) % 6 < 2) {
                    canvas.set(left + x, y, [25; 3]);
                }
            }
            canvas.text(left, top + height + 34, Align::Left, HATCHED);
        }
        for tick in Scale::linear(low, high).ticks() {
            if (low..=high).contains(&tick) {
                let y = top + ((high - tick) / (high - low) * (height - 1) as f64) as usize;
                canvas.horizontal(left + 22, y, 5);
                canvas.text(left + 32, y.saturating_sub(7), Align::Left, &format!("{tick:.digits$}"));
            }
        }
        canvas.text(left, top + height + 12, Align::Left, self.unit);
    }

    /// Two figures of one row: the map with its scale, and its sections along x and y through the middle.
    pub fn figures(&self, title: &str) -> [String; 2] {
        [self.figure(title), self.sections(title)]
    }

    fn figure(&self, title: &str) -> String {
        let (low, high) = self.range();
        let digits = digits(low, high);
        let [w, h] = self.size_mm;
        let mut svg = Svg::figure(title);
        let mut frame = Frame::of_figure(Scale::linear(-0.5 * w, 0.5 * w), Scale::linear(-0.5 * h, 0.5 * h));
        let side = frame.height;
        (frame.width, frame.height) = (side * w / w.max(h), side * h / w.max(h));
        let (top, wide, tall) = (frame.top, frame.width, frame.height);
        svg.image(frame.left, top, wide, tall, &self.bare_png(512));
        frame.draw(&mut svg, "x / mm", "y / mm");
        let bar = frame.left + wide + 16.0;
        for step in 0..64 {
            let [r, g, b] = viridis(1.0 - (f64::from(step) + 0.5) / 64.0);
            let mut fill = String::new();
            let _ = write!(fill, "#{r:02x}{g:02x}{b:02x}");
            svg.rectangle(
                bar,
                top + f64::from(step) * tall / 64.0,
                14.0,
                tall / 64.0 + 0.6,
                &fill,
                None,
            );
        }
        for tick in Scale::linear(low, high).ticks() {
            if (low..=high).contains(&tick) {
                let y = top + tall * (high - tick) / (high - low);
                svg.text(
                    (bar + 19.0, y + 4.5),
                    Anchor::Start,
                    colour::INK,
                    &format!("{tick:.digits$}"),
                );
            }
        }
        if let Some((from, to)) = self.below_uncertainty((low, high)) {
            let y = |value: f64| top + tall * (high - value) / (high - low);
            let mut at = y(to);
            while at < y(from) {
                svg.line((bar, at + 3.0), (bar + 14.0, at), Stroke::solid(colour::INK, 1.2));
                at += 5.0;
            }
            svg.text((bar - 30.0, HEIGHT - 10.0), Anchor::Start, colour::INK, HATCHED);
        }
        svg.text((bar, 20.0), Anchor::Start, colour::INK, self.unit);
        svg.text((frame.left, 20.0), Anchor::Start, colour::INK, title);
        svg.finish()
    }

    fn sections(&self, title: &str) -> String {
        let mut svg = Svg::figure(&format!("sections of {title}"));
        let [w, h] = self.size_mm;
        let along_x: Vec<f64> = (0..self.nx)
            .map(|ix| f64::from(self.values[self.ny / 2 * self.nx + ix]))
            .collect();
        let along_y: Vec<f64> = (0..self.ny)
            .map(|iy| f64::from(self.values[iy * self.nx + self.nx / 2]))
            .collect();
        let frame = Frame::of_figure(
            Scale::linear(-0.5 * w.max(h), 0.5 * w.max(h)),
            Scale::around(along_x.iter().chain(&along_y).copied(), false),
        );
        frame.draw(&mut svg, "position / mm", &format!("{} / {}", self.quantity, self.unit));
        for (values, extent, colour, name, line) in [
            (&along_x, w, colour::C0, "along x, y = 0", 0.0),
            (&along_y, h, colour::C90, "along y, x = 0", 120.0),
        ] {
            let stride = (values.len() / 400).max(1);
            let points = (0..values.len() / stride).map(|k| {
                let part = &values[k * stride..(k + 1) * stride];
                let at = (k as f64 + 0.5) * stride as f64 / values.len() as f64 - 0.5;
                frame.at(at * extent, part.iter().sum::<f64>() / stride as f64)
            });
            svg.polyline(points, Stroke::solid(colour, 1.6));
            svg.text((frame.left + line, 22.0), Anchor::Start, colour, name);
        }
        svg.finish()
    }
}

/// Decimals that tell ticks of a range apart.
fn digits(low: f64, high: f64) -> usize {
    let step = crate::axes::tick_step(high - low);
    (-step.log10().floor()).clamp(0.0, 9.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_runs_from_violet_to_yellow() {
        assert_eq!(viridis(0.0), [71, 1, 85]);
        let [r, g, b] = viridis(1.0);
        assert!(r > 240 && g > 220 && b < 60, "{r} {g} {b}");
        assert_eq!(viridis(f64::NAN), viridis(0.0));
    }

    #[test]
    fn row_zero_is_at_the_bottom() {
        let values = [0.0, 0.0, 1.0, 1.0];
        let map = Map {
            values: &values,
            nx: 2,
            ny: 2,
            size_mm: [1.0; 2],
            quantity: "irradiance",
            unit: "W/m²",
            u: None,
        };
        assert_eq!(map.shown(0, 0, 2, 2), 1.0);
        assert_eq!(map.shown(0, 1, 2, 2), 0.0);
        let png = map.png();
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    }

    #[test]
    fn an_even_map_is_drawn() {
        let values = [3.5; 6];
        let map = Map {
            values: &values,
            nx: 3,
            ny: 2,
            size_mm: [3.0, 2.0],
            quantity: "illuminance",
            unit: "lx",
            u: None,
        };
        assert!(map.figures("even")[1].contains("along x"));
        assert!(map.png().len() > 1000);
    }
}
