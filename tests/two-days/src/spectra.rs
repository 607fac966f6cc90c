//! The spectrum of a second day against the model of the first.

use camino::Utf8Path;
use isolux_app::diagnosis::diagnose::{self, DiagnoseRequest, DiagnosisResult};
use isolux_app::files::Overwrite;
use isolux_app::front_end::progress::Silent;
use isolux_darkroom::Darkroom;

use crate::case::StatedDiagnosis;
use crate::days::{self, DayError, Days};
use crate::lamps::Lamp;

/// What is otherwise on the second day.
pub struct Second<'a> {
    /// In the room.
    pub change: &'a dyn Fn(&mut Darkroom),
    /// Another spectroradiometer reads.
    pub other_instrument: bool,
}

impl Default for Second<'_> {
    fn default() -> Self {
        Self {
            change: &|_| {},
            other_instrument: false,
        }
    }
}

/// What a diagnosis says of the spectrum of a second day.
///
/// # Errors
/// As scans, reductions and diagnosis.
pub fn answer(
    days: &Days,
    root: &Utf8Path,
    (lamp, seed, day): (Lamp, u64, u64),
    second: &Second<'_>,
) -> Result<StatedDiagnosis, DayError> {
    let model = days.model(lamp, seed)?;
    let known = lamp.room(seed, day);
    let mut room = known.clone();
    (second.change)(&mut room);
    let folder = root.join(format!("second-{day}"));
    let spectrum = days::second_spectrum(&room, &known, &folder.join("run"))?;
    if !second.other_instrument {
        same_instrument(&model, &spectrum)?;
    }
    let request = DiagnoseRequest {
        model: model.as_ref().clone(),
        observations: vec![spectrum],
        out: folder.join("diagnosis"),
        held_out: None,
        seed: 1,
        accept: false,
        overwrite: Overwrite::Never,
    };
    let DiagnosisResult { document, .. } = diagnose::run(&request, &Silent)?;
    Ok(StatedDiagnosis::of(&document))
}

/// The room draws its instruments with the seed of the day; here the one of the first day reads on the second, too.
fn same_instrument(model: &Utf8Path, spectrum: &Utf8Path) -> Result<(), DayError> {
    let wrong = |error: std::io::Error| DayError(error.to_string());
    let read = |file: &Utf8Path| std::fs::read_to_string(file).map_err(wrong);
    let (model, text) = (read(model)?, read(spectrum)?);
    let named = |line: &&str| line.starts_with("instrument = ");
    let (Some(first), Some(second)) = (model.lines().find(named), text.lines().find(named)) else {
        return Err(DayError("a file names no instrument".to_owned()));
    };
    std::fs::write(spectrum, text.replace(second, first)).map_err(wrong)
}
