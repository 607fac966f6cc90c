//! Polar intensity diagram: the two principal planes, γ = 0 down, C0 and C90 to the right.

use isolux_photometry::IntensityDistribution;

use super::shown;
use crate::axes::{number, tick_step};
use crate::svg::{Anchor, Stroke, Svg, colour};

/// What a polar or cartesian diagram shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PolarOptions {
    /// Text above the diagram.
    pub title: String,
    /// Lamp flux in lm: the scale is then cd/klm, otherwise cd.
    pub per_lamp_flux_lm: Option<f64>,
    /// Intensities up to this many cd cannot be told from no light: that range is shaded, and what of a curve lies in
    /// it is dotted.
    pub doubtful_cd: Option<f64>,
}

/// What of a curve cannot be told from no light.
pub(super) const DOUBTFUL: Stroke<'static> = Stroke {
    colour: colour::MUTED,
    width: 1.4,
    dash: "1.5 3",
};

/// The runs of a curve, as `(doubtful, points)`; neighbouring runs share a point, so that no gap opens between them.
pub(super) fn runs<P: Copy>(points: &[(f64, P)], doubtful_cd: Option<f64>) -> Vec<(bool, Vec<P>)> {
    let doubtful = |value: f64| doubtful_cd.is_some_and(|limit| value.abs() <= limit);
    let mut runs: Vec<(bool, Vec<P>)> = Vec::new();
    for &(value, point) in points {
        match runs.last_mut() {
            Some((known, run)) if *known == doubtful(value) => run.push(point),
            last => {
                let before = last.and_then(|(_, run)| run.last().copied());
                runs.push((doubtful(value), before.into_iter().chain([point]).collect()));
            }
        }
    }
    runs
}

impl PolarOptions {
    /// What a candela is multiplied by, and the unit on the scale.
    pub(super) fn scale(&self) -> (f64, &'static str) {
        match self.per_lamp_flux_lm {
            Some(flux) if flux > 0.0 && flux.is_finite() => (1000.0 / flux, "cd/klm"),
            _ => (1.0, "cd"),
        }
    }
}

