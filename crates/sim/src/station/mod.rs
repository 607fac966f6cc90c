//! What stands beside the direct path (`isolux_model::optics`), as factors of a pixel and as a change of the spectrum.
//! Every part has a closed form; `crate::optics` holds them and tests them.

mod mesh;
mod mixture;

use glam::DVec3;
use isolux_model::optics::{Lens, Optics, Share, Target, Vapour, Window};
use isolux_photometry::angles_deg;
use isolux_spectrum::Spectrum;

use rayon::prelude::*;

use self::mesh::Mesh;
use self::mixture::Mixture;
use crate::optics;
use crate::sensor::Sensor;

/// Why the parts of a scene do not fit its lamp.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StationError {
    /// A spectral part before a lamp without spectrum.
    #[error("{part} depends on the wavelength, and the model has no spectrum: give luminaire.spectrum")]
    NoSpectrum {
        /// Which part.
        part: &'static str,
    },
    /// All power is outside what the parts let through or know.
    #[error("no light is left of the lamp's spectrum behind {part}")]
    Dark {
        /// Which part.
        part: &'static str,
    },
}

/// The parts of a scene made ready for a lamp.
#[derive(Debug, Clone)]
pub struct Station {
    optics: Optics,
    /// The lamp's spectrum on γ = 0, where it is known.
    lamp: Option<Spectrum>,
    /// Without a spectrum or efficacy the map is in lx.
    radiometric: bool,
}

/// Wavelengths at 1 nm.
const FROM_NM: u32 = 360;
const TO_NM: u32 = 830;
const TABLE: usize = (TO_NM - FROM_NM + 1) as usize;

/// Places along each side of the sensor for the mean of its spectrum.
const RASTER: usize = 16;

impl Station {
    /// `None` where the scene has nothing beside the direct path.
    ///
    /// # Errors
    /// [`StationError`] where a part needs a spectrum that the lamp has not.
    pub fn new(optics: &Optics, lamp: Option<&Spectrum>, radiometric: bool) -> Result<Option<Self>, StationError> {
        let empty = Optics {
            camera: optics.camera,
            ..Optics::default()
        };
        if *optics == empty {
            return Ok(None);
        }
        if lamp.is_none() {
            let spectral = |share: &Share| matches!(share, Share::Spectral(_));
            let part = if optics.windows.iter().any(|window| spectral(&window.transmittance)) {
                Some("window.transmittance")
            } else if optics.vapour.as_ref().is_some_and(|vapour| spectral(&vapour.epsilon)) {
                Some("vapour.epsilon_l_per_mol_cm")
            } else if optics.colour.is_some() {
                Some("colour")
            } else {
                None
            };
            if let Some(part) = part {
                return Err(StationError::NoSpectrum { part });
            }
        }
        let station = Self {
            optics: optics.clone(),
            lamp: lamp.cloned(),
            radiometric,
        };
        if let Some(lamp) = lamp
            && lamp.integral() > 0.0
            && station
                .spectrum(DVec3::Z, 1.0)
                .is_none_or(|behind| behind.integral() <= 0.0)
        {
            return Err(StationError::Dark {
                part: "the windows and the vapour",
            });
        }
        Ok(Some(station))
    }

    /// How much nearer the light seems through the plates, mm: Σ t·(1 − 1/n), for light near the normal.
    pub fn apparent_shift_mm(&self) -> f64 {
        self.optics
            .windows
            .iter()
            .map(|window| window.thickness_mm * (1.0 - window.index.recip()))
            .sum()
    }

