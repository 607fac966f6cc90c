//! The table of the product information sheet (Regulation (EU) 2019/2015, Annex V, Table 3), row by row.

use isolux_record::Run;
use isolux_record::rated::EU_LABEL_KEYS;
use isolux_units::digits::K;

use super::{Cone, Label};
use crate::colour::Colour;
use crate::quantity::no_uncertainty;
use crate::ratings::rated_colour;
use crate::{Quantity, Reduction};

/// One row. Its name is this program's own: those of the product database could not be checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name for programs.
    pub name: &'static str,
    /// What it is, as Table 3 has it.
    pub what: &'static str,
    /// Its value, and where it is from.
    pub known: Known,
}

/// A value and where it is from.
#[derive(Debug, Clone, PartialEq)]
pub enum Known {
    /// Measured: the value as Table 3 rounds it, its unit, and the measured number.
    Measured {
        /// As the sheet has it.
        value: String,
        /// Its unit; empty for a word.
        unit: &'static str,
        /// What was measured.
        quantity: Option<Quantity>,
    },
    /// Stated in the job.
    Stated(String),
    /// Not known, and why.
    NotKnown(String),
}

/// Why a displacement factor is not given.
const NO_HARMONICS: &str = "not measured: cos φ1 needs a power meter that separates the fundamentals of voltage and current; \
    the power factor holds the harmonics as well";
const NO_SPECTRUM: &str = "no spectrum was taken";
const NO_POWER: &str = "no power meter was read";
/// Why a text of the supplier is not known.
pub const NOT_STATED: &str = "not stated in [eu_label.stated] of the job";

/// All rows, in the order of Table 3.
pub(super) fn rows(label: &Label, reduction: &Reduction, run: &Run) -> Vec<Row> {
    let mut rows = Rows {
        label,
        run,
        rows: Vec::new(),
    };
    let luminaire = &run.header.luminaire;
    let model = luminaire.catalogue_number.as_ref().or(luminaire.name.as_ref());
    rows.subject(
        "supplier",
        "supplier's name or trade mark",
        luminaire.maker.as_ref(),
        "luminaire.maker",
    );
    rows.stated("supplier_address");
    rows.subject(
        "model_identifier",
        "model identifier",
        model,
        "luminaire.catalogue_number",
    );
    rows.stated("lighting_technology");
    rows.directional();
    rows.stated("cap_type");
    rows.mains();
    for name in [
        "connected",
        "colour_tuneable",
        "envelope",
        "high_luminance",
        "anti_glare_shield",
        "dimmable",
    ] {
        rows.stated(name);
    }
    rows.energy(reduction);
    rows.useful_flux();
    let colour = reduction.over_angle.as_ref().map(|of| &of.facts.total.colour);
    let colour = colour.or_else(|| reduction.spectral.as_ref().map(|of| &of.colour));
    rows.colour(colour);
    for name in [
        "standby_power_w",
        "networked_standby_power_w",
        "height_mm",
        "width_mm",
        "depth_mm",
        "equivalent_power_w",
    ] {
        rows.stated(name);
    }
    if label.directional.is_directional {
        rows.beam(reduction);
    }
    rows.of_colour(
        "r9",
        "R9 colour rendering index value",
        colour.map(|colour| &colour.r9),
        |r9| format!("{r9:.0}"),
        "",
    );
    for name in ["survival_factor", "lumen_maintenance_factor", "lifetime_h"] {
        rows.stated(name);
    }
    rows.push(
        "displacement_factor",
        "displacement factor (cos φ1)",
        Known::NotKnown(NO_HARMONICS.to_owned()),
    );
    rows.consistency(reduction);
    rows.stated("flicker_pst_lm");
    rows.stated("stroboscopic_svm");
    rows.rows
}

struct Rows<'a> {
    label: &'a Label,
    run: &'a Run,
    rows: Vec<Row>,
}

