//! Pictures of luminaires and light sources: each a function from data to an SVG string.

mod cartesian;
mod chromaticity;
mod cone;
mod contour;
mod isocandela;
mod isolux;
mod polar;
mod solid;
mod spectral_colour;
mod spectrum;
mod tm30;
mod zones;

pub use cartesian::cartesian;
pub use chromaticity::{Diagram, chromaticity};
pub use cone::{Cone, cone, cones};
pub use isocandela::isocandela;
pub use isolux::{IsoluxOptions, isolux};
pub use polar::{PolarOptions, polar};
pub use solid::solid;
pub use spectrum::{SpectrumOptions, spectrum};
pub use tm30::tm30;
pub use zones::zones;

use isolux_photometry::IntensityDistribution;

use crate::axes::{Scale, number};
use crate::svg::{Anchor, Stroke, Svg, colour};

/// Whether light goes above γ = 90°: more than 0.5 % of the largest intensity.
fn upper_light(distribution: &IntensityDistribution) -> bool {
    let peak = distribution.peak().intensity.value();
    distribution.c_deg().iter().enumerate().any(|(plane, _)| {
        distribution
            .gamma_deg()
            .iter()
            .zip(distribution.row(plane))
            .any(|(g, v)| *g > 90.0 && *v > 0.005 * peak)
    })
}

/// The largest γ that a picture needs: the data's own, or 90° where nothing is above.
fn shown_gamma(distribution: &IntensityDistribution) -> f64 {
    let last = distribution.gamma_deg().last().copied().unwrap_or(180.0);
    if upper_light(distribution) {
        last
    } else {
        last.min(90.0)
    }
}

/// Whether all planes are alike to a millionth of the largest intensity.
fn alike(distribution: &IntensityDistribution) -> bool {
    let near = 1e-6 * distribution.peak().intensity.value().abs();
    (1..distribution.c_deg().len()).all(|plane| {
        let rows = distribution.row(plane).iter().zip(distribution.row(0));
        rows.into_iter().all(|(a, b)| (a - b).abs() <= near)
    })
}

/// A vertical bar from 0 to `high` beside a picture in the colours of [`contour::shade`].
fn scale_bar(svg: &mut Svg, (x, y, width, height): (f64, f64, f64, f64), high: f64, unit: &str) {
    const STEPS: usize = 60;
    for i in 0..STEPS {
        let [r, g, b] = contour::shade((i as f64 + 0.5) / STEPS as f64);
        let step = height / STEPS as f64;
        let top = y + height - (i as f64 + 1.0) * step;
        svg.rectangle(x, top, width, step + 0.5, &format!("#{r:02x}{g:02x}{b:02x}"), None);
    }
    svg.rectangle(x, y, width, height, "none", Some(Stroke::solid(colour::INK, 1.0)));
    svg.text((x, y - 8.0), 11.0, Anchor::Start, colour::INK, unit);
    if high > 0.0 {
        let scale = Scale::linear(0.0, high);
        for tick in scale.ticks() {
            let at = y + height * (1.0 - scale.fraction(tick));
            svg.line((x + width, at), (x + width + 4.0, at), Stroke::solid(colour::INK, 1.0));
            svg.text(
                (x + width + 7.0, at + 4.0),
                10.0,
                Anchor::Start,
                colour::INK,
                &number(tick),
            );
        }
    }
}
