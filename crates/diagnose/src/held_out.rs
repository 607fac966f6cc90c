//! Readings kept back by rule: whole half-planes, whole maps, whole dark blocks; never scattered points.

use std::collections::BTreeMap;

use crate::table::{Light, ObservationKind, Row};

/// Which rows are kept back, and in words.
#[derive(Debug, Clone)]
pub struct HeldOut {
    /// One flag a row.
    pub rows: Vec<bool>,
    /// What was kept back.
    pub note: String,
}

/// The rules in the order in which they are tried: every fifth lit half-plane or map, from this one.
pub const RULES: [usize; 5] = [3, 1, 2, 4, 0];

/// Every fifth lit half-plane or map from number `first`, and the last block of each kind of dark record, where others
/// of its kind stay. None where there is too little to keep anything back.
pub fn by_rule(rows: &[Row], first: usize) -> Option<HeldOut> {
    let mut held = vec![false; rows.len()];
    // Lit groups: a half-plane is one (file, block, C, distance, visit); a reference visit is short and stays.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut last_key = None;
    for (i, row) in rows.iter().enumerate() {
        let key = (
            row.file,
            row.group,
            row.light as u8,
            row.c_deg.to_bits(),
            row.distance_mm.to_bits(),
            row.source as u8,
        );
        if last_key == Some(key)
            && let Some(group) = groups.last_mut()
        {
            group.push(i);
        } else {
            groups.push(vec![i]);
            last_key = Some(key);
        }
    }
    let illuminated: Vec<&Vec<usize>> = groups
        .iter()
        .filter(|group| rows[group[0]].light == Light::Lit && group.len() >= 8)
        .collect();
    let at = |group: &[usize]| {
        let row = &rows[group[0]];
        match row.source {
            ObservationKind::Reading => row.distance_mm.to_bits(),
            _ => 0,
        }
    };
    let mut per_distance: BTreeMap<u64, usize> = BTreeMap::new();
    for group in &illuminated {
        *per_distance.entry(at(group)).or_default() += 1;
    }
    let mut planes = 0;
    for (k, group) in illuminated.iter().enumerate() {
        let stay = per_distance.get(&at(group)).copied().unwrap_or(0);
        if k % 5 == first && stay >= 2 && illuminated.len() >= 5 {
            per_distance.insert(at(group), stay - 1);
            group.iter().for_each(|&i| held[i] = true);
            planes += 1;
        }
    }
    let mut darks = 0;
    for kind in [Light::Baffled, Light::LampOff, Light::Capped] {
        let blocks: Vec<&Vec<usize>> = groups.iter().filter(|group| rows[group[0]].light == kind).collect();
        if blocks.len() >= 2
            && let Some(last) = blocks.last()
        {
            last.iter().for_each(|&i| held[i] = true);
            darks += 1;
        }
    }
    let what = if rows.iter().any(|row| row.source == ObservationKind::Bin) {
        "maps"
    } else {
        "half-planes"
    };
    (planes > 0).then(|| HeldOut {
        rows: held,
        note: format!(
            "by rule: {planes} of {} lit {what} and {darks} dark blocks, predicted by a fit without them",
            illuminated.len()
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(rows: &mut Vec<Row>, c_deg: f64, distance_mm: f64) {
        for k in 0..10 {
            rows.push(Row {
                c_deg,
                gamma_deg: f64::from(k),
                distance_mm,
                ..Row::bare(ObservationKind::Reading, 1.0, 0.1)
            });
        }
    }

    #[test]
    fn keeps_back_whole_planes_and_never_the_last_of_a_distance() {
        let mut rows = Vec::new();
        for k in 0..10 {
            plane(&mut rows, 15.0 * f64::from(k), if k == 3 { 1000.0 } else { 2000.0 });
        }
        let held = by_rule(&rows, 3).unwrap();
        let planes: Vec<usize> = (0..10).filter(|k| held.rows[10 * k]).collect();
        assert_eq!(planes, [8], "plane 3 is the only one at its distance");
        for k in 0..10 {
            assert!(held.rows[10 * k..10 * (k + 1)].iter().all(|h| *h == held.rows[10 * k]));
        }
    }

    #[test]
    fn too_few_planes_keep_nothing_back() {
        let mut rows = Vec::new();
        plane(&mut rows, 0.0, 2000.0);
        plane(&mut rows, 90.0, 2000.0);
        assert!(by_rule(&rows, 3).is_none());
    }
}
