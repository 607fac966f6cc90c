//! The table of twins: by which driver an instrument of the room can be reached, and which twin answers that driver.

use std::collections::BTreeMap;

use isolux_darkroom::Instrument;

pub use crate::twin::{InMotion, TwinKind};

mod exposed;
mod luxmeter;
mod mavo;
mod modbus_lux;
mod oriental;
mod oscilloscope;
mod p9710;
mod parker;
mod powermeter;
mod spectrometer;
mod sts;
mod supply;
mod template_axes;
mod template_lux;
mod wt300;
mod zaber;

/// All twins; of those that play one instrument the first is the default. A new twin is one entry here, and its `mod`.
pub const TWINS: &[TwinKind] = &[
    zaber::TWIN,
    oriental::TWIN,
    parker::TWIN,
    template_axes::TWIN,
    luxmeter::TWIN,
    modbus_lux::TWIN,
    mavo::TWIN,
    p9710::TWIN,
    template_lux::TWIN,
    spectrometer::LIGHT_METER,
    sts::LIGHT_METER,
    spectrometer::TWIN,
    sts::TWIN,
    powermeter::TWIN,
    wt300::TWIN,
    supply::TWIN,
    oscilloscope::TWIN,
];

/// Parts of a station that hang on the axes' controller where it has outputs and inputs.
const OUTPUTS: [&str; 5] = ["rail", "lamp", "shutter", "baffle", "ambient"];

/// Instruments that a room has only where they are chosen.
const CHOSEN_ONLY: [Instrument; 3] = [Instrument::Powermeter, Instrument::Supply, Instrument::Oscilloscope];

/// Which twin plays which instrument.
#[derive(Clone)]
pub struct Choice(BTreeMap<Instrument, &'static TwinKind>);

/// A driver without a twin of that instrument.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("driver {driver} has no twin that plays the {}; those with one: {known}", instrument.name())]
pub struct NoTwin {
    /// The driver.
    pub driver: String,
    /// The instrument.
    pub instrument: Instrument,
    /// Drivers with a twin of it.
    pub known: String,
}

impl Default for Choice {
    fn default() -> Self {
        let mut choice = Self(BTreeMap::new());
        for twin in TWINS.iter().filter(|twin| !CHOSEN_ONLY.contains(&twin.instrument)) {
            choice.0.entry(twin.instrument).or_insert(twin);
        }
        choice.complete();
        choice
    }
}

impl Choice {
    /// The twin that answers `driver` plays `instrument`.
    ///
    /// # Errors
    /// [`NoTwin`] names the drivers that could be chosen.
    pub fn choose(&mut self, instrument: Instrument, driver: &str) -> Result<(), NoTwin> {
        // What hangs on a controller of axes is played by such a controller.
        let plays = |twin: &&TwinKind| match instrument {
            Instrument::Outputs => {
                twin.instrument == Instrument::Axes && OUTPUTS.iter().all(|part| twin.open(part).is_some())
            }
            _ => twin.instrument == instrument,
        };
        let mut able = TWINS.iter().filter(plays);
        let Some(twin) = able.clone().find(|twin| twin.driver == driver) else {
            let known: Vec<&str> = able.by_ref().map(|twin| twin.driver).collect();
            return Err(NoTwin {
                driver: driver.to_owned(),
                instrument,
                known: known.join(", "),
            });
        };
        self.0.insert(instrument, twin);
        if instrument == Instrument::Axes {
            self.0.remove(&Instrument::Outputs);
            self.complete();
        }
        Ok(())
    }

    /// The default twin plays `instrument`, if none does yet.
    pub fn add(&mut self, instrument: Instrument) {
        if let Some(twin) = TWINS.iter().find(|twin| twin.instrument == instrument) {
            self.0.entry(instrument).or_insert(twin);
        }
    }

    /// Where the axes' controller cannot switch the lamp, or lacks another of the outputs, a controller that can stands
    /// beside.
    fn complete(&mut self) {
        let lacks = |twin: &TwinKind| OUTPUTS.iter().any(|part| twin.open(part).is_none());
        if self.0.get(&Instrument::Axes).is_none_or(|twin| lacks(twin))
            && let Some(twin) = TWINS
                .iter()
                .find(|twin| twin.instrument == Instrument::Axes && !lacks(twin))
        {
            self.0.entry(Instrument::Outputs).or_insert(twin);
        }
    }

    /// The twin of an instrument; none where the room has no such instrument.
    pub fn twin(&self, instrument: Instrument) -> Option<&'static TwinKind> {
        self.0.get(&instrument).copied()
    }

    /// The instruments that are played, in a fixed order.
    pub fn instruments(&self) -> impl Iterator<Item = Instrument> + '_ {
        self.0.keys().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_has_every_part_once_and_no_second_controller() {
        let choice = Choice::default();
        assert!(choice.twin(Instrument::Outputs).is_none());
        for part in ["axis.c", "axis.gamma", "luxmeter", "spectroradiometer"]
            .iter()
            .chain(&OUTPUTS)
        {
            let able = choice.0.values().filter(|twin| twin.open(part).is_some()).count();
            assert_eq!(able, 1, "{part}");
        }
    }

    #[test]
    fn every_twin_can_be_chosen_and_every_part_is_played() {
        for twin in TWINS {
            let mut choice = Choice::default();
            choice.choose(twin.instrument, twin.driver).unwrap();
            assert_eq!(choice.twin(twin.instrument).unwrap().driver, twin.driver);
            for part in OUTPUTS {
                assert!(
                    choice.0.values().any(|twin| twin.open(part).is_some()),
                    "{}: {part}",
                    twin.driver
                );
            }
        }
        let error = Choice::default().choose(Instrument::Luxmeter, "zaber").unwrap_err();
        assert!(error.to_string().contains("konica-t10a"), "{error}");
    }
}