    /// Factor of every pixel of `sensor` on what the direct path gives: mean over 2 × 2 Gauss points.
    pub fn factors(&self, sensor: &Sensor) -> Vec<f64> {
        let mixture = match (&self.lamp, self.radiometric) {
            (Some(lamp), true) => {
                // The direct path gives E_v / K of the lamp.
                let efficacy = lamp.luminous_integral() / lamp.integral();
                if let Some(colour) = &self.optics.colour {
                    Mixture::of_lamp(self, colour, sensor, efficacy, &|_| 1.0)
                } else {
                    let (per_nm, luminous) = (lamp.per_nm(), lamp.luminous_integral());
                    Mixture::of_one(Mesh::new(sensor, |place| {
                        let kept = self.kept(&per_nm, cosine(sensor, place), place.length(), &|_| 1.0);
                        efficacy * kept / luminous
                    }))
                }
            }
            // No spectrum: every part is grey.
            _ => Mixture::of_one(Mesh::new(sensor, |place| {
                self.grey(cosine(sensor, place), place.length())
            })),
        };
        let g = 0.5 / 3.0_f64.sqrt();
        let at = |x: f64, y: f64| mixture.at(sensor, x, y) * self.image(sensor, x, y);
        (0..sensor.pixels())
            .into_par_iter()
            .with_min_len(1024)
            .map(|index| {
                let (x, y) = ((index % sensor.nx) as f64 + 0.5, (index / sensor.nx) as f64 + 0.5);
                0.25 * (at(x - g, y - g) + at(x + g, y - g) + at(x - g, y + g) + at(x + g, y + g))
            })
            .collect()
    }

    /// The lamp's spectrum behind everything at the middle of the sensor, in the lamp's own scale, or with spectra over
    /// angle for one lumen; `None` without one.
    pub fn spectrum_at_centre(&self, sensor: &Sensor) -> Option<Spectrum> {
        let place = sensor.centre();
        self.spectrum(place, cosine(sensor, place))
    }

    /// The light towards a place, before windows and vapour, where the scene has spectra over angle.
    pub fn colour_at(&self, place: DVec3) -> Option<Spectrum> {
        let colour = self.optics.colour.as_ref()?;
        let (c_deg, gamma_deg) = angles_deg(place);
        at_1_nm(colour.at(c_deg, gamma_deg).into_iter())
    }

    /// ∫S·weight dλ behind everything over ∫S dλ there, for each pixel at its middle, where the scene has
    /// spectra over angle; `weight` by the wavelength in nm.
    pub fn per_watt(&self, sensor: &Sensor, weight: &dyn Fn(f64) -> f64) -> Option<Vec<f64>> {
        let colour = self.optics.colour.as_ref()?;
        let all = Mixture::of_lamp(self, colour, sensor, 1.0, &|_| 1.0);
        let weighted = Mixture::of_lamp(self, colour, sensor, 1.0, weight);
        let ratio = |index: usize| {
            let (x, y) = ((index % sensor.nx) as f64 + 0.5, (index / sensor.nx) as f64 + 0.5);
            let power = all.at(sensor, x, y);
            if power > 0.0 {
                weighted.at(sensor, x, y) / power
            } else {
                0.0
            }
        };
        let pixels = (0..sensor.pixels()).into_par_iter().with_min_len(1024);
        Some(pixels.map(ratio).collect())
    }

    /// Spectrum of the light on the sensor, its mean over `map` in W/m², at a raster of places, where the scene has
    /// spectra over angle; none where the map is dark.
    pub fn mean_spectrum(&self, sensor: &Sensor, map: &[f64]) -> Option<Spectrum> {
        self.optics.colour.as_ref()?;
        let place = |k: usize, pixels: usize| (2 * k + 1) * pixels / (2 * RASTER);
        let mut sum = [0.0; TABLE];
        for row in 0..RASTER {
            for column in 0..RASTER {
                let (ix, iy) = (place(column, sensor.nx), place(row, sensor.ny));
                let at = sensor.point(ix as f64 + 0.5, iy as f64 + 0.5);
                let there = self.spectrum(at, cosine(sensor, at))?;
                let power: f64 = there.value().iter().sum();
                if power > 0.0 {
                    let share = map[iy * sensor.nx + ix] / power;
                    sum.iter_mut()
                        .zip(there.value())
                        .for_each(|(sum, value)| *sum += share * value);
                }
            }
        }
        at_1_nm(sum.into_iter()).filter(|mean| mean.integral() > 0.0)
    }

