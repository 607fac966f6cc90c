//! Readings that the model's own distribution was made of.
//!
//! What such a reading differs from the model is no noise: the distribution took up most of what it is off, and some of
//! what its neighbours are. It is smaller than the reading's uncertainty, by another share in every direction,
//! correlated between neighbours, and never larger than the interval that smoothing leaves it, whatever is wrong.
//! Readings of the same record that made no direction (closing half-plane, visits to the reference, other blocks)
//! differ from it as those of another record do.

use isolux_model::Model;
use isolux_record::observation::{Observations, Readings};

use crate::overlap::Given;

/// Leaves the readings that made the distribution of `model` out of `given`; the note says how many.
pub fn leave_out(model: &Model, given: &mut Given<'_>) -> Option<String> {
    let provenance = model.provenance()?;
    if provenance.get("readings_sha256")?.as_str() != Some(given.sha256) {
        return None;
    }
    let Observations::Readings(readings) = &given.set else {
        return None;
    };
    let own = own(readings, provenance.get("distribution_rows")?.as_array()?);
    if own.is_empty() {
        return None;
    }
    let note = format!(
        "{} of {} readings of {} made the model's distribution, which follows them: they check nothing and were left out",
        own.len(),
        readings.rows().len(),
        given.path
    );
    given.set = Observations::Readings(readings.without_rows(&own));
    Some(note)
}

/// Places of the readings whose numbers are in one of the ranges `[first, last]`.
fn own(readings: &Readings, ranges: &[toml::Value]) -> Vec<usize> {
    let ranges: Vec<(i64, i64)> = ranges
        .iter()
        .filter_map(|range| match range.as_array()?.as_slice() {
            [first, last] => Some((first.as_integer()?, last.as_integer()?)),
            _ => None,
        })
        .collect();
    let made = |index: i64| ranges.iter().any(|(first, last)| (*first..=*last).contains(&index));
    let rows = readings.rows().iter().enumerate();
    rows.filter(|(_, row)| row.index.is_some_and(made))
        .map(|(place, _)| place)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::observation::{Need, open};

    #[test]
    fn readings_are_found_by_their_numbers_wherever_they_stand() {
        let keep = tempfile::tempdir().unwrap();
        let path = camino::Utf8Path::from_path(keep.path()).unwrap().join("readings.csv");
        let mut text = String::from(
            "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx\n",
        );
        for index in [9, 0, 1, 2, 5, 3, 4] {
            text += &format!("{index},b,lit,{index},0,{index},3700,0,1,24,1.0,0.01\n");
        }
        std::fs::write(&path, text).unwrap();
        let Ok(Observations::Readings(readings)) = open(&path, Need::Values) else {
            panic!("readings");
        };
        let ranges: toml::Table = "of = [[1, 2], [5, 5], [7, 8]]".parse().unwrap();
        assert_eq!(own(&readings, ranges["of"].as_array().unwrap()), [2, 3, 4]);
    }
}
