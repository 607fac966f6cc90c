//! run.toml: what a run is of, how far it is known to be written, and the checksum that says that nobody changed it
//! since.

use camino::Utf8Path;
use jiff::{SignedDuration, Timestamp};
use serde::{Deserialize, Serialize};

use super::error::{RunError, vacant};
use super::format::{FORMAT, FORMAT_3};
use crate::disk::sha256;
use crate::document::{SourceText, read_text};
use crate::event::{Event, Logged, StopHow};
use crate::plan::Plan;
use crate::rated::{EuLabel, Ratings};
use crate::reading::Reading;
use crate::readings::Layout;
use crate::responsivity::MeterCurves;
use crate::spectra::SpectralCalibration;
use crate::station::Station;
use crate::subject::{Commission, Luminaire, Subject};
use crate::sweeps::SweepEntry;

/// run.toml.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunHeader {
    /// [`FORMAT`], or [`FORMAT_3`] of a run that an earlier program began.
    pub format: String,
    /// Name and version of the program that wrote the run.
    pub program: String,
    /// UTC of the start, RFC 3339.
    pub started_utc: String,
    /// UTC of the last switching on of the lamp; none before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp_on_utc: Option<String>,
    /// How often the lamp was switched on.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub burnings: u32,
    /// Rows that readings.csv holds at least.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub written: Option<Written>,
    /// How the run ended; none while it lasts, and for ever if its program was killed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped: Option<Stopped>,
    /// When the run was resumed, the first start left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resumed: Vec<Resumed>,
    /// The spectra of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spectrum: Vec<SpectrumEntry>,
    /// The sweeps of the run, torn ones among them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sweep: Vec<SweepEntry>,
    /// Identities of the instruments.
    #[serde(default)]
    pub device: Vec<DeviceRecord>,
    /// Calibration of the spectroradiometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectral: Option<SpectralCalibration>,
    /// What the head of the lux meter answers over wavelength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub luxmeter: Option<MeterCurves>,
    /// What was measured.
    #[serde(default, skip_serializing_if = "Luminaire::is_empty")]
    pub luminaire: Luminaire,
    /// For whom.
    #[serde(default, skip_serializing_if = "Commission::is_empty")]
    pub report: Commission,
    /// What its light is rated by.
    #[serde(default, skip_serializing_if = "Ratings::is_empty")]
    pub ratings: Ratings,
    /// The light source for an EU energy label.
    #[serde(default, skip_serializing_if = "EuLabel::is_empty")]
    pub eu_label: EuLabel,
    /// What the history of the bench said of it when the run began.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bench_check: Vec<BenchCheck>,
    /// The station as it was.
    pub station: Station,
    /// The plan as it was.
    pub plan: Plan,
}

/// The last calibration, or the last check of a reference lamp or reading, of one quantity.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchCheck {
    /// What was followed.
    pub quantity: String,
    /// UTC of its last value, RFC 3339.
    pub time_utc: String,
    /// Whether it is within its limits; none: there are too few values for limits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_control: Option<bool>,
    /// The same in words.
    pub sentence: String,
}

/// Rows that readings.csv holds at least, and the `chain` of two of them: rows that are lost or of another run are
/// missed, even where the program was killed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// How many.
    pub readings: u64,
    /// `chain` of the first.
    pub first_chain: String,
    /// `chain` of the last of them.
    pub chain: String,
}

/// A further session at the bench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Resumed {
    /// UTC, RFC 3339.
    pub utc: String,
    /// Name and version of the program.
    pub program: String,
    /// Its first row.
    pub first_row: u64,
    /// Seconds since the run began at which it began; none in format 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_s: Option<f64>,
    /// What was damaged, where what is whole was kept and the rest is read again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damage: Vec<String>,
    /// Folder in the run with the damaged files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set_aside: Option<String>,
}

/// A spectrum of the run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpectrumEntry {
    /// Its number, which names the file.
    pub index: u64,
    /// Pixels in it.
    pub pixels: u64,
    /// SHA-256 of the file.
    pub sha256: String,
}

impl SpectrumEntry {
    /// The file's name in the run.
    pub fn file(&self) -> String {
        format!("spectra/{:03}.csv", self.index)
    }
}

/// What an instrument said of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceRecord {
    /// Its part: `axis.c`, `axis.gamma`, `luxmeter`, `spectroradiometer`, `lamp`, …
    pub role: String,
    /// `driver:target`, or `prompt` for a person.
    pub open: String,
    /// Model.
    pub model: String,
    /// Serial number, where it can be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Firmware, where it can be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<String>,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopped {
    /// UTC, RFC 3339.
    pub utc: String,
    /// In a word.
    pub how: StopHow,
    /// In a sentence.
    pub message: String,
    /// Whether both axes were verified at rest.
    pub axes_at_rest: bool,
    /// Readings recorded; set by the record.
    #[serde(default)]
    pub readings: u64,
    /// SHA-256 of readings.csv with these rows; set by the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readings_sha256: Option<String>,
    /// Events recorded; set by the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub events: Option<u64>,
    /// SHA-256 of events.jsonl with these lines; set by the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub events_sha256: Option<String>,
}

impl Stopped {
    /// How a run ended; what it holds is set by the record.
    pub fn new(utc: String, how: StopHow, message: String, axes_at_rest: bool) -> Self {
        Self {
            utc,
            how,
            message,
            axes_at_rest,
            readings: 0,
            readings_sha256: None,
            events: None,
            events_sha256: None,
        }
    }

