//! `model.toml`: what the operator believes, whole.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_photometry::DistributionError;
use isolux_record::document::{DocumentError, Fault, SourceText, read_text};

use crate::colour::{self, ColourOverAngle};
use crate::document::{
    LuminaireDocument, MODEL_FORMAT, ModelDocument, NoiseDocument, ShapeTrust, SpectrumUncertainty, Trust, Uncertainty,
    UncertaintyScale, effect_from_table, table_from_effect,
};
use crate::effect::Effect;
use crate::effects::{Act, Values};
use crate::emitter::Emitter;
use crate::luminaire::{Luminaire, Spectral};
use crate::photometric_file::{read_distribution, read_spectrum};
use crate::reader::Reader;
use crate::refined::Refined;
use crate::smoothed_spectrum::SmoothedSpectrum;

/// Most luminous flux of a lamp: a thousand stadiums.
const MOST_FLUX_LM: f64 = 1e10;
/// Most luminous efficacy of radiation: that of 555 nm, CIE S 023.
const MOST_LER_LM_PER_W: f64 = 683.01;
/// Longest that a lamp burned, in s: 30 years.
const MOST_AGE_S: f64 = 1e9;

/// A luminaire and the effects that are believed to act.
#[derive(Debug, Clone)]
pub struct Model {
    luminaire: Arc<Luminaire>,
    refined: Refined,
    effects: Vec<Effect>,
    document: Arc<LuminaireDocument>,
    trust: Trust,
    u_scale: UncertaintyScale,
    folder: Utf8PathBuf,
    /// The spectrum of the file with less noise, where the file says how much it has.
    smoothed_spectrum: Option<Arc<SmoothedSpectrum>>,
    colour: Option<Arc<ColourOverAngle>>,
}

/// Names of the effects that a simulation applies, and of those that it does not, in file order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct InSimulation {
    /// Luminaire, path and sensor.
    pub applied: Vec<&'static str>,
    /// Bench and camera signal.
    pub not_applicable: Vec<&'static str>,
}

impl Model {
    /// A model of a luminaire that no file describes, without effects.
    pub fn of(luminaire: Luminaire) -> Self {
        Self {
            luminaire: Arc::new(luminaire),
            refined: Refined::default(),
            effects: Vec::new(),
            document: Arc::default(),
            trust: Trust::default(),
            u_scale: UncertaintyScale::default(),
            folder: Utf8PathBuf::new(),
            smoothed_spectrum: None,
            colour: None,
        }
    }

    /// The model of a `model.toml` with the files that it names.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line of the first thing that is wrong.
    pub fn load(path: &Utf8Path) -> Result<Self, DocumentError> {
        Self::parse(path, &read_text(path)?)
    }

