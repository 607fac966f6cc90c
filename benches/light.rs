//! Times of the solvers on the published scene (337 lm, sensor 24.576 mm at 500 mm, 2048² pixels), as JSON on standard
//! output: seconds of each repetition. `tests/peers/light.sh` runs it beside other programs.
//!
//!     cargo bench -p isolux-sim --bench light -- FOLDER [REPETITIONS]
//!
//! FOLDER receives the table of intensities and the reference map, so that every program works on the same numbers.

#![expect(clippy::print_stdout, reason = "a program to run by hand")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::source::{Shape, Source};
use isolux_sim::table::Table;
use isolux_sim::{direct, inverse};
use isolux_units::Lumen;

const PIXELS: usize = 2048;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut given = std::env::args().skip(1).filter(|word| !word.starts_with("--"));
    let folder = given.next().unwrap_or_else(|| "target/light".to_owned());
    let repetitions: usize = given.next().map_or(Ok(7), |word| word.parse())?;
    let lamp = lamp()?;
    let table = Arc::new(Table::new(&lamp));
    let point = Source::single(Arc::clone(&table), Shape::Point(DVec3::ZERO));
    let disc = Source::single(
        table,
        Shape::Disc {
            centre: DVec3::ZERO,
            radius: 0.5,
        },
    );
    let sensor = Sensor::new(&Pose {
        size_mm: [24.576; 2],
        pixels: [PIXELS; 2],
        distance_mm: 500.0,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: 0.0,
        offset_mm: [0.0; 2],
    })?;
    write(Path::new(&folder), &lamp, &point, &disc, &sensor)?;
    let time = |name: &str, work: &dyn Fn()| {
        work();
        let seconds: Vec<String> = (0..repetitions)
            .map(|_| {
                let start = Instant::now();
                work();
                format!("{:.6}", start.elapsed().as_secs_f64())
            })
            .collect();
        println!("{{\"name\": \"{name}\", \"seconds\": [{}]}}", seconds.join(", "));
    };
    // Into memory that is used again, as the other programs' own allocators do.
    let wide = std::cell::RefCell::new(vec![0.0_f64; sensor.pixels()]);
    let single = std::cell::RefCell::new(vec![0.0_f32; sensor.pixels()]);
    for (name, source) in [("inverse point", &point), ("inverse disc", &disc)] {
        time(name, &|| {
            black_box(inverse::solve_into(source, &sensor, &mut wide.borrow_mut()));
        });
    }
    for (name, source) in [("inverse f32 point", &point), ("inverse f32 disc", &disc)] {
        time(name, &|| {
            black_box(inverse::solve_into(source, &sensor, &mut single.borrow_mut()));
        });
    }
    time("traced 1e8", &|| {
        black_box(direct::traced(&disc, &sensor, 100_000_000, 1).ok());
    });
    time("thinned 2e9", &|| {
        black_box(direct::thinned(&disc, &sensor, 2_000_000_000, 1).ok());
    });
    let map = inverse::solve(&disc, &sensor).illuminance_lx;
    time("expected 2e9", &|| {
        black_box(direct::expected(&disc, &sensor, &map, 2_000_000_000, 1).ok());
    });
    Ok(())
}

/// cosⁿγ of 337 lm and 995 cd/klm on the axis, 2 % elliptic, every 15° of C and 1° of γ.
fn lamp() -> Result<IntensityDistribution, Box<dyn std::error::Error>> {
    let n = std::f64::consts::TAU * 0.995 - 1.0;
    let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
    let gamma_deg: Vec<f64> = (0..=90).map(f64::from).collect();
    let mut intensity_cd = Vec::new();
    for c in &c_deg {
        for g in &gamma_deg {
            let (sin, cos) = g.to_radians().sin_cos();
            let ellipse = 1.0 + 0.02 * sin * sin * (2.0 * c.to_radians()).cos();
            intensity_cd.push(cos.max(0.0).powf(n) * ellipse);
        }
    }
    Ok(IntensityDistribution::new(c_deg, gamma_deg, intensity_cd)?.scaled_to_flux(Lumen::new(337.0)?)?)
}

/// `table.f64` (C plane after C plane), and rows 0, 64, 128 … of the reference maps (each pixel by itself), lx.
fn write(
    folder: &Path,
    lamp: &IntensityDistribution,
    point: &Source,
    disc: &Source,
    sensor: &Sensor,
) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;
    let bytes = |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    std::fs::write(folder.join("table.f64"), bytes(lamp.intensity_cd()))?;
    for (name, source) in [("point", point), ("disc", disc)] {
        let map = inverse::solve(source, sensor).illuminance_lx;
        std::fs::write(folder.join(format!("ours-{name}.f64")), bytes(&map))?;
        let mut single = vec![0.0_f32; sensor.pixels()];
        let bound = inverse::solve_into(source, sensor, &mut single);
        println!("{{\"bound\": \"{name}\", \"largest\": {:e}}}", bound.largest);
        let wide: Vec<f64> = single.iter().map(|value| f64::from(*value)).collect();
        std::fs::write(folder.join(format!("ours-f32-{name}.f64")), bytes(&wide))?;
        let mut rows = Vec::new();
        for row in (0..PIXELS).step_by(64) {
            let line = Sensor {
                corner: sensor.point(0.0, row as f64),
                ny: 1,
                ..*sensor
            };
            rows.extend(inverse::solve_each(source, &line).illuminance_lx);
        }
        std::fs::write(folder.join(format!("reference-{name}.f64")), bytes(&rows))?;
    }
    Ok(())
}
