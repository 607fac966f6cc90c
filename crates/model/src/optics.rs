//! What a scene may put beside the direct path: windows and filters, vapour, a target plane seen through a lens,
//! spectra over angle, the camera's electronics. The tables of `scene.toml`, read and checked.

use camino::Utf8Path;
use isolux_record::document::{DocumentError, SourceText, read_text};
use isolux_spectrum::Spectrum;
use serde::Deserialize;

use crate::colour::{self, ColourDocument, ColourOverAngle};
use crate::reader::Reader;

/// A number for every wavelength, or a spectrum of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Share {
    /// The same for every wavelength.
    Grey(f64),
    /// By wavelength; zero outside the file's range.
    Spectral(Spectrum),
}

/// `[[window]]`: a plane-parallel plate before the sensor, parallel to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Refractive index.
    pub index: f64,
    /// Thickness, mm: what the refracted light is nearer by.
    pub thickness_mm: f64,
    /// Internal transmittance along the normal.
    pub transmittance: Share,
}

/// `[vapour]`: an absorbing medium in the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Vapour {
    /// Decadic molar extinction, l/(mol·cm).
    pub epsilon: Share,
    /// Concentration, mol/l.
    pub concentration_mol_l: f64,
    /// Thickness of a layer parallel to the sensor, mm; the whole path without it.
    pub length_mm: Option<f64>,
}

/// `[target]`: what returns the light; the pose of the sensor is the target's.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A Lambertian plane of this reflectance.
    Lambertian(f64),
    /// A measured BRDF in 1/sr over the angles of incidence and of viewing, bilinear.
    Measured {
        /// Angles of incidence, rising.
        incidence_deg: Vec<f64>,
        /// Angles of viewing, rising.
        viewing_deg: Vec<f64>,
        /// `[incidence · viewing]`.
        brdf_per_sr: Vec<f64>,
    },
}

/// `[lens]`: the thin lens through which the target is seen, on the target's normal.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lens {
    /// Focal length, mm.
    pub focal_mm: f64,
    /// Focal length over the diameter of the pupil.
    pub f_number: f64,
    /// Distance of the lens from the target, mm.
    pub distance_mm: f64,
    /// Transmittance of the glass.
    #[serde(default = "one")]
    pub transmittance: f64,
    /// Length of a barrel of the pupil's diameter before the pupil, mm; it vignettes.
    #[serde(default)]
    pub barrel_mm: f64,
}

/// `[sensor.camera]`: a pixel as an EMVA 1288 data sheet has it.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSheet {
    /// Exposure time, s.
    pub exposure_s: f64,
    /// Dark current, electrons/s.
    #[serde(default)]
    pub dark_electrons_per_s: f64,
    /// Temporal dark noise, electrons.
    #[serde(default)]
    pub read_noise_electrons: f64,
    /// Dark signal non-uniformity, electrons.
    #[serde(default)]
    pub dsnu_electrons: f64,
    /// Photo response non-uniformity, relative.
    #[serde(default)]
    pub prnu_rel: f64,
    /// Full well, electrons.
    pub full_well_electrons: f64,
    /// System gain, digital numbers per electron.
    pub gain_dn_per_electron: f64,
    /// Offset, digital numbers.
    #[serde(default)]
    pub offset_dn: f64,
    /// Bits of the converter, at most 16.
    pub bits: u32,
    /// Seed of what differs from exposure to exposure.
    #[serde(default = "seed")]
    pub seed: u64,
}

/// All of it; empty where a scene has none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Optics {
    /// Plates, from the lamp on.
    pub windows: Vec<Window>,
    /// The medium.
    pub vapour: Option<Vapour>,
    /// What returns the light.
    pub target: Option<Target>,
    /// What images the target.
    pub lens: Option<Lens>,
    /// Spectra over angle, of the scene or else of its model.
    pub colour: Option<ColourOverAngle>,
    /// The electronics.
    pub camera: Option<CameraSheet>,
}

fn one() -> f64 {
    1.0
}

