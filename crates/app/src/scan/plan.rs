//! `plan`: what a plan asks of a station, before anything moves, and what its distance costs.

use camino::Utf8Path;
use isolux_record::document::{self, Fault};
use isolux_record::{Plan, Station};
use isolux_scan::{Cost, DisplayRange, Distances, DryRun, distances, dry_run};
use serde::Serialize;

use crate::Failure;
use crate::instruments::bench::StationFiles;
use crate::instruments::catalogue;

/// A dry run, and what distances cost where the plan has a distribution and the meter's digits are known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planned {
    /// Points, travel, time, limits.
    #[serde(flatten)]
    pub run: DryRun,
    /// Rounding, noise and near field by distance.
    pub distances: Option<Distances>,
    /// What a scan will not be able to claim, one sentence each.
    pub not_claimable: Vec<String>,
}

/// The dry run of a plan file on a station file.
///
/// # Errors
/// Bad input (exit 2) with file and line: also for a plan outside the limits of the axes.
pub fn run(station: &Utf8Path, plan: &Utf8Path) -> Result<Planned, Failure> {
    let StationFiles { station, file, .. } = StationFiles::load(station)?;
    let (parsed, text) = load(plan)?;
    let run = dry_run(&station, &parsed).map_err(|fault| located(plan, &text, &fault))?;
    let distances = display(&station, &file).and_then(|display| distances(&station, &parsed, &display));
    let not_claimable = not_claimable(&station, &parsed);
    Ok(Planned {
        run,
        distances,
        not_claimable,
    })
}

/// What a scan of this plan will not be able to claim of its conditions, one sentence each. The limits of a job say
/// more.
pub fn not_claimable(station: &Station, plan: &Plan) -> Vec<String> {
    isolux_conformity::before::not_measured(station, plan)
}

/// The ranges of the station's lux meter.
pub(crate) fn display(station: &Station, file: &Utf8Path) -> Option<Vec<DisplayRange>> {
    let ranges = catalogue::display_lx(&station.luxmeter().open, file);
    let range = |(full_scale_lx, digit_lx)| DisplayRange {
        full_scale_lx,
        digit_lx,
    };
    (!ranges.is_empty()).then(|| ranges.into_iter().map(range).collect())
}

impl Planned {
    /// The costs of distances as a table: a head and one line each; empty where there are none.
    pub fn table(&self) -> Vec<[String; 10]> {
        let Some(distances) = &self.distances else {
            return Vec::new();
        };
        let head = [
            "distance/mm",
            "",
            "/D",
            "axis/lx",
            "flux: rounding",
            "noise",
            "I max: rounding",
            "noise",
            "near field",
            "both: u(d)",
        ];
        let mut lines = vec![head.map(str::to_owned)];
        lines.extend(distances.costs.iter().map(|cost| line(cost, distances.best_mm)));
        lines
    }

    /// The proposal in one sentence, and what is not known.
    pub fn proposal(&self) -> Vec<String> {
        let Some(distances) = &self.distances else {
            return Vec::new();
        };
        let of = |wanted: &dyn Fn(&Cost) -> bool| distances.costs.iter().find(|cost| wanted(cost));
        let planned = of(&|cost| cost.planned);
        let mut lines = Vec::new();
        if let (Some(best), Some(planned)) = (of(&|cost| Some(cost.distance_mm) == distances.best_mm), planned) {
            let [flux, i_max] = [best.flux_rel, best.i_max_rel].map(percent);
            lines.push(if best.planned {
                format!("proposed: the plan's {} mm, with {flux} % on the flux and {i_max} % on I max", best.distance_mm)
            } else {
                let [flux_now, i_max_now] = [planned.flux_rel, planned.i_max_rel].map(percent);
                let how = if distances.by_hand { "moved by hand, with a `prompt`" } else { "the rail drives there" };
                format!(
                    "proposed: distance_mm = {} in the blocks of the lux meter ({how}): {flux} % on the flux instead of {flux_now} %, \
                     {i_max} % on I max instead of {i_max_now} %",
                    best.distance_mm
                )
            });
        }
        if !distances.unknown.is_empty() {
            lines.push(format!(
                "{}; the station may state {}",
                if distances.best_mm.is_some() {
                    "not everything is known"
                } else {
                    "no distance is proposed"
                },
                distances.unknown.join("; ")
            ));
        }
        lines
    }
}

fn line(cost: &Cost, best_mm: Option<f64>) -> [String; 10] {
    let mark = match (cost.planned, Some(cost.distance_mm) == best_mm) {
        (true, true) => "plan, best",
        (true, false) => "plan",
        (false, true) => "best",
        (false, false) => "",
    };
    let number =
        |value: Option<f64>, unit: &str| value.map_or_else(|| "?".to_owned(), |value| format!("{value:.2} {unit}"));
    [
        format!("{:.0}", cost.distance_mm),
        mark.to_owned(),
        cost.distance_class
            .ratio()
            .map_or_else(|| "?".to_owned(), |ratio| format!("{ratio:.0}")),
        cost.illuminance_lx
            .map_or_else(|| "?".to_owned(), |lux| format!("{lux:.1}")),
        number(Some(cost.rounding_lm), "lm"),
        number(cost.noise_lm, "lm"),
        number(cost.rounding_cd, "cd"),
        number(cost.noise_cd, "cd"),
        format!("{} %", percent(cost.near_field_rel)),
        format!("{} %", percent(cost.distance_rel)),
    ]
}

fn percent(rel: Option<f64>) -> String {
    rel.map_or_else(|| "?".to_owned(), |rel| format!("{:.2}", 100.0 * rel))
}

/// A plan and its text.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub(crate) fn load(file: &Utf8Path) -> Result<(Plan, String), Failure> {
    let text = document::read_text(file).map_err(Failure::bad_input)?;
    let plan = Plan::parse(file, &text).map_err(Failure::bad_input)?;
    Ok((plan, text))
}

/// A fault of the dry run, with the plan's line.
pub(crate) fn located(file: &Utf8Path, text: &str, fault: &Fault) -> Failure {
    Failure::bad_input(document::SourceText { file, text }.locate(fault))
        .help("nothing was moved and nothing was written")
}
