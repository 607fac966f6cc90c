//! A folder to start from.

use std::path::PathBuf;
use std::sync::{Arc, PoisonError};

use camino::Utf8PathBuf;
use isolux_app::files::Overwrite;
use isolux_app::init::subject::Subject;
use isolux_app::init::{self, DayPlan, Instruments};
use pyo3::prelude::*;

use super::{Noted, Notes};
use crate::error::{bad_input, raised};
use crate::path::utf8;

/// Writes a station, plan, scene and job to start from into `folder`; the files written.
#[pyfunction(name = "init")]
#[pyo3(signature = (folder, *, lamp=None, plan="near", in_motion=false, colour=false, overwrite=false))]
pub(crate) fn begin_folder(
    py: Python<'_>,
    folder: PathBuf,
    lamp: Option<PathBuf>,
    plan: &str,
    in_motion: bool,
    colour: bool,
    overwrite: bool,
) -> PyResult<Vec<PathBuf>> {
    let folder = utf8(py, folder)?;
    let instruments = Instruments {
        in_motion,
        colour,
        ..Instruments::default()
    };
    let (subject, overwrite) = (Subject::default(), Overwrite::requested(overwrite));
    let written = if let Some(lamp) = lamp {
        let notes = Notes::default();
        let noted = Noted(Arc::clone(&notes));
        let written = init::for_lamp(&folder, &utf8(py, lamp)?, &instruments, &subject, overwrite, &noted);
        let notes = std::mem::take(&mut *notes.lock().unwrap_or_else(PoisonError::into_inner));
        for note in notes {
            py.import("warnings")?.call_method1("warn", (note,))?;
        }
        written
    } else {
        let known = DayPlan::named(plan).ok_or_else(|| {
            let names = DayPlan::ALL.map(DayPlan::name).join(", ");
            bad_input(py, format!("no plan is named {plan}"), &format!("one of: {names}"))
        })?;
        init::run(&folder, known, &instruments, &subject, overwrite)
    };
    let written = written.map_err(|failure| raised(py, failure))?;
    Ok(written.into_iter().map(Utf8PathBuf::into_std_path_buf).collect())
}