fn seed() -> u64 {
    1
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a number, or the name of a spectrum file in quotes")]
enum NumberOrFile {
    Number(f64),
    File(String),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WindowDocument {
    #[serde(default = "one")]
    index: f64,
    #[serde(default)]
    thickness_mm: f64,
    transmittance: Option<NumberOrFile>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VapourDocument {
    epsilon_l_per_mol_cm: NumberOrFile,
    concentration_mol_l: f64,
    length_mm: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TargetDocument {
    reflectance: Option<f64>,
    brdf: Option<String>,
}

/// The tables of a scene that this module reads.
pub(crate) struct Tables<'a> {
    pub window: &'a [WindowDocument],
    pub vapour: Option<&'a VapourDocument>,
    pub target: Option<&'a TargetDocument>,
    pub lens: Option<Lens>,
    pub colour: &'a [ColourDocument],
    pub camera: Option<CameraSheet>,
}

/// Reads the files that the tables name and checks every number.
pub(crate) fn read(source: SourceText<'_>, tables: &Tables<'_>) -> Result<Optics, DocumentError> {
    let reader = Reader { source };
    let mut windows = Vec::new();
    for (index, window) in tables.window.iter().enumerate() {
        let at = |key: &str| format!("window.{index}.{key}");
        reader.within(&at("index"), window.index, 1.0, 5.0)?;
        reader.within(&at("thickness_mm"), window.thickness_mm, 0.0, 1e6)?;
        let transmittance = match &window.transmittance {
            None => Share::Grey(1.0),
            Some(given) => reader.share(&at("transmittance"), given, 1.0)?,
        };
        windows.push(Window {
            index: window.index,
            thickness_mm: window.thickness_mm,
            transmittance,
        });
    }
    let vapour = tables
        .vapour
        .map(|vapour| {
            reader.within("vapour.concentration_mol_l", vapour.concentration_mol_l, 0.0, 1e3)?;
            if let Some(length) = vapour.length_mm {
                reader.within("vapour.length_mm", length, 0.0, 1e9)?;
            }
            Ok::<_, DocumentError>(Vapour {
                epsilon: reader.share("vapour.epsilon_l_per_mol_cm", &vapour.epsilon_l_per_mol_cm, 1e9)?,
                concentration_mol_l: vapour.concentration_mol_l,
                length_mm: vapour.length_mm,
            })
        })
        .transpose()?;
    let target = tables.target.map(|target| reader.target(target)).transpose()?;
    match (&target, &tables.lens) {
        (None, Some(_)) => return Err(reader.fault("lens", "a lens needs a [target] to look at")),
        (Some(_), None) => return Err(reader.fault("target", "a target needs a [lens] that images it on the camera")),
        _ => {}
    }
    if let Some(lens) = &tables.lens {
        reader.within("lens.focal_mm", lens.focal_mm, 1e-3, 1e6)?;
        reader.within("lens.f_number", lens.f_number, 0.1, 1e4)?;
        reader.within("lens.transmittance", lens.transmittance, 0.0, 1.0)?;
        reader.within("lens.barrel_mm", lens.barrel_mm, 0.0, 1e6)?;
        reader.within("lens.distance_mm", lens.distance_mm, 1e-3, 1e9)?;
        if lens.distance_mm <= lens.focal_mm {
            return Err(reader.fault(
                "lens.distance_mm",
                "the target must be farther away than the focal length, or there is no image",
            ));
        }
    }
    let colour = colour::read(&reader, "colour", tables.colour)?;
    if let Some(camera) = &tables.camera {
        reader.camera(camera)?;
    }
    Ok(Optics {
        windows,
        vapour,
        target,
        lens: tables.lens,
        colour,
        camera: tables.camera,
    })
}

impl Reader<'_> {
    fn camera(&self, camera: &CameraSheet) -> Result<(), DocumentError> {
        let key = |key: &str| format!("sensor.camera.{key}");
        self.within(&key("exposure_s"), camera.exposure_s, 1e-9, 1e6)?;
        self.within(&key("dark_electrons_per_s"), camera.dark_electrons_per_s, 0.0, 1e9)?;
        self.within(&key("read_noise_electrons"), camera.read_noise_electrons, 0.0, 1e6)?;
        self.within(&key("dsnu_electrons"), camera.dsnu_electrons, 0.0, 1e6)?;
        self.within(&key("prnu_rel"), camera.prnu_rel, 0.0, 1.0)?;
        self.within(&key("full_well_electrons"), camera.full_well_electrons, 1.0, 1e9)?;
        self.within(&key("gain_dn_per_electron"), camera.gain_dn_per_electron, 1e-9, 1e6)?;
        self.within(&key("offset_dn"), camera.offset_dn, 0.0, 65_535.0)?;
        self.within(&key("bits"), f64::from(camera.bits), 1.0, 16.0)
    }

    fn share(&self, path: &str, given: &NumberOrFile, most: f64) -> Result<Share, DocumentError> {
        match given {
            NumberOrFile::Number(value) => {
                self.within(path, *value, 0.0, most)?;
                Ok(Share::Grey(*value))
            }
            NumberOrFile::File(file) => {
                let spectrum = self.spectrum(path, file)?;
                for value in spectrum.value() {
                    self.within(path, *value, 0.0, most)?;
                }
                Ok(Share::Spectral(spectrum))
            }
        }
    }

    fn target(&self, target: &TargetDocument) -> Result<Target, DocumentError> {
        match (target.reflectance, &target.brdf) {
            (Some(reflectance), None) => {
                self.within("target.reflectance", reflectance, 0.0, 1.0)?;
                Ok(Target::Lambertian(reflectance))
            }
            (None, Some(file)) => self.brdf(&self.path(file)),
            _ => Err(self.fault("target", "give reflectance or brdf, one of them")),
        }
    }

    /// `incidence_deg,viewing_deg,brdf_per_sr`, a full grid in rising order.
    fn brdf(&self, path: &Utf8Path) -> Result<Target, DocumentError> {
        let wrong = |line: usize, message: &str| self.fault("target.brdf", &format!("{path}:{line}: {message}"));
        let text = read_text(path).map_err(|error| self.fault("target.brdf", &error.to_string()))?;
        let (mut incidence_deg, mut viewing_deg, mut brdf_per_sr) = (Vec::new(), Vec::new(), Vec::new());
        for (index, row) in text.lines().enumerate().filter(|(_, row)| !row.trim().is_empty()) {
            if index == 0 {
                if row.trim() != "incidence_deg,viewing_deg,brdf_per_sr" {
                    return Err(wrong(1, "the header is incidence_deg,viewing_deg,brdf_per_sr"));
                }
                continue;
            }
            let cells: Vec<f64> = row
                .split(',')
                .map(|cell| {
                    cell.trim()
                        .parse::<f64>()
                        .ok()
                        .filter(|value| value.is_finite() && *value >= 0.0)
                })
                .collect::<Option<_>>()
                .ok_or_else(|| wrong(index + 1, "three numbers of zero or more are needed"))?;
            let [incidence, viewing, value] = cells[..] else {
                return Err(wrong(index + 1, "three numbers are needed"));
            };
            if incidence_deg.last().is_none_or(|last| *last != incidence) {
                if incidence_deg.last().is_some_and(|last| *last > incidence) || incidence > 90.0 {
                    return Err(wrong(index + 1, "incidence_deg must rise, up to 90"));
                }
                incidence_deg.push(incidence);
            }
            if incidence_deg.len() == 1 {
                if viewing_deg.last().is_some_and(|last| *last >= viewing) || viewing > 90.0 {
                    return Err(wrong(index + 1, "viewing_deg must rise, up to 90"));
                }
                viewing_deg.push(viewing);
            } else if viewing_deg[brdf_per_sr.len() % viewing_deg.len()] != viewing {
                return Err(wrong(index + 1, "every incidence_deg needs the same viewing_deg"));
            }
            brdf_per_sr.push(value);
        }
        if brdf_per_sr.is_empty() || brdf_per_sr.len() != incidence_deg.len() * viewing_deg.len() {
            return Err(wrong(1, "the grid of angles is not complete"));
        }
        Ok(Target::Measured {
            incidence_deg,
            viewing_deg,
            brdf_per_sr,
        })
    }
}
