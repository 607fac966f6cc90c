//! Polar intensity diagram: the two principal planes, γ = 0 down, C0 and C90 to the right.

use isolux_photometry::IntensityDistribution;

use super::shown;
use crate::axes::{number, tick_step};
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

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

/// Where a diagram lies and what its rim stands for.
struct Frame {
    centre: (f64, f64),
    radius: f64,
    /// Largest γ with a spoke.
    widest_deg: f64,
    /// Rings, and what is from one to the next in the unit of the scale.
    rings: usize,
    step: f64,
    /// What a candela is multiplied by.
    factor: f64,
}

/// Room of the rim's labels beside it and above or below it.
const BESIDE: f64 = 46.0;
const LABEL: f64 = 22.0;

impl Frame {
    /// For intensities up to `peak_cd`.
    fn new(peak_cd: f64, upper_light: bool, factor: f64) -> Self {
        let peak = peak_cd * factor;
        let step = tick_step(if peak > 0.0 { 2.0 * peak } else { 1.0 });
        let widest_deg = if upper_light { 180.0 } else { 105.0_f64 };
        // Below the title, above the legend.
        let (top, bottom) = (28.0 + if upper_light { LABEL } else { 0.0 }, HEIGHT - 34.0 - LABEL);
        let above = -widest_deg.to_radians().cos();
        let radius = (0.5 * WIDTH - BESIDE).min((bottom - top) / (1.0 + above));
        let spare = bottom - top - (1.0 + above) * radius;
        Self {
            centre: (0.5 * WIDTH, top + 0.5 * spare + above * radius),
            radius,
            widest_deg,
            rings: (peak / step).ceil().max(1.0) as usize,
            step,
            factor,
        }
    }

    /// What the rim stands for, in cd.
    fn full_cd(&self) -> f64 {
        self.rings as f64 * self.step / self.factor
    }

    /// γ above zero lies in the half-plane at the right, below zero in the opposite one.
    fn at(&self, gamma_deg: f64, cd: f64) -> (f64, f64) {
        let r = self.radius * (cd / self.full_cd()).clamp(0.0, 1.0);
        let (sin, cos) = gamma_deg.to_radians().sin_cos();
        (self.centre.0 + r * sin, self.centre.1 + r * cos)
    }

    /// A line of one intensity.
    fn ring(&self, cd: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        (-90..=90).map(move |i| self.at(f64::from(i) * self.widest_deg / 90.0, cd))
    }

    fn draw(&self, svg: &mut Svg) {
        let grid = Stroke::solid(colour::GRID, 1.0);
        for ring in 1..=self.rings {
            svg.polyline(self.ring(ring as f64 * self.step / self.factor), grid);
        }
        let mut spoke = 0.0;
        while spoke <= self.widest_deg {
            for side in [1.0, -1.0] {
                svg.line(self.centre, self.at(side * spoke, self.full_cd()), grid);
                let (sin, cos) = spoke.to_radians().sin_cos();
                let label = (
                    self.centre.0 + side * (self.radius + 10.0) * sin,
                    self.centre.1 + (self.radius + 10.0) * cos + 4.5,
                );
                let anchor = if sin.abs() < 0.05 {
                    Anchor::Middle
                } else if side > 0.0 {
                    Anchor::Start
                } else {
                    Anchor::End
                };
                if side > 0.0 || (spoke > 0.0 && spoke < 180.0) {
                    let at = (label.0, label.1 + if spoke == 0.0 { 6.0 } else { 0.0 });
                    svg.text(at, anchor, colour::MUTED, &format!("{spoke:.0}°"));
                }
            }
            spoke += if self.widest_deg > 105.0 { 30.0 } else { 15.0 };
        }
    }

    /// Ring values, last and on white, so that no curve hides them.
    fn values(&self, svg: &mut Svg) {
        for ring in 1..=self.rings {
            let value = ring as f64 * self.step;
            let (x, y) = self.at(0.0, value / self.factor);
            let text = number(value);
            let w = 7.4 * text.len() as f64 + 4.0;
            svg.raw(&format!(
                r##"<rect x="{:.2}" y="{:.2}" width="{w:.2}" height="15" fill="#ffffff" fill-opacity="0.8"/>"##,
                x - 0.5 * w,
                y - 15.5
            ));
            svg.text((x, y - 4.0), Anchor::Middle, colour::INK, &text);
        }
    }

