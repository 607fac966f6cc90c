//! A small polar diagram without text, to tell runs apart at a glance.

use isolux_photometry::IntensityDistribution;

use super::shown;
use crate::svg::{Stroke, Svg, colour};

const WIDTH: f64 = 160.0;
const HEIGHT: f64 = 120.0;

/// The curves C0–C180 and C90–C270 as `(γ, cd)`: γ in degrees, below zero in the opposite half-plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// C0–C180.
    pub c0: Vec<(f64, f64)>,
    /// C90–C270.
    pub c90: Vec<(f64, f64)>,
}

impl Curves {
    /// Those of a distribution.
    pub fn of(distribution: &IntensityDistribution) -> Self {
        let last = shown::shown_gamma(distribution);
        let through = |c_deg: f64| {
            let steps = last.ceil().max(1.0) as i32;
            (-steps..=steps)
                .map(|i| {
                    let gamma = last * f64::from(i) / f64::from(steps);
                    let c = if i < 0 { c_deg + 180.0 } else { c_deg };
                    (gamma, distribution.intensity_cd_at(c, gamma.abs()))
                })
                .collect()
        };
        Self {
            c0: through(0.0),
            c90: through(90.0),
        }
    }
}

/// Both curves in one picture as large as it allows; none where there is no light.
pub fn thumbnail(curves: &Curves) -> Option<String> {
    let all = || curves.c0.iter().chain(&curves.c90);
    let peak = all().map(|(_, cd)| *cd).filter(|cd| cd.is_finite()).fold(0.0, f64::max);
    if peak <= 0.0 {
        return None;
    }
    let at = |(gamma, cd): (f64, f64)| {
        let (sin, cos) = gamma.to_radians().sin_cos();
        let r = (cd / peak).clamp(0.0, 1.0);
        (r * sin, r * cos)
    };
    // γ = 0 points down. What the curves and the light centre take is fitted into the picture, alike along both axes.
    let bounds = all()
        .map(|point| at(*point))
        .fold([0.0_f64; 4], |[l, r, t, b], (x, y)| {
            [l.min(x), r.max(x), t.min(y), b.max(y)]
        });
    let [left, right, top, bottom] = bounds;
    let half = right.max(-left);
    let scale = (0.46 * WIDTH / half.max(1e-9)).min(0.9 * HEIGHT / (bottom - top).max(1e-9));
    let origin = (0.5 * WIDTH, 0.5 * (HEIGHT - scale * (top + bottom)));
    let place = |point: &(f64, f64)| {
        let (x, y) = at(*point);
        (origin.0 + scale * x, origin.1 + scale * y)
    };
    let mut svg = Svg::new(WIDTH, HEIGHT, "Luminous intensity, polar");
    for (share, dash) in [(0.5, "2 3"), (1.0, "")] {
        svg.circle(
            origin,
            share * scale,
            "none",
            Some(Stroke {
                colour: colour::GRID,
                width: 1.0,
                dash,
            }),
        );
    }
    for (points, stroke) in [
        (&curves.c90, Stroke::dashed(colour::C90, 1.6)),
        (&curves.c0, Stroke::solid(colour::C0, 1.8)),
    ] {
        let line: Vec<(f64, f64)> = points.iter().map(place).collect();
        svg.polygon(std::iter::once(origin).chain(line.iter().copied()), stroke.colour, 0.1);
        svg.polyline(line, stroke);
    }
    Some(svg.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_fill_the_picture_and_stay_inside() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let row: Vec<f64> = gamma.iter().map(|g| 700.0 * g.to_radians().cos()).collect();
        let lambertian = IntensityDistribution::new(vec![0.0], gamma, row).unwrap();
        let svg = thumbnail(&Curves::of(&lambertian)).unwrap();
        let path = svg
            .lines()
            .find(|line| line.contains("fill=\"none\" stroke-linejoin"))
            .unwrap();
        let numbers = path.split_once("d=\"M").unwrap().1.split_once('"').unwrap().0;
        let points: Vec<Vec<f64>> = numbers
            .split('L')
            .map(|point| point.split(' ').map(|number| number.parse().unwrap()).collect())
            .collect();
        let reach = points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min)
            ..=points.iter().map(|point| point[1]).fold(0.0, f64::max);
        assert!(*reach.start() > 0.0 && *reach.end() < HEIGHT, "{reach:?}");
        assert!(reach.end() - reach.start() > 0.8 * HEIGHT, "{reach:?}");
        assert!(points.iter().all(|point| (0.0..=WIDTH).contains(&point[0])));
    }

    #[test]
    fn no_light_is_no_picture() {
        assert_eq!(thumbnail(&Curves::default()), None);
        let dark = Curves {
            c0: vec![(0.0, 0.0), (10.0, f64::NAN)],
            c90: vec![(0.0, -1.0)],
        };
        assert_eq!(thumbnail(&dark), None);
    }
}
