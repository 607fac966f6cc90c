//! The inverse solver against closed forms and against brute force with another interpolation kernel.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_sim::inverse::{self, Accuracy, Map};
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::source::{LightSource, Shape};
use isolux_sim::table::IntensityTable;

fn pose(size_mm: f64, pixels: usize, distance_mm: f64) -> Pose {
    Pose {
        size_mm: [size_mm; 2],
        pixels: [pixels; 2],
        distance_mm,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: 0.0,
        offset_mm: [0.0; 2],
    }
}

/// A lobe without symmetry on a coarse, uneven grid, with values that differ at the pole.
fn rough() -> IntensityDistribution {
    let c_deg = vec![0.0, 20.0, 65.0, 90.0, 150.0, 210.0, 275.0, 330.0];
    let gamma_deg = vec![0.0, 2.0, 5.0, 11.0, 20.0, 33.0, 50.0, 71.0, 90.0, 130.0, 180.0];
    let intensity_cd = c_deg
        .iter()
        .flat_map(|c: &f64| {
            gamma_deg.iter().map(|g: &f64| {
                300.0 + 700.0 * (-(g / 30.0).powi(2)).exp() * (1.0 + 0.4 * (c.to_radians() + g / 20.0).cos())
            })
        })
        .collect();
    IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
}

fn disc(distribution: &IntensityDistribution, radius: f64) -> LightSource {
    LightSource::single(
        Arc::new(IntensityTable::new(distribution)),
        Shape::Disc {
            centre: DVec3::ZERO,
            radius,
        },
    )
}

/// Midpoint sums over `n` × `n` parts of the pixel and `rings` × 4·`rings` parts of the disc.
fn brute(
    distribution: &IntensityDistribution,
    sensor: &Sensor,
    ix: usize,
    iy: usize,
    radius: f64,
    n: usize,
    rings: usize,
) -> f64 {
    let mut sum = 0.0;
    let spokes = 4 * rings;
    for i in 0..n {
        for j in 0..n {
            let p = sensor.point(
                ix as f64 + (i as f64 + 0.5) / n as f64,
                iy as f64 + (j as f64 + 0.5) / n as f64,
            );
            for ring in 0..rings {
                let r = radius * ((ring as f64 + 0.5) / rings as f64).sqrt();
                for spoke in 0..spokes {
                    let (sin, cos) = (TAU * (spoke as f64 + 0.37 * ring as f64) / spokes as f64).sin_cos();
                    let v = p - DVec3::new(r * cos, r * sin, 0.0);
                    sum += 1e6 * distribution.toward(v) * sensor.toward.dot(v) / v.length().powi(3);
                }
            }
        }
    }
    sum / (n * n * rings * spokes) as f64
}

fn reference(source: &LightSource, sensor: &Sensor) -> Map {
    inverse::solve(source, sensor, Accuracy::Reference)
}

#[test]
fn a_point_source_on_the_axis_obeys_the_inverse_square_law() {
    // Isotropic 100 cd over a pixel: the exact solid angle of a square is 4·asin(s²/(s² + 4 d²)) for side s.
    let isotropic = IntensityDistribution::new(vec![0.0], vec![0.0, 180.0], vec![100.0; 2]).unwrap();
    let sensor = Sensor::new(&pose(400.0, 1, 100.0)).unwrap();
    let map = reference(
        &LightSource::single(Arc::new(IntensityTable::new(&isotropic)), Shape::Point(DVec3::ZERO)),
        &sensor,
    );
    let solid_angle = 4.0 * (1.6e5_f64 / (1.6e5 + 4.0e4)).asin();
    let expected = 100.0 * solid_angle / 0.16;
    assert!(
        (map.illuminance_lx[0] / expected - 1.0).abs() < 1e-9,
        "{} {expected}",
        map.illuminance_lx[0]
    );
}

#[test]
fn a_lambertian_disc_obeys_its_form_factor() {
    // Point on the axis of a Lambertian disc of radius a, intensity I0·cos γ: E = I0/(a² + d²). The table is dense
    // enough for its own interpolation error, 1/8·Δγ², to stay below 1e-6.
    let gamma_deg: Vec<f64> = (0..=3600).map(|i| f64::from(i) * 0.025).collect();
    let intensity = gamma_deg.iter().map(|g| 250.0 * g.to_radians().cos()).collect();
    let lambert = IntensityDistribution::new(vec![0.0], gamma_deg, intensity).unwrap();
    for (radius, distance) in [(0.5, 500.0), (20.0, 30.0)] {
        let sensor = Sensor::new(&pose(1e-3, 1, distance)).unwrap();
        let map = reference(&disc(&lambert, radius), &sensor);
        let expected = 1e6 * 250.0 / (radius * radius + distance * distance);
        assert!(
            (map.illuminance_lx[0] / expected - 1.0).abs() < 1e-6,
            "{} {expected}",
            map.illuminance_lx[0]
        );
    }
}