    fn legend(svg: &mut Svg, unit: &str, entries: &[(&str, Stroke<'_>)]) {
        const ENTRY: f64 = 138.0;
        let y = HEIGHT - 12.0;
        svg.text((16.0, y), Anchor::Start, colour::INK, unit);
        let mut x = WIDTH - 10.0 - ENTRY * entries.len() as f64;
        for (name, stroke) in entries {
            svg.line((x, y - 4.5), (x + 30.0, y - 4.5), *stroke);
            svg.text((x + 36.0, y), Anchor::Start, colour::INK, name);
            x += ENTRY;
        }
    }
}

const C0: (&str, Stroke<'static>) = ("C0–C180", Stroke::solid(colour::C0, 2.2));
const C90: (&str, Stroke<'static>) = ("C90–C270", Stroke::dashed(colour::C90, 2.2));

/// C0–C180 solid red, C90–C270 dashed blue. A negative intensity is drawn at the centre.
pub fn polar(distribution: &IntensityDistribution, options: &PolarOptions) -> String {
    let (factor, unit) = options.scale();
    let last_gamma = distribution.gamma_deg().last().copied().unwrap_or(180.0);
    let peak_cd = distribution.intensity_cd().iter().fold(0.0, |m: f64, v| m.max(*v));
    let frame = Frame::new(peak_cd, shown::upper_light(distribution), factor);
    let mut svg = Svg::figure(&format!("Polar intensity diagram {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    frame.draw(&mut svg);
    if let Some(limit) = options.doubtful_cd {
        svg.polygon(frame.ring(limit).chain([frame.centre]), colour::MUTED, 0.3);
    }
    // C0–C180 last, above the other.
    let shown: &[(f64, (&str, Stroke<'_>))] = if distribution.is_rotational() {
        &[(0.0, ("all C planes", C0.1))]
    } else {
        &[(90.0, C90), (0.0, C0)]
    };
    let steps = (last_gamma / 0.5).ceil().max(1.0) as i32;
    for &(right, (_, stroke)) in shown {
        let points: Vec<_> = (-steps..=steps)
            .map(|i| {
                let gamma = last_gamma * f64::from(i) / f64::from(steps);
                let c = if i < 0 { right + 180.0 } else { right };
                let cd = distribution.intensity_cd_at(c, gamma.abs());
                (cd, frame.at(gamma, cd))
            })
            .collect();
        for (doubtful, run) in runs(&points, options.doubtful_cd) {
            svg.polyline(run, if doubtful { DOUBTFUL } else { stroke });
        }
    }
    frame.values(&mut svg);
    let entries: Vec<_> = shown.iter().rev().map(|(_, entry)| *entry).collect();
    Frame::legend(&mut svg, unit, &entries);
    svg.finish()
}

/// What was read of a distribution so far, as `(γ, cd)`: γ in degrees, below zero in the opposite half-plane.
#[derive(Debug, Clone, PartialEq, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolarSoFar {
    /// C0–C180.
    pub c0: Vec<(f64, f64)>,
    /// C90–C270.
    pub c90: Vec<(f64, f64)>,
    /// The half-planes that are being read, with their name, where they are others.
    pub current: Option<(String, Vec<(f64, f64)>)>,
    /// The direction that was read last.
    pub ray: Option<(f64, f64)>,
    /// Largest intensity so far in cd, in whatever half-plane.
    pub peak_cd: f64,
    /// Largest γ of the plan in degrees.
    pub reach_deg: f64,
}

/// The diagram of a scan that goes on: the curves as far as they were read, the current direction as a spoke with its
/// reading on it.
pub fn polar_so_far(so_far: &PolarSoFar) -> String {
    let frame = Frame::new(so_far.peak_cd, so_far.reach_deg > 90.0, 1.0);
    let mut svg = Svg::figure("Polar intensity diagram of the scan so far");
    frame.draw(&mut svg);
    let mut entries = vec![C0, C90];
    let mut curve = |points: &[(f64, f64)], stroke| {
        svg.polyline(points.iter().map(|(gamma, cd)| frame.at(*gamma, *cd)), stroke);
    };
    curve(&so_far.c90, C90.1);
    curve(&so_far.c0, C0.1);
    if let Some((name, points)) = &so_far.current {
        let dotted = Stroke {
            colour: colour::NOW,
            width: 1.8,
            dash: "2 3",
        };
        curve(points, dotted);
        entries.push((name, dotted));
    }
    if let Some((gamma, cd)) = so_far.ray {
        let rim = frame.at(gamma, frame.full_cd());
        svg.line(frame.centre, rim, Stroke::solid(colour::NOW, 2.5));
        svg.circle(frame.at(gamma, cd), 5.0, colour::NOW, None);
    }
    frame.values(&mut svg);
    Frame::legend(&mut svg, "cd", &entries);
    svg.finish()
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

    #[test]
    fn a_scan_that_goes_on_is_drawn_on_the_same_scale_as_its_end() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let row: Vec<f64> = gamma.iter().map(|g| 100.0 * g.to_radians().cos()).collect();
        let whole =
            IntensityDistribution::new(vec![0.0, 90.0], gamma.clone(), [row.clone(), row.clone()].concat()).unwrap();
        let so_far = PolarSoFar {
            c0: gamma.iter().copied().zip(row).take(31).collect(),
            ray: Some((30.0, 86.6)),
            peak_cd: 100.0,
            reach_deg: 90.0,
            ..PolarSoFar::default()
        };
        let (whole, part) = (polar(&whole, &PolarOptions::default()), polar_so_far(&so_far));
        let grid = |svg: &str| {
            svg.lines()
                .filter(|line| line.contains(colour::GRID))
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        assert_eq!(grid(&whole), grid(&part));
        // 204 px to the rim of 100 cd, γ = 30°.
        let tip = 250.0 + 204.0 * 0.866 * 0.5;
        assert!(part.contains(&format!("<circle cx=\"{tip:.2}\"")), "{part}");
        assert!(part.contains(colour::NOW) && !whole.contains(colour::NOW));
    }
}
