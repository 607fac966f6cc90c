//! Which lit blocks make the distribution.

use isolux_record::plan::Instrument;
use isolux_record::run::{Run, StopHow};
use isolux_record::{Plan, Reading, ReadingKind, Role};

use crate::direction::{Direction, once, order, target};
use crate::error::ReduceError;
use crate::grid::is_pole;
use crate::partial::{Partial, unread_blocks};
use crate::samples::unsigned;

/// One lit block of the lux meter: what the plan asks for and what was read.
#[derive(Debug)]
struct Block<'a> {
    name: &'a str,
    distance_mm: f64,
    /// Whether the scan chooses from its half-planes.
    chosen: bool,
    /// Directions of the plan and of the readings, each once.
    directions: Vec<Direction>,
    /// Directions of the plan, each once.
    planned: Vec<Direction>,
    rows: Vec<&'a Reading>,
}

impl Block<'_> {
    /// Half-planes that the scan did not choose are no part of what it was to read.
    fn without_those_not_chosen(&mut self) {
        if self.chosen {
            let read: Vec<f64> = self.rows.iter().map(|row| row.c_target_deg).collect();
            let is_read = |direction: &Direction| read.contains(&direction.0);
            self.planned.retain(is_read);
            self.directions.retain(is_read);
        }
    }
}

/// The blocks of the distribution.
#[derive(Debug)]
pub struct Chosen<'a> {
    /// Their lit point readings, as they were taken.
    pub rows: Vec<&'a Reading>,
    /// Distance of these readings.
    pub distance_mm: f64,
    /// What of the plan was read, where the scan ended early; `rows` are then those of whole half-planes.
    pub partial: Option<Partial>,
    /// The lit blocks that are left out, one sentence each.
    pub notes: Vec<String>,
}

impl<'a> Chosen<'a> {
    /// The blocks at the distance with the most directions that make one grid together; where they make none, the block
    /// with the most directions and those that join its grid. What counts are the directions of the plan, so that
    /// neither repeats nor an early end change which blocks are the distribution.
    ///
    /// # Errors
    /// [`ReduceError::NoLight`] without lit points, [`ReduceError::Unfinished`] when no half-plane was read to its end.
    pub fn of(run: &'a Run) -> Result<Self, ReduceError> {
        let points = run.readings.rows.iter();
        let points: Vec<&Reading> = points
            .filter(|row| row.kind == ReadingKind::Lit && row.role == Role::Point)
            .collect();
        let mut blocks = lit_blocks(&run.header.plan, run.header.station.bench().distance_mm, points);
        let stopped = run.header.stopped.as_ref();
        if stopped.is_some_and(|stopped| stopped.how == StopHow::Completed) {
            blocks.iter_mut().for_each(Block::without_those_not_chosen);
        }
        // Without any reading there is nothing to reduce, whatever the plan says.
        if blocks.iter().all(|block| block.rows.is_empty()) {
            return Err(ReduceError::NoLight);
        }
        let Some(distance_mm) = main_distance(&blocks) else {
            return Err(ReduceError::NoLight);
        };
        let (there, elsewhere): (Vec<&Block<'_>>, Vec<&Block<'_>>) =
            blocks.iter().partition(|block| block.distance_mm == distance_mm);
        let (chosen, beside) = one_grid(&there);
        let partial = unfinished(run, &chosen)?;
        // In the order in which they were taken, whatever the order of the blocks.
        let mut rows: Vec<&Reading> = chosen.iter().flat_map(|block| block.rows.iter().copied()).collect();
        if let Some(partial) = &partial {
            rows.retain(|row| partial.holds(row.c_target_deg, row.gamma_target_deg));
        }
        rows.sort_by_key(|row| row.index);
        let left_out = |block: &&Block<'_>, why: &str| {
            let count = block.directions.len();
            let directions = if count == 1 { "direction" } else { "directions" };
            format!(
                "block {:?} ({count} {directions} at {} mm) is left out of the distribution: {why}",
                block.name, block.distance_mm
            )
        };
        let mut notes: Vec<String> = beside
            .iter()
            .map(|block| left_out(block, &format!("it makes no one grid with block {:?}", chosen[0].name)))
            .collect();
        notes.extend(
            elsewhere
                .iter()
                .map(|block| left_out(block, &format!("that is taken at {distance_mm} mm"))),
        );
        Ok(Self {
            rows,
            distance_mm,
            partial,
            notes,
        })
    }
}

/// The directions of the distribution that a plan asks for, chosen as in [`Chosen::of`], before anything is read.
///
/// # Errors
/// [`ReduceError::NoLight`] without lit points of the lux meter.
pub fn planned(plan: &Plan, station_mm: f64) -> Result<Vec<Direction>, ReduceError> {
    let blocks = lit_blocks(plan, station_mm, Vec::new());
    let distance_mm = main_distance(&blocks).ok_or(ReduceError::NoLight)?;
    let there: Vec<&Block<'_>> = blocks.iter().filter(|block| block.distance_mm == distance_mm).collect();
    let (chosen, _) = one_grid(&there);
    Ok(once(chosen.iter().flat_map(|block| block.planned.iter().copied())))
}

