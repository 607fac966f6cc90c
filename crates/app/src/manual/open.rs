//! The instruments of a bench, open, and the steps by hand on them.

use camino::Utf8Path;
use isolux_record::Limits;
use isolux_record::station::Rail;
use isolux_scan::motion::{Axes, Pose, drive_rail, stop_all};
use isolux_scan::settle::Photometer;
use isolux_scan::warmup::{Criterion, Stable, until_stable};
use isolux_scan::{Cancel, Devices, ScanError, ScanSummary, TwoState, dark};
use jiff::Timestamp;
use tokio::time::Instant;

use super::{Lux, Output, Position, WarmedUp, device, readings, spectrum};
use crate::Failure;
use crate::front_end::control::Control;
use crate::front_end::progress::{Event, Progress, Silent, left_words};
use crate::instruments::bench::StationFiles;
use crate::instruments::catalogue::Catalogue;
use crate::instruments::owner::TakeOver;
use crate::instruments::roles;
use crate::instruments::session::{self, Session};
use crate::scan::{self, Operator, Place, ScanJob, Target, spread_words};
use crate::system::keep_awake::{KeptAwake, keep_awake};

/// The instruments of a station, open and owned by this process.
pub struct OpenBench {
    source: StationFiles,
    devices: Devices,
    taken: Option<TakeOver>,
    _awake: KeptAwake,
    session: Session,
}

impl OpenBench {
    /// Becomes the owner of the instruments and opens them. Nothing moves. Must be called on the runtime that goes with
    /// the station.
    ///
    /// # Errors
    /// Exit 2 for the station, 3 for an instrument that does not open or belongs to another process.
    pub async fn open(source: StationFiles, force: Option<&str>, progress: &dyn Progress) -> Result<Self, Failure> {
        let session = Session::of(&source.station, &source.file, progress)?;
        let taken = session.claim(&source.station, force).await?;
        // A step by hand is short: where the system refuses, nobody has to read of it each time.
        let awake = keep_awake(!roles::is_virtual(&source.station), &Silent);
        let catalogue = Catalogue::new(session.links.clone()).beside(&source.file);
        let devices = source.open(&catalogue).await?;
        Ok(Self {
            source,
            devices,
            taken,
            _awake: awake,
            session,
        })
    }

    /// Does `step`, and stops the axes when it does not end well or `cancel` asks for its end.
    async fn step<T>(&self, cancel: &Cancel, step: impl Future<Output = Result<T, ScanError>>) -> Result<T, Failure> {
        let outcome = tokio::select! {
            biased;
            reason = cancel.cancelled() => Err(ScanError::Interrupted { reason, readings: 0 }),
            outcome = step => outcome,
        };
        let error = match outcome {
            Ok(value) => return Ok(value),
            Err(error) => error,
        };
        let error = match stop_all(&self.devices).await {
            Ok(()) => error,
            Err(axes) => ScanError::NotAtRest {
                axes,
                before: format!("; before that: {error}"),
            },
        };
        Err(self.session.explain(session::failure(&error)))
    }

    /// Homes both axes.
    ///
    /// # Errors
    /// Exit 3 for an instrument that fails or an axis not at rest, 130 when interrupted.
    pub async fn home(&self, cancel: &Cancel) -> Result<Position, Failure> {
        let mut axes = Axes::new(&self.devices, &self.source.station);
        self.step(cancel, async { Ok(position(axes.home().await?)) }).await
    }

    /// Where the axes stand, and the detector where it is driven. Nothing moves.
    ///
    /// # Errors
    /// As [`home`](Self::home).
    pub async fn position(&self, cancel: &Cancel) -> Result<Position, Failure> {
        let axes = Axes::new(&self.devices, &self.source.station);
        self.step(cancel, async {
            let distance_mm = match &self.devices.rail {
                Some(rail) => Some(rail.position().await.map_err(device("rail"))?.place.value()),
                None => None,
            };
            Ok(Position {
                distance_mm,
                ..position(axes.pose().await?)
            })
        })
        .await
    }

    /// Moves both axes to (C, γ) and the detector to a distance; what is not given stays.
    ///
    /// # Errors
    /// As [`home`](Self::home); exit 2 before anything moves for a position outside the limits, and for a distance
    /// without a driven rail.
    pub async fn move_to(
        &self,
        c_deg: Option<f64>,
        gamma_deg: Option<f64>,
        distance_mm: Option<f64>,
        cancel: &Cancel,
    ) -> Result<Position, Failure> {
        within_limits(&self.source, c_deg, gamma_deg, distance_mm)?;
        let mut axes = Axes::new(&self.devices, &self.source.station);
        self.step(cancel, async {
            let mut at = position(axes.pose().await?);
            if let (Some(distance_mm), Some(rail)) = (distance_mm, &self.devices.rail) {
                at.distance_mm = Some(drive_rail(rail.as_ref(), distance_mm).await?);
            }
            if c_deg.is_some() || gamma_deg.is_some() {
                let (c_deg, gamma_deg) = (c_deg.unwrap_or(at.c_deg), gamma_deg.unwrap_or(at.gamma_deg));
                let pose = position(axes.go_to(c_deg, gamma_deg).await?);
                at = Position {
                    distance_mm: at.distance_mm,
                    ..pose
                };
            }
            Ok(at)
        })
        .await
    }

