//! The procedure of a calibration: a plan like any other, so that its record is like any other.

use isolux_record::{Standard, Station};
use isolux_reduce::standard::Calibrated;

/// Peaks of the spectra, as shares of saturation: the first and the last are the brightest.
const PEAKS: [f64; 6] = [0.7, 0.5, 0.3, 0.15, 0.08, 0.7];
/// Spectra averaged at each.
const SPECTRA: u32 = 20;
/// Readings of the lux meter where it is calibrated, and where it only shows that lamp and current are as they were.
const READINGS: u32 = 20;
const CHECKS: u32 = 5;

/// Distance at which an instrument is calibrated: of the spectroradiometer its own; of the lux meter that of the
/// certificate where the rail goes there, else the station's.
pub(super) fn distance_mm(what: Calibrated, station: &Station, standard: &Standard) -> f64 {
    let own = station.bench().distance_mm;
    match what {
        Calibrated::Spectroradiometer => station.spectroradiometer().map_or(own, |spectro| spectro.distance_mm),
        Calibrated::Luxmeter => {
            let certified = standard.illuminance().map(|illuminance| illuminance.distance_mm);
            let reached = |mm: &f64| match station.rail() {
                Some(rail) => rail
                    .driven()
                    .is_none_or(|rail| (rail.limit_mm[0]..=rail.limit_mm[1]).contains(mm)),
                None => false,
            };
            certified.filter(reached).unwrap_or(own)
        }
    }
}

/// The plan as text.
pub(super) fn plan(what: Calibrated, station: &Station, standard: &Standard) -> String {
    let mut text = format!(
        "format = \"isolux-plan/1\"\nname = \"calibration of the {} with a standard lamp\"\n",
        what.role()
    );
    let mut block = |name: &str, kind: &str, rest: &str| {
        text += &format!("\n[[block]]\nname = \"{name}\"\nkind = \"{kind}\"\nc_deg = 0\ngamma_deg = 0\n{rest}");
    };
    match what {
        Calibrated::Spectroradiometer => {
            let checks = format!("repeats = {CHECKS}\n");
            let spectrum = format!("instrument = \"spectroradiometer\"\nrepeats = {SPECTRA}\n");
            block("lamp before", "lit", &checks);
            for (place, peak) in PEAKS.iter().enumerate() {
                let name = format!("spectrum {}", place + 1);
                block(&name, "lit", &format!("{spectrum}peak_counts_rel = {peak:?}\n"));
            }
            block("lamp after", "lit", &checks);
            block("stray light", "baffled", &spectrum);
        }
        Calibrated::Luxmeter => {
            let distance_mm = distance_mm(what, station, standard);
            let readings = format!("repeats = {READINGS}\ndistance_mm = {distance_mm:?}\n");
            block("lamp before", "lit", &readings);
            block("stray light", "baffled", &readings);
            block("lamp after", "lit", &readings);
        }
    }
    text
}
