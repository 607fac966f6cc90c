//! `model.toml` and `scene.toml` as they stand in the file.

use isolux_record::observation::OneOrTwo;
use serde::{Deserialize, Serialize};

use crate::colour::ColourDocument;
use crate::effect::{Effect, EffectError, Notes};
use crate::emitter::Emitter;
use crate::luminaire::Interpolation;
use crate::optics::{CameraSheet, Lens, TargetDocument, VapourDocument, WindowDocument};
use crate::refined::Refined;

/// The `format` of a model file.
pub(crate) const MODEL_FORMAT: &str = "isolux-model/1";
/// The `format` of a scene file.
pub(crate) const SCENE_FORMAT: &str = "isolux-scene/1";

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelDocument {
    pub format: String,
    pub luminaire: LuminaireDocument,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseDocument>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effect: Vec<toml::Table>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LuminaireDocument {
    pub distribution: String,
    #[serde(default, skip_serializing_if = "Interpolation::is_linear")]
    pub interpolation: Interpolation,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ler_lm_per_w: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flux_lm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emitter: Option<Emitter>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trust: Option<Trust>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<Uncertainty>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<Refined>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<toml::Table>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colour: Vec<ColourDocument>,
}

/// What a diagnosis refits freely, because its uncertainty is not known: `[luminaire.trust]`. A file that states its
/// uncertainty (`[luminaire.u]`) needs none: what is stated is a prior, and nothing is refitted beyond it for free.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trust {
    /// How far the γ shape of the distribution is trusted.
    #[serde(default)]
    pub shape: ShapeTrust,
    /// Harmonics m of which cos(m·C)·sinᵐγ may be refitted.
    #[serde(default)]
    pub c_harmonics: Vec<u32>,
}

impl Trust {
    /// What is assumed of a file that states nothing: a level, a smooth shape over γ and an oval cross-section that may
    /// all be off.
    pub(crate) fn of_a_catalogue() -> Self {
        Self {
            shape: ShapeTrust::Smooth,
            c_harmonics: vec![2],
        }
    }
}

/// How far the γ shape of the distribution is trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeTrust {
    /// It is right.
    #[default]
    Exact,
    /// It may have a smooth error.
    Smooth,
}

/// What the model knows of its own measurement: `[luminaire.u]`, standard uncertainties (k = 1).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// Relative, of every intensity alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intensity_rel: Option<f64>,
    /// Of the γ of all directions, in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gamma_deg: Option<f64>,
    /// Of what adds to every intensity alike (offset, ambient and stray light that were taken out), in candela.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub common_cd: Option<f64>,
    /// Relative, of the flux.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flux_rel: Option<f64>,
    /// Relative, of the luminous efficacy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ler_rel: Option<f64>,
    /// Of each direction of the distribution on its own (the noise of its reading, before any smoothing), relative to
    /// its intensity; adds in squares to `direction_cd`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction_rel: Option<f64>,
    /// The same in candela, however little light there is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction_cd: Option<f64>,
    /// Where the intensities were smoothed: the share that the noise of a direction's own reading has in its smoothed
    /// value, along γ and around C; its neighbours have the rest. In (0, 1]; without it directions are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction_share: Option<[f64; 2]>,
    /// The same share of the mean of all half-planes along γ, which was smoothed by itself: more of its noise is left
    /// than of what the half-planes differ from it. Without it, it has the share of `direction_share` along γ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_share: Option<f64>,
    /// Age of the lamp in s when each half-plane of the distribution was read, where they were read one after the other:
    /// what is not known of the lamp's change in time is wrong in them too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_plane_lamp_s: Option<Vec<f64>>,
    /// Distance in mm from which the intensities were measured, as illuminance times its square: what another emitter
    /// shows there is in them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_at_mm: Option<f64>,
    /// First and last γ that were measured, where that is not the whole sphere, in degrees: outside the file is dark.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_gamma_deg: Option<[f64; 2]>,
    /// What was neither measured nor stated: a number that is computed from this luminaire has no complete uncertainty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// Diameter of the luminous area where the emitter is smaller: close by, a sensor sees a near field that the model
    /// lacks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub luminous_diameter_mm: Option<f64>,
    /// Of the spectrum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<SpectrumUncertainty>,
}

/// What the model knows of its spectrum: `[luminaire.u.spectrum]`, standard uncertainties (k = 1).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpectrumUncertainty {
    /// Rising wavelengths, between which the noise is linear.
    pub wavelength_nm: Vec<f64>,
    /// Noise of the value at each single wavelength of the spectrum's file, in its unit; one for each of
    /// `wavelength_nm`.
    pub noise: Vec<f64>,
    /// Relative, of the ratios of 700 nm to 400 nm and of 550 nm to both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape_rel: Option<f64>,
    /// Of the wavelength scale, in nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale_nm: Option<f64>,
    /// The spectroradiometer and its calibration: spectra that the same one read have its errors too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
}