    /// Whether what stands in the path takes the same of every ray.
    fn is_clear(&self) -> bool {
        self.optics.windows.is_empty() && self.optics.vapour.is_none()
    }

    /// Power behind windows and vapour of a spectrum given at 1 nm, each wavelength weighted.
    fn kept(&self, per_nm: &[f64], cos: f64, path_mm: f64, weight: &dyn Fn(f64) -> f64) -> f64 {
        (FROM_NM..=TO_NM)
            .map(f64::from)
            .zip(per_nm)
            .map(|(nm, value)| value * self.share_at(cos, path_mm, nm) * weight(nm))
            .sum()
    }

    /// What windows and vapour let through at one wavelength.
    fn share_at(&self, cos: f64, path_mm: f64, nm: f64) -> f64 {
        let windows: f64 = self
            .optics
            .windows
            .iter()
            .map(|window| through(window, cos, nm))
            .product();
        windows
            * self
                .optics
                .vapour
                .as_ref()
                .map_or(1.0, |vapour| behind(vapour, cos, path_mm, nm))
    }

    fn grey(&self, cos: f64, path_mm: f64) -> f64 {
        self.share_at(cos, path_mm, 555.0)
    }

    /// The light at a place behind everything.
    fn spectrum(&self, place: DVec3, cos: f64) -> Option<Spectrum> {
        let emitted = match &self.optics.colour {
            Some(_) => self.colour_at(place)?,
            None => self.lamp.clone()?,
        };
        let nm = (FROM_NM..=TO_NM).map(f64::from);
        at_1_nm(
            nm.zip(emitted.per_nm())
                .map(|(nm, value)| value * self.share_at(cos, place.length(), nm)),
        )
    }

    /// Target and lens: irradiance in the image over irradiance on the target; 1 without them.
    fn image(&self, sensor: &Sensor, x: f64, y: f64) -> f64 {
        let (Some(target), Some(lens)) = (&self.optics.target, &self.optics.lens) else {
            return 1.0;
        };
        let place = sensor.point(x, y);
        let field = ((place - sensor.centre()).length() / lens.distance_mm).atan();
        let radiance = match target {
            Target::Lambertian(rho) => optics::lambertian(*rho, 1.0),
            Target::Measured {
                incidence_deg,
                viewing_deg,
                brdf_per_sr,
            } => {
                let incidence = cosine(sensor, place).clamp(-1.0, 1.0).acos().to_degrees();
                bilinear(incidence_deg, viewing_deg, brdf_per_sr, incidence, field.to_degrees())
            }
        };
        seen(lens, radiance, field)
    }
}

/// Magnification of the image of a target at the lens's distance.
pub fn magnification(lens: &Lens) -> f64 {
    lens.focal_mm / (lens.distance_mm - lens.focal_mm)
}

fn seen(lens: &Lens, radiance: f64, field_rad: f64) -> f64 {
    let radius = 0.5 * lens.focal_mm / lens.f_number;
    optics::thin_lens(
        radiance,
        lens.transmittance,
        lens.f_number,
        magnification(lens),
        field_rad,
    ) * optics::overlap(lens.barrel_mm * field_rad.tan() / radius)
}

fn through(window: &Window, cos: f64, nm: f64) -> f64 {
    optics::plate(window.index, share(&window.transmittance, nm), cos.clamp(1e-9, 1.0)).transmitted
}

fn behind(vapour: &Vapour, cos: f64, path_mm: f64, nm: f64) -> f64 {
    let length_mm = vapour.length_mm.map_or(path_mm, |layer| layer / cos.max(1e-9));
    optics::beer_lambert(share(&vapour.epsilon, nm), vapour.concentration_mol_l, 0.1 * length_mm)
}

