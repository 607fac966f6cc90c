//! The first page: what was measured, and the numbers that a reader looks for.

use crate::document::{Block, Section};
use crate::html::Tile;
use crate::plots::{PolarOptions, polar, solid};
use isolux_reduce::{BeamAngles, Quantity, Reduction};

use super::results::DayResults;
use super::words::{direction, identity};
use crate::sensor;
use isolux_reduce::no_uncertainty;

/// How every number of the report is stated (JCGM 100; EN ISO/IEC 17025, 7.8.3.1).
const STATEMENT: &str = "± is the expanded uncertainty U = k·u of the value with k = 2, about 95 % coverage for a normal distribution, \
    evaluated by JCGM 100; the parts are under “Corrections and uncertainty”. A number without ± has no evaluated uncertainty, for the reason given \
    beside it.";

pub fn section(day_results: &DayResults) -> Section {
    let mut section = Section::default();
    if let Some(partial) = &day_results.reduction.partial {
        section.add(Block::Verdict(partial.note(), false));
    }
    if let Some(sentence) = day_results.conformity.sentence() {
        let [_, fail, not_decided] = day_results.conformity.counts();
        section.add(Block::Verdict(
            format!("Requirements: {sentence}."),
            fail + not_decided == 0,
        ));
    }
    if let Some(comparison) = &day_results.comparison {
        let (sentence, good) = comparison.verdict();
        section.add(Block::Verdict(sentence, good));
    }
    if let Some(accepted) = &day_results.reduction.accepted {
        section.add(Block::Verdict(isolux_reduce::note(accepted), false));
    }
    section.add(Block::Tiles(tiles(day_results)));
    section.paragraph(STATEMENT);
    let reduction = &day_results.reduction;
    let options = PolarOptions {
        title: String::new(),
        per_lamp_flux_lm: Some(reduction.flux.value),
        doubtful_cd: Some(super::light::doubtful_cd(day_results)),
    };
    let shown = &reduction.grid.distribution;
    section.figures([
        (
            polar(shown, &options),
            &format!(
                "Luminous intensity, C0–C180 solid red, C90–C270 dashed blue, in cd/klm. {}",
                super::light::below(day_results)
            ),
        ),
        (
            solid(shown, &options),
            "Photometric solid: intensity as the distance from the light centre.",
        ),
    ]);
    section.subheading("Item and report");
    identity(day_results, &mut section);
    section
}

/// A headline number: the value with its uncertainty, or why there is none.
fn tile(name: &str, quantity: &Quantity) -> Tile {
    let stated = quantity.rounded();
    let (value, note) = match quantity.u {
        Some(_) => (
            format!("{} ± {} {}", stated.value, stated.expanded, quantity.unit),
            "k = 2".to_owned(),
        ),
        None => (
            format!("{} {}", stated.value, quantity.unit),
            no_uncertainty(&quantity.missing),
        ),
    };
    Tile {
        name: name.to_owned(),
        value,
        note,
    }
}

pub fn tiles(day_results: &DayResults) -> Vec<Tile> {
    let reduction = &day_results.reduction;
    let plain = |name: &str, value: String, note: &str| Tile {
        name: name.to_owned(),
        value,
        note: note.to_owned(),
    };
    let mut tiles = vec![tile("luminous flux", &reduction.flux)];
    let (c_deg, gamma_deg) = reduction.i_max_deg;
    let mut largest = tile("largest luminous intensity", &reduction.i_max);
    largest.note = format!("{}; {}", direction(c_deg, gamma_deg), largest.note);
    tiles.push(largest);
    if let Some(line) = &reduction.electrical {
        tiles.push(tile("active power", &line.power));
        tiles.push(tile("luminous efficacy", &line.luminous_efficacy));
    } else {
        for name in ["active power", "luminous efficacy"] {
            tiles.push(plain(name, "not measured".to_owned(), "no power meter"));
        }
    }
    tiles.push(angle_tile("beam angle (50 %)", reduction, |plane| plane.beam.as_ref()));
    tiles.push(angle_tile("field angle (10 %)", reduction, |plane| {
        plane.field.as_ref()
    }));
    if let Some(spectral) = &reduction.spectral {
        match &spectral.colour.cct {
            Some(cct) => tiles.push(tile("correlated colour temperature", cct)),
            None => tiles.push(plain(
                "correlated colour temperature",
                "none".to_owned(),
                "too far from the Planckian locus",
            )),
        }
        let of = &spectral.colour;
        tiles.extend(of.duv.as_ref().map(|duv| tile("Duv", duv)));
        let indices = [("Ra", &of.ra), ("Rf (TM-30)", &of.rf), ("Rg (TM-30)", &of.rg)];
        tiles.extend(
            indices
                .into_iter()
                .filter_map(|(name, index)| Some(tile(name, index.as_ref()?))),
        );
    }
    if reduction.spectral.is_none() {
        tiles.push(plain("colour", "not measured".to_owned(), "no spectrum"));
    }
    let mean = sensor::mean(&day_results.simulation.facts);
    let (value, note) = mean.split_once(", ").unwrap_or((&mean, ""));
    tiles.push(plain(
        "mean on the sensor, simulated",
        value.replace(" (k = 2)", ""),
        if note.is_empty() { "k = 2" } else { note },
    ));
    tiles
}

/// An angle in the planes through C0 and C90.
fn angle_tile<'a>(name: &str, reduction: &'a Reduction, of: impl Fn(&'a BeamAngles) -> Option<&'a Quantity>) -> Tile {
    if reduction.angles.is_empty() {
        return Tile {
            name: name.to_owned(),
            value: "none".to_owned(),
            note: "no half-plane at C 0° or C 90°".to_owned(),
        };
    }
    let found: Vec<Option<&Quantity>> = reduction.angles.iter().map(of).collect();
    let stated = found.iter().map(|found| match found {
        None => "none".to_owned(),
        Some(quantity) => {
            let stated = quantity.rounded();
            match quantity.u {
                Some(_) => format!("{}\u{a0}±\u{a0}{}°", stated.value, stated.expanded),
                None => format!("{}°", stated.value),
            }
        }
    });
    let planes: Vec<String> = reduction.angles.iter().map(BeamAngles::name).collect();
    let first = found.iter().flatten().next();
    let note = match first.filter(|quantity| quantity.u.is_none()) {
        Some(quantity) => no_uncertainty(&quantity.missing),
        None => "k = 2".to_owned(),
    };
    Tile {
        name: name.to_owned(),
        value: stated.collect::<Vec<String>>().join(", "),
        note: format!("{}; {note}", planes.join(" / ")),
    }
}