impl Rows<'_> {
    fn push(&mut self, name: &'static str, what: &'static str, known: Known) {
        self.rows.push(Row { name, what, known });
    }

    fn measured(&mut self, name: &'static str, what: &'static str, value: String, unit: &'static str, of: &Quantity) {
        let quantity = Some(of.clone());
        self.push(name, what, Known::Measured { value, unit, quantity });
    }

    /// A text of `[eu_label.stated]`.
    fn stated(&mut self, name: &'static str) {
        let Some(key) = EU_LABEL_KEYS.iter().find(|key| key.name == name) else {
            return;
        };
        let text = self.run.header.eu_label.text(name);
        let known = text.map_or_else(
            || Known::NotKnown(NOT_STATED.to_owned()),
            |text| Known::Stated(text.to_owned()),
        );
        self.push(name, key.what, known);
    }

    /// A text of another table of the job.
    fn subject(&mut self, name: &'static str, what: &'static str, text: Option<&String>, key: &str) {
        let not_known = || Known::NotKnown(format!("the job does not state {key}"));
        self.push(
            name,
            what,
            text.map_or_else(not_known, |text| Known::Stated(text.clone())),
        );
    }

    fn directional(&mut self) {
        let directional = &self.label.directional;
        let word = if directional.is_directional { "DLS" } else { "NDLS" };
        let share = directional.share.clone();
        self.measured(
            "directional",
            "non-directional or directional",
            word.to_owned(),
            "",
            &share,
        );
    }

    fn mains(&mut self) {
        let known = match self.run.header.eu_label.mains {
            Some(mains) => Known::Stated(if mains { "MLS" } else { "NMLS" }.to_owned()),
            None => Known::NotKnown("the job does not say eu_label.mains".to_owned()),
        };
        self.push("mains", "mains or non-mains", known);
    }

    fn energy(&mut self, reduction: &Reduction) {
        let power = reduction.electrical.as_ref().map(|line| line.power.clone());
        let (consumption, on_mode) = (
            ("energy_consumption", "energy consumption in on-mode, rounded up"),
            ("on_mode_power", "on-mode power"),
        );
        match &power {
            Some(power) => {
                // A watt is a kilowatt-hour in 1000 hours.
                let up = format!("{:.0}", power.value.ceil());
                self.measured(consumption.0, consumption.1, up, "kWh/1000 h", power);
                self.measured(on_mode.0, on_mode.1, format!("{:.1}", power.value), "W", power);
            }
            None => {
                for (name, what) in [consumption, on_mode] {
                    self.push(name, what, Known::NotKnown(NO_POWER.to_owned()));
                }
            }
        }
        let (name, what) = ("energy_class", "energy efficiency class");
        match (&self.label.efficacy, self.label.class) {
            (Ok(efficacy), Some(class)) => {
                let efficacy = efficacy.clone();
                self.measured(name, what, class.letter().to_owned(), "", &efficacy);
            }
            (Err(why), _) => self.push(name, what, Known::NotKnown((*why).to_owned())),
            (Ok(_), None) => {}
        }
    }

    fn useful_flux(&mut self) {
        let flux = self.label.useful_flux.clone();
        let cone = self.label.cone.words().to_owned();
        let rounded = format!("{:.0}", flux.value);
        self.measured("useful_flux", "useful luminous flux", rounded, "lm", &flux);
        let known = Known::Measured {
            value: cone,
            unit: "",
            quantity: None,
        };
        self.push("useful_flux_in", "where the useful luminous flux lies", known);
    }

    fn colour(&mut self, colour: Option<&Colour>) {
        let hundreds = |cct: f64| format!("{:.0}", (cct / 100.0).round() * 100.0);
        let whole = |ra: f64| format!("{ra:.0}");
        let thousandths = |x: f64| format!("{x:.3}");
        self.of_colour(
            "cct",
            "correlated colour temperature, to 100 K",
            colour.map(|of| &of.cct),
            hundreds,
            "K",
        );
        self.of_colour("cri", "colour rendering index", colour.map(|of| &of.ra), whole, "");
        self.of_colour(
            "x",
            "chromaticity coordinate x",
            colour.map(|of| &of.x),
            thousandths,
            "",
        );
        self.of_colour(
            "y",
            "chromaticity coordinate y",
            colour.map(|of| &of.y),
            thousandths,
            "",
        );
    }

    fn of_colour(
        &mut self,
        name: &'static str,
        what: &'static str,
        of: Option<&Option<Quantity>>,
        rounded: impl Fn(f64) -> String,
        unit: &'static str,
    ) {
        match of {
            Some(Some(quantity)) => self.measured(name, what, rounded(quantity.value), unit, quantity),
            Some(None) => self.push(name, what, Known::NotKnown("the light has none".to_owned())),
            None => self.push(name, what, Known::NotKnown(NO_SPECTRUM.to_owned())),
        }
    }

    fn beam(&mut self, reduction: &Reduction) {
        let peak = &reduction.i_max;
        self.measured(
            "peak_intensity",
            "peak luminous intensity",
            format!("{:.0}", peak.value),
            "cd",
            peak,
        );
        let known = match self.label.directional.beam_deg {
            Some(beam) => Known::Measured {
                value: format!("{beam:.0}"),
                unit: "°",
                quantity: None,
            },
            None => {
                Known::NotKnown("the intensity does not fall to half of that on the axis in every plane".to_owned())
            }
        };
        self.push("beam_angle", "beam angle, 50 % of the intensity on the axis", known);
    }

    fn consistency(&mut self, reduction: &Reduction) {
        let (name, what) = (
            "colour_consistency",
            "colour consistency, in steps of 0.0011 in u′v′ in place of MacAdam ellipses",
        );
        let declared = self.run.header.ratings.rated_xy.is_some();
        match rated_colour(reduction, self.run).filter(|_| declared) {
            Some(rated) => self.measured(name, what, format!("{:.1}", rated.steps.value), "steps", &rated.steps),
            None if declared => self.push(name, what, Known::NotKnown(NO_SPECTRUM.to_owned())),
            None => {
                let why = "the job does not state ratings.rated_xy, the centre that the supplier declares";
                self.push(name, what, Known::NotKnown(why.to_owned()));
            }
        }
    }
}

