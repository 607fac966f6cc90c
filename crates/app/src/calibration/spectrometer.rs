//! `calibrate spectroradiometer --lines`, `--cut-on`, `--linearity`: what a procedure finds of the instrument itself
//! becomes a file that the station names, and by which every spectrum is corrected.

mod found;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::document::read_text;
use isolux_record::filter::CutOnFilter;
use isolux_record::lines::{LineList, MERCURY_ARGON};
use isolux_record::run::StopHow;
use isolux_record::{Run, Subject};
use isolux_reduce::spectrometer::{self, InstrumentError};

use super::{AtBench, FOLDER, recorded};
use crate::files::{self as disk_files, Overwrite};
use crate::instruments::bench::StationFiles;
use crate::run::record;
use crate::{Failure, history};

pub use found::Found;

/// Spectra averaged in a block of lines, of light behind a filter, at an integration time.
const OF_LINES: u32 = 30;
const BEHIND_FILTER: u32 = 40;
const AT_A_TIME: u32 = 20;
/// Peaks of the spectra that show linearity, as shares of saturation: the first and the last are the brightest.
const PEAKS: [f64; 7] = [0.75, 0.5, 0.3, 0.2, 0.12, 0.07, 0.75];

/// What is found, and with what.
#[derive(Debug, Clone, PartialEq)]
pub enum Procedure {
    /// Wavelength scale and bandpass, from the lines of a lamp close before the entrance.
    Lines(LineList),
    /// Scattered light, from what is seen where a filter before the entrance is opaque.
    CutOn(CutOnFilter),
    /// Linearity, from the light of a steady lamp at several integration times.
    Linearity,
}

impl Procedure {
    /// The lines of the lamp `named`, or of the list in that file.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line.
    pub fn lines(named: &str) -> Result<Self, Failure> {
        if named == MERCURY_ARGON {
            return Ok(Self::Lines(LineList::mercury_argon()));
        }
        let file = Utf8Path::new(named);
        let text = read_text(file).map_err(|error| {
            let help = format!("--lines is {MERCURY_ARGON}, or a file of the format isolux-lines/1");
            Failure::bad_input(error).help(help)
        })?;
        LineList::parse(file, &text)
            .map(Self::Lines)
            .map_err(Failure::bad_input)
    }

    /// With the filter of that file before the entrance.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line.
    pub fn cut_on(file: &Utf8Path) -> Result<Self, Failure> {
        let text = read_text(file).map_err(Failure::bad_input)?;
        CutOnFilter::parse(file, &text)
            .map(Self::CutOn)
            .map_err(Failure::bad_input)
    }

    /// What it is called in the record.
    fn name(&self) -> String {
        match self {
            Self::Lines(list) => format!("lines of {}", list.lamp),
            Self::CutOn(filter) => format!("light behind {}", filter.designation),
            Self::Linearity => "linearity".to_owned(),
        }
    }

    /// The plan as text.
    fn plan(&self) -> String {
        let mut text = format!("format = \"isolux-plan/1\"\nname = {:?}\n", self.name());
        let mut block = |number: usize, kind: &str, rest: &str| {
            text += &format!(
                "\n[[block]]\nname = \"spectrum {number}\"\nkind = \"{kind}\"\ninstrument = \"spectroradiometer\"\n\
                 c_deg = 0\ngamma_deg = 0\n{rest}"
            );
        };
        match self {
            Self::Lines(_) => (1..=2).for_each(|number| block(number, "lamp_off", &format!("repeats = {OF_LINES}\n"))),
            Self::CutOn(_) => (1..=2).for_each(|number| block(number, "lit", &format!("repeats = {BEHIND_FILTER}\n"))),
            Self::Linearity => PEAKS.iter().enumerate().for_each(|(place, peak)| {
                let rest = format!("repeats = {AT_A_TIME}\npeak_counts_rel = {peak:?}\n");
                block(place + 1, "lit", &rest);
            }),
        }
        text
    }

    fn subject(&self) -> Subject {
        let mut subject = Subject::default();
        subject.luminaire.name = Some(self.name());
        subject
    }

    fn found(&self, run: &Run) -> Result<Found, InstrumentError> {
        match self {
            Self::Lines(list) => spectrometer::wavelengths(run, list).map(Found::Wavelengths),
            Self::CutOn(filter) => spectrometer::scatter(run, filter).map(Found::Scatter),
            Self::Linearity => spectrometer::linearity(run).map(Found::Linearity),
        }
    }
}

/// What was found and the files that were written.
#[derive(Debug)]
pub struct Done {
    /// What was found.
    pub found: Found,
    /// The folder of its files.
    pub folder: Utf8PathBuf,
    /// Their names.
    pub files: Vec<String>,
}

/// Carries `procedure` out on the bench of `station` and computes what the record says.
///
/// # Errors
/// Bad input (exit 2), before anything is opened, for a station without a spectroradiometer. "No" (exit 1) where the
/// record does not show what is to be found. As a scan for the rest.
pub fn run(procedure: &Procedure, station: &Utf8Path, bench: &AtBench<'_>) -> Result<Done, Failure> {
    let source = StationFiles::load(station)?;
    let recorded = recorded(bench.out)?;
    if recorded != Some(StopHow::Completed) {
        if source.station.spectroradiometer().is_none() {
            return Err(Failure::bad_input(format!("{station}: has no [spectroradiometer]")));
        }
        bench.scan(&source, &procedure.plan(), &procedure.subject(), recorded.is_some())?;
    }
    let run = record::read_at_rest(bench.out)?;
    let header = disk_files::read(&bench.out.join("run.toml"))?;
    let mut found = procedure.found(&run).map_err(|error| {
        let message = format!("{}: {error}", bench.out);
        if error.is_input() {
            return Failure::bad_input(message);
        }
        Failure::no(message).help("nothing was written; the record stays as evidence, begin again in another folder")
    })?;
    found.made_mut().record_sha256 = isolux_record::disk::sha256(&header);
    let folder = bench.out.join(FOLDER);
    let made = found.files()?;
    for (name, text) in &made {
        // They are computed from the record, whose hash is in them: the same again, or those of a better program.
        disk_files::write(&folder.join(name), text.as_bytes(), Overwrite::Force)?;
    }
    history::add(station, &found.entries(bench.out))?;
    Ok(Done {
        found,
        folder,
        files: made.into_iter().map(|(name, _)| name).collect(),
    })
}
