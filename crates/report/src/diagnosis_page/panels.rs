//! What the pictures of a diagnosis show: residuals over the directions or the sensor, and along one coordinate.

use std::collections::BTreeMap;

use isolux_diagnose::diagnosis::{Diagnosis, along_words};
use isolux_diagnose::table::{Coordinate, Light, ObservationKind, Row};

use crate::diagnosis::{Panel, residuals_along};

/// Panels of half-planes (one a distance, rows in order of measurement) or of maps.
pub fn panels(found: &Diagnosis) -> (Vec<Panel>, &'static str, &'static str) {
    let rows = &found.rows;
    if rows.iter().any(|row| row.source == ObservationKind::Bin) {
        let mut groups: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (i, row) in rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.source == ObservationKind::Bin)
        {
            groups.entry((row.file, row.group)).or_default().push(i);
        }
        let panels = groups
            .values()
            .take(12)
            .map(|indices| {
                let row = &rows[indices[0]];
                let name = match row.light {
                    Light::Capped => "capped".to_owned(),
                    Light::LampOff => "lamp off".to_owned(),
                    _ => format!("{} mm, exposure {}", row.distance_mm, row.exposure),
                };
                panel(name, found, indices, |row| row.x_mm, |row| row.y_mm)
            })
            .collect();
        return (panels, "x in mm", "y in mm (as the lamp sees the sensor)");
    }
    let mut distances: Vec<f64> = rows
        .iter()
        .filter(|row| row.source == ObservationKind::Reading)
        .map(|row| row.distance_mm)
        .filter(|d| d.is_finite())
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    let panels = distances
        .iter()
        .filter_map(|&distance| {
            let pick: Vec<usize> = (0..rows.len())
                .filter(|&i| rows[i].source == ObservationKind::Reading && rows[i].distance_mm == distance)
                .filter(|&i| rows[i].light == Light::Lit && rows[i].travel != 0.0)
                .collect();
            (pick.len() > 4).then(|| {
                panel(
                    format!("{distance} mm"),
                    found,
                    &pick,
                    |row| row.gamma_deg,
                    |row| row.c_deg,
                )
            })
        })
        .collect();
    (panels, "signed γ in degrees", "C in degrees")
}

fn panel(name: String, found: &Diagnosis, indices: &[usize], x: fn(&Row) -> f64, y: fn(&Row) -> f64) -> Panel {
    let places = |f: fn(&Row) -> f64| {
        let mut values: Vec<f64> = indices.iter().map(|&i| f(&found.rows[i])).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (xs, ys) = (places(x), places(y));
    let mut before = vec![f64::NAN; xs.len() * ys.len()];
    let mut after = before.clone();
    for &i in indices {
        let row = &found.rows[i];
        let column = xs.partition_point(|value| *value < x(row));
        let line = ys.partition_point(|value| *value < y(row));
        before[line * xs.len() + column] = found.before[i];
        after[line * xs.len() + column] = found.left[i];
    }
    Panel {
        name,
        columns: xs.len(),
        rows: ys.len(),
        before,
        after,
        x: xs,
        y: ys,
    }
}

/// A coordinate in words, with its unit.
fn axis_label(coordinate: &str) -> String {
    let words = along_words(coordinate);
    let units = [("_s", "s"), ("_deg", "°"), ("_mm", "mm"), ("_c", "°C"), ("_nm", "nm")];
    match units.iter().find(|(suffix, _)| coordinate.ends_with(suffix)) {
        Some((_, unit)) => format!("{words} in {unit}"),
        None => words.to_owned(),
    }
}

/// Residuals against the coordinate of the strongest pattern.
pub fn along(found: &Diagnosis) -> Option<(Coordinate, String)> {
    const ALL: [Coordinate; 16] = [
        Coordinate::TimeS,
        Coordinate::GammaDeg,
        Coordinate::CDeg,
        Coordinate::DistanceMm,
        Coordinate::Travel,
        Coordinate::Range,
        Coordinate::AmbientC,
        Coordinate::Level,
        Coordinate::XMm,
        Coordinate::YMm,
        Coordinate::RadiusMm,
        Coordinate::IncidenceDeg,
        Coordinate::Exposure,
        Coordinate::WavelengthNm,
        Coordinate::Index,
        Coordinate::Noise,
    ];
    let document = &found.document;
    let wanted = document
        .unexplained
        .as_ref()
        .map(|unexplained| &unexplained.coordinate)
        .or_else(|| document.places.first().map(|place| &place.coordinate))?;
    let coordinate = ALL.into_iter().find(|coordinate| coordinate.name() == *wanted)?;
    let place = |i: usize| found.rows[i].coordinate(coordinate, found.level[i]);
    let pick: Vec<usize> = (0..found.rows.len()).filter(|&i| place(i).is_finite()).collect();
    let points: Vec<(f64, f64)> = pick.iter().map(|&i| (place(i), found.before[i])).collect();
    let fit: Vec<(f64, f64)> = pick.iter().map(|&i| (place(i), found.explained[i])).collect();
    (!points.is_empty()).then(|| (coordinate, residuals_along(&axis_label(wanted), &points, Some(&fit))))
}

/// Residuals of spectra over the wavelength, as given and after; none without spectra.
pub fn of_spectra(found: &Diagnosis) -> Option<[String; 2]> {
    let samples = || {
        found
            .rows
            .iter()
            .enumerate()
            .filter(|(_, row)| row.source == ObservationKind::Sample)
    };
    samples().next()?;
    let over = |residuals: &[f64]| {
        let points: Vec<(f64, f64)> = samples().map(|(i, row)| (row.wavelength_nm, residuals[i])).collect();
        residuals_along(&axis_label(Coordinate::WavelengthNm.name()), &points, None)
    };
    Some([over(&found.before), over(&found.left)])
}