impl Row {
    /// The expanded uncertainty (k = 2) of what was measured, where it is known; its unit is that of the measured
    /// number.
    pub fn expanded(&self) -> Option<(f64, &Quantity)> {
        match &self.known {
            Known::Measured {
                quantity: Some(quantity),
                ..
            } => Some((K * quantity.u?, quantity)),
            _ => None,
        }
    }
}

impl Label {
    /// The sentence on the class: how probable another one is.
    pub fn sentence(&self) -> String {
        let class = match (&self.efficacy, self.class) {
            (Ok(efficacy), Some(class)) => format!(
                "Class {}: total mains efficacy {}, of {} in the {}.",
                class.letter(),
                efficacy.brief(),
                self.useful_flux.brief(),
                self.cone.words()
            ),
            (Err(why), _) => format!("The class is not known: {why}."),
            (Ok(_), None) => String::new(),
        };
        let directional = &self.directional;
        let kind = if directional.is_directional {
            "directional"
        } else {
            "not directional"
        };
        let share = format!(
            "The light source is {kind} (80 % within the cone of 120° are needed): {} lie there, about γ {}°.",
            directional.share.brief(),
            directional.axis_gamma_deg
        );
        let others: Vec<String> = self
            .probabilities
            .iter()
            .map(|(class, share)| format!("{} {:.1} %", class.letter(), 100.0 * share))
            .collect();
        let probabilities = match (others.len(), self.class) {
            (_, None) => String::new(),
            (0, _) => {
                let missing = self
                    .efficacy
                    .as_ref()
                    .map_or_else(|_| String::new(), |of| no_uncertainty(&of.missing));
                format!(" How probable another class is, is not known: the efficacy has {missing}.")
            }
            _ => format!(
                " Probability by the uncertainty of the efficacy alone: {}.",
                others.join(", ")
            ),
        };
        let near = match self.cone {
            Cone::Sphere => String::new(),
            Cone::Wide | Cone::Narrow => directional.beam_deg.map_or_else(String::new, |beam| {
                format!(" The beam angle is {beam:.1}°; from 90° on the cone of 120° counts.")
            }),
        };
        format!("{class}{probabilities} {share}{near}")
    }
}