impl SpectrumUncertainty {
    /// Noise at a wavelength, in the unit of the spectrum's file; that of the nearest end outside.
    pub fn noise_at(&self, wavelength_nm: f64) -> f64 {
        let next = self.wavelength_nm.partition_point(|at| *at <= wavelength_nm);
        match (next.checked_sub(1), self.noise.get(next)) {
            (Some(before), Some(after)) => {
                let (low, high) = (self.wavelength_nm[before], self.wavelength_nm[next]);
                let share = (wavelength_nm - low) / (high - low);
                self.noise[before] + share * (after - self.noise[before])
            }
            (Some(before), None) => self.noise[before],
            (None, first) => first.copied().unwrap_or(0.0),
        }
    }

    /// What is wrong with its lists, if anything is.
    pub(crate) fn fault(&self) -> Option<String> {
        let (nm, noise) = (&self.wavelength_nm, &self.noise);
        if nm.is_empty() || nm.len() != noise.len() {
            return Some(format!(
                "{} wavelengths and {} values of noise: give one for each, one at least",
                nm.len(),
                noise.len()
            ));
        }
        if !nm.iter().all(|nm| nm.is_finite()) || nm.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Some("its wavelengths must rise".to_owned());
        }
        let possible = noise.iter().all(|value| value.is_finite() && *value >= 0.0);
        (!possible).then(|| "its noise must be finite and not below zero".to_owned())
    }
}

impl Uncertainty {
    /// Standard uncertainty of one direction of intensity `intensity_cd` on its own, as it was read, independent of
    /// every other direction; 0 where nothing is stated.
    pub fn of_direction_cd(&self, intensity_cd: f64) -> f64 {
        (self.direction_rel.unwrap_or(0.0) * intensity_cd).hypot(self.direction_cd.unwrap_or(0.0))
    }

    /// Every key that is stated, its value, and the most that it can mean.
    pub(crate) fn stated(&self) -> impl Iterator<Item = (&'static str, f64, f64)> + use<> {
        // A relative uncertainty of one direction in the dark is large.
        [
            ("intensity_rel", self.intensity_rel, 10.0),
            ("gamma_deg", self.gamma_deg, 90.0),
            ("common_cd", self.common_cd, 1e9),
            ("flux_rel", self.flux_rel, 10.0),
            ("ler_rel", self.ler_rel, 10.0),
            ("direction_rel", self.direction_rel, 1e3),
            ("direction_cd", self.direction_cd, 1e9),
            ("direction_share", self.direction_share.map(|[along, _]| along), 1.0),
            ("direction_share", self.direction_share.map(|[_, around]| around), 1.0),
            ("mean_share", self.mean_share, 1.0),
            (
                "measured_gamma_deg",
                self.measured_gamma_deg.map(|[first, _]| first),
                180.0,
            ),
            (
                "measured_gamma_deg",
                self.measured_gamma_deg.map(|[_, last]| last),
                180.0,
            ),
            ("luminous_diameter_mm", self.luminous_diameter_mm, 1e5),
            ("measured_at_mm", self.measured_at_mm, 1e7),
            (
                "spectrum.shape_rel",
                self.spectrum.as_ref().and_then(|u| u.shape_rel),
                10.0,
            ),
            (
                "spectrum.scale_nm",
                self.spectrum.as_ref().and_then(|u| u.scale_nm),
                1e3,
            ),
        ]
        .into_iter()
        .filter_map(|(key, value, most)| Some((key, value?, most)))
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseDocument {
    #[serde(default)]
    pub u_scale: UncertaintyScale,
}

/// What the stated uncertainties of observations are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UncertaintyScale {
    /// They hold.
    #[default]
    Stated,
    /// One common factor on all of them is fitted.
    Fit,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneDocument {
    #[serde(rename = "format")]
    pub _format: String,
    pub model: Option<String>,
    pub luminaire: Option<LuminaireDocument>,
    #[serde(default)]
    pub effect: Vec<toml::Table>,
    pub noise: Option<NoiseDocument>,
    pub sensor: SensorDocument,
    #[serde(default)]
    pub window: Vec<WindowDocument>,
    pub vapour: Option<VapourDocument>,
    pub target: Option<TargetDocument>,
    pub lens: Option<Lens>,
    #[serde(default)]
    pub colour: Vec<ColourDocument>,
    #[serde(default)]
    pub simulation: SimulationDocument,
}

/// `[simulation]`: how a scene is computed, where that is not left to the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SimulationDocument {
    #[serde(default)]
    pub accuracy: Accuracy,
}

/// How far a noise-free map may be off, as its own rules can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// 1e-5 of a pixel above 1e-3 of the map's largest, 1e-8 of the largest below.
    #[default]
    Standard,
    /// 1e-6 of a pixel, many times slower: to check the other one.
    Reference,
}

