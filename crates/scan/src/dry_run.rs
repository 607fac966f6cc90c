//! What a plan asks of a station, before anything moves.

use isolux_record::document::Fault;
use isolux_record::plan::{Block, Instrument, Plan, Repeats};
use isolux_record::station::{Access, Axis};
use isolux_record::{DistanceClass, ReadingKind, Role, Station, apart_from_mm, seen_under_deg};
use serde::Serialize;

use crate::itinerary::{Visit, is_last_sweep, visits};
use crate::read_distance::{distance_mm, own_distance_mm};
use crate::second;
use crate::sweep_note;
use crate::sweeps;
use crate::warmup::Criterion;

/// Readings that a settled point needs at least, and the wait for each: T-10A class meters renew every 0.5 s and one
/// conversion is let pass.
const SETTLE_READINGS: f64 = 2.0;
const READING_S: f64 = 1.0;
/// Position checks after a move.
const POSITION_CHECK_S: f64 = 0.15;
/// A spectrum with its exposure search and its dark.
const SPECTRUM_S: f64 = 20.0;

/// Points, travel, time, limits and distance class of a plan on a station.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DryRun {
    /// Points of the plan.
    pub points: u64,
    /// Visits to the reference point.
    pub references: u64,
    /// Readings of the lux meter at least; a block with `u_rel` may take more.
    pub readings: u64,
    /// Spectra.
    pub spectra: u64,
    /// Way of the C axis.
    pub travel_c_deg: f64,
    /// Way of the γ axis.
    pub travel_gamma_deg: f64,
    /// Time of all motion.
    pub motion_s: f64,
    /// Time of all readings, at least.
    pub reading_s: f64,
    /// Time of the warm-up, at least.
    pub warm_up_s: f64,
    /// All of it.
    pub total_s: f64,
    /// Times a person is asked.
    pub prompts: u64,
    /// One entry a block.
    pub blocks: Vec<BlockSummary>,
    /// What should be known before the plan is run.
    pub notes: Vec<String>,
}

/// One block of a dry run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlockSummary {
    /// Its name.
    pub name: String,
    /// What the detector can see.
    pub kind: ReadingKind,
    /// Points.
    pub points: u64,
    /// Distance of the detector.
    pub distance_mm: f64,
    /// Its class.
    pub distance_class: DistanceClass,
}

/// Interprets `plan` on `station`.
///
/// # Errors
/// A [`Fault`] with the plan's key for a pose outside an axis' limits, an instrument that the station lacks, a switch
/// that nobody would throw.
pub fn dry_run(station: &Station, plan: &Plan) -> Result<DryRun, Fault> {
    for (index, block) in plan.blocks().iter().enumerate() {
        check_block(station, index, block)?;
    }
    let visits = visits(plan);
    let mut run = DryRun {
        points: 0,
        references: 0,
        readings: 0,
        spectra: 0,
        travel_c_deg: 0.0,
        travel_gamma_deg: 0.0,
        motion_s: 0.0,
        reading_s: 0.0,
        warm_up_s: 0.0,
        total_s: 0.0,
        prompts: plan.blocks().iter().filter(|block| block.prompt.is_some()).count() as u64,
        blocks: plan.blocks().iter().map(|block| summary(station, block)).collect(),
        notes: notes(station, plan),
    };
    if plan.blocks().iter().any(|block| block.kind.needs_lamp()) {
        run.warm_up_s = Criterion::of(station, plan.limits()).least_s();
    }
    // Where the axes stand before the first visit is not known; homing ends at the drive's own zero.
    let mut at: Option<(f64, f64)> = None;
    for (place, visit) in visits.iter().enumerate() {
        add_visit(&mut run, station, plan, visit, at);
        if is_last_sweep(&visits, place) {
            let block = &plan.blocks()[visit.block];
            run.readings += at_rest(block) as u64;
            run.reading_s += at_rest_s(station, block) + second::least_s(station, block);
        }
        at = Some(visit.stands_deg());
        if visit.role == Role::Point {
            run.blocks[visit.block].points += 1;
        }
    }
    run.total_s = run.warm_up_s + run.motion_s + run.reading_s;
    Ok(run)
}

fn add_visit(run: &mut DryRun, station: &Station, plan: &Plan, visit: &Visit, from: Option<(f64, f64)>) {
    let block = &plan.blocks()[visit.block];
    if let Some((c, gamma)) = from {
        let (way_c, way_gamma) = ((visit.c_deg - c).abs(), (visit.gamma_deg - gamma).abs());
        run.travel_c_deg += way_c;
        run.travel_gamma_deg += way_gamma;
        run.motion_s += motion_s(station, visit, (c, gamma));
    }
    match visit.role {
        Role::Reference => run.references += 1,
        Role::Point => run.points += 1,
        // They are drawn by the sweeps.
        Role::Check => {}
    }
    run.reading_s += reading_s(station, block, visit);
    if block.instrument == Instrument::Spectroradiometer {
        run.spectra += 1;
    } else {
        run.readings += readings(block, visit) as u64;
    }
}

