//! The photometric solid: intensity as the distance from the light centre, seen from above and aside.

use isolux_photometry::IntensityDistribution;

use super::contour::shade;
use super::polar::PolarOptions;
use super::shown;
use crate::axes::number;
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};

/// The solid with its three axes. γ = 0 points down, C runs counter-clockwise seen from above (CIE 121), so the
/// luminaire's (x, y, z) becomes the right-handed (x, y, −z) of the room.
pub fn solid(distribution: &IntensityDistribution, options: &PolarOptions) -> String {
    let (factor, unit) = options.scale();
    let high = distribution.peak().intensity_cd;
    let last = shown::shown_gamma(distribution);
    let mut svg = Svg::figure(&format!("Photometric solid {}", options.title));
    svg.text((0.5 * WIDTH, 20.0), Anchor::Middle, colour::INK, &options.title);
    let (centre, radius) = if shown::upper_light(distribution) {
        ((0.5 * WIDTH, 200.0), 145.0)
    } else {
        ((0.5 * WIDTH, 130.0), 200.0)
    };

    // Camera 25° above the horizon, turned 35° from the axis C0 so that no axis hides another.
    let (turn, lift) = (35f64.to_radians(), 25f64.to_radians());
    // Right, up on the picture, and depth towards the viewer.
    let project = |p: [f64; 3]| {
        let (right, away) = (
            p[0] * turn.cos() + p[1] * turn.sin(),
            -p[0] * turn.sin() + p[1] * turn.cos(),
        );
        let up = p[2] * lift.cos() + away * lift.sin();
        let depth = p[2] * lift.sin() - away * lift.cos();
        ((centre.0 + radius * right, centre.1 - radius * up), depth)
    };
    let point = |c_deg: f64, gamma_deg: f64| {
        let share = if high > 0.0 {
            (distribution.intensity_cd_at(c_deg, gamma_deg) / high).max(0.0)
        } else {
            0.0
        };
        let ((sc, cc), (sg, cg)) = (c_deg.to_radians().sin_cos(), gamma_deg.to_radians().sin_cos());
        ([share * sg * cc, share * sg * sc, -share * cg], share)
    };
    let axes = [
        ([1.0, 0.0, 0.0], "C0"),
        ([0.0, 1.0, 0.0], "C90"),
        ([-1.0, 0.0, 0.0], "C180"),
        ([0.0, -1.0, 0.0], "C270"),
        ([0.0, 0.0, -1.0], "γ 0°"),
    ];
    for (end, _) in axes {
        let (from, to) = (project([0.0; 3]).0, project(end.map(|v| 1.08 * v)).0);
        svg.line(from, to, Stroke::solid(colour::MUTED, 1.0));
    }

    let (columns, rows) = (72usize, ((last / 3.0).round() as usize).clamp(8, 60));
    let mut faces = Vec::with_capacity(columns * rows);
    for i in 0..columns {
        for j in 0..rows {
            let (c, g) = (
                [i, i + 1].map(|i| 360.0 * i as f64 / columns as f64),
                [j, j + 1].map(|j| last * j as f64 / rows as f64),
            );
            let corners = [(c[0], g[0]), (c[1], g[0]), (c[1], g[1]), (c[0], g[1])].map(|(c, g)| point(c, g));
            let share = corners.iter().map(|p| p.1).sum::<f64>() / 4.0;
            if share < 1e-4 {
                continue;
            }
            let (p, q) = (
                difference(corners[2].0, corners[0].0),
                difference(corners[3].0, corners[1].0),
            );
            let normal = [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ];
            let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
            // Light from the viewer's upper left; both sides of a face alike.
            let light = [-0.35, -0.75, 0.55];
            let illuminated = if length > 0.0 {
                (normal.iter().zip(light).map(|(n, l)| n * l).sum::<f64>() / length).abs()
            } else {
                0.5
            };
            let projected = corners.map(|p| project(p.0));
            let depth = projected.iter().map(|p| p.1).sum::<f64>() / 4.0;
            let fill = shade(0.12 + 0.72 * share).map(|v| (f64::from(v) * (0.62 + 0.38 * illuminated)).round() as u8);
            faces.push((depth, projected.map(|p| p.0), fill));
        }
    }
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, corners, [r, g, b]) in faces {
        let path: Vec<String> = corners.iter().map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
        svg.raw(&format!(
            r##"<path d="M{}Z" fill="#{r:02x}{g:02x}{b:02x}" stroke="#{r:02x}{g:02x}{b:02x}" stroke-width="0.5"/>"##,
            path.join("L")
        ));
    }
    for (end, name) in axes {
        let label = project(end.map(|v| 1.16 * v)).0;
        svg.text((label.0, label.1 + 4.5), Anchor::Middle, colour::INK, name);
    }
    let note = format!(
        "largest radius {} {unit}",
        number((high * factor * 10.0).round() / 10.0)
    );
    svg.text((16.0, HEIGHT - 10.0), Anchor::Start, colour::INK, &note);
    svg.finish()
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