impl Accuracy {
    /// As scene files and results spell it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SensorDocument {
    pub size_mm: OneOrTwo<f64>,
    pub pixels: OneOrTwo<usize>,
    pub distance_mm: f64,
    #[serde(default)]
    pub tilt_x_deg: f64,
    #[serde(default)]
    pub tilt_y_deg: f64,
    #[serde(default)]
    pub rot_z_deg: f64,
    #[serde(default)]
    pub offset_mm: [f64; 2],
    pub time_s: Option<f64>,
    pub responsivity: Option<String>,
    #[serde(default)]
    pub background_w_m2: f64,
    pub camera: Option<CameraSheet>,
}

/// Why one `[[effect]]` is none, and the key that is to blame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EffectFault {
    pub key: String,
    pub message: String,
}

/// The largest size of an effect's number in a file, by its unit: beyond it predictions are infinite and mean nothing.
fn most_of(key: &str) -> f64 {
    match key {
        _ if key.ends_with("_deg") && !key.ends_with("_per_deg") => 360.0,
        _ if key.ends_with("_mm") => 1e6,
        _ if key.ends_with("_nm") => 1e4,
        _ => 1e9,
    }
}

/// One `[[effect]]` as the catalogue knows it.
pub(crate) fn effect_from_table(table: &toml::Table) -> Result<Effect, EffectFault> {
    let fault = |key: &str, message: String| EffectFault {
        key: key.to_owned(),
        message,
    };
    let name = match table.get("name") {
        Some(toml::Value::String(name)) => name,
        Some(_) => return Err(fault("name", "must be text".into())),
        None => return Err(fault("", "an effect needs a name".into())),
    };
    let mut given = Vec::new();
    let mut notes = Notes::default();
    for (key, value) in table {
        let note = match key.as_str() {
            "name" => continue,
            "u" => &mut notes.u,
            "evidence" => &mut notes.evidence,
            "provenance" => &mut notes.provenance,
            _ => {
                let number = match value {
                    toml::Value::Float(value) => *value,
                    toml::Value::Integer(value) => *value as f64,
                    _ => return Err(fault(key, format!("`{key}` of effect `{name}` must be a number"))),
                };
                let most = most_of(key);
                if !(-most..=most).contains(&number) {
                    return Err(fault(
                        key,
                        format!("`{key}` of effect `{name}` is {number}: it must lie between -{most} and {most}"),
                    ));
                }
                given.push((key.as_str(), number));
                continue;
            }
        };
        match value {
            toml::Value::Table(table) => *note = Some(table.clone()),
            _ => return Err(fault(key, format!("`{key}` of effect `{name}` must be a table"))),
        }
    }
    let mut effect = Effect::from_keys(name, given).map_err(|error| {
        let key = match &error {
            EffectError::UnknownName(_) => "name".to_owned(),
            EffectError::UnknownKey { key, .. } => key.clone(),
            EffectError::Value { key, .. } => (*key).to_owned(),
            EffectError::MissingKey { .. } | EffectError::Count { .. } => String::new(),
        };
        EffectFault {
            key,
            message: error.to_string(),
        }
    })?;
    effect.notes = notes;
    Ok(effect)
}

/// The `[[effect]]` of an effect. Amplitudes and whatever differs from its default are written.
pub(crate) fn table_from_effect(effect: &Effect) -> toml::Table {
    use crate::effects::Role;
    let mut table = toml::Table::new();
    table.insert("name".into(), effect.name().into());
    for (parameter, &value) in effect.spec().parameters.iter().zip(effect.values()) {
        // A null amplitude goes without saying, unless it is all that there is to say.
        let is_amplitude = |role| matches!(role, Role::Alternative | Role::Amplitude);
        let all_null = effect.is_null();
        let is_first = parameter.key == effect.spec().parameters[0].key;
        if is_amplitude(parameter.role) && value == parameter.null && !(is_first && all_null) {
            continue;
        }
        let value = match parameter.role {
            Role::RangeId => toml::Value::Integer(value as i64),
            _ => toml::Value::Float(value),
        };
        table.insert(parameter.key.into(), value);
    }
    let notes = &effect.notes;
    for (key, note) in [
        ("u", &notes.u),
        ("evidence", &notes.evidence),
        ("provenance", &notes.provenance),
    ] {
        if let Some(note) = note {
            table.insert(key.into(), toml::Value::Table(note.clone()));
        }
    }
    table
}
