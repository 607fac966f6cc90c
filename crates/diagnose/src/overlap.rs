//! Readings that are given twice. What was fitted proves nothing when it is predicted, and what is fitted twice makes
//! the uncertainties smaller than they are.

use std::collections::HashMap;

use camino::Utf8Path;
use isolux_record::ReadingKind;
use isolux_record::observation::{Observations, ReadingRow, Readings};

/// One set of observations and where it comes from.
pub struct Given<'a> {
    /// The file or run directory.
    pub path: &'a Utf8Path,
    /// Of its data.
    pub sha256: &'a str,
    /// The observations.
    pub set: Observations,
}

/// A set whose readings were all given before.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{later}, given {role}, holds the readings of {earlier} and no others")]
pub struct NothingNew {
    later: String,
    role: String,
    earlier: String,
}

/// What `later` holds beyond `earlier`; the note says how many readings were left out of it.
///
/// Readings are the same when they have the same coordinates, time and value. Two scans of one plan may share
/// coordinates and time, and round to equal values here and there: readings are taken for copies only where no value at
/// a shared place differs.
///
/// # Errors
/// When nothing is left of `later`.
pub fn beyond(later: &mut Given<'_>, earlier: &Given<'_>, role: &str) -> Result<Option<String>, NothingNew> {
    let nothing_new = NothingNew {
        later: later.path.to_string(),
        role: role.to_owned(),
        earlier: earlier.path.to_string(),
    };
    if later.sha256 == earlier.sha256 {
        return Err(nothing_new);
    }
    match (&later.set, &earlier.set) {
        (Observations::Readings(held), Observations::Readings(fitted)) => {
            let copies = copies(held, fitted);
            if copies.len() == held.rows().len() {
                return Err(nothing_new);
            }
            if copies.is_empty() {
                return Ok(None);
            }
            let note = format!(
                "{} of {} readings of {}, given {role}, are readings of {} and were left out",
                copies.len(),
                held.rows().len(),
                later.path,
                earlier.path
            );
            later.set = Observations::Readings(held.without_rows(&copies));
            Ok(Some(note))
        }
        (Observations::Maps(held), Observations::Maps(fitted)) => {
            let poses = |set: &isolux_record::observation::MapSet| {
                let mut poses = set.maps().to_vec();
                for pose in &mut poses {
                    pose.file = None;
                    pose.held_out = false;
                    pose.name.clear();
                }
                poses
            };
            let same =
                held.cells() == fitted.cells() && held.values() == fitted.values() && poses(held) == poses(fitted);
            if same { Err(nothing_new) } else { Ok(None) }
        }
        (Observations::Spectra(held), Observations::Spectra(fitted)) => {
            let rows = |set: &isolux_record::observation::SpectraSet| {
                let rows = set.rows().iter();
                rows.map(|row| (row.kind, row.wavelength_nm, row.value))
                    .collect::<Vec<_>>()
            };
            let place = |set: &isolux_record::observation::SpectraSet| [set.distance_mm, set.c_deg, set.gamma_deg];
            let same = place(held) == place(fitted) && rows(held) == rows(fitted);
            if same { Err(nothing_new) } else { Ok(None) }
        }
        _ => Ok(None),
    }
}

/// Rows of `held` that are rows of `fitted`; none where readings at the same place and time have different values.
fn copies(held: &Readings, fitted: &Readings) -> Vec<usize> {
    let mut values: HashMap<Place, Vec<Option<u64>>> = HashMap::new();
    for row in fitted.rows() {
        values.entry(place(row)).or_default().push(value(row));
    }
    let mut copies = Vec::new();
    for (index, row) in held.rows().iter().enumerate() {
        match values.get(&place(row)) {
            None => {}
            Some(there) if there.contains(&value(row)) => copies.push(index),
            Some(_) => return Vec::new(),
        }
    }
    copies
}

/// Kind, C, γ, distance and time, bit by bit.
type Place = (ReadingKind, [u64; 3], Option<u64>);

fn place(row: &ReadingRow) -> Place {
    let at = &row.at;
    let numbers = [at.c_deg, at.gamma_deg, at.distance_mm].map(f64::to_bits);
    (at.kind, numbers, at.time_s.map(f64::to_bits))
}

fn value(row: &ReadingRow) -> Option<u64> {
    row.illuminance_lx.map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::observation::{Need, open};

    const HEAD: &str =
        "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx\n";

    fn file(folder: &Utf8Path, name: &str, rows: impl IntoIterator<Item = (u32, f64)>) {
        let text = rows.into_iter().fold(HEAD.to_owned(), |text, (minute, lux)| {
            text + &format!(
                "{minute},a,lit,{}.0,0.0,{minute}.0,2000.0,1,,,{lux},0.01\n",
                60 * minute
            )
        });
        std::fs::write(folder.join(name), text).unwrap();
    }

    #[test]
    fn copies_are_refused_or_left_out_and_a_second_scan_is_not_taken_for_one() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        file(folder, "fitted.csv", (0..20).map(|k| (k, 5.0)));
        file(folder, "copy.csv", (5..15).map(|k| (k, 5.0)));
        file(folder, "partly.csv", (15..30).map(|k| (k, 5.0)));
        // The same plan again: rounding gives many equal values, noise some others.
        file(
            folder,
            "again.csv",
            (0..20).map(|k| (k, if k == 7 { 5.1 } else { 5.0 })),
        );
        let beyond = |later: &str| {
            let open = |name: &str| open(&folder.join(name), Need::Values).unwrap();
            let earlier = Given {
                path: "fitted.csv".into(),
                sha256: "fitted",
                set: open("fitted.csv"),
            };
            let mut later = Given {
                path: later.into(),
                sha256: later,
                set: open(later),
            };
            let note = beyond(&mut later, &earlier, "as --held-out")?;
            let Observations::Readings(left) = later.set else {
                panic!("readings stay readings");
            };
            Ok::<_, NothingNew>((note, left.rows().len()))
        };
        let refused = beyond("copy.csv").unwrap_err();
        assert!(refused.to_string().contains("copy.csv"), "{refused}");
        let (note, left) = beyond("partly.csv").unwrap();
        assert!(
            note.as_ref().is_some_and(|note| note.starts_with("5 of 15 readings")),
            "{note:?}"
        );
        assert_eq!(left, 10);
        assert_eq!(beyond("again.csv").unwrap(), (None, 20));
    }
}
