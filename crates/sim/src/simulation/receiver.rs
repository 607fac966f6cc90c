//! What the light arrives at: its spectrum there, its colour over the sensor, and the camera that counts it.

use std::borrow::Cow;

use isolux_model::optics::CameraSheet;
use isolux_model::{Scene, Spectral};
use isolux_photometry::polar_deg;
use isolux_spectrum::Spectrum;

use super::error::SimulationError;
use super::exposure::Exposure;
use super::facts::{Band, ColourAt, ColourFacts};
use crate::setup::Setup;
use crate::{camera, station};

/// The receiving side of a scene, read and checked before the map is computed.
pub(super) struct Receiver<'a> {
    /// The spectrum that arrives: the lamp's, behind all that stands before the sensor.
    spectrum: Option<Cow<'a, Spectrum>>,
    /// Photons per (m²·s) of one unit of the map, weighted by the quantum efficiency; none without a responsivity.
    photons: Option<f64>,
    /// The quantum efficiency over the wavelength.
    responsivity: Option<Spectrum>,
    /// The same of each pixel, where colours differ over the sensor.
    photons_of_pixel: Option<Vec<f64>>,
    /// Area that a pixel has on the sensor's chip, in m².
    pixel_m2: f64,
    sheet: Option<&'a CameraSheet>,
    /// Colour over the sensor.
    pub colour: Option<ColourFacts>,
    /// What the operator should know.
    pub finding: Option<String>,
}

impl<'a> Receiver<'a> {
    /// Of a scene.
    ///
    /// # Errors
    /// [`SimulationError::Responsivity`] for a file that cannot be read, or a camera without the lamp's spectrum.
    pub fn of(scene: &'a Scene, setup: &Setup) -> Result<Self, SimulationError> {
        let arriving = setup
            .station
            .as_ref()
            .and_then(|station| station.spectrum_at_centre(&setup.sensor));
        let spectrum = match (arriving, scene.model.luminaire().spectral()) {
            (Some(arriving), _) => Some(Cow::Owned(arriving)),
            (None, Spectral::Spectrum(lamp)) => Some(Cow::Borrowed(lamp)),
            _ => None,
        };
        let wrong = |message: String| SimulationError::Responsivity { message };
        let mut finding = None;
        let responsivity = match (&spectrum, &scene.sensor.responsivity) {
            (Some(_), Some(path)) => Some(isolux_model::read_spectrum(path).map_err(|error| wrong(error.to_string()))?),
            (None, Some(_)) => {
                finding = Some("responsivity needs the model's spectrum; electrons are not computed".to_owned());
                None
            }
            (_, None) => None,
        };
        let photons = photons(spectrum.as_deref(), responsivity.as_ref());
        let sheet = scene.optics.camera.as_ref();
        if sheet.is_some() && photons.is_none() {
            return Err(wrong(
                "sensor.camera needs the model's spectrum, to count electrons".to_owned(),
            ));
        }
        // In the image of a lens a pixel is as much smaller as the image.
        let magnification = scene.optics.lens.map_or(1.0, |lens| station::magnification(&lens));
        Ok(Self {
            colour: colour(scene, setup),
            pixel_m2: setup.sensor.pixel_area_m2() * magnification * magnification,
            spectrum,
            photons,
            responsivity,
            photons_of_pixel: None,
            sheet,
            finding,
        })
    }

    /// The same once the map is known: where colours differ over the sensor, its spectrum is the mean of the map's, and
    /// every pixel counts the photons of its own.
    pub fn lit_by(mut self, setup: &Setup, map: &[f64]) -> Self {
        let Some(station) = &setup.station else { return self };
        if let Some(mean) = station.mean_spectrum(&setup.sensor, map) {
            self.photons = photons(Some(&mean), self.responsivity.as_ref());
            self.spectrum = Some(Cow::Owned(mean));
        }
        if let (Some(curve), Some(_)) = (&self.responsivity, self.sheet) {
            // Photons of a watt at λ, λ/(h·c), each weighted by the efficiency.
            let electrons = |nm: f64| camera::photons_per_joule(nm) * curve.at_nm(nm);
            self.photons_of_pixel = station.per_watt(&setup.sensor, &electrons);
        }
        self
    }

    /// One exposure of the scene's camera.
    pub fn exposure(&self, map: &[f64]) -> Option<Exposure> {
        let (sheet, all) = (self.sheet?, self.photons?);
        let photons = |pixel: usize| self.photons_of_pixel.as_ref().map_or(all, |of| of[pixel]);
        Some(Exposure::of(sheet, map, &photons, self.pixel_m2))
    }

    /// Luminous efficacy of the light that arrives, in lm/W; `stated` where there is no spectrum.
    pub fn efficacy(&self, stated: Option<f64>) -> Option<f64> {
        match &self.spectrum {
            Some(spectrum) => spectrum.ler_lm_per_w(),
            None => stated,
        }
    }

    /// Photon irradiance of a mean, 1/(m²·s).
    pub fn photon_irradiance(&self, mean: f64) -> Option<f64> {
        camera::photon_irradiance(mean, self.spectrum.as_ref()?, |_| 1.0)
    }

    /// Electrons per second and pixel of a mean.
    pub fn electrons_per_s(&self, mean: f64) -> Option<f64> {
        self.photons.map(|photons| photons * mean * self.pixel_m2)
    }

    /// Irradiance of a mean in bands of 50 nm.
    pub fn bands(&self, mean: f64) -> Vec<Band> {
        let Some(spectrum) = &self.spectrum else {
            return Vec::new();
        };
        (0..10)
            .filter_map(|k| {
                let (from_nm, to_nm) = (350.0 + 50.0 * f64::from(k), 400.0 + 50.0 * f64::from(k));
                let irradiance_w_m2 = camera::band_irradiance(mean, spectrum, from_nm, to_nm)?;
                Some(Band {
                    from_nm,
                    to_nm,
                    irradiance_w_m2,
                })
            })
            .collect()
    }
}

/// Photons per (m²·s) of 1 W/m² of a spectrum, weighted by a quantum efficiency.
fn photons(spectrum: Option<&Spectrum>, responsivity: Option<&Spectrum>) -> Option<f64> {
    let curve = responsivity?;
    camera::photon_irradiance(1.0, spectrum?, |nm| curve.at_nm(nm))
}

/// Colour at the middle and at the corner that differs most, where the scene has spectra over angle.
fn colour(scene: &Scene, setup: &Setup) -> Option<ColourFacts> {
    let station = setup.station.as_ref().filter(|_| scene.optics.colour.is_some())?;
    let (nx, ny) = (setup.sensor.nx as f64, setup.sensor.ny as f64);
    let at = |x: f64, y: f64| {
        let place = setup.sensor.point(x, y);
        let gamma_deg = polar_deg(place);
        let of = isolux_spectrum::quantities(&station.colour_at(place)?);
        Some(ColourAt {
            gamma_deg,
            cct_k: of.cct_k,
            u_prime: of.u_prime?,
            v_prime: of.v_prime?,
        })
    };
    let centre = at(0.5 * nx, 0.5 * ny)?;
    let apart = |other: &ColourAt| (other.u_prime - centre.u_prime).hypot(other.v_prime - centre.v_prime);
    let corner = [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]]
        .into_iter()
        .filter_map(|[x, y]| at(x, y))
        .max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    Some(ColourFacts {
        delta_u_prime_v_prime: apart(&corner),
        centre,
        corner,
    })
}