    /// Switches outputs, one after the other, and reads each back. Nothing moves.
    ///
    /// # Errors
    /// As [`home`](Self::home); exit 2 for an output that the station does not have or leaves to a person.
    pub async fn switch(&self, outputs: &[(Output, bool)], cancel: &Cancel) -> Result<Vec<(Output, bool)>, Failure> {
        driven(&self.source, outputs)?;
        self.step(cancel, async {
            let mut states = Vec::new();
            for (output, on) in outputs {
                let part = match output {
                    Output::Lamp | Output::Supply => &self.devices.lamp,
                    Output::Shutter => &self.devices.shutter,
                    Output::Baffle => &self.devices.baffle,
                };
                if let Some(TwoState::Device(switch)) = part {
                    switch.set(*on).await.map_err(device(output.name()))?;
                    states.push((*output, switch.state().await.map_err(device(output.name()))?));
                }
            }
            Ok(states)
        })
        .await
    }

    /// Reads the lux meter `count` times, and the power meter with it, with lamp, shutter and baffle as they are.
    ///
    /// # Errors
    /// As [`home`](Self::home).
    pub async fn read(&self, count: u32, cancel: &Cancel) -> Result<Vec<Lux>, Failure> {
        let devices = &self.devices;
        let factor = self.source.station.luxmeter().calibration_factor;
        self.step(cancel, async {
            dark::behind_shutter(devices).await?;
            readings(devices.meter.as_ref(), devices.power.as_deref(), factor, count).await
        })
        .await
    }

    /// Takes one spectrum with the integration time that its light needs, with lamp, shutter and baffle as they are. An
    /// instrument without dark pixels gets its dark from the station's shutter, which is put back as it was.
    ///
    /// # Errors
    /// As [`home`](Self::home); exit 2 where the station has no spectroradiometer, or nothing to make dark with.
    pub async fn spectrum(&self, cancel: &Cancel) -> Result<spectrum::Reading, Failure> {
        let taken = self.step(cancel, spectrum::take(&self.devices)).await?;
        spectrum::reading(&self.source.file, taken)
    }

    /// Switches the lamp on, opens the path, goes to the reference point and waits until the lamp is stable.
    ///
    /// # Errors
    /// As [`home`](Self::home); exit 1 when it does not become stable.
    pub async fn warm_up(&self, cancel: &Cancel, progress: &dyn Progress) -> Result<WarmedUp, Failure> {
        self.step(cancel, self.until_stable(progress)).await
    }

    async fn until_stable(&self, progress: &dyn Progress) -> Result<WarmedUp, ScanError> {
        let Self { source, devices, .. } = self;
        let mut axes = Axes::new(devices, &source.station);
        let homed = devices.axis_c.position().await.map_err(device("axis.c"))?.homed
            && devices.axis_gamma.position().await.map_err(device("axis.gamma"))?.homed;
        if !homed {
            axes.home().await?;
        }
        axes.go_to(0.0, 0.0).await?;
        dark::behind_shutter(devices).await?;
        for (role, switch, on) in [
            ("baffle", &devices.baffle, false),
            ("shutter", &devices.shutter, true),
            ("lamp", &devices.lamp, true),
        ] {
            match switch {
                Some(TwoState::Device(switch)) => switch.set(on).await.map_err(device(role))?,
                Some(TwoState::Person(prompt)) => progress.event(Event::Note(prompt)),
                None => {}
            }
        }
        let on_at = Instant::now();
        let criterion = Criterion::of(&source.station, &Limits::default());
        progress.event(Event::Began {
            step: "warm up",
            total: Some(criterion.least_s() as u64),
        });
        let mut photometer = Photometer::new(devices.meter.as_ref());
        let Stable {
            elapsed_s,
            spread_rel,
            illuminance_lx,
            ..
        } = until_stable(&mut photometer, devices.power.as_deref(), &criterion, on_at, |look| {
            let spread = look
                .spread_rel
                .map_or_else(String::new, |spread| format!(", {}", spread_words(spread, &criterion)));
            let left = left_words((criterion.least_s() - look.elapsed_s).max(0.0), Timestamp::now());
            let what = format!("{:.3} lx{spread}; {left}", look.illuminance_lx);
            progress.event(Event::At {
                done: look.elapsed_s as u64,
                what: &what,
            });
        })
        .await?;
        progress.event(Event::Ended("lamp stable"));
        Ok(WarmedUp {
            elapsed_s,
            spread_rel,
            illuminance_lx,
        })
    }