/// Readings of the lux meter at a visit, at least.
fn readings(block: &Block, visit: &Visit) -> f64 {
    match block.repeats {
        Repeats::Exactly(count) if visit.role == Role::Point => f64::from(count),
        _ => 1.0,
    }
}

fn reading_s(station: &Station, block: &Block, visit: &Visit) -> f64 {
    if let Some(pass) = &visit.pass {
        return sweeps::pass_s(station, pass);
    }
    if block.instrument == Instrument::Spectroradiometer {
        return SPECTRUM_S;
    }
    (SETTLE_READINGS - 1.0 + readings(block, visit)) * READING_S
}

/// Directions of a block of sweeps that are read at rest afterwards.
fn at_rest(block: &Block) -> f64 {
    sweeps::AT_REST.min(block.c_deg.len() * block.gamma_deg.len()) as f64
}

/// How long they take with the ways between them: a third of that of γ each, as two places drawn at random are apart.
fn at_rest_s(station: &Station, block: &Block) -> f64 {
    let span = |angles: &[f64]| {
        let (low, high) = angles
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
                (low.min(*angle), high.max(*angle))
            });
        (high - low).max(0.0)
    };
    let count = at_rest(block);
    let way_gamma_s = duration(station.axis_gamma(), span(&block.gamma_deg) / 3.0);
    let way_c_s = duration(station.axis_c(), span(&block.c_deg) / count.max(1.0));
    count * (way_gamma_s.max(way_c_s) + POSITION_CHECK_S + SETTLE_READINGS * READING_S)
}

/// How long a visit takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisitTime {
    /// Motion and readings, at least.
    pub work_s: f64,
    /// The warm-up before it, at least; 0 where the lamp is warm or not needed.
    pub warm_up_s: f64,
}

/// How long each visit of `plan` takes on `station`, in the order of [`visits`].
pub fn visit_times(station: &Station, plan: &Plan) -> Vec<VisitTime> {
    let least_s = Criterion::of(station, plan.limits()).least_s();
    let (mut at, mut warm) = (None, false);
    let visits = visits(plan);
    let time = |(place, visit): (usize, &Visit)| {
        let block = &plan.blocks()[visit.block];
        let needs = block.kind.needs_lamp();
        let warm_up_s = if needs && !warm { least_s } else { 0.0 };
        warm = needs || warm && block.kind != ReadingKind::LampOff;
        let work_s = at.map_or(0.0, |from| motion_s(station, visit, from)) + reading_s(station, block, visit);
        let afterwards_s = if is_last_sweep(&visits, place) {
            at_rest_s(station, block) + second::least_s(station, block)
        } else {
            0.0
        };
        at = Some(visit.stands_deg());
        VisitTime {
            work_s: work_s + afterwards_s,
            warm_up_s,
        }
    };
    visits.iter().enumerate().map(time).collect()
}

fn motion_s(station: &Station, visit: &Visit, (c, gamma): (f64, f64)) -> f64 {
    let (way_c, way_gamma) = ((visit.c_deg - c).abs(), (visit.gamma_deg - gamma).abs());
    duration(station.axis_c(), way_c).max(duration(station.axis_gamma(), way_gamma)) + POSITION_CHECK_S
}

fn duration(axis: &Axis, way_deg: f64) -> f64 {
    let ramp = axis.speed_deg_s * axis.speed_deg_s / axis.accel_deg_s2;
    if way_deg < ramp {
        2.0 * (way_deg / axis.accel_deg_s2).sqrt()
    } else {
        way_deg / axis.speed_deg_s + axis.speed_deg_s / axis.accel_deg_s2
    }
}

/// A block of spectra over angle whose directions are nearer to each other than the lamp is wide.
fn blurred(station: &Station, block: &Block) -> Option<String> {
    let extent_mm = station.lamp()?.diameter_mm?;
    let mut gammas = block.gamma_deg.clone();
    gammas.sort_by(f64::total_cmp);
    let steps = gammas.windows(2).map(|pair| pair[1] - pair[0]);
    let step_deg = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let distance_mm = distance_mm(station, block);
    let half_deg = seen_under_deg(extent_mm, distance_mm);
    let over_angle = block.instrument == Instrument::Spectroradiometer && step_deg.is_finite();
    (over_angle && 2.0 * half_deg > step_deg).then(|| {
        format!(
            "block `{}`: at {distance_mm:.0} mm the spectroradiometer sees the lamp under ±{half_deg:.1}° and \
             mixes the colours of directions that are {step_deg}° apart; from {:.0} mm on it would not",
            block.name,
            apart_from_mm(extent_mm, step_deg)
        )
    })
}