    /// The model of `text`, which stands or would stand at `path`.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn parse(path: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        let source = SourceText { file: path, text };
        let document: ModelDocument = source.parse(MODEL_FORMAT)?;
        Self::build(source, document.luminaire, document.noise, &document.effect)
    }

    pub(crate) fn build(
        source: SourceText<'_>,
        document: LuminaireDocument,
        noise: Option<NoiseDocument>,
        effect: &[toml::Table],
    ) -> Result<Self, DocumentError> {
        let fault = |path: &str, message: String| {
            source.locate(&Fault {
                path: path.to_owned(),
                message,
            })
        };
        let folder = source.file.parent().unwrap_or(Utf8Path::new("")).to_owned();
        let reader = Reader { source };
        let mut distribution = read_distribution(&folder.join(&document.distribution))
            .map_err(|error| fault("luminaire.distribution", error.to_string()))?;
        if let Some(flux_lm) = document.flux_lm {
            reader.within("luminaire.flux_lm", flux_lm, 1e-9, MOST_FLUX_LM)?;
            distribution = document
                .interpolation
                .scaled_to_flux_lm(&distribution, flux_lm)
                .map_err(|error: DistributionError| fault("luminaire.flux_lm", error.to_string()))?;
        }
        let emitter = document
            .emitter
            .clone()
            .unwrap_or(Emitter::Point {})
            .checked()
            .map_err(|error| {
                let key = error.key().map_or(String::new(), |key| format!(".{key}"));
                fault(&format!("luminaire.emitter{key}"), error.to_string())
            })?;
        let spectral = match (&document.spectrum, document.ler_lm_per_w) {
            (Some(_), Some(_)) => {
                return Err(fault(
                    "luminaire.ler_lm_per_w",
                    "give either spectrum or ler_lm_per_w, not both".into(),
                ));
            }
            (Some(file), None) => Spectral::Spectrum(
                read_spectrum(&folder.join(file)).map_err(|error| fault("luminaire.spectrum", error.to_string()))?,
            ),
            (None, Some(ler)) => {
                reader.within("luminaire.ler_lm_per_w", ler, 1e-3, MOST_LER_LM_PER_W)?;
                Spectral::Efficacy(ler)
            }
            (None, None) => Spectral::None,
        };
        let colour = colour::read(&reader, "luminaire.colour", &document.colour)?;
        if colour.is_some() && !matches!(spectral, Spectral::Spectrum(_)) {
            return Err(fault(
                "luminaire.colour",
                "spectra over angle need luminaire.spectrum, that of the axis".into(),
            ));
        }
        let refined = document.refined.clone().unwrap_or_default();
        if !refined.is_possible() {
            return Err(fault(
                "luminaire.refined",
                "its numbers must be finite and of a size that no exponent or power makes infinite, its angles above zero".into(),
            ));
        }
        for (key, value, most) in document.u.iter().flat_map(Uncertainty::stated) {
            reader.within(&format!("luminaire.u.{key}"), value, 0.0, most)?;
        }
        if let Some(ages) = document.u.as_ref().and_then(|u| u.half_plane_lamp_s.as_ref()) {
            const KEY: &str = "luminaire.u.half_plane_lamp_s";
            for age_s in ages {
                reader.within(KEY, *age_s, 0.0, MOST_AGE_S)?;
            }
            let planes = distribution.c_deg().len();
            if ages.len() != planes {
                return Err(fault(
                    KEY,
                    format!(
                        "{} ages for {planes} half-planes: give one for each, in the order of C",
                        ages.len()
                    ),
                ));
            }
        }
        let of_spectrum = document.u.as_ref().and_then(|u| u.spectrum.as_ref());
        if let Some(message) = of_spectrum.and_then(SpectrumUncertainty::fault) {
            return Err(fault("luminaire.u.spectrum", message));
        }
        let trust = match (&document.trust, &document.u) {
            (Some(trust), _) => trust.clone(),
            (None, Some(_)) => Trust::default(),
            // A file of which nothing is known, as those of a catalogue are.
            (None, None) => Trust::of_a_catalogue(),
        };
        if trust.c_harmonics.contains(&0) {
            return Err(fault(
                "luminaire.trust.c_harmonics",
                "harmonics start at 1; the level is part of the shape".into(),
            ));
        }
        let mut effects = Vec::with_capacity(effect.len());
        for (index, table) in effect.iter().enumerate() {
            let effect = effect_from_table(table).map_err(|wrong| {
                let key = if wrong.key.is_empty() {
                    String::new()
                } else {
                    format!(".{}", wrong.key)
                };
                fault(&format!("effect.{index}{key}"), wrong.message)
            })?;
            effects.push(effect);
        }
        let u_cd = |cd: f64| document.u.as_ref().map_or(0.0, |u| u.of_direction_cd(cd));
        let interpolation = document.interpolation;
        let grid = interpolation.grid_of(&distribution, &u_cd);
        let smoothed_spectrum = match (&spectral, document.u.as_ref().and_then(|u| u.spectrum.as_ref())) {
            (Spectral::Spectrum(spectrum), Some(u)) => SmoothedSpectrum::new(spectrum, u).map(Arc::new),
            _ => None,
        };
        let model = Self {
            smoothed_spectrum,
            colour: colour.map(Arc::new),
            luminaire: Arc::new(Luminaire::on_grid(distribution, grid, interpolation, emitter, spectral)),
            refined,
            effects,
            document: Arc::new(document),
            trust,
            u_scale: noise.map(|noise| noise.u_scale).unwrap_or_default(),
            folder,
        };
        model
            .refuse_two_emitters()
            .map_err(|(index, message)| fault(&format!("effect.{index}"), message))?;
        Ok(model)
    }

    /// The luminaire as the files give it.
    pub fn luminaire(&self) -> &Luminaire {
        &self.luminaire
    }

    /// The effects in file order.
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// What was refitted.
    pub fn refined(&self) -> &Refined {
        &self.refined
    }

    /// What a diagnosis may refit freely.
    pub fn trust(&self) -> &Trust {
        &self.trust
    }

    /// Whether the shape over γ and the level are refitted freely, because nothing is stated of them.
    pub fn refits_shape(&self) -> bool {
        self.trust.shape == ShapeTrust::Smooth
    }

    /// Whether the file says neither how uncertain the luminaire is nor what may be refitted of it.
    pub fn states_nothing(&self) -> bool {
        self.document.trust.is_none() && self.document.u.is_none()
    }

    /// What stated uncertainties are worth.
    pub fn u_scale(&self) -> UncertaintyScale {
        self.u_scale
    }

    /// What the model knows of its own measurement.
    pub fn uncertainty(&self) -> Option<&Uncertainty> {
        self.document.u.as_ref()
    }

    /// Where the distribution is from, as written.
    pub fn provenance(&self) -> Option<&toml::Table> {
        self.document.provenance.as_ref()
    }

    /// The same luminaire with other effects. Cheap: nothing is read again.
    #[must_use]
    pub fn with_effects(&self, effects: Vec<Effect>) -> Self {
        Self {
            effects,
            ..self.clone()
        }
    }

    /// The same model with another refit of the luminaire.
    #[must_use]
    pub fn with_refined(&self, refined: Refined) -> Self {
        Self {
            refined,
            ..self.clone()
        }
    }

    /// The same model with another emitter, distribution or spectrum.
    #[must_use]
    pub fn with_luminaire(&self, luminaire: Luminaire) -> Self {
        let same = luminaire.spectral() == self.luminaire.spectral();
        Self {
            luminaire: Arc::new(luminaire),
            smoothed_spectrum: self.smoothed_spectrum.clone().filter(|_| same),
            colour: self.colour.clone().filter(|_| same),
            ..self.clone()
        }
    }

    /// The spectra over angle, where the file names some.
    pub fn colour(&self) -> Option<&ColourOverAngle> {
        self.colour.as_deref()
    }

    pub(crate) fn smoothed_spectrum(&self) -> Option<&SmoothedSpectrum> {
        self.smoothed_spectrum.as_deref()
    }

    /// The files that the model names, as written in it and where they are.
    pub fn files(&self) -> Vec<(String, Utf8PathBuf)> {
        std::iter::once(&self.document.distribution)
            .chain(&self.document.spectrum)
            .chain(self.document.colour.iter().map(|entry| &entry.spectrum))
            .map(|name| (name.clone(), self.folder.join(name)))
            .collect()
    }

    /// The same model with its files named as if they stood beside it, under their own names.
    #[must_use]
    pub fn beside_its_files(&self) -> Self {
        let name = |path: &String| {
            Utf8Path::new(path)
                .file_name()
                .map_or_else(|| path.clone(), str::to_owned)
        };
        let mut document = (*self.document).clone();
        document.distribution = name(&document.distribution);
        document.spectrum = document.spectrum.as_ref().map(name);
        for entry in &mut document.colour {
            entry.spectrum = name(&entry.spectrum);
        }
        Self {
            document: Arc::new(document),
            ..self.clone()
        }
    }

    /// The text of the model file: complete, every path relative to it.
    pub fn to_toml(&self) -> String {
        let luminaire = LuminaireDocument {
            refined: (self.refined != Refined::default()).then(|| self.refined.clone()),
            emitter: Some(self.luminaire.emitter().clone()),
            ..(*self.document).clone()
        };
        let document = ModelDocument {
            format: MODEL_FORMAT.to_owned(),
            luminaire,
            noise: Some(NoiseDocument { u_scale: self.u_scale }),
            effect: self.effects.iter().map(table_from_effect).collect(),
        };
        // A document of plain tables and numbers always serialises; an empty text would not load and so not pass for
        // one.
        toml::to_string(&document).unwrap_or_default()
    }

    /// The emitter with the effects that replace it.
    pub fn emitter(&self) -> Emitter {
        self.effective_emitter()
            .unwrap_or_else(|| self.luminaire.emitter().clone())
    }

    /// Standard deviation in pixels of the spread of light to neighbours.
    pub fn blur_px(&self) -> f64 {
        let square: f64 = self
            .acts()
            .map(|(act, values)| match act {
                Act::Blur(law) => law(values).powi(2),
                _ => 0.0,
            })
            .sum();
        square.sqrt()
    }

    /// Which effects a simulation of a sensor applies. Those of the bench never; those of a camera's signal (exposure,
    /// linearity, zero, saturation, steps) neither, because a simulation ends at the light on the sensor.
    pub fn in_simulation(&self) -> InSimulation {
        let mut names = InSimulation::default();
        for effect in &self.effects {
            let lights = effect.acts().any(|(act, _)| {
                matches!(
                    act,
                    Act::Emitter(_)
                        | Act::Direction(_)
                        | Act::Part(_)
                        | Act::Lamp(_)
                        | Act::Path(_)
                        | Act::Placement(_)
                        | Act::Pixel(_)
                        | Act::Background(_)
                        | Act::Blur(_)
                        | Act::Efficacy(_)
                        | Act::Colour(_)
                )
            });
            if lights {
                names.applied.push(effect.name());
            } else {
                names.not_applicable.push(effect.name());
            }
        }
        names
    }

    /// Factor of the lamp's effects at a time since it was switched on; without a time warm-up is complete.
    pub fn lamp_factor(&self, time_s: Option<f64>) -> f64 {
        self.acts().fold(1.0, |factor, (act, values)| match act {
            Act::Lamp(law) => factor * law(values, time_s),
            _ => factor,
        })
    }

    /// Factor of the effects on the path, over a length in mm.
    pub fn path_factor(&self, path_mm: f64) -> f64 {
        self.acts().fold(1.0, |factor, (act, values)| match act {
            Act::Path(law) => factor * law(values, path_mm),
            _ => factor,
        })
    }

    /// Luminous efficacy of radiation in lm/W with the effects on it, where it is known.
    pub fn ler_lm_per_w(&self) -> Option<f64> {
        let factor = self.acts().fold(1.0, |factor, (act, values)| match act {
            Act::Efficacy(law) => factor * law(values),
            _ => factor,
        });
        self.luminaire.ler_lm_per_w().map(|ler| ler * factor)
    }

    /// Watts of a lumen towards a direction of this cos γ over those on the axis, by the effects: spectra over angle
    /// come on top.
    pub fn watts_of_a_lumen(&self, cos_gamma: f64) -> f64 {
        self.acts().fold(1.0, |factor, (act, values)| match act {
            Act::Colour(law) => factor * law(values, cos_gamma),
            _ => factor,
        })
    }

    /// Every act of every effect with its values, in the order of the catalogue within each kind of act.
    pub(crate) fn acts(&self) -> impl Iterator<Item = (&'static Act, &Values)> {
        let mut order: Vec<(usize, &Effect)> = self
            .effects
            .iter()
            .map(|effect| {
                let place = crate::catalogue().iter().position(|spec| spec.name == effect.name());
                (place.unwrap_or(usize::MAX), effect)
            })
            .collect();
        order.sort_by_key(|(place, _)| *place);
        order.into_iter().flat_map(|(_, effect)| effect.acts())
    }

    pub(crate) fn effective_emitter(&self) -> Option<Emitter> {
        self.effects.iter().find_map(|effect| {
            effect.acts().find_map(|(act, values)| match act {
                // At radius 0 the emitter of the file stays: a ring of no extent is no reason to forget a disc.
                Act::Emitter(law) if !effect.is_null() => Some(law(values)),
                _ => None,
            })
        })
    }

    pub(crate) fn refuse_two_emitters(&self) -> Result<(), (usize, String)> {
        let mut effects = self.effects.iter().enumerate();
        let mut found = effects.by_ref().filter(|(_, effect)| effect.spec().replaces_emitter());
        let Some((first, effect)) = found.next() else {
            return Ok(());
        };
        if !matches!(self.luminaire.emitter(), Emitter::Point {} | Emitter::Disc { .. }) {
            let name = effect.name();
            return Err((
                first,
                format!("effect `{name}` replaces the emitter of a point or disc; this model has another"),
            ));
        }
        match found.next() {
            Some((second, effect)) => Err((second, format!("effect `{}` is there twice", effect.name()))),
            None => Ok(()),
        }
    }
}
