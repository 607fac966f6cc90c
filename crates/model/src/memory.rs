//! What was computed of a luminaire once: a diagnosis asks for the same light hundreds of times.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::DVec3;

use crate::angle_table::AngleTable;
use crate::lobe::Lobe;

/// γ, lean of the axis, distance, height.
pub(crate) type RowKey = [u64; 4];

/// C, γ, lean of the axis, distance, stated distance, height.
pub(crate) type FloorKey = [u64; 6];

/// Light from the floor at albedo 1, and where it left the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FloorLight {
    pub illuminance_lx: f64,
    /// Sum of the directions in which it left, weighted by what each contributes.
    pub whence: DVec3,
}

impl FloorLight {
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            illuminance_lx: factor * self.illuminance_lx,
            whence: factor * self.whence,
        }
    }

    pub fn plus(self, other: Self) -> Self {
        Self {
            illuminance_lx: self.illuminance_lx + other.illuminance_lx,
            whence: self.whence + other.whence,
        }
    }
}

/// Light of one node at one point, from the luminaire as its file gives it: no effects, nothing refitted.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct NodeLight {
    pub c_deg: f64,
    pub gamma_deg: f64,
    pub length_mm: f64,
    /// 0 where the node is behind the plane.
    pub bare_lx: f64,
}

/// Light of every node at every point of a plane, as a prepared model asks for it.
pub(crate) type SeenLight = Vec<NodeLight>;

/// What is kept beside a luminaire, shared by its copies.
#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    floor: Kept<FloorKey, FloorLight>,
    floor_rows: Kept<RowKey, Arc<[FloorLight]>>,
    floor_integrals: Kept<RowKey, Arc<[FloorLight]>>,
    seen: Kept<Vec<u64>, Arc<SeenLight>>,
    lobes: Kept<Vec<u64>, Option<Arc<Lobe>>>,
    lobe_target: Arc<OnceLock<Arc<[f64]>>>,
    part_lobe: Arc<OnceLock<Arc<AngleTable>>>,
}

impl Memory {
    /// What holds of the same distribution with another emitter.
    pub fn of_distribution(&self) -> Self {
        Self {
            lobe_target: Arc::clone(&self.lobe_target),
            part_lobe: Arc::clone(&self.part_lobe),
            ..Self::default()
        }
    }

    /// The light of the floor at one place.
    pub fn floor_or(&self, key: FloorKey, compute: impl FnOnce() -> FloorLight) -> FloorLight {
        // A fit of the height asks for new ones at every step.
        self.floor.get_or(key, |kept| kept.len() >= 200_000, compute)
    }

    /// The light of the floor at one γ for C evenly around the circle: 2 kB each.
    pub fn floor_row_or(&self, key: RowKey, compute: impl FnOnce() -> Arc<[FloorLight]>) -> Arc<[FloorLight]> {
        self.floor_rows.get_or(key, |kept| kept.len() >= 4_000, compute)
    }

    /// The same at one height of the lattice. A fit of the height and the distances of a plan need a few dozen of
    /// these, at fifty γ and three leans of the axis.
    pub fn floor_integrals_or(&self, key: RowKey, compute: impl FnOnce() -> Arc<[FloorLight]>) -> Arc<[FloorLight]> {
        self.floor_integrals.get_or(key, |kept| kept.len() >= 10_000, compute)
    }

    /// The light of the emitter's nodes at the places of a sensor, 32 bytes each: those of a hundred maps of 24 × 24
    /// bins are kept.
    pub fn seen_or(&self, key: Vec<u64>, compute: impl FnOnce() -> SeenLight) -> Arc<SeenLight> {
        let held = |kept: &BTreeMap<_, Arc<SeenLight>>| kept.values().map(|seen| seen.len()).sum::<usize>();
        self.seen
            .get_or(key, |kept| held(kept) > 2_000_000, || Arc::new(compute()))
    }

    /// The lobe of LEDs that lean, 30 kB each.
    pub fn lobe_or(&self, key: Vec<u64>, compute: impl FnOnce() -> Option<Lobe>) -> Option<Arc<Lobe>> {
        self.lobes
            .get_or(key, |kept| kept.len() >= 500, || compute().map(Arc::new))
    }

    /// What the lobes of all LEDs add up to.
    pub fn lobe_target_or(&self, compute: impl FnOnce() -> Arc<[f64]>) -> Arc<[f64]> {
        Arc::clone(self.lobe_target.get_or_init(compute))
    }

    /// The lobe of a part that gives more or less than the others.
    pub fn part_lobe_or(&self, compute: impl FnOnce() -> AngleTable) -> Arc<AngleTable> {
        Arc::clone(self.part_lobe.get_or_init(|| Arc::new(compute())))
    }
}

impl PartialEq for Memory {
    /// Memory is no part of what a luminaire is.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Values by their keys, in order: keys of places are long, and differ early.
#[derive(Debug)]
struct Kept<K, V>(Arc<Mutex<BTreeMap<K, V>>>);

impl<K: Ord, V: Clone> Kept<K, V> {
    /// The value of `key`, computed where it is not known; where the memory is `full`, it begins anew.
    fn get_or(&self, key: K, full: impl FnOnce(&BTreeMap<K, V>) -> bool, compute: impl FnOnce() -> V) -> V {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        known.unwrap_or_else(|| {
            let value = compute();
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            if full(&kept) {
                kept.clear();
            }
            kept.insert(key, value.clone());
            value
        })
    }
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<K, V> Clone for Kept<K, V> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}