fn summary(station: &Station, block: &Block) -> BlockSummary {
    let distance_mm = distance_mm(station, block);
    let extent = station.lamp().and_then(|lamp| lamp.diameter_mm);
    BlockSummary {
        name: block.name.clone(),
        kind: block.kind,
        points: 0,
        distance_mm,
        distance_class: DistanceClass::of(distance_mm, extent),
    }
}

fn check_block(station: &Station, index: usize, block: &Block) -> Result<(), Fault> {
    sweeps::check_axis(station, index, block)?;
    let key = |name: &str| format!("block.{index}.{name}");
    let fault = |path: String, message: String| Err(Fault { path, message });
    // The plan says angles either as a list or as a range; the fault is located at the one that is there.
    for (axis_name, axis, angles, list, range) in [
        ("C", station.axis_c(), &block.c_deg, "c_deg", "c_range"),
        ("γ", station.axis_gamma(), &block.gamma_deg, "gamma_deg", "gamma_range"),
    ] {
        let [low, high] = axis.limit_deg;
        if let Some(angle) = angles.iter().find(|angle| !(low..=high).contains(*angle)) {
            return fault(
                format!("{}|{range}", key(list)),
                format!(
                    "block `{}`: {axis_name} = {angle}° is outside the axis' limits {low}°…{high}°; \
                     shorten the plan or correct limit_deg in the station",
                    block.name
                ),
            );
        }
        if block.reference_every.is_some() && !(low..=high).contains(&0.0) {
            return fault(
                key("reference_every"),
                format!("the reference point {axis_name} = 0° is outside {low}°…{high}°"),
            );
        }
    }
    if let Some(distance) = block.distance_mm
        && distance != own_distance_mm(station, block.instrument)
        && block.prompt.is_none()
        && station.rail().is_none()
    {
        return fault(
            key("distance_mm"),
            format!(
                "block `{}` needs the detector at {distance} mm; add a `prompt`, or a [rail] to the station",
                block.name
            ),
        );
    }
    if let Some(rail) = station.rail().and_then(isolux_record::station::Rail::driven)
        && block.instrument == Instrument::Luxmeter
    {
        let [low, high] = rail.limit_mm;
        let wanted = distance_mm(station, block);
        if !(low..=high).contains(&wanted) {
            return fault(
                key("distance_mm"),
                format!("{wanted} mm is outside the rail's limits {low}…{high} mm"),
            );
        }
    }
    if block.instrument == Instrument::Spectroradiometer {
        if station.spectroradiometer().is_none() {
            return fault(key("instrument"), "the station has no [spectroradiometer]".to_owned());
        }
        if station.shutter().is_none() {
            return fault(
                key("instrument"),
                "a spectrum needs its dark: the station has no [shutter]".to_owned(),
            );
        }
        if matches!(block.repeats, Repeats::Exactly(count) if count < 2) {
            return fault(
                key("instrument"),
                "a spectrum is a mean of at least 2; add `repeats`".to_owned(),
            );
        }
    }
    let thrown = |access: Option<&Access>| access.is_some() || block.prompt.is_some();
    let (missing, switch) = match block.kind {
        ReadingKind::Lit => (false, ""),
        ReadingKind::Baffled => (!thrown(station.baffle()), "baffle"),
        ReadingKind::Capped => (!thrown(station.shutter()), "shutter"),
        ReadingKind::LampOff => (station.lamp_switch().is_none() && block.prompt.is_none(), "lamp"),
    };
    if missing {
        return fault(
            key("kind"),
            format!(
                "block `{}` is {}, but the station has no [{switch}]; add it, or a `prompt` to the block",
                block.name, block.kind
            ),
        );
    }
    Ok(())
}

