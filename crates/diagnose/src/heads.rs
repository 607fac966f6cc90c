//! Which photometer head read what: where the model and the runs say so by model and serial number.

use isolux_model::Model;
use isolux_record::observation::Observations;

use crate::overlap::Given;

/// Numbers the heads of runs: 0 is that of the model, or of the first run where the model names none. The notes name
/// the others. What a CSV says in its column `head` stays.
pub fn number(model: &Model, all: &mut [Given<'_>]) -> Vec<String> {
    let of_model = model.provenance().and_then(|table| table.get("luxmeter")?.as_str());
    let mut known: Vec<String> = of_model.into_iter().map(str::to_owned).collect();
    let mut notes = Vec::new();
    for given in all {
        let Observations::Readings(readings) = &mut given.set else {
            continue;
        };
        let Some(name) = readings.luxmeter().map(str::to_owned) else {
            continue;
        };
        let head = place_of(&name, &mut known);
        if head > 0 {
            readings.set_head(head as u32);
            notes.push(format!(
                "{} was read by {name}, not by {}: their calibrations are taken to agree within 2 %",
                given.path, known[0]
            ));
        }
    }
    notes
}

/// The place of a head among those that are known, behind them where it is new.
fn place_of(name: &str, known: &mut Vec<String>) -> usize {
    known.iter().position(|one| one == name).unwrap_or_else(|| {
        known.push(name.to_owned());
        known.len() - 1
    })
}

#[cfg(test)]
mod tests {
    use super::place_of;

    #[test]
    fn a_head_keeps_its_number() {
        let mut known = vec!["P-9710 17".to_owned()];
        let names = ["P-9710 18", "P-9710 17", "T-10A 3", "P-9710 18"];
        assert_eq!(names.map(|name| place_of(name, &mut known)), [1, 0, 2, 1]);
    }
}