    /// Carries out the plan of the file `plan` into a run directory, on these instruments. `force` also takes the
    /// directory from a process that does not answer.
    ///
    /// # Errors
    /// As [`ScanJob::execute`]; exit 2 with file and line of the plan.
    pub async fn scan(
        &mut self,
        plan: &Utf8Path,
        target: Target<'_>,
        operator: Option<&dyn Operator>,
        control: &Control,
        progress: &dyn Progress,
    ) -> Result<ScanSummary, Failure> {
        let (plan, _) = scan::planned(&self.source, plan, operator.is_some())?;
        for sentence in scan::plan::not_claimable(&self.source.station, &plan) {
            progress.event(Event::Note(&format!("not to be claimed of this scan: {sentence}")));
        }
        let in_memory = roles::is_virtual(&self.source.station);
        let _awake = keep_awake(!in_memory, progress);
        let job = ScanJob {
            source: &self.source,
            plan: &plan,
            place: Place::take(target, self.taken.is_some())?,
            force: None,
            operator,
            control,
            progress,
        };
        // The states of a scan are too many for the stack of whoever waits for it.
        let work = Box::pin(job.execute_on(&mut self.devices, self.taken.as_ref(), Timestamp::now()));
        let outcome = if in_memory {
            control.paced(work).await
        } else {
            work.await
        };
        outcome.map_err(|failure| self.session.explain(failure))
    }

    /// Stops everything that moves, from any state, and verifies that it rests.
    ///
    /// # Errors
    /// Exit 3 when an axis could not be verified at rest.
    pub async fn stop(&self) -> Result<(), Failure> {
        stop_all(&self.devices).await.map_err(|axes| {
            let before = String::new();
            self.session
                .explain(session::failure(&ScanError::NotAtRest { axes, before }))
        })
    }
}

/// That the station drives all of `outputs`.
///
/// # Errors
/// Exit 2 for one that it does not have or leaves to a person.
pub(crate) fn driven(source: &StationFiles, outputs: &[(Output, bool)]) -> Result<(), Failure> {
    let StationFiles { station, file, .. } = source;
    let lamp = station.lamp_switch();
    for (output, _) in outputs {
        let part = match output {
            Output::Lamp => lamp.as_ref(),
            Output::Shutter => station.shutter(),
            Output::Baffle => station.baffle(),
            Output::Supply => lamp.as_ref().filter(|_| station.supply().is_some()),
        };
        if part.is_some_and(|part| part.open.is_some()) {
            continue;
        }
        let name = output.name();
        return Err(Failure::bad_input(match part.map(|part| &part.prompt) {
            Some(Some(prompt)) => format!("{file}: the {name} is left to a person: {prompt}"),
            _ => format!("{file}: there is no [{name}]"),
        })
        .help("nothing was switched"));
    }
    Ok(())
}

/// That axes and rail of the station may go there.
///
/// # Errors
/// Exit 2 with the limits, and for a distance without a driven rail.
pub(crate) fn within_limits(
    source: &StationFiles,
    c_deg: Option<f64>,
    gamma_deg: Option<f64>,
    distance_mm: Option<f64>,
) -> Result<(), Failure> {
    let StationFiles { station, file, .. } = source;
    let refused = |reason: String| Err(Failure::bad_input(reason).help("nothing was moved"));
    for (name, angle, [low, high]) in [
        ("C", c_deg, station.axis_c().limit_deg),
        ("γ", gamma_deg, station.axis_gamma().limit_deg),
    ] {
        if let Some(angle) = angle
            && !(low..=high).contains(&angle)
        {
            return refused(format!("{name} = {angle}° is outside the axis' limits {low}°…{high}°"));
        }
    }
    let Some(wanted) = distance_mm else { return Ok(()) };
    match station.rail().and_then(Rail::driven).map(|rail| rail.limit_mm) {
        Some([low, high]) if (low..=high).contains(&wanted) => Ok(()),
        Some([low, high]) => refused(format!("{wanted} mm is outside the rail's limits {low} mm…{high} mm")),
        None => refused(format!("{file}: no rail is driven here; the detector is set by hand")),
    }
}

fn position(pose: Pose) -> Position {
    Position {
        c_deg: pose.c_deg,
        gamma_deg: pose.gamma_deg,
        distance_mm: None,
    }
}