    /// The same as an event, of which the record of the events may know nothing.
    pub fn logged(self) -> Logged {
        Logged {
            time_utc: self.utc,
            event: Event::Stopped {
                how: self.how,
                message: self.message,
                axes_at_rest: self.axes_at_rest,
                left: None,
            },
        }
    }
}

impl RunHeader {
    /// UTC of `time_s` seconds of the run; its beginning where that is not known.
    pub fn utc(&self, time_s: Option<f64>) -> String {
        let began = self.started_utc.parse::<Timestamp>().unwrap_or_default();
        let after = SignedDuration::try_from_secs_f64(time_s.unwrap_or_default()).unwrap_or_default();
        began.checked_add(after).unwrap_or(began).to_string()
    }

    /// Model and serial number of the lux meter, where it has one: another meter has others.
    pub fn luxmeter_name(&self) -> Option<String> {
        let device = self.device.iter().find(|device| device.role == "luxmeter")?;
        Some(format!("{} {}", device.model, device.serial.as_ref()?))
    }

    /// A row of the run as the event that it was.
    pub fn logged(&self, row: &Reading) -> Logged {
        Logged {
            time_utc: self.utc(row.time_s),
            event: Event::Reading(Box::new(row.clone())),
        }
    }

    /// run.toml of a run that begins: no lamp, no rows, no spectrum yet.
    pub fn new(
        program: String,
        started_utc: String,
        device: Vec<DeviceRecord>,
        spectral: Option<SpectralCalibration>,
        station: Station,
        plan: Plan,
    ) -> Self {
        Self {
            format: FORMAT.to_owned(),
            program,
            started_utc,
            lamp_on_utc: None,
            burnings: 0,
            written: None,
            stopped: None,
            resumed: Vec::new(),
            spectrum: Vec::new(),
            sweep: Vec::new(),
            device,
            spectral,
            bench_check: Vec::new(),
            luxmeter: None,
            luminaire: Luminaire::default(),
            report: Commission::default(),
            ratings: Ratings::default(),
            eu_label: EuLabel::default(),
            station,
            plan,
        }
    }

    /// States what is measured and for whom, where that is known.
    pub fn state(&mut self, subject: &Subject) {
        if !subject.is_empty() {
            self.luminaire = subject.luminaire.clone();
            self.report = subject.report.clone();
            self.ratings = subject.ratings.clone();
            self.eu_label = subject.eu_label.clone();
        }
    }

    /// What was measured and for whom.
    pub fn subject(&self) -> Subject {
        Subject {
            luminaire: self.luminaire.clone(),
            report: self.report.clone(),
            ratings: self.ratings.clone(),
            eu_label: self.eu_label.clone(),
        }
    }

    /// run.toml of the run in `path`, without its rows and spectra.
    ///
    /// # Errors
    /// As [`Run::read`](super::Run::read) for run.toml.
    pub fn read(path: &Utf8Path) -> Result<Self, RunError> {
        let file = path.join("run.toml");
        if !file.is_file() {
            return Err(RunError::NoRun {
                path: path.to_owned(),
                unfinished: path.exists() && vacant(path),
            });
        }
        Self::parse(&file, &read_text(&file)?)
    }

    /// Seconds from the start of the run to a UTC; none where one of both is no time.
    pub fn seconds(&self, utc: &str) -> Option<f64> {
        let [start, at] = [&self.started_utc, utc].map(str::parse::<Timestamp>);
        Some(at.ok()?.duration_since(start.ok()?).as_secs_f64())
    }

    /// Columns of its readings.csv.
    pub fn layout(&self) -> Layout {
        match self.format.as_str() {
            FORMAT_3 => Layout::V3,
            _ => Layout::V4,
        }
    }

    /// The text of run.toml. It ends with the SHA-256 of everything before.
    pub(super) fn to_text(&self) -> Result<String, toml::ser::Error> {
        let body = toml::to_string(self)?;
        let body = format!("{}\n", body.trim_end());
        let check = check(&body);
        Ok(body + &check)
    }

    /// Parses run.toml of either format.
    fn parse(file: &Utf8Path, text: &str) -> Result<Self, RunError> {
        let first = text.lines().next().unwrap_or_default();
        let stated = first
            .strip_prefix("format = \"")
            .and_then(|rest| rest.strip_suffix('"'));
        let format = match stated {
            Some(FORMAT_3) => FORMAT_3,
            Some(found) if found != FORMAT && found.starts_with("isolux-run/") => {
                return Err(RunError::OtherFormat {
                    file: file.to_owned(),
                    found: found.to_owned(),
                });
            }
            _ => FORMAT,
        };
        let changed = |what: &str| RunError::HeaderChanged {
            file: file.to_owned(),
            what: what.to_owned(),
        };
        let Some(end) = text.rfind(CHECK) else {
            // A file that never was of this format says so in its own words.
            SourceText { file, text }.parse::<toml::Table>(format)?;
            return Err(changed("the [check] at its end is missing"));
        };
        let body = &text[..end];
        if text[end..] != check(body) {
            return Err(changed("its SHA-256 is not that of its [check]"));
        }
        Ok(SourceText { file, text: body }.parse(format)?)
    }
}

const CHECK: &str = "\n[check]\n";

fn check(body: &str) -> String {
    format!("{CHECK}sha256 = \"{}\"\n", sha256(body.as_bytes()))
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}
