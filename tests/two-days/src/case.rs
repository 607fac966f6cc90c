//! One case: the first day's model, the second day with one fault or none, and what `isolux diagnose` says.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::diagnosis::diagnose::{self, DiagnosisResult};
use isolux_app::files::Overwrite;
use isolux_app::front_end::progress::Silent;
use isolux_darkroom::Darkroom;
use isolux_diagnose::assumed::Part;
use isolux_diagnose::document::Document;
use isolux_diagnose::observe::observed;
use isolux_diagnose::table::{ObservationKind, Row};
use isolux_hidden_effects::random::Draws;
use isolux_model::Model;
use isolux_record::observation::{MapSet, Need, Observations, open};
use nalgebra::DVector;

use crate::days::{self, DayError, Days};
use crate::faults::{Drawn, FAULTS, Fault, Kind};
use crate::lamps::Lamp;
use crate::oracle::{self, LookAlike};
use crate::plans::Grid;
use crate::strength::{Known, change, reaching};
use crate::truth::Places;

/// What is wanted of a case.
#[derive(Debug, Clone)]
pub struct Order {
    /// What is recorded on the second day.
    pub kind: Kind,
    /// The fault of the second day, and how strong it is to be, in σ above noise and the model's own uncertainty.
    pub fault: Option<(&'static Fault, f64)>,
    /// The lamp.
    pub lamp: Lamp,
    /// Where the second scan reads; maps are the same on every grid.
    pub grid: Grid,
    /// Number of the lamp among those of its kind, and of its first day.
    pub seed: u64,
    /// Number of the second day: its noise, and what is drawn of the fault.
    pub day: u64,
}

/// What came of a case.
#[derive(Debug)]
pub enum Outcome {
    /// No lamp shows the fault as strong within its plausible range: what lies beyond is never named for sure.
    TooWeak,
    /// The second scan itself ended early: the operator knows that something is wrong before any diagnosis.
    Stopped(String),
    /// There is an answer.
    Answered(Box<Case>),
}

/// A case with its answer.
#[derive(Debug)]
pub struct Case {
    /// What was wanted, with the lamp on which the fault could be as strong.
    pub order: Order,
    /// Strength of the fault and what was drawn with it.
    pub fault: String,
    /// How strong the fault is in what was recorded, in σ; 0 without one.
    pub sigma: f64,
    /// The answer.
    pub stated: StatedDiagnosis,
    /// The effect that comes nearest to the fault's change and is not it.
    pub look_alike: Option<LookAlike>,
    /// Share of the gap that is gone where nobody looked: 1 is what the first day's model leaves without the fault.
    pub removed: Option<f64>,
    /// Time of `isolux diagnose`, s.
    pub seconds: f64,
}

/// The answer in the few words that the shares need.
#[derive(Debug)]
pub struct StatedDiagnosis {
    /// `consistent`, `named`, `ambiguous`, `unexplained`.
    pub verdict: String,
    /// Every effect that was added: its name, the other names of its set, its probability.
    pub effects: Vec<(String, Vec<String>, f64)>,
    /// The sentence.
    pub sentence: String,
    /// rms of the disagreement in σ of the readings: as given, refitted, with the effects, and expected of noise.
    pub gap: [f64; 4],
}

impl StatedDiagnosis {
    /// From `diagnosis.json`.
    pub fn of(document: &Document) -> Self {
        let gap = &document.gap;
        let effects = document.effects.iter();
        Self {
            verdict: format!("{:?}", document.verdict).to_lowercase(),
            effects: effects
                .map(|effect| {
                    let others = effect.equivalents.clone();
                    (effect.name.clone().into_owned(), others, effect.evidence.posterior)
                })
                .collect(),
            sentence: document.sentence.clone(),
            gap: [gap.as_given, gap.before, gap.after, gap.floor],
        }
    }
}

/// What the second day looks at and how well it sees.
struct Look {
    places: Places,
    rows: Vec<Row>,
}

/// Plays the second day of an order below `folder`, and diagnoses the first day's model against it.
///
/// # Errors
/// Where a day without a fault, the capture or the diagnosis fails: a mistake of this program or of the workflow.
pub fn play(days: &Days, order: &Order, folder: &Utf8Path) -> Result<Outcome, DayError> {
    let Some((fault, wanted)) = order.fault else {
        let room = order.lamp.room(order.seed, order.day);
        return answered(days, order.clone(), folder, (&room, &room), None);
    };
    // On the lamp of the order where that shows the fault so strongly, else on another.
    let first = Lamp::ALL.iter().position(|lamp| *lamp == order.lamp).unwrap_or(0);
    for turn in 0..Lamp::ALL.len() {
        let order = Order {
            lamp: Lamp::ALL[(first + turn) % Lamp::ALL.len()],
            ..order.clone()
        };
        let number = FAULTS.iter().position(|other| std::ptr::eq(other, fault)).unwrap_or(0);
        let drawn = fault.draw(&mut Draws::new(order.day, number as u64));
        let without = drawn.within(order.lamp.room(order.seed, order.day), 0.0);
        let Some(strength) = strength(days, &order, &drawn, &without, wanted)? else {
            continue;
        };
        let with = drawn.within(order.lamp.room(order.seed, order.day), strength);
        return answered(days, order, folder, (&with, &without), Some((&drawn, strength)));
    }
    Ok(Outcome::TooWeak)
}

/// Sees the places of a day without a fault as the station does.
fn look(days: &Days, order: &Order) -> Result<Look, DayError> {
    Ok(match order.kind {
        Kind::Readings => {
            let hasty = order.fault.is_some_and(|(fault, _)| fault.hasty());
            of_readings(days.readings(order.lamp, order.grid, hasty)?.as_ref())?
        }
        Kind::Maps => of_maps(days.maps(order.lamp, order.seed)?.as_ref().clone()),
    })
}

fn of_readings(readings: &Observations) -> Result<Look, DayError> {
    let (seen, _) = observed(readings, 0);
    let Part::Readings(at) = seen.part else {
        return Err(DayError("the second scan holds no readings".to_owned()));
    };
    Ok(Look {
        places: Places::Readings(at),
        rows: seen.rows,
    })
}

fn of_maps(maps: MapSet) -> Look {
    let (signal, u) = maps.values().unwrap_or_default();
    let rows = signal
        .iter()
        .zip(u)
        .map(|(signal, u)| Row::bare(ObservationKind::Bin, *signal, *u))
        .collect();
    Look {
        places: Places::Maps(maps),
        rows,
    }
}

fn model_of(days: &Days, order: &Order) -> Result<(Arc<Utf8PathBuf>, Model), DayError> {
    let file = days.model(order.lamp, order.seed)?;
    let model = Model::load(&file).map_err(|error| DayError(error.to_string()))?;
    Ok((file, model))
}

/// The strength that reaches `wanted` σ; none where its plausible range does not.
fn strength(
    days: &Days,
    order: &Order,
    drawn: &Drawn,
    without: &Darkroom,
    wanted: f64,
) -> Result<Option<f64>, DayError> {
    let look = look(days, order)?;
    let (_, model) = model_of(days, order)?;
    let Some(known) = Known::new(&model, &look.places, &look.rows) else {
        return Err(DayError("the first day's model predicts no second day".to_owned()));
    };
    let plain = look.places.truth(without);
    let room = order.lamp.room(order.seed, order.day);
    let sigma = |strength: f64| {
        let with = look.places.truth(&drawn.within(room.clone(), strength));
        known.sigma(&change(&with, &plain))
    };
    Ok(reaching(wanted, drawn.fault.plausible, sigma))
}

/// Scans or captures in the room `with`, diagnoses, and judges the answer by the rooms with and without the fault.
fn answered(
    days: &Days,
    order: Order,
    folder: &Utf8Path,
    (with, without): (&Darkroom, &Darkroom),
    fault: Option<(&Drawn, f64)>,
) -> Result<Outcome, DayError> {
    let observations = match order.kind {
        Kind::Readings => {
            let run = folder.join("run");
            let hasty = fault.is_some_and(|(drawn, _)| drawn.fault.hasty());
            if let Err(failure) = days::second_scan(with, without, order.grid, hasty, &run) {
                return Ok(Outcome::Stopped(failure.message));
            }
            run
        }
        Kind::Maps => days::second_maps(with, folder)?,
    };
    let (model_file, model) = model_of(days, &order)?;
    let out = folder.join("diagnosis");
    let request = diagnose::DiagnoseRequest {
        model: model_file.as_ref().clone(),
        observations: vec![observations.clone()],
        out: out.clone(),
        held_out: None,
        seed: 1,
        accept: false,
        overwrite: Overwrite::Never,
    };
    let started = Instant::now();
    let DiagnosisResult { document, .. } = diagnose::run(&request, &Silent)?;
    let seconds = started.elapsed().as_secs_f64();
    let mut case = Case {
        fault: fault.map_or_else(String::new, |(drawn, strength)| drawn.words(strength)),
        sigma: 0.0,
        stated: StatedDiagnosis::of(&document),
        look_alike: None,
        removed: None,
        seconds,
        order,
    };
    if let Some((drawn, _)) = fault {
        let after = Model::load(&out.join("model.after.toml")).map_err(|error| DayError(error.to_string()))?;
        judge(&mut case, drawn, &observations, (&model, &after), (with, without))?;
    }
    Ok(Outcome::Answered(Box::new(case)))
}

/// What is known of a case by whoever made it.
fn judge(
    case: &mut Case,
    drawn: &Drawn,
    observations: &Utf8Path,
    (given, after): (&Model, &Model),
    (with, without): (&Darkroom, &Darkroom),
) -> Result<(), DayError> {
    let look = match open(observations, Need::Values).map_err(|error| DayError(error.to_string()))? {
        Observations::Maps(maps) => of_maps(maps),
        readings @ Observations::Readings(_) => of_readings(&readings)?,
        Observations::Spectra(_) => return Ok(()),
    };
    let Some(known) = Known::new(given, &look.places, &look.rows) else {
        return Err(DayError("the first day's model predicts no second day".to_owned()));
    };
    let (with_fault, plain) = (look.places.truth(with), look.places.truth(without));
    let change = change(&with_fault, &plain);
    case.sigma = known.sigma(&change);
    if case.order.fault.is_some_and(|(_, wanted)| wanted >= 10.0) {
        case.look_alike = oracle::nearest(&known, &look.rows, &change, drawn.fault.effect);
    }
    case.removed = removed(&look.places.kept_back(), (given, after), (with, without));
    Ok(())
}

/// Share of the gap that is gone where nobody looked; none where the fault hardly shows there beside what the first
/// day's model leaves anyway.
fn removed(
    kept_back: &Places,
    (given, after): (&Model, &Model),
    (with, without): (&Darkroom, &Darkroom),
) -> Option<f64> {
    let (truth, plain) = (kept_back.truth(with), kept_back.truth(without));
    let sigma = kept_back.noise(without, &plain);
    let scaled = |values: &[f64]| DVector::from_iterator(values.len(), values.iter().zip(&sigma).map(|(v, s)| v / s));
    let left = |model: &Model, truth: &[f64]| {
        let truth = scaled(truth);
        let mut predicted = match kept_back {
            Places::Readings(readings) => scaled(&model.predict_readings(readings)),
            Places::Maps(maps) => scaled(&model.predict_maps(maps)),
        };
        // What one lux is of a relative signal is in no file.
        if matches!(kept_back, Places::Maps(_)) {
            predicted *= predicted.dot(&truth) / predicted.norm_squared();
        }
        (truth - predicted).norm_squared()
    };
    let (before, floor, after) = (left(given, &truth), left(given, &plain), left(after, &truth));
    (before > 1.1 * floor + 16.0).then(|| (before - after) / (before - floor))
}

impl Case {
    /// The effect that the fault is, where the catalogue has a name for it.
    pub fn truth(&self) -> Option<&'static str> {
        self.order.fault.and_then(|(fault, _)| fault.effect)
    }

