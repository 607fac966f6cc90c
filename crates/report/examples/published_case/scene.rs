//! Lamp, sensor and unit of the published case.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::source::{LightSource, Shape};
use isolux_sim::table::IntensityTable;
use isolux_spectrum::Spectrum;

use crate::Book;

/// Luminous efficacy of radiation that the published means imply, lm/W: an assumption, no measurement.
pub(crate) const LER: f64 = 255.1;
/// Luminous flux of the published lamp.
pub(crate) const FLUX_LM: f64 = 337.0;
/// Axial intensity per lumen of the lobe.
pub(crate) const AXIAL_CD_PER_LM: f64 = 0.995;

/// One published row: pixels a side, rays, mean and maximum in W/m².
pub(crate) struct Published {
    pub pixels: usize,
    pub rays: u64,
    pub mean: f64,
    pub max: f64,
}

/// The published table.
pub(crate) const PUBLISHED: [Published; 4] = [
    Published {
        pixels: 2048,
        rays: 200_000,
        mean: 5.07,
        max: 5096.2,
    },
    Published {
        pixels: 2048,
        rays: 2_000_000_000,
        mean: 5.38,
        max: 11.95,
    },
    Published {
        pixels: 1024,
        rays: 200_000,
        mean: 5.05,
        max: 2548.1,
    },
    Published {
        pixels: 1024,
        rays: 2_000_000_000,
        mean: 5.25,
        max: 8.58,
    },
];

impl Published {
    /// `2048², 2·10⁵` for a table.
    pub fn name(&self) -> String {
        let rays = if self.rays == 200_000 { "2·10⁵" } else { "2·10⁹" };
        format!("{}², {rays}", self.pixels)
    }
}

/// A lobe cosⁿγ with the published flux; `askew` leans it to one side and makes it elliptic, for the sweep of
/// half-planes.
pub(crate) fn lamp(c_step: f64, gamma_step: f64, askew: f64) -> IntensityDistribution {
    let n = std::f64::consts::TAU * AXIAL_CD_PER_LM - 1.0;
    let c_deg: Vec<f64> = if askew == 0.0 {
        vec![0.0]
    } else {
        (0..(360.0 / c_step) as u32).map(|k| f64::from(k) * c_step).collect()
    };
    let gamma_deg: Vec<f64> = (0..=(90.0 / gamma_step) as u32)
        .map(|k| f64::from(k) * gamma_step)
        .collect();
    let mut intensity = Vec::new();
    for c in &c_deg {
        for g in &gamma_deg {
            let (sin, cos) = g.to_radians().sin_cos();
            // Turned by 20°, so that no step of the sweep meets the lobe's own symmetry.
            let c = (c - 20.0).to_radians();
            let shape = 1.0 + askew * (sin * c.cos() + 2.0 * sin * sin * (2.0 * c).cos());
            intensity.push(cos.max(0.0).powf(n) * shape);
        }
    }
    IntensityDistribution::new(c_deg, gamma_deg, intensity)
        .and_then(|lamp| lamp.scaled_to_flux_lm(FLUX_LM))
        .expect("a lobe")
}

/// The lamp's light from the disc of 1 mm.
pub(crate) fn source(lamp: &IntensityDistribution) -> LightSource {
    LightSource::single(
        Arc::new(IntensityTable::new(lamp)),
        Shape::Disc {
            centre: DVec3::ZERO,
            radius: 0.5,
        },
    )
}

/// A square sensor that faces the lamp.
pub(crate) fn sensor(side_mm: f64, pixels: usize, distance_mm: f64) -> Sensor {
    Sensor::new(&Pose {
        size_mm: [side_mm; 2],
        pixels: [pixels; 2],
        distance_mm,
        tilt_x_deg: 0.0,
        tilt_y_deg: 0.0,
        rot_z_deg: 0.0,
        offset_mm: [0.0; 2],
    })
    .expect("a sensor")
}

/// The efficacy that the published means imply, and efficacies of spectra.
pub(crate) fn efficacy(book: &mut Book) {
    let lux = |axial: f64| FLUX_LM * axial / 0.25;
    let mut text = String::from(
        "## The luminous efficacy that the means imply\n\nK = E_v / E_e, with E_v = 337 lm · 1000 cd/klm / (0.5 m)² = 1348 lx on the axis:\n\n\
         | published mean | K for 1000 cd/klm | K for 995 cd/klm |\n|---|---|---|\n",
    );
    for mean in [5.38, 5.25] {
        let _ = writeln!(
            text,
            "| {mean} W/m² | {:.1} lm/W | {:.1} lm/W |",
            lux(1.0) / mean,
            lux(AXIAL_CD_PER_LM) / mean
        );
    }
    text.push_str("\nSpectra, summed at 1 nm over 360–830 nm, and the irradiance that the same 1348 lx would be with each:\n\n| spectrum | K | irradiance |\n|---|---|---|\n");
    for (name, spectrum) in spectra() {
        let ler = spectrum.ler_lm_per_w().unwrap_or(f64::NAN);
        let _ = writeln!(text, "| {name} | {ler:.1} lm/W | {:.3} W/m² |", lux(1.0) / ler);
    }
    text.push_str(
        "\nCIE LED-B1 to LED-B5 have 305–319 lm/W. A cool white with an honest blue peak therefore reads 4.2–4.4 W/m² here, and nothing is tuned to \
         the published 5.3; why the published efficacy lies 16–20 % below such LEDs stays open.\n",
    );
    book.write(&text);
}

/// Spectra by closed forms: black bodies, equal energy, and a blue peak with a phosphor band.
pub(crate) fn spectra() -> Vec<(String, Spectrum)> {
    let nm: Vec<f64> = (360..=830).map(f64::from).collect();
    let of = |law: &dyn Fn(f64) -> f64| {
        Spectrum::new(nm.clone(), nm.iter().map(|nm| law(*nm)).collect()).expect("wavelengths that rise")
    };
    let planck = |kelvin: f64| move |nm: f64| (nm / 560.0).powi(-5) / ((1.438_776_877e7 / (nm * kelvin)).exp() - 1.0);
    let bell = |nm: f64, centre: f64, width: f64| (-0.5 * ((nm - centre) / width).powi(2)).exp();
    // 460 nm chip, phosphor at 560 nm; the ratio of the peaks makes it colder or warmer.
    let white = |blue: f64| move |nm: f64| blue * bell(nm, 460.0, 11.0) + bell(nm, 560.0, 55.0);
    vec![
        ("black body 2856 K".to_owned(), of(&planck(2856.0))),
        ("black body 6500 K".to_owned(), of(&planck(6500.0))),
        ("equal energy".to_owned(), of(&|_| 1.0)),
        ("460 nm peak and phosphor, 1 : 1".to_owned(), of(&white(1.0))),
        ("460 nm peak and phosphor, 2 : 1".to_owned(), of(&white(2.0))),
        ("460 nm peak and phosphor, 4 : 1".to_owned(), of(&white(4.0))),
    ]
}
