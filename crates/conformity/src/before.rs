//! What a scan will not be able to claim, said before it begins.

use isolux_record::plan::Instrument;
use isolux_record::requirements::{DecisionRule, MeasuredWith};
use isolux_record::{Conditions, DistanceClass, Plan, ReadingKind, Requirements, Station};

/// The same of a scan without a job, which has no limits: what its bench leaves out of the conditions that instruments
/// measure.
pub fn not_measured(station: &Station, plan: &Plan) -> Vec<String> {
    let meter = station.powermeter();
    let lamp = station.lamp();
    let missing = [
        ("ambient temperature ([ambient])", station.ambient().is_none()),
        ("supply voltage and power ([powermeter])", meter.is_none()),
        ("stabilisation ([lamp])", lamp.is_none()),
        (
            "luminous diameter, for the distance (lamp.diameter_mm)",
            lamp.is_none_or(|lamp| lamp.diameter_mm.is_none()),
        ),
        (
            "uncertainty of the distance (bench.u_distance_mm)",
            station.bench().u_distance_mm.is_none(),
        ),
    ];
    let missing: Vec<&str> = missing.iter().filter(|(_, is)| *is).map(|(what, _)| *what).collect();
    let mut sentences = Vec::new();
    if !missing.is_empty() {
        sentences.push(format!(
            "conditions that the station does not know: {}",
            missing.join(", ")
        ));
    }
    sentences.extend(too_near(station, plan));
    sentences
}

/// One sentence for each claim that station, plan and job leave without a ground; empty where there is none.
/// `has_waveform` is whether the job names a record of the light over time.
pub fn not_claimable(
    station: &Station,
    plan: &Plan,
    conditions: &Conditions,
    requirements: &Requirements,
    has_waveform: bool,
) -> Vec<String> {
    let mut sentences = Vec::new();
    let (mut no_limit, mut no_value, mut no_u) = (Vec::new(), Vec::new(), Vec::new());
    for (key, stated) in conditions.all() {
        let limits = stated.and_then(|stated| stated.limits(key.name).ok().flatten());
        let own_value = stated.is_some_and(|stated| stated.measured.is_some());
        let own_u = stated.is_some_and(|stated| stated.u.is_some());
        let meter = station.powermeter();
        let stabilised = station.lamp().is_some();
        // Which of value and uncertainty the bench gives.
        let (value, u) = match key.name {
            "ambient_c" => (own_value || station.ambient().is_some(), own_u),
            "supply_voltage_v" => (
                own_value || meter.is_some(),
                own_u || meter.is_some_and(|meter| meter.u_voltage_rel.is_some()),
            ),
            "operating_time_min" | "stabilisation_rel" => (stabilised, true),
            "power_stabilisation_rel" => (stabilised && meter.is_some(), true),
            "distance_ratio" => (
                station.lamp().is_some_and(|lamp| lamp.diameter_mm.is_some()),
                station.bench().u_distance_mm.is_some(),
            ),
            _ => (own_value, own_u),
        };
        // The distance has its limit from the width of the beam.
        if limits.is_none() && key.name != "distance_ratio" {
            no_limit.push(key.name);
        } else if !value {
            no_value.push(key.name);
        } else if !u {
            no_u.push(key.name);
        }
    }
    if no_limit.len() == conditions.all().len() - 1 {
        sentences.push("no condition will be judged: the job states no limits in [conditions]".to_owned());
    } else if !no_limit.is_empty() {
        sentences.push(format!(
            "conditions without a limit in [conditions]: {}",
            no_limit.join(", ")
        ));
    }
    if !no_value.is_empty() {
        sentences.push(format!(
            "conditions that nothing measures, with no `measured` stated: {}",
            no_value.join(", ")
        ));
    }
    if !no_u.is_empty() {
        sentences.push(format!("conditions without an uncertainty: {}", no_u.join(", ")));
    }
    sentences.extend(too_near(station, plan));
    sentences.extend(undecidable(station, plan, requirements, has_waveform));
    sentences
}

fn too_near(station: &Station, plan: &Plan) -> Option<String> {
    let extent_mm = station.lamp()?.diameter_mm?;
    let lux = plan
        .blocks()
        .iter()
        .find(|block| block.kind == ReadingKind::Lit && block.instrument != Instrument::Spectroradiometer)?;
    let distance_mm = lux.distance_mm.unwrap_or(station.bench().distance_mm);
    match DistanceClass::of(distance_mm, Some(extent_mm)) {
        DistanceClass::Unknown | DistanceClass::Narrow(_) => None,
        class => Some(format!(
            "the distribution at {distance_mm} mm, {class}: other readings are apparent intensities"
        )),
    }
}

fn undecidable(station: &Station, plan: &Plan, requirements: &Requirements, has_waveform: bool) -> Vec<String> {
    let spectra: Vec<_> = plan
        .blocks()
        .iter()
        .filter(|block| block.instrument == Instrument::Spectroradiometer && block.kind == ReadingKind::Lit)
        .collect();
    let meter = station.powermeter();
    let missing = |with: MeasuredWith| match with {
        MeasuredWith::PowerMeter if meter.is_none() => Some("the station has no power meter"),
        MeasuredWith::Spectrum | MeasuredWith::SpectraOverAngle if spectra.is_empty() => {
            Some("the plan takes no spectrum")
        }
        MeasuredWith::Waveform if !has_waveform => Some("the job names no waveform in [light_modulation]"),
        _ => None,
    };
    let bench = station.bench();
    let no_u = |with: MeasuredWith| match with {
        MeasuredWith::LuxMeter | MeasuredWith::PowerMeter if bench.u_distance_mm.is_none() => {
            Some("the station states no bench.u_distance_mm")
        }
        MeasuredWith::PowerMeter if meter.is_some_and(|meter| meter.u_power_rel.is_none()) => {
            Some("the station states no powermeter.u_power_rel")
        }
        MeasuredWith::Spectrum | MeasuredWith::SpectraOverAngle
            if station
                .spectroradiometer()
                .is_some_and(|meter| meter.u_shape_rel.is_none()) =>
        {
            Some("the station states no spectroradiometer.u_shape_rel")
        }
        _ => None,
    };
    let mut sentences = Vec::new();
    for limit in &requirements.limit {
        let Some(key) = limit.key() else { continue };
        let simple = requirements.rule_of(limit) == Some(DecisionRule::Simple);
        let why = missing(key.with).or_else(|| no_u(key.with).filter(|_| !simple));
        sentences.extend(why.map(|why| format!("the requirement on {} cannot be decided: {why}", key.name)));
    }
    sentences
}