#[test]
fn agrees_with_brute_force_tilted_shifted_and_across_kinks() {
    let distribution = rough();
    let tilted = Pose {
        tilt_x_deg: 25.0,
        tilt_y_deg: -35.0,
        rot_z_deg: 70.0,
        offset_mm: [12.0, -7.0],
        ..pose(60.0, 8, 60.0)
    };
    for (radius, pose) in [
        (0.5, tilted),
        (8.0, tilted),
        (4.0, pose(24.0, 8, 40.0)),
        (0.5, pose(60.0, 7, 90.0)),
    ] {
        let sensor = Sensor::new(&pose).unwrap();
        let map = inverse::solve_each(&disc(&distribution, radius), &sensor);
        let pixel = sensor.step_x.length();
        let (n, rings) = if pixel > radius { (64, 4) } else { (24, 24) };
        // Brute force cannot follow values that differ at the pole: the pixels stay clear of it.
        for (ix, iy) in [(0, 0), (6, 2), (1, 5)] {
            let expected = brute(&distribution, &sensor, ix, iy, radius, n, rings);
            let found = map.illuminance_lx[iy * sensor.nx + ix];
            assert!(
                (found / expected - 1.0).abs() < 2e-5,
                "pixel {ix} {iy} radius {radius}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_closed_box_receives_the_flux() {
    // Six sensors round the lamp, each pixel's mean times its area: nothing may be lost between the faces.
    let distribution = rough();
    let flux = distribution.flux_lm();
    for radius in [0.0, 5.0] {
        let source = if radius == 0.0 {
            LightSource::single(Arc::new(IntensityTable::new(&distribution)), Shape::Point(DVec3::ZERO))
        } else {
            disc(&distribution, radius)
        };
        let half = 50.0;
        let mut caught = 0.0;
        for (tilt_x_deg, tilt_y_deg) in [
            (0.0, 0.0),
            (180.0, 0.0),
            (90.0, 0.0),
            (-90.0, 0.0),
            (0.0, 90.0),
            (0.0, -90.0),
        ] {
            let face = Pose {
                tilt_x_deg,
                tilt_y_deg,
                ..pose(2.0 * half, 3, 0.0)
            };
            let toward = Sensor::new(&face).unwrap().toward * half;
            let face = Pose {
                distance_mm: toward.z,
                offset_mm: [toward.x, toward.y],
                ..face
            };
            let sensor = Sensor::new(&face).unwrap();
            let map = reference(&source, &sensor);
            caught += map.illuminance_lx.iter().sum::<f64>() * sensor.pixel_area_m2();
        }
        assert!(
            (caught / flux - 1.0).abs() < 1e-6,
            "radius {radius}: {caught} lm of {flux} lm"
        );
    }
}

#[test]
fn tiles_change_nothing() {
    let distribution = rough();
    let sensor = Sensor::new(&Pose {
        tilt_x_deg: 10.0,
        offset_mm: [3.0, 2.0],
        ..pose(10.0, 32, 150.0)
    })
    .unwrap();
    let source = disc(&distribution, 0.5);
    let (tiled, each) = (reference(&source, &sensor), inverse::solve_each(&source, &sensor));
    for (a, b) in tiled.illuminance_lx.iter().zip(&each.illuminance_lx) {
        assert!((a / b - 1.0).abs() < 3e-6, "{a} {b}");
    }
}

/// Smooth in C as a ring illuminator is: 15° planes, 2° in γ, 2 % elliptic, equal at the pole.
fn ring_illuminator(exponent: f64) -> IntensityDistribution {
    let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let gamma_deg: Vec<f64> = (0..=45).map(|k| 2.0 * f64::from(k)).collect();
    let intensity_cd = c_deg
        .iter()
        .flat_map(|c| {
            gamma_deg.iter().map(move |g| {
                let (sin, cos) = g.to_radians().sin_cos();
                335.0 * cos.max(0.0).powf(exponent) * (1.0 + 0.02 * sin * (2.0 * c.to_radians()).cos())
            })
        })
        .collect();
    IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
}

#[test]
fn both_accuracies_keep_to_the_bounds_that_they_state() {
    let smooth = ring_illuminator(5.3);
    let narrow = ring_illuminator(60.0);
    let uneven = rough();
    let rotational =
        IntensityDistribution::new(vec![0.0], smooth.gamma_deg().to_vec(), smooth.row(0).to_vec()).unwrap();
    let tilted = Pose {
        tilt_x_deg: 20.0,
        tilt_y_deg: -12.0,
        rot_z_deg: 33.0,
        offset_mm: [40.0, -15.0],
        ..pose(24.576, 256, 500.0)
    };
    let point = Shape::Point(DVec3::ZERO);
    let disc = Shape::Disc {
        centre: DVec3::ZERO,
        radius: 0.5,
    };
    let cases: [(&str, &IntensityDistribution, Shape, Pose); 9] = [
        ("point", &smooth, point, pose(24.576, 512, 500.0)),
        ("point, tilted", &smooth, point, tilted),
        ("point, narrow lobe", &narrow, point, pose(60.0, 256, 500.0)),
        ("point, rotational", &rotational, point, pose(24.576, 256, 300.0)),
        ("point, near", &smooth, point, pose(24.576, 256, 40.0)),
        (
            "point, values that differ at the pole",
            &uneven,
            point,
            pose(24.576, 64, 200.0),
        ),
        ("disc", &smooth, disc, pose(24.576, 256, 500.0)),
        ("disc, tilted", &smooth, disc, tilted),
        ("disc, rotational", &rotational, disc, pose(24.576, 128, 300.0)),
    ];
    for (name, distribution, shape, pose) in cases {
        let source = LightSource::single(Arc::new(IntensityTable::new(distribution)), shape);
        let sensor = Sensor::new(&pose).unwrap();
        let quick = inverse::solve(&source, &sensor, Accuracy::Standard);
        assert!(quick.bound.of_allowed <= 1.0, "{name}: {:?}", quick.bound);
        let slow = reference(&source, &sensor);
        assert!(slow.bound.largest <= 1e-6, "{name}, reference: {:?}", slow.bound);
        // Whole rows of pixels, each by itself, and single pixels round the axis.
        let (mut worst, mut worst_slow, mut sum) = (0.0_f64, 0.0_f64, 0.0);
        let middle = sensor.ny / 2;
        let step = if matches!(shape, Shape::Point(_)) { 1 } else { 11 };
        for iy in [0, sensor.ny / 3, middle - 1, middle, sensor.ny - 2] {
            for ix in (0..sensor.nx).step_by(step) {
                let pixel = Sensor {
                    corner: sensor.point(ix as f64, iy as f64),
                    nx: 1,
                    ny: 1,
                    ..sensor
                };
                let truth = inverse::solve_each(&source, &pixel).illuminance_lx[0];
                let index = iy * sensor.nx + ix;
                worst = worst.max((quick.illuminance_lx[index] / truth - 1.0).abs());
                worst_slow = worst_slow.max((slow.illuminance_lx[index] / truth - 1.0).abs());
                sum += truth;
            }
        }
        assert!(
            worst <= quick.bound.largest,
            "{name}: {worst:e} beyond {:?}",
            quick.bound
        );
        assert!(worst < 5e-6, "{name}: {worst:e}");
        assert!(
            worst_slow <= slow.bound.largest && worst_slow < 2e-7,
            "{name}, reference: {worst_slow:e} beyond {:?}",
            slow.bound
        );
        assert!(sum > 0.0, "{name} is dark");
    }
}

#[test]
fn leds_are_the_sum_of_their_points() {
    let distribution = ring_illuminator(5.3);
    let table = Arc::new(IntensityTable::new(&distribution));
    let leds = 5;
    let part = |k: i32, share: f64| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(leds)).sin_cos();
        isolux_sim::source::Part {
            share,
            shape: Shape::Point(DVec3::new(17.0 * cos, 17.0 * sin, 0.0)),
            table: Arc::clone(&table),
            aim: None,
        }
    };
    let sensor = Sensor::new(&pose(24.576, 512, 150.0)).unwrap();
    let ring = LightSource::new((0..leds).map(|k| part(k, 1.0 / f64::from(leds))).collect());
    let all = reference(&ring, &sensor);
    let mut sum = vec![0.0; sensor.pixels()];
    for k in 0..leds {
        let one = reference(&LightSource::new(vec![part(k, 1.0 / f64::from(leds))]), &sensor);
        sum.iter_mut()
            .zip(one.illuminance_lx)
            .for_each(|(sum, one)| *sum += one);
    }
    for (a, b) in all.illuminance_lx.iter().zip(&sum) {
        let off = (a / b - 1.0).abs();
        assert!(off < 1e-6 && off <= all.bound.largest, "{a} {b} {:?}", all.bound);
    }
}

#[test]
fn a_ring_is_the_mean_of_its_points() {
    let distribution = rough();
    let table = Arc::new(IntensityTable::new(&distribution));
    let sensor = Sensor::new(&pose(10.0, 2, 80.0)).unwrap();
    let found = reference(
        &LightSource::single(
            Arc::clone(&table),
            Shape::Ring {
                centre: DVec3::ZERO,
                inner: 22.0,
                outer: 34.0,
            },
        ),
        &sensor,
    );
    let mut sum = 0.0;
    let (rings, spokes) = (20, 720);
    for ring in 0..rings {
        let r = (22.0_f64.powi(2) + (34.0_f64.powi(2) - 22.0_f64.powi(2)) * (f64::from(ring) + 0.5) / f64::from(rings))
            .sqrt();
        for spoke in 0..spokes {
            let (sin, cos) = (2.0 * PI * f64::from(spoke) / f64::from(spokes)).sin_cos();
            for part in 0..36 {
                let (s, t) = ((f64::from(part % 6) + 0.5) / 6.0, (f64::from(part / 6) + 0.5) / 6.0);
                let v = sensor.point(s, t) - DVec3::new(r * cos, r * sin, 0.0);
                sum += 1e6 * distribution.toward(v) * v.z / v.length().powi(3);
            }
        }
    }
    let expected = sum / f64::from(rings * spokes * 36);
    assert!(
        (found.illuminance_lx[0] / expected - 1.0).abs() < 3e-5,
        "{} {expected}",
        found.illuminance_lx[0]
    );
}

#[test]
fn outlines_and_chords_agree_on_near_emitters() {
    // Two ways that share neither coordinates nor rules.
    let centre = DVec3::ZERO;
    let shapes = [
        Shape::Disc { centre, radius: 15.0 },
        Shape::Ring {
            centre,
            inner: 11.0,
            outer: 17.0,
        },
        Shape::Rectangle {
            centre,
            half: [12.0, 5.0],
        },
    ];
    let tilted = Pose {
        tilt_x_deg: 50.0,
        tilt_y_deg: -20.0,
        rot_z_deg: 10.0,
        offset_mm: [14.0, -9.0],
        ..pose(10.0, 1, 40.0)
    };
    let table = Arc::new(IntensityTable::new(&rough()));
    for shape in shapes {
        for pose in [pose(6.0, 1, 20.0), tilted] {
            let source = LightSource::single(Arc::clone(&table), shape);
            let sensor = Sensor::new(&pose).unwrap();
            let (outlines, chords) = (reference(&source, &sensor), inverse::solve_each(&source, &sensor));
            for (a, b) in outlines.illuminance_lx.iter().zip(&chords.illuminance_lx) {
                assert!((a / b - 1.0).abs() < 1.5e-6, "{shape:?} {pose:?}: {a} {b}");
            }
            let mean = outlines.illuminance_lx[0];
            assert!(
                outlines.bound.mean_lx < 1e-6 * mean,
                "{shape:?}: bound {}",
                outlines.bound.mean_lx / mean
            );
        }
    }
}

#[test]
fn a_thin_ring_near_the_sensor_obeys_its_closed_form() {
    // Lambertian annulus a < r < b, point on its axis at d: E = I0·d²/((a² + d²)(b² + d²)).
    let gamma_deg: Vec<f64> = (0..=3600).map(|i| f64::from(i) * 0.025).collect();
    let intensity = gamma_deg.iter().map(|g| 250.0 * g.to_radians().cos()).collect();
    let lambert = IntensityDistribution::new(vec![0.0], gamma_deg, intensity).unwrap();
    for (inner, outer, distance) in [(11.0, 17.0, 20.0), (16.5, 17.0, 40.0)] {
        let ring = LightSource::single(
            Arc::new(IntensityTable::new(&lambert)),
            Shape::Ring {
                centre: DVec3::ZERO,
                inner,
                outer,
            },
        );
        let map = reference(&ring, &Sensor::new(&pose(1e-3, 1, distance)).unwrap());
        let square = distance * distance;
        let expected = 1e6 * 250.0 * square / ((inner * inner + square) * (outer * outer + square));
        let found = map.illuminance_lx[0] / expected - 1.0;
        assert!(found.abs() < 1e-6, "{inner} to {outer} mm at {distance} mm: {found:e}");
    }
}

#[test]
fn a_pixel_whose_middle_is_dark_is_bounded_and_soon_done() {
    // 100 cd within a cone of 30°, dark beyond; the pixel's middle lies outside, one side inside.
    let cone = IntensityDistribution::new(vec![0.0], vec![0.0, 30.0], vec![100.0; 2]).unwrap();
    let distance = 100.0;
    let mut pose = pose(40.0, 1, distance);
    let edge = distance * 30.0_f64.to_radians().tan();
    pose.offset_mm = [edge + 10.0, 3.0];
    let sensor = Sensor::new(&pose).unwrap();
    for shape in [
        Shape::Point(DVec3::ZERO),
        Shape::Disc {
            centre: DVec3::ZERO,
            radius: 2.0,
        },
    ] {
        let map = reference(
            &LightSource::single(Arc::new(IntensityTable::new(&cone)), shape),
            &sensor,
        );
        // Rows of the pixel in closed form for a point, ∫ d/(x² + y² + d²)^(3/2) dx; spots of the disc by brute
        // force.
        let of = |spot: DVec3| {
            let rows = 4000;
            let mut sum = 0.0;
            for row in 0..rows {
                let y = 3.0 - spot.y + 40.0 * ((f64::from(row) + 0.5) / f64::from(rows) - 0.5);
                let end = (edge * edge - y * y).max(0.0).sqrt();
                let (from, to) = (edge - 10.0 - spot.x, edge + 30.0 - spot.x);
                let primitive = |x: f64| {
                    distance * x / ((y * y + distance * distance) * (x * x + y * y + distance * distance).sqrt())
                };
                sum += (primitive(to.min(end)) - primitive(from.max(-end).min(end))).max(0.0);
            }
            1e8 * sum / (40.0 * f64::from(rows))
        };
        let radius = shape.radius();
        let mut expected = 0.0;
        let (rings, spokes) = if radius > 0.0 { (12, 48) } else { (1, 1) };
        for ring in 0..rings {
            for spoke in 0..spokes {
                let r = radius * ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
                let (sin, cos) = (TAU * (f64::from(spoke) + 0.5) / f64::from(spokes)).sin_cos();
                expected += of(DVec3::new(r * cos, r * sin, 0.0)) / f64::from(rings * spokes);
            }
        }
        let found = map.illuminance_lx[0] / expected - 1.0;
        assert!(found.abs() < 2e-5, "{shape:?}: {found:e}");
        assert!(
            map.bound.mean_lx < 6e-6 * expected,
            "{shape:?}: bound {}",
            map.bound.mean_lx / expected
        );
    }
}

#[test]
fn light_behind_the_plane_of_an_emitter_is_that_of_a_mirror() {
    // A lamp that shines backwards as it does forwards lights a sensor behind it as one before it.
    let gamma_deg: Vec<f64> = (0..=36).map(|k| 5.0 * f64::from(k)).collect();
    let intensity = |k: usize| 100.0 + 50.0 * (gamma_deg[k].min(180.0 - gamma_deg[k]) / 30.0).cos();
    let lamp: Vec<f64> = (0..37).map(intensity).collect();
    let even = IntensityDistribution::new(vec![0.0], gamma_deg, lamp).unwrap();
    let source = disc(&even, 10.0);
    let sensor = |tilt_x_deg: f64| {
        Sensor::new(&Pose {
            tilt_x_deg,
            offset_mm: [0.0, -60.0],
            ..pose(30.0, 8, 40.0)
        })
        .unwrap()
    };
    let front = sensor(50.0);
    let turned = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
    let back = Sensor {
        corner: turned(front.corner),
        step_x: turned(front.step_x),
        step_y: turned(front.step_y),
        toward: turned(front.toward),
        ..front
    };
    for accuracy in [Accuracy::Standard, Accuracy::Reference] {
        let [front, back] = [&front, &back].map(|sensor| inverse::solve(&source, sensor, accuracy));
        for (a, b) in front.illuminance_lx.iter().zip(&back.illuminance_lx) {
            assert!((a / b - 1.0).abs() < 1e-5 && *a > 0.0, "{accuracy:?}: {a} {b}");
        }
    }
}
