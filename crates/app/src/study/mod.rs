//! A run that is shown, worked on: reduced with other corrections, lit in other poses, its diagnosis taken over into
//! the model, the next measurement prepared. Nothing here moves an axis.

pub mod card;
mod curves;
pub mod diagnosed;
pub mod in_motion;
pub mod next;
pub mod results;
pub mod what_if;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::Job;
use serde::Serialize;

/// A picture of the report, and what it shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// In words.
    pub title: String,
    /// The picture, SVG.
    pub svg: String,
}

impl Figure {
    fn new(title: &str, svg: String) -> Self {
        let title = title.to_owned();
        Self { title, svg }
    }
}

/// A number as the report states it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StatedNumber {
    /// What it is.
    pub name: String,
    /// The number with unit and expanded uncertainty, or with what is missing in it.
    pub value: String,
    /// The same in the results as they lie in the folder, where it is another one.
    pub reported: Option<String>,
}

/// The job that a day keeps, if it keeps one that can be read.
fn job(run: &Utf8Path) -> Option<Job> {
    Job::load(&run.join("job/job.toml")).ok()
}

/// The model that the results of a run made.
fn reduced_model(run: &Utf8Path) -> Utf8PathBuf {
    run.join("results/luminaire.model.toml")
}