/// C0–C180 solid red, C90–C270 dashed blue. A negative intensity is drawn at the centre.
pub fn polar(distribution: &IntensityDistribution, options: &PolarOptions) -> String {
    let (factor, unit) = options.scale();
    let last_gamma = distribution.gamma_deg().last().copied().unwrap_or(180.0);
    let peak = distribution.intensity_cd().iter().fold(0.0, |m: f64, v| m.max(*v)) * factor;
    let step = tick_step(if peak > 0.0 { 2.0 * peak } else { 1.0 });
    let rings = (peak / step).ceil().max(1.0);
    let outer = rings * step;

    let upper_light = shown::upper_light(distribution);
    let widest = if upper_light { 180.0 } else { 105.0_f64 };
    let radius = 220.0;
    let (width, top) = (600.0, 56.0);
    let centre = (
        0.5 * width,
        top + 14.0
            + radius
                * if upper_light {
                    1.0
                } else {
                    0.5 - 0.5 * (widest - 60.0_f64).to_radians().cos()
                },
    );
    let height = centre.1 + radius + 74.0;
    let mut svg = Svg::new(width, height, &format!("Polar intensity diagram {}", options.title));
    svg.text((0.5 * width, 26.0), 15.0, Anchor::Middle, colour::INK, &options.title);

    // γ to the right is the C0 or C90 half-plane, to the left C180 or C270.
    let at = |gamma_deg: f64, side: f64, value: f64| {
        let r = radius * (value * factor / outer).clamp(0.0, 1.0);
        let (sin, cos) = gamma_deg.to_radians().sin_cos();
        (centre.0 + side * r * sin, centre.1 + r * cos)
    };
    let grid = Stroke::solid(colour::GRID, 1.0);
    let full = outer / factor;
    for ring in 1..=rings as usize {
        let value = ring as f64 * step / factor;
        let arc = |i: i32| at(f64::from(i).abs() * widest / 90.0, f64::from(i).signum(), value);
        svg.polyline((-90..=90).map(arc), grid);
    }
    let mut spoke = 0.0;
    while spoke <= widest {
        for side in [1.0, -1.0] {
            svg.line(centre, at(spoke, side, full), grid);
            let (sin, cos) = spoke.to_radians().sin_cos();
            let label = (
                centre.0 + side * (radius + 12.0) * sin,
                centre.1 + (radius + 12.0) * cos + 4.0,
            );
            let anchor = if sin.abs() < 0.05 {
                Anchor::Middle
            } else if side > 0.0 {
                Anchor::Start
            } else {
                Anchor::End
            };
            if side > 0.0 || (spoke > 0.0 && spoke < 180.0) {
                let below = if spoke == 0.0 { 6.0 } else { 0.0 };
                svg.text(
                    (label.0, label.1 + below),
                    11.0,
                    anchor,
                    colour::MUTED,
                    &format!("{spoke:.0}°"),
                );
            }
        }
        spoke += if widest > 105.0 { 30.0 } else { 15.0 };
    }

    if let Some(limit) = options.doubtful_cd {
        let rim = |i: i32| at(f64::from(i).abs() * widest / 90.0, f64::from(i).signum(), limit);
        svg.polygon((-90..=90).map(rim).chain([centre]), colour::MUTED, 0.3);
    }

    let planes: [(f64, f64, Stroke<'_>); 2] = if distribution.is_rotational() {
        [(0.0, 180.0, Stroke::solid(colour::C0, 2.2)); 2]
    } else {
        [
            (90.0, 270.0, Stroke::dashed(colour::C90, 2.2)),
            (0.0, 180.0, Stroke::solid(colour::C0, 2.2)),
        ]
    };
    let shown = if distribution.is_rotational() {
        &planes[..1]
    } else {
        &planes[..]
    };
    let steps = (last_gamma / 0.5).ceil().max(1.0) as usize;
    for &(right, left, stroke) in shown {
        let curve = |c: f64, side: f64| {
            (0..=steps).map(move |i| {
                let gamma = last_gamma * i as f64 / steps as f64;
                (gamma, side, distribution.intensity_cd_at(c, gamma))
            })
        };
        let points: Vec<_> = curve(left, -1.0)
            .collect::<Vec<_>>()
            .into_iter()
            .rev()
            .chain(curve(right, 1.0))
            .map(|(g, s, v)| (v, at(g, s, v)))
            .collect();
        for (doubtful, run) in runs(&points, options.doubtful_cd) {
            svg.polyline(run, if doubtful { DOUBTFUL } else { stroke });
        }
    }
    // Ring values last and on white, so that no curve hides them.
    for ring in 1..=rings as usize {
        let value = ring as f64 * step;
        let (x, y) = at(0.0, 1.0, value / factor);
        let text = number(value);
        let w = 7.0 * text.len() as f64 + 4.0;
        svg.raw(&format!(
            r##"<rect x="{:.2}" y="{:.2}" width="{w:.2}" height="13" fill="#ffffff" fill-opacity="0.8"/>"##,
            x - 0.5 * w,
            y - 14.0
        ));
        svg.text((x, y - 4.0), 11.0, Anchor::Middle, colour::INK, &text);
    }
    legend(&mut svg, height - 20.0, width, unit, distribution.is_rotational());
    svg.finish()
}

fn legend(svg: &mut Svg, y: f64, width: f64, unit: &str, rotational: bool) {
    svg.text((24.0, y), 12.0, Anchor::Start, colour::INK, unit);
    let mut x = width - 290.0;
    let entries: &[(&str, Stroke<'_>)] = if rotational {
        &[("all C planes", Stroke::solid(colour::C0, 2.2))]
    } else {
        &[
            ("C0–C180", Stroke::solid(colour::C0, 2.2)),
            ("C90–C270", Stroke::dashed(colour::C90, 2.2)),
        ]
    };
    for (name, stroke) in entries {
        svg.line((x, y - 4.0), (x + 34.0, y - 4.0), *stroke);
        svg.text((x + 42.0, y), 12.0, Anchor::Start, colour::INK, name);
        x += 150.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lambertian_is_drawn_once_and_a_tilted_lobe_in_two_planes() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let row: Vec<f64> = gamma.iter().map(|g| 100.0 * g.to_radians().cos()).collect();
        let lambertian = IntensityDistribution::new(vec![0.0], gamma.clone(), row.clone()).unwrap();
        let out = polar(&lambertian, &PolarOptions::default());
        assert!(out.contains("all C planes") && !out.contains("C90–C270"));
        let planes: Vec<f64> = (0..4)
            .flat_map(|c| row.iter().map(move |v| v * f64::from(c + 1)))
            .collect();
        let other = IntensityDistribution::new(vec![0.0, 90.0, 180.0, 270.0], gamma, planes).unwrap();
        let out = polar(
            &other,
            &PolarOptions {
                title: "a < b".into(),
                per_lamp_flux_lm: Some(1000.0),
                doubtful_cd: None,
            },
        );
        assert!(out.contains(colour::C0) && out.contains("stroke-dasharray") && out.contains("cd/klm"));
        assert!(out.contains("a &lt; b") && !out.contains("NaN"));
        assert!(!out.contains(DOUBTFUL.dash), "nothing is said to be doubtful");
    }

    #[test]
    fn what_cannot_be_told_from_no_light_is_dotted_and_nothing_else() {
        let points: Vec<(f64, usize)> = [9.0, 2.0, 1.0, -1.0, -3.0].into_iter().zip(0..).collect();
        assert_eq!(
            runs(&points, Some(1.5)),
            [(false, vec![0, 1]), (true, vec![1, 2, 3]), (false, vec![3, 4])]
        );
        assert_eq!(runs(&points, None), [(false, vec![0, 1, 2, 3, 4])]);
        let gamma: Vec<f64> = (0..=180).map(f64::from).collect();
        let row = gamma.iter().map(|g| 100.0 * g.to_radians().cos().max(0.0)).collect();
        let lambertian = IntensityDistribution::new(vec![0.0], gamma, row).unwrap();
        let options = PolarOptions {
            doubtful_cd: Some(0.5),
            ..PolarOptions::default()
        };
        for out in [
            polar(&lambertian, &options),
            super::super::cartesian(&lambertian, &options),
        ] {
            assert!(out.contains(DOUBTFUL.dash) && out.contains("fill-opacity=\"0.3\""));
        }
    }
}