fn share(share: &Share, nm: f64) -> f64 {
    match share {
        Share::Grey(value) => *value,
        Share::Spectral(spectrum) => spectrum.at_nm(nm),
    }
}

fn at_1_nm(values: impl Iterator<Item = f64>) -> Option<Spectrum> {
    let nm = (FROM_NM..=TO_NM).map(f64::from).collect();
    Spectrum::new(nm, values.collect()).ok()
}

fn cosine(sensor: &Sensor, place: DVec3) -> f64 {
    place.dot(sensor.toward) / place.length()
}

fn bilinear(rows: &[f64], columns: &[f64], values: &[f64], row: f64, column: f64) -> f64 {
    let place = |grid: &[f64], at: f64| {
        let k = grid.partition_point(|g| *g <= at).clamp(1, grid.len().max(2) - 1) - 1;
        let next = (k + 1).min(grid.len() - 1);
        let t = if next == k {
            0.0
        } else {
            ((at - grid[k]) / (grid[next] - grid[k])).clamp(0.0, 1.0)
        };
        (k, next, t)
    };
    let ((r, r1, s), (c, c1, t)) = (place(rows, row), place(columns, column));
    let at = |r: usize, c: usize| values[r * columns.len() + c];
    (1.0 - s) * ((1.0 - t) * at(r, c) + t * at(r, c1)) + s * ((1.0 - t) * at(r1, c) + t * at(r1, c1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{self, Pose};
    use isolux_model::ColourOverAngle;

    fn plane(tilt_x_deg: f64, size_mm: f64) -> Sensor {
        sensor::Sensor::new(&Pose {
            size_mm: [size_mm; 2],
            pixels: [8; 2],
            distance_mm: 100.0,
            tilt_x_deg,
            tilt_y_deg: 0.0,
            rot_z_deg: 0.0,
            offset_mm: [0.0; 2],
        })
        .unwrap()
    }

    fn clear(index: f64) -> Window {
        Window {
            index,
            thickness_mm: 0.0,
            transmittance: Share::Grey(1.0),
        }
    }

    fn station(optics: Optics, lamp: Option<&Spectrum>) -> Station {
        Station::new(&optics, lamp, lamp.is_some()).unwrap().unwrap()
    }

    #[test]
    fn nothing_in_the_path_is_nothing_to_do() {
        assert!(Station::new(&Optics::default(), None, false).unwrap().is_none());
    }

    #[test]
    fn a_tilted_window_loses_what_fresnel_says() {
        let optics = Optics {
            windows: vec![clear(1.52)],
            ..Optics::default()
        };
        let sensor = plane(60.0, 1e-3);
        let found = station(optics, None).factors(&sensor)[27];
        assert!(
            (found - optics::plate(1.52, 1.0, 0.5).transmitted).abs() < 1e-5,
            "{found}"
        );
    }

    #[test]
    fn vapour_takes_each_wavelength_by_its_own_law() {
        // Half the power at a wavelength that loses nine tenths over 100 mm, half at one that loses nothing.
        let lamp = Spectrum::new(
            vec![500.0, 501.0, 502.0, 600.0, 601.0, 602.0],
            vec![0.0, 1.0, 0.0, 0.0, 1.0, 0.0],
        )
        .unwrap();
        let epsilon = Spectrum::new(vec![360.0, 550.0, 551.0, 830.0], vec![10.0, 10.0, 0.0, 0.0]).unwrap();
        let optics = Optics {
            vapour: Some(Vapour {
                epsilon: Share::Spectral(epsilon),
                concentration_mol_l: 0.01,
                length_mm: None,
            }),
            ..Optics::default()
        };
        let station = station(optics, Some(&lamp));
        let sensor = plane(0.0, 1e-3);
        assert!((station.factors(&sensor)[27] - 0.55).abs() < 1e-9);
        let behind = station.spectrum_at_centre(&sensor).unwrap();
        assert!((behind.at_nm(501.0) - 0.1).abs() < 1e-9 && (behind.at_nm(601.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn another_colour_at_an_angle_has_another_power_per_lumen() {
        let line = |nm: f64| Spectrum::new(vec![nm - 1.0, nm, nm + 1.0], vec![0.0, 1.0, 0.0]).unwrap();
        let (green, red) = (line(555.0), line(650.0));
        let k = |spectrum: &Spectrum| spectrum.ler_lm_per_w().unwrap();
        let optics = Optics {
            colour: Some(ColourOverAngle::new(vec![((0.0, 0.0), green.clone()), ((0.0, 40.0), red.clone())]).unwrap()),
            ..Optics::default()
        };
        let station = station(optics, Some(&green));
        // 100 mm off the axis at 100 mm: γ = 45°, beyond the last; on the axis the first.
        let sensor = plane(0.0, 200.0);
        let factors = station.factors(&sensor);
        assert!(
            (factors[0] / (k(&green) / k(&red)) - 1.0).abs() < 1e-9,
            "{}",
            factors[0]
        );
        // A quarter of the way a quarter of the lumens are red; electrons of a sensor that sees red alone follow.
        let tan = 10.0_f64.to_radians().tan();
        let near = station.colour_at(DVec3::new(tan, 0.0, 1.0)).unwrap();
        let red_lumens = near.at_nm(650.0) / red.at_nm(650.0) * red.luminous_integral();
        assert!((red_lumens - 0.25).abs() < 1e-9, "{red_lumens}");
        let seen = station
            .per_watt(&sensor, &|nm| if nm > 600.0 { 1.0 } else { 0.0 })
            .unwrap();
        let x_mm = sensor.point(3.5, 3.5);
        let t = angles_deg(x_mm).1 / 40.0;
        let watts = [(1.0 - t) / k(&green), t / k(&red)];
        assert!((seen[27] / (watts[1] / (watts[0] + watts[1])) - 1.0).abs() < 1e-9);
        assert!((seen[0] - 1.0).abs() < 1e-9);
        let mean = station.mean_spectrum(&sensor, &[1.0; 64]).unwrap();
        let share = seen.iter().sum::<f64>() / 64.0;
        let of_red: f64 = (601..=830).map(|nm| mean.at_nm(f64::from(nm))).sum();
        assert!((of_red / mean.integral() - share).abs() < 1e-9, "{share}");
    }

    #[test]
    fn a_target_through_a_lens_is_as_bright_as_the_formula() {
        let lens = Lens {
            focal_mm: 25.0,
            f_number: 4.0,
            distance_mm: 525.0,
            transmittance: 0.9,
            barrel_mm: 0.0,
        };
        let of = |target: Target| {
            let optics = Optics {
                target: Some(target),
                lens: Some(lens),
                ..Optics::default()
            };
            station(optics, None).factors(&plane(0.0, 1e-3))[27]
        };
        // m = 25/500: E′/E = ρ·τ/(4·N²·(1.05)²).
        let expected = 0.5 * 0.9 / (4.0 * 16.0 * 1.05 * 1.05);
        assert!((of(Target::Lambertian(0.5)) / expected - 1.0).abs() < 1e-9);
        let measured = Target::Measured {
            incidence_deg: vec![0.0, 90.0],
            viewing_deg: vec![0.0],
            brdf_per_sr: vec![0.5 / std::f64::consts::PI, 0.0],
        };
        assert!((of(measured) / expected - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_spectral_part_needs_a_spectrum() {
        let optics = Optics {
            windows: vec![Window {
                transmittance: Share::Spectral(Spectrum::new(vec![400.0, 700.0], vec![1.0, 1.0]).unwrap()),
                ..clear(1.5)
            }],
            ..Optics::default()
        };
        assert!(matches!(
            Station::new(&optics, None, true),
            Err(StationError::NoSpectrum { .. })
        ));
    }
}
