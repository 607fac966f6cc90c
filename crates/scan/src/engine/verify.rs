//! Verification: axes, rail and outputs are asked whether they are as the engine left them.

use std::time::Duration;

use isolux_device::{Axis, Switch};
use isolux_record::Event;
use isolux_units::Millimetre;
use tokio::sync::Notify;
use tokio::time::sleep;

use super::session::Session;
use crate::devices::TwoState;
use crate::error::ScanError;
use crate::motion::{Axes, rail_holds};

/// How often the bench is asked while an instrument reads. Light that is changed and changed back in less lies in one
/// of two conversions that must agree, half a second apart, and not in the other.
const EVERY: Duration = Duration::from_millis(400);

/// An output that can be asked, and the state in which it was left.
pub(super) struct Output<'a> {
    pub role: &'static str,
    pub device: &'a dyn Switch,
    pub left: bool,
    /// Words for on and off.
    pub words: [&'static str; 2],
    /// The event of its being switched.
    pub switched: fn(bool) -> Event,
}

/// The bench as it was left.
pub(super) struct BenchState<'b, 'a> {
    pub axes: &'b Axes<'a>,
    /// The rail and where it was driven to.
    pub rail: Option<(&'a dyn Axis<Millimetre>, f64)>,
    pub outputs: Vec<Output<'a>>,
}

impl<'a> Session<'a> {
    /// Verifies that axes, rail and outputs are as they were left. Outputs that a person switches cannot be asked.
    ///
    /// # Errors
    /// [`ScanError::Disturbed`] names the first that is not; what the instruments report.
    pub async fn verify(&self) -> Result<(), ScanError> {
        self.left().verify().await
    }

    /// The bench as it was left.
    pub fn left(&self) -> BenchState<'_, 'a> {
        BenchState {
            axes: &self.axes,
            rail: self.rail_left(),
            outputs: self.outputs_left(),
        }
    }

    /// The rail, where it is driven, and its distance.
    pub fn rail_left(&self) -> Option<(&'a dyn Axis<Millimetre>, f64)> {
        self.devices.rail.as_deref().zip(self.rail_mm)
    }

    /// The outputs that were switched and can be asked.
    pub fn outputs_left(&self) -> Vec<Output<'a>> {
        let output = |role, switch: &'a Option<TwoState>, left: Option<bool>, words, switched: fn(bool) -> Event| match (
            switch, left,
        ) {
            (Some(TwoState::Device(device)), Some(left)) => Some(Output {
                role,
                device: device.as_ref(),
                left,
                words,
                switched,
            }),
            _ => None,
        };
        let devices = self.devices;
        [
            output("lamp", &devices.lamp, Some(self.lamp_is_on), ["on", "off"], |on| {
                Event::Lamp { on }
            }),
            output(
                "shutter",
                &devices.shutter,
                self.shutter_open,
                ["open", "closed"],
                |on| Event::Shutter { on },
            ),
            output(
                "baffle",
                &devices.baffle,
                self.baffle_in,
                ["in the beam", "out of the beam"],
                |on| Event::Baffle { on },
            ),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl BenchState<'_, '_> {
    /// Lets an instrument work, and verifies all the while and at the end.
    ///
    /// # Errors
    /// As [`Session::verify`]; they win over what the instrument reports, because they explain it.
    pub async fn during<T>(&self, work: impl Future<Output = Result<T, ScanError>>) -> Result<T, ScanError> {
        let ended = Notify::new();
        let (outcome, watched) = tokio::join!(
            async {
                let outcome = work.await;
                ended.notify_one();
                outcome
            },
            self.watch(&ended)
        );
        watched?;
        self.verify().await?;
        outcome
    }

    async fn watch(&self, ended: &Notify) -> Result<(), ScanError> {
        loop {
            tokio::select! {
                biased;
                () = ended.notified() => return Ok(()),
                () = sleep(EVERY) => self.verify().await?,
            }
        }
    }

    async fn verify(&self) -> Result<(), ScanError> {
        self.axes.hold().await?;
        if let Some((rail, distance_mm)) = self.rail {
            rail_holds(rail, distance_mm).await?;
        }
        for output in &self.outputs {
            let found = output.device.state().await.map_err(ScanError::device(output.role))?;
            if found != output.left {
                let word = |on: bool| output.words[usize::from(!on)].to_owned();
                return Err(ScanError::Disturbed {
                    role: output.role,
                    expected: word(output.left),
                    found: word(found),
                });
            }
        }
        Ok(())
    }
}