fn notes(station: &Station, plan: &Plan) -> Vec<String> {
    let mut notes = Vec::new();
    let has = |kind| plan.blocks().iter().any(|block| block.kind == kind);
    let illuminated = has(ReadingKind::Lit);
    if illuminated && !has(ReadingKind::Capped) && !has(ReadingKind::LampOff) {
        notes.push("no lamp_off or capped block: the meter's offset will not be corrected".to_owned());
    }
    if illuminated && !has(ReadingKind::Baffled) {
        notes.push("no baffled block: stray light made by the lamp will not be corrected".to_owned());
    }
    if !plan.blocks().iter().any(|block| block.reference_every.is_some()) && illuminated {
        notes.push("no reference_every: drift will not be corrected".to_owned());
    }
    let at_rest_s = SETTLE_READINGS * READING_S + POSITION_CHECK_S;
    notes.extend(
        plan.blocks()
            .iter()
            .filter_map(|block| sweep_note::note(station, block, at_rest_s)),
    );
    notes.extend(plan.blocks().iter().filter_map(|block| blurred(station, block)));
    let mut lamp_was_on = false;
    let mut switched_off = false;
    for block in plan.blocks() {
        match block.kind {
            ReadingKind::LampOff if lamp_was_on => switched_off = true,
            kind if kind.needs_lamp() => {
                if switched_off {
                    notes.push(format!(
                        "block `{}` follows a lamp_off block: the lamp must warm up again",
                        block.name
                    ));
                    switched_off = false;
                }
                lamp_was_on = true;
            }
            _ => {}
        }
    }
    if station.lamp_switch().is_none() && illuminated {
        notes.push("the station has no [lamp]: it is taken to be on since the start".to_owned());
    }
    if station.bench().u_distance_mm.is_none() {
        notes.push("bench.u_distance_mm is not given: the budget will lack the distance".to_owned());
    }
    if station.bench().u_gamma_deg.is_none() {
        notes.push("bench.u_gamma_deg is not given: the budget will lack the angle".to_owned());
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{PLAN_HEAD, station};
    use camino::Utf8Path;

    const LIT: &str = "[[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, 360, 15]\ngamma_range = [0, 180, 2]\n\
        reference_every = 91\n";

    fn plan_of(blocks: &str) -> Plan {
        Plan::parse(Utf8Path::new("p.toml"), &format!("{PLAN_HEAD}{blocks}")).unwrap()
    }

    fn run(blocks: &str) -> Result<DryRun, Fault> {
        dry_run(&station(), &plan_of(blocks))
    }

    #[test]
    fn counts_the_day() {
        let day = run(LIT).unwrap();
        assert_eq!((day.points, day.references), (2275, 26));
        assert_eq!(
            day.travel_c_deg,
            24.0 * 15.0 + (0..25).map(|i| 15.0 * f64::from(i)).sum::<f64>() * 2.0 - 24.0 * 15.0
        );
        // Each plane 180° up; then back to 0 for the reference.
        assert_eq!(day.travel_gamma_deg, 25.0 * 360.0);
        assert!(day.warm_up_s >= 1800.0);
        let times = visit_times(&station(), &plan_of(LIT));
        let sum = |of: fn(&VisitTime) -> f64| times.iter().map(of).sum::<f64>();
        assert!((sum(|time| time.work_s) - day.motion_s - day.reading_s).abs() < 1e-6);
        assert_eq!(sum(|time| time.warm_up_s), day.warm_up_s);
        assert!(matches!(day.blocks[0].distance_class, DistanceClass::Narrow(_)));
        assert_eq!(
            day.notes.iter().filter(|note| note.starts_with("no ")).count(),
            2,
            "{:?}",
            day.notes
        );
    }

    #[test]
    fn spectra_nearer_to_each_other_than_the_lamp_is_wide_are_named() {
        let block = |step: f64| {
            let block = format!(
                "[[block]]\nname = \"colour\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\nc_deg = [0, 90]\n\
                 gamma_range = [-80, 80, {step}]\nrepeats = 4\n"
            );
            run(&block).unwrap().notes
        };
        let about = |notes: &[String]| notes.iter().find(|note| note.contains("`colour`")).cloned();
        // 70 mm at 500 mm: ±4.0°.
        assert_eq!(about(&block(10.0)), None);
        let blurred = about(&block(5.0)).unwrap();
        assert!(
            blurred.contains("±4.0°") && blurred.contains("from 810 mm on"),
            "{blurred}"
        );
        // The spectrum on the axis alone has no step.
        let axis = "[[block]]\nname = \"colour\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\nc_deg = 0\n\
            gamma_deg = 0\nrepeats = 4\n";
        assert_eq!(about(&run(axis).unwrap().notes), None);
    }

    #[test]
    fn refuses_what_the_station_cannot() {
        let outside = run("[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = [0, 366]\ngamma_deg = [0]\n").unwrap_err();
        assert!(
            outside.path.starts_with("block.0.c_deg") && outside.message.contains("366"),
            "{outside}"
        );
        let far =
            run("[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = 0\ndistance_mm = 5000\n").unwrap_err();
        assert_eq!(far.path, "block.0.distance_mm");
        let prompted = "[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = 0\ndistance_mm = 5000\nprompt = \"move it\"\n";
        assert_eq!(run(prompted).unwrap().prompts, 1);
    }
}
