//! `isolux-job/1`: which station, plan and scene make a day.

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};

use crate::conditions::Conditions;
use crate::document::{DocumentError, Fault, SourceText, read_text};
use crate::layout::Layout;
use crate::light_modulation::LightModulation;
use crate::rated::{EuLabel, Ratings};
use crate::requirements::Requirements;
use crate::subject::{Commission, Luminaire, Subject};

/// Value of `format` in a job file.
pub const FORMAT: &str = "isolux-job/1";

/// A job file as written. Paths are relative to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JobDocument {
    format: String,
    station: Utf8PathBuf,
    plan: Utf8PathBuf,
    scene: Utf8PathBuf,
    #[serde(default)]
    diagnose: Option<DiagnoseDocument>,
    #[serde(default)]
    luminaire: Luminaire,
    #[serde(default)]
    report: Commission,
    #[serde(default)]
    ratings: Ratings,
    #[serde(default)]
    eu_label: EuLabel,
    #[serde(default)]
    conditions: Conditions,
    #[serde(default)]
    requirements: Requirements,
    #[serde(default)]
    layout: Layout,
    #[serde(default)]
    light_modulation: Option<LightModulation>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DiagnoseDocument {
    model: Utf8PathBuf,
    observations: Vec<Utf8PathBuf>,
}

/// A valid job: every path resolved against the folder of the job file.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    station: Utf8PathBuf,
    plan: Utf8PathBuf,
    scene: Utf8PathBuf,
    diagnose: Option<(Utf8PathBuf, Vec<Utf8PathBuf>)>,
    subject: Subject,
    conditions: Conditions,
    requirements: Requirements,
    layout: Layout,
    light_modulation: Option<LightModulation>,
}

impl Job {
    /// Reads and validates a job file; the files that it names must be there.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn load(file: &Utf8Path) -> Result<Self, DocumentError> {
        let text = read_text(file)?;
        let source = SourceText { file, text: &text };
        let job: JobDocument = source.parse(FORMAT)?;
        let subject = Subject {
            luminaire: job.luminaire,
            report: job.report,
            ratings: job.ratings,
            eu_label: job.eu_label,
        };
        subject
            .check()
            .and_then(|()| job.conditions.check())
            .and_then(|()| job.requirements.check())
            .and_then(|()| job.layout.check())
            .map_err(|fault| source.locate(&fault))?;
        let folder = file.parent().unwrap_or(Utf8Path::new(""));
        let resolve = |key: &str, path: &Utf8Path| {
            let resolved = folder.join(path);
            let wrong = if !resolved.exists() {
                "is not there"
            } else if !(resolved.is_file() || resolved.is_dir()) {
                "is a device, pipe or socket; save its content as a file and name that"
            } else {
                return Ok(resolved);
            };
            Err(source.locate(&Fault::new(key, format!("{resolved} {wrong}"))))
        };
        let mut layout = job.layout;
        for (key, file) in layout.files() {
            *file = resolve(key, file)?;
        }
        Ok(Self {
            station: resolve("station", &job.station)?,
            plan: resolve("plan", &job.plan)?,
            scene: resolve("scene", &job.scene)?,
            diagnose: job
                .diagnose
                .map(|diagnose| {
                    if diagnose.observations.is_empty() {
                        let message = "a diagnosis needs at least one file or run";
                        return Err(source.locate(&Fault::new("diagnose.observations", message)));
                    }
                    let observations = diagnose
                        .observations
                        .iter()
                        .enumerate()
                        .map(|(place, path)| resolve(&format!("diagnose.observations.{place}"), path))
                        .collect::<Result<_, _>>()?;
                    Ok((resolve("diagnose.model", &diagnose.model)?, observations))
                })
                .transpose()?,
            subject,
            conditions: job.conditions,
            requirements: job.requirements,
            layout,
            light_modulation: job
                .light_modulation
                .map(|light| {
                    light.check().map_err(|fault| source.locate(&fault))?;
                    let waveform = resolve("light_modulation.waveform", &light.waveform)?;
                    Ok(LightModulation { waveform, ..light })
                })
                .transpose()?,
        })
    }

    /// The station file.
    pub fn station(&self) -> &Utf8Path {
        &self.station
    }

    /// The plan file.
    pub fn plan(&self) -> &Utf8Path {
        &self.plan
    }

    /// What is measured, and for whom.
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// Limits of the conditions, and what the bench does not measure of them.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// What the luminaire has to keep.
    pub fn requirements(&self) -> &Requirements {
        &self.requirements
    }

    /// How its report looks; paths are resolved.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The scene file.
    pub fn scene(&self) -> &Utf8Path {
        &self.scene
    }

    /// The record of the light over time, if the job names one.
    pub fn light_modulation(&self) -> Option<&LightModulation> {
        self.light_modulation.as_ref()
    }

    /// Model and observations of a diagnosis, if the job asks for one.
    pub fn diagnose(&self) -> Option<(&Utf8Path, &[Utf8PathBuf])> {
        self.diagnose
            .as_ref()
            .map(|(model, observations)| (model.as_path(), observations.as_slice()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_job_and_must_be_there() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        for name in ["s.toml", "p.toml"] {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let file = folder.join("job.toml");
        let text = "format = \"isolux-job/1\"\nstation = \"s.toml\"\nplan = \"p.toml\"\nscene = \"c.toml\"\n";
        std::fs::write(&file, text).unwrap();
        let error = Job::load(&file).unwrap_err();
        assert_eq!(error.line, Some(4), "{error}");
        std::fs::write(folder.join("c.toml"), "").unwrap();
        assert_eq!(Job::load(&file).unwrap().scene(), folder.join("c.toml"));

        let with = |table: &str| {
            std::fs::write(&file, format!("{text}[luminaire]\n{table}")).unwrap();
            Job::load(&file)
        };
        let named = with("name = \"Downlight\"\n").unwrap();
        assert_eq!(named.subject().luminaire.name.as_deref(), Some("Downlight"));
        for (table, line) in [
            ("waveform = \"none.csv\"", 6),
            ("waveform = \"c.toml\"\nline_time_us = -1.0", 7),
        ] {
            std::fs::write(&file, format!("{text}[light_modulation]\n{table}\n")).unwrap();
            let error = Job::load(&file).unwrap_err();
            assert_eq!(error.line, Some(line), "{error}");
        }
        std::fs::write(
            &file,
            format!("{text}[light_modulation]\nwaveform = \"c.toml\"\ndark = 0.5\n"),
        )
        .unwrap();
        let job = Job::load(&file).unwrap();
        let light = job.light_modulation().unwrap();
        assert_eq!((&light.waveform, light.dark), (&folder.join("c.toml"), Some(0.5)));
        for wrong in ["maker = \"a\"\nmarker = \"b\"\n", "maker = \"a\"\nname = \"\"\n"] {
            assert_eq!(with(wrong).unwrap_err().line, Some(7), "{wrong}");
        }
    }
}
