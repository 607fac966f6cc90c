//! A small SVG writer: shapes in pixels, y downwards, text escaped, numbers short.

use std::fmt::Write as _;

/// Colours shared by every picture.
pub mod colour {
    /// C0–C180, customary solid red.
    pub const C0: &str = "#c8102e";
    /// C90–C270, customary dashed blue.
    pub const C90: &str = "#0047bb";
    /// Axes, ticks and text.
    pub const INK: &str = "#222831";
    /// Lines and text upon a coloured map, which is alike in every theme.
    pub const OVER: &str = "#1f252d";
    /// Secondary text.
    pub const MUTED: &str = "#66707c";
    /// Grid lines.
    pub const GRID: &str = "#d9dee4";
    /// Measured data.
    pub const DATA: &str = "#1b6e8c";
    /// Simulated or fitted data.
    pub const MODEL: &str = "#d9730d";
    /// What is being read now.
    pub const NOW: &str = "#6d28a8";
    /// A good verdict.
    pub const GOOD: &str = "#2e7d4f";
    /// A bad verdict.
    pub const BAD: &str = "#b3261e";
}

/// How text sits about its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Begins there.
    Start,
    /// Centred there.
    Middle,
    /// Ends there.
    End,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke<'a> {
    /// CSS colour.
    pub colour: &'a str,
    /// Width in pixels.
    pub width: f64,
    /// SVG dash pattern, empty for solid.
    pub dash: &'a str,
}

impl<'a> Stroke<'a> {
    /// A solid line.
    pub const fn solid(colour: &'a str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: "",
        }
    }

    /// A dashed line.
    pub const fn dashed(colour: &'a str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: "6 4",
        }
    }
}

/// Width of a figure in pixels: two stand beside each other on a report's page.
pub const WIDTH: f64 = 500.0;
/// Height in pixels of a figure that shares its row with another.
pub const HEIGHT: f64 = 400.0;
/// Size of every text in a figure, in pixels. Figures are as wide as each other, so that it is one size on the screen.
pub const TEXT: f64 = 13.0;

/// An SVG document under construction.
#[derive(Debug, Clone)]
pub struct Svg {
    width: f64,
    height: f64,
    title: String,
    body: String,
}

impl Svg {
    /// An empty picture of `width` × `height` pixels; `title` is what a screen reader says.
    pub fn new(width: f64, height: f64, title: &str) -> Self {
        Self {
            width,
            height,
            title: escape(title),
            body: String::new(),
        }
    }

    /// An empty figure as wide and as high as every other that shares its row.
    pub fn figure(title: &str) -> Self {
        Self::new(WIDTH, HEIGHT, title)
    }

