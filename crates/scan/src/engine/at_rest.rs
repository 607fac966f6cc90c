//! Directions of a block of sweeps that are read at rest afterwards: whether the sweeps say the same.
//!
//! Which ones is drawn from the checksums of the sweeps. Nobody can know it before they are made, and a scan that is
//! taken up again draws the same.

use isolux_record::Role;
use isolux_record::disk::sha256;

use super::progress::Progress;
use super::session::Session;
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::sweeps::AT_REST;

/// Of the directions that are read, those that are drawn from where there is light.
const IN_LIGHT: usize = 5;
/// Share of the largest light that counts as light.
const LIGHT: f64 = 0.1;

impl Session<'_> {
    /// Reads ten directions of the block of `planned` at rest, less those that `progress` holds. `planned` is one of
    /// its sweeps, `visits` are those of the plan.
    pub(super) async fn read_at_rest(
        &mut self,
        planned: &Visit,
        visits: &[Visit],
        progress: &Progress,
    ) -> Result<(), ScanError> {
        let Some(block) = self.run.header().plan.blocks().get(planned.block).cloned() else {
            return Ok(());
        };
        let drawn = self.drawn(planned, visits);
        if drawn.iter().all(|at| progress.has_check(&block, *at)) {
            return Ok(());
        }
        self.note(&format!(
            "{} directions of block `{}`, drawn by its sweeps, are read at rest",
            drawn.len(),
            block.name
        ))?;
        for (c_deg, gamma_deg) in drawn {
            if progress.has_check(&block, (c_deg, gamma_deg)) {
                continue;
            }
            self.look_at_wall_clock()?;
            self.awake(async |session| session.pause_if_asked().await).await?;
            let visit = Visit {
                role: Role::Check,
                c_deg,
                gamma_deg,
                pass: None,
                ..*planned
            };
            self.awake(async |session| {
                session.prove_lamp(&block, &visit).await?;
                session.visit(&block, &visit, (0, &[])).await
            })
            .await?;
        }
        Ok(())
    }

    /// Whether a direction of the block of `planned` that is to be read at rest was not.
    pub(super) fn lacks_checks(&self, planned: &Visit, visits: &[Visit], progress: &Progress) -> bool {
        let blocks = self.run.header().plan.blocks();
        let drawn = self.drawn(planned, visits);
        blocks
            .get(planned.block)
            .is_some_and(|block| drawn.iter().any(|at| !progress.has_check(block, *at)))
    }

    /// By the whole sweeps of this block: others are made later, and would draw others.
    fn drawn(&self, planned: &Visit, visits: &[Visit]) -> Vec<(f64, f64)> {
        let Some(block) = self.run.header().plan.blocks().get(planned.block) else {
            return Vec::new();
        };
        let of_block = |point: u64| {
            visits
                .iter()
                .any(|visit| visit.block == planned.block && visit.point == point && visit.pass.is_some())
        };
        let whole = self
            .run
            .header()
            .sweep
            .iter()
            .filter(|entry| !entry.torn && of_block(entry.point));
        let hashes: Vec<&str> = whole.map(|entry| entry.sha256.as_str()).collect();
        directions(&hashes.concat(), &self.coverage.light(block))
    }
}

/// Directions out of `cells`, (C, γ) in degrees with the light there, drawn by `seed`; half of them where there is
/// light. From the last half-plane on each time the nearest one: both axes move at once.
fn directions(seed: &str, cells: &[(f64, f64, f64)]) -> Vec<(f64, f64)> {
    let largest = cells.iter().map(|cell| cell.2).fold(0.0, f64::max);
    let illuminated: Vec<usize> = (0..cells.len())
        .filter(|&at| cells[at].2 >= LIGHT * largest && largest > 0.0)
        .collect();
    let all: Vec<usize> = (0..cells.len()).collect();
    let mut places: Vec<usize> = Vec::new();
    let mut draw = 0_u64;
    // A cell that comes twice is drawn again; there is an end to it where cells are few.
    while places.len() < AT_REST.min(cells.len()) && draw < 1000 {
        let from = if places.len() < IN_LIGHT && illuminated.len() >= IN_LIGHT {
            &illuminated
        } else {
            &all
        };
        let digits = sha256(format!("{seed}/{draw}").as_bytes());
        let number = u64::from_str_radix(digits.get(..16).unwrap_or("0"), 16).unwrap_or(draw);
        let place = from[(number % from.len() as u64) as usize];
        if !places.contains(&place) {
            places.push(place);
        }
        draw += 1;
    }
    let mut left: Vec<(f64, f64)> = places.into_iter().map(|at| (cells[at].0, cells[at].1)).collect();
    left.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    let mut drawn: Vec<(f64, f64)> = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let way = |to: &(f64, f64)| {
            drawn
                .last()
                .map_or(0.0, |from| (to.0 - from.0).abs().max((to.1 - from.1).abs()))
        };
        let nearest = (1..left.len()).fold(0, |best, at| if way(&left[at]) < way(&left[best]) { at } else { best });
        drawn.push(left.remove(nearest));
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells() -> Vec<(f64, f64, f64)> {
        let light = |gamma: f64| if gamma.abs() < 10.0 { 100.0 } else { 0.1 };
        let plane = |c: f64| {
            (0..121)
                .map(move |k| -180.0 + 3.0 * f64::from(k))
                .map(move |gamma| (c, gamma, light(gamma)))
        };
        [0.0, 60.0, 120.0].into_iter().flat_map(plane).collect()
    }

    #[test]
    fn ten_directions_are_drawn_by_the_seed_half_of_them_in_light() {
        let first = directions("a", &cells());
        assert_eq!(first, directions("a", &cells()));
        assert_ne!(first, directions("b", &cells()));
        for seed in 0..40 {
            let drawn = directions(&seed.to_string(), &cells());
            assert_eq!(drawn.len(), AT_REST);
            assert!(drawn.windows(2).all(|pair| pair[0] != pair[1]));
            assert!(
                drawn.iter().filter(|at| at.1.abs() < 10.0).count() >= IN_LIGHT,
                "{drawn:?}"
            );
        }
        assert_eq!(directions("a", &cells()[..4]).len(), 4);
        // Everything in one half-plane is passed in one way.
        let one_plane: Vec<(f64, f64, f64)> = cells().into_iter().filter(|cell| cell.0 == 60.0).collect();
        let drawn = directions("a", &one_plane);
        assert!(drawn.windows(2).all(|pair| pair[0].1 > pair[1].1), "{drawn:?}");
        assert_eq!(directions("a", &[]), []);
    }
}