    /// Whether the plan can tell the fault from every other effect.
    pub fn separable(&self) -> bool {
        self.truth().is_some()
            && self
                .look_alike
                .as_ref()
                .is_none_or(|nearest| nearest.left >= oracle::SEPARABLE_SIGMA)
    }

    /// One line for a developer.
    pub fn line(&self) -> String {
        let order = &self.order;
        let mut text = format!(
            "{:?} {} {} seed {} day {}",
            order.kind,
            order.lamp.name(),
            order.grid.name(),
            order.seed,
            order.day
        );
        match order.fault {
            None => text.push_str(" no fault"),
            Some((fault, wanted)) => {
                let _ = write!(
                    text,
                    " {} {wanted} σ ({:.1} σ: {})",
                    fault.label, self.sigma, self.fault
                );
            }
        }
        let _ = write!(text, " → {}", self.stated.verdict);
        for (name, others, posterior) in &self.stated.effects {
            let _ = write!(text, " {name} {posterior:.3} {others:?}");
        }
        let [given, before, after, floor] = self.stated.gap;
        let _ = write!(text, "; gap {given:.2} | {before:.2} | {after:.2}, floor {floor:.2}");
        if let Some(nearest) = &self.look_alike {
            let _ = write!(text, "; nearest {} {:.1} σ", nearest.name, nearest.left);
        }
        if let Some(removed) = self.removed {
            let _ = write!(text, "; removed {removed:.3}");
        }
        let _ = write!(text, "; {:.2} s; {}", self.seconds, self.stated.sentence);
        text
    }
}