    /// Adds a straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: Stroke<'_>) {
        let _ = writeln!(
            self.body,
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}"{}/>"#,
            n(from.0),
            n(from.1),
            n(to.0),
            n(to.1),
            attributes(stroke)
        );
    }

    /// Adds a line through points; points that are not finite break it.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = (f64, f64)>, stroke: Stroke<'_>) {
        let path = path_of(points, false);
        if !path.is_empty() {
            let _ = writeln!(
                self.body,
                r#"<path d="{path}" fill="none" stroke-linejoin="round"{}/>"#,
                attributes(stroke)
            );
        }
    }

    /// Adds a closed, filled shape.
    pub fn polygon(&mut self, points: impl IntoIterator<Item = (f64, f64)>, fill: &str, opacity: f64) {
        let path = path_of(points, true);
        if !path.is_empty() {
            let _ = writeln!(
                self.body,
                r#"<path d="{path}" fill="{}" fill-opacity="{}"/>"#,
                escape(fill),
                n(opacity)
            );
        }
    }

    /// Adds a rectangle.
    pub fn rectangle(&mut self, x: f64, y: f64, width: f64, height: f64, fill: &str, stroke: Option<Stroke<'_>>) {
        let _ = writeln!(
            self.body,
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{}"{}/>"#,
            n(x),
            n(y),
            n(width),
            n(height),
            escape(fill),
            stroke.map(attributes).unwrap_or_default()
        );
    }

    /// Adds a circle.
    pub fn circle(&mut self, centre: (f64, f64), radius: f64, fill: &str, stroke: Option<Stroke<'_>>) {
        let _ = writeln!(
            self.body,
            r#"<circle cx="{}" cy="{}" r="{}" fill="{}"{}/>"#,
            n(centre.0),
            n(centre.1),
            n(radius),
            escape(fill),
            stroke.map(attributes).unwrap_or_default()
        );
    }

    /// Adds text at its baseline.
    pub fn text(&mut self, at: (f64, f64), anchor: Anchor, fill: &str, text: &str) {
        self.turned_text(at, anchor, fill, 0.0, text);
    }

    /// Adds text turned by `degrees` about its point.
    pub fn turned_text(&mut self, at: (f64, f64), anchor: Anchor, fill: &str, degrees: f64, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if degrees == 0.0 {
            String::new()
        } else {
            format!(r#" transform="rotate({} {} {})""#, n(degrees), n(at.0), n(at.1))
        };
        let _ = writeln!(
            self.body,
            r#"<text x="{}" y="{}" text-anchor="{anchor}" fill="{}"{turn}>{}</text>"#,
            n(at.0),
            n(at.1),
            escape(fill),
            escape(text)
        );
    }

    /// Adds a PNG, stretched without smoothing over the rectangle.
    pub fn image(&mut self, x: f64, y: f64, width: f64, height: f64, png: &[u8]) {
        let _ = writeln!(
            self.body,
            r#"<image x="{}" y="{}" width="{}" height="{}" preserveAspectRatio="none" image-rendering="pixelated" href="{}"/>"#,
            n(x),
            n(y),
            n(width),
            n(height),
            data_uri(png)
        );
    }

    /// Adds raw SVG, for what this writer has no word for (gradients, clip paths). The caller escapes.
    pub fn raw(&mut self, svg: &str) {
        self.body.push_str(svg);
        self.body.push('\n');
    }

    /// The finished document.
    pub fn finish(self) -> String {
        let (w, h) = (n(self.width), n(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" \
             font-size=\"{TEXT}\" font-family=\"'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif\">\n<title>{}</title>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.title, self.body
        )
    }
}

/// A PNG inside an address, for pages that fetch nothing.
pub fn data_uri(png: &[u8]) -> String {
    use base64::Engine as _;
    format!(
        "data:image/png;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(png)
    )
}

/// Text made safe inside XML and HTML.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML 1.0 has no way to write other control characters.
            c if c < ' ' && !matches!(c, '\n' | '\t') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// A pixel coordinate with two decimals at most, the same on every machine.
fn n(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    if rounded == 0.0 {
        "0".to_owned()
    } else {
        format!("{rounded}")
    }
}

fn attributes(stroke: Stroke<'_>) -> String {
    let dash = if stroke.dash.is_empty() {
        String::new()
    } else {
        format!(r#" stroke-dasharray="{}""#, stroke.dash)
    };
    format!(
        r#" stroke="{}" stroke-width="{}"{dash}"#,
        escape(stroke.colour),
        n(stroke.width)
    )
}

fn path_of(points: impl IntoIterator<Item = (f64, f64)>, close: bool) -> String {
    let mut path = String::new();
    let mut pen_down = false;
    for (x, y) in points {
        if x.is_finite() && y.is_finite() {
            let _ = write!(path, "{}{} {}", if pen_down { "L" } else { "M" }, n(x), n(y));
            pen_down = true;
        } else {
            pen_down = false;
        }
    }
    if close && !path.is_empty() {
        path.push('Z');
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_in_the_data_is_a_gap_in_the_line() {
        assert_eq!(
            path_of([(0.0, 1.0), (1.0, 1.5), (f64::NAN, 0.0), (3.0, 2.004)], false),
            "M0 1L1 1.5M3 2"
        );
    }

    #[test]
    fn text_cannot_leave_its_element() {
        let mut svg = Svg::new(10.0, 10.0, "a < b");
        svg.text((1.0, 2.0), Anchor::Start, "#000", "</text><script>\u{1}");
        let out = svg.finish();
        assert!(out.contains("&lt;/text&gt;&lt;script&gt;\u{fffd}</text>") && !out.contains("<script>"));
        assert!(out.contains("<title>a &lt; b</title>"));
    }
}