/// The lit blocks of the plan and of the lit points that were read, in that order. A block that has no reading yet is
/// one of them.
fn lit_blocks<'a>(plan: &'a Plan, station_mm: f64, points: Vec<&'a Reading>) -> Vec<Block<'a>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    for block in plan.blocks() {
        if block.kind != ReadingKind::Lit || block.instrument != Instrument::Luxmeter {
            continue;
        }
        let read_mm = points
            .iter()
            .find(|row| row.block == block.name)
            .map(|row| row.distance_mm);
        let planned = once(
            block
                .c_deg
                .iter()
                .flat_map(|c| block.gamma_deg.iter().map(move |gamma| (*c, *gamma))),
        );
        blocks.push(Block {
            name: &block.name,
            distance_mm: read_mm.or(block.distance_mm).unwrap_or(station_mm),
            chosen: block.target.is_some(),
            directions: planned.clone(),
            planned,
            rows: Vec::new(),
        });
    }
    let mut at = 0;
    for row in points {
        let is_of = |block: &Block<'_>| block.name == row.block && block.distance_mm == row.distance_mm;
        // A row is nearly always of the block of the one before.
        if !blocks.get(at).is_some_and(is_of) {
            at = blocks.iter().position(is_of).unwrap_or(blocks.len());
        }
        if at == blocks.len() {
            blocks.push(Block {
                name: &row.block,
                distance_mm: row.distance_mm,
                chosen: false,
                directions: Vec::new(),
                planned: Vec::new(),
                rows: Vec::new(),
            });
        }
        blocks[at].rows.push(row);
    }
    for block in &mut blocks {
        let read = block.rows.iter().map(|row| target(row));
        block.directions = once(block.directions.iter().copied().chain(read));
    }
    blocks
}

/// The distance with the most directions; of equally many the farther: the inverse square law holds better there.
fn main_distance(blocks: &[Block<'_>]) -> Option<f64> {
    let directions_at = |distance_mm: f64| {
        let there = blocks.iter().filter(move |block| block.distance_mm == distance_mm);
        once(there.flat_map(|block| block.directions.iter().copied())).len()
    };
    let mut distances_mm: Vec<f64> = blocks.iter().map(|block| block.distance_mm).collect();
    distances_mm.sort_by(f64::total_cmp);
    distances_mm.dedup();
    distances_mm
        .into_iter()
        .max_by_key(|distance_mm| directions_at(*distance_mm))
}

/// The blocks that make one grid, the largest first, and the others.
fn one_grid<'b, 'a>(there: &[&'b Block<'a>]) -> (Vec<&'b Block<'a>>, Vec<&'b Block<'a>>) {
    let mut by_size = there.to_vec();
    // Stable: of equally many directions, the first.
    by_size.sort_by_key(|block| std::cmp::Reverse(block.directions.len()));
    if is_grid(&by_size) {
        return (by_size, Vec::new());
    }
    let (mut chosen, mut beside) = (Vec::new(), Vec::new());
    for block in by_size {
        chosen.push(block);
        if chosen.len() > 1 && !is_grid(&chosen) {
            chosen.pop();
            beside.push(block);
        }
    }
    (chosen, beside)
}

/// Whether every half-plane has the same γ, the poles aside: they are of all half-planes.
fn is_grid(blocks: &[&Block<'_>]) -> bool {
    let directions = blocks.iter().flat_map(|block| block.directions.iter());
    let nodes = once(directions.map(|&(c, gamma)| unsigned(c, gamma)));
    let mut planes = nodes.chunk_by(|a, b| a.0 == b.0);
    let Some(first) = planes.next() else { return true };
    let between = |plane: &[Direction]| -> Vec<f64> {
        let gammas = plane.iter().map(|node| node.1);
        gammas.filter(|&gamma| !is_pole(gamma)).collect()
    };
    let expected = between(first);
    planes.all(|plane| between(plane) == expected)
}

/// What was read of the directions that the plan asks of the blocks that were chosen, in this block or in another of
/// them, and of the plan's other blocks; none where it is all.
fn unfinished(run: &Run, chosen: &[&Block<'_>]) -> Result<Option<Partial>, ReduceError> {
    let read = once(chosen.iter().flat_map(|block| block.rows.iter().map(|row| target(row))));
    let is_read = |direction: &Direction| read.binary_search_by(|at| order(at, direction)).is_ok();
    let planned = once(chosen.iter().flat_map(|block| block.planned.iter().copied()));
    let found = planned.iter().filter(|direction| is_read(direction)).count();
    let unread = unread_blocks(run, |name| chosen.iter().any(|block| block.name == name));
    if found == planned.len() && unread.is_empty() {
        return Ok(None);
    }
    match Partial::of(&planned, is_read, unread) {
        Some(partial) => Ok(Some(partial)),
        None => Err(ReduceError::Unfinished {
            found,
            planned: planned.len(),
        }),
    }
}
