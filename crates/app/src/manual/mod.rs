//! `home`, `move`, `stop`, `read`, `warmup`: one step of the day by hand.

pub mod spectrum;
pub mod stop;

use camino::Utf8Path;
use isolux_device::{LuxMeter, LuxOutcome, PowerMeter};
use isolux_record::station::Rail;
use isolux_record::{Electrical, Limits, Station};
use isolux_scan::motion::{Axes, Pose, drive_rail, stop_all};
use isolux_scan::settle::Photometer;
use isolux_scan::warmup::{Criterion, Stable, until_stable};
use isolux_scan::{Devices, ScanError, TwoState, dark, electrical};
use jiff::Timestamp;
use serde::Serialize;
use tokio::time::Instant;

use crate::front_end::progress::{Event, Progress, Silent, left_words};
use crate::instruments::bench::StationFiles;
use crate::instruments::catalogue::Catalogue;
use crate::instruments::roles;
use crate::instruments::session::{self, Session};
use crate::scan::spread_words;
use crate::system::keep_awake::keep_awake;
use crate::system::signals::OnSignals;
use crate::{Failure, FailureKind};

/// Where the axes stand, read back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Position {
    /// C in degrees.
    pub c_deg: f64,
    /// γ in degrees.
    pub gamma_deg: f64,
    /// Distance of the detector in mm, where it was driven.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

/// An output of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Output {
    /// On: lit.
    Lamp,
    /// On: open.
    Shutter,
    /// On: in the beam.
    Baffle,
    /// On: it feeds the lamp.
    Supply,
}

impl Output {
    /// Its table in the station file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lamp => "lamp",
            Self::Shutter => "shutter",
            Self::Baffle => "baffle",
            Self::Supply => "supply",
        }
    }
}

/// One reading of the lux meter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lux {
    /// Illuminance after the station's calibration factor; none out of range or of unsteady light.
    pub illuminance_lx: Option<f64>,
    /// One digit of the display.
    pub digit_lx: f64,
    /// The meter's range.
    pub range: u8,
    /// `ok`, `over_range`, `under_range` or `unsteady`.
    pub quality: &'static str,
    /// The lamp's supply line at that time, where the bench has a power meter.
    #[serde(flatten)]
    pub electrical: Electrical,
}

/// The lamp is stable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WarmedUp {
    /// Seconds since it was switched on.
    pub elapsed_s: f64,
    /// (max − min)/mean over the window.
    pub spread_rel: f64,
    /// Illuminance at the reference point.
    pub illuminance_lx: f64,
}

/// Homes both axes. `force` is the reason for which the instruments may be taken over from a process that does not
/// answer.
///
/// # Errors
/// Exit 2 for the station, 3 for an instrument that fails or belongs to another process, or an axis not at rest, 130
/// when interrupted.
pub fn home(station: &Utf8Path, force: Option<&str>, progress: &dyn Progress) -> Result<Position, Failure> {
    one_step(station, force, progress, async |source, devices| {
        Ok(position(Axes::new(devices, &source.station).home().await?))
    })
}

/// Switches outputs, one after the other, and reads each back. Nothing moves.
///
/// # Errors
/// As [`home`]; exit 2 for an output that the station does not have or leaves to a person.
pub fn switch(
    station: &Utf8Path,
    outputs: &[(Output, bool)],
    force: Option<&str>,
    progress: &dyn Progress,
) -> Result<Vec<(Output, bool)>, Failure> {
    let known = Station::load(station).map_err(Failure::bad_input)?;
    let lamp = known.lamp_switch();
    for (output, _) in outputs {
        let part = match output {
            Output::Lamp => lamp.as_ref(),
            Output::Shutter => known.shutter(),
            Output::Baffle => known.baffle(),
            Output::Supply => lamp.as_ref().filter(|_| known.supply().is_some()),
        };
        if part.is_some_and(|part| part.open.is_some()) {
            continue;
        }
        let name = output.name();
        return Err(Failure::bad_input(match part.map(|part| &part.prompt) {
            Some(Some(prompt)) => format!("{station}: the {name} is left to a person: {prompt}"),
            _ => format!("{station}: there is no [{name}]"),
        })
        .help("nothing was switched"));
    }
    one_step(station, force, progress, async |_, devices| {
        let mut states = Vec::new();
        for (output, on) in outputs {
            let part = match output {
                Output::Lamp | Output::Supply => &devices.lamp,
                Output::Shutter => &devices.shutter,
                Output::Baffle => &devices.baffle,
            };
            if let Some(TwoState::Device(switch)) = part {
                switch.set(*on).await.map_err(device(output.name()))?;
                states.push((*output, switch.state().await.map_err(device(output.name()))?));
            }
        }
        Ok(states)
    })
}

/// Moves both axes to (C, γ) and the detector to a distance; what is not given stays.
///
/// # Errors
/// As [`home`]; exit 2 before anything moves for a position outside the limits, and for a distance without a driven
/// rail.
pub fn move_to(
    station: &Utf8Path,
    c_deg: Option<f64>,
    gamma_deg: Option<f64>,
    distance_mm: Option<f64>,
    force: Option<&str>,
    progress: &dyn Progress,
) -> Result<Position, Failure> {
    let limits = Station::load(station).map_err(Failure::bad_input)?;
    for (name, angle, [low, high]) in [
        ("C", c_deg, limits.axis_c().limit_deg),
        ("γ", gamma_deg, limits.axis_gamma().limit_deg),
    ] {
        if let Some(angle) = angle
            && !(low..=high).contains(&angle)
        {
            return Err(
                Failure::bad_input(format!("{name} = {angle}° is outside the axis' limits {low}°…{high}°"))
                    .help("nothing was moved"),
            );
        }
    }
    if let Some(wanted) = distance_mm {
        let refused = |reason: String| Err(Failure::bad_input(reason).help("nothing was moved"));
        match limits.rail().and_then(Rail::driven).map(|rail| rail.limit_mm) {
            Some([low, high]) if (low..=high).contains(&wanted) => {}
            Some([low, high]) => {
                return refused(format!("{wanted} mm is outside the rail's limits {low} mm…{high} mm"));
            }
            None => {
                return refused(format!(
                    "{station}: no rail is driven here; the detector is set by hand"
                ));
            }
        }
    }
    one_step(station, force, progress, async |source, devices| {
        let mut axes = Axes::new(devices, &source.station);
        let mut at = position(axes.pose().await?);
        if let (Some(distance_mm), Some(rail)) = (distance_mm, &devices.rail) {
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
}

impl Lux {
    /// The supply line in words, where there was a power meter that gave a number.
    pub fn electrical(&self) -> Option<String> {
        (self.electrical != Electrical::default()).then(|| in_words(&self.electrical))
    }
}

/// Volts, amperes, watts and power factor; a dash where the meter gave no number.
pub(crate) fn in_words(reading: &Electrical) -> String {
    let shown =
        |value: Option<f64>, unit: &str| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.5}{unit}"));
    [
        shown(reading.voltage_v, " V"),
        shown(reading.current_a, " A"),
        shown(reading.power_w, " W"),
        format!("power factor {}", shown(reading.power_factor, "")),
    ]
    .join(", ")
}

/// Reads the lux meter `count` times, and the power meter with it, with lamp, shutter and baffle as they are.
///
/// # Errors
/// As [`home`].
pub fn read(station: &Utf8Path, count: u32, force: Option<&str>, progress: &dyn Progress) -> Result<Vec<Lux>, Failure> {
    one_step(station, force, progress, async |source, devices| {
        dark::behind_shutter(devices).await?;
        readings(
            devices.meter.as_ref(),
            devices.power.as_deref(),
            source.station.luxmeter().calibration_factor,
            count,
        )
        .await
    })
}

/// Switches the lamp on, opens the path, goes to the reference point and waits until the lamp is stable.
///
/// # Errors
/// As [`home`]; exit 1 when it does not become stable.
pub fn warm_up(station: &Utf8Path, force: Option<&str>, progress: &dyn Progress) -> Result<WarmedUp, Failure> {
    one_step(station, force, progress, async |source, devices| {
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
    })
}

/// `count` new readings.
///
/// # Errors
/// What the meter reports.
pub(crate) async fn readings(
    meter: &dyn LuxMeter,
    power: Option<&dyn PowerMeter>,
    factor: f64,
    count: u32,
) -> Result<Vec<Lux>, ScanError> {
    let mut photometer = Photometer::new(meter);
    let mut list = Vec::new();
    for _ in 0..count {
        let now = Instant::now();
        let reading = photometer.read(now).await?;
        let electrical = match power {
            Some(power) => electrical::recorded(&electrical::read(power, now).await?),
            None => Electrical::default(),
        };
        let quality = match reading.outcome {
            LuxOutcome::Measured(_) => "ok",
            LuxOutcome::OverRange => "over_range",
            LuxOutcome::UnderRange => "under_range",
            LuxOutcome::Unsteady => "unsteady",
        };
        list.push(Lux {
            illuminance_lx: reading.illuminance().map(|lux| lux.value() * factor),
            digit_lx: reading.digit.value() * factor,
            range: reading.range,
            quality,
            electrical,
        });
    }
    Ok(list)
}

/// Opens the station, does `step` under a handle for signals, and stops the axes when it does not end well.
pub(crate) fn one_step<T>(
    station: &Utf8Path,
    force: Option<&str>,
    progress: &dyn Progress,
    step: impl AsyncFnOnce(&StationFiles, &Devices) -> Result<T, ScanError>,
) -> Result<T, Failure> {
    let source = StationFiles::load(station)?;
    let in_memory = roles::is_virtual(&source.station);
    session::run(in_memory, async {
        let session = Session::of(&source.station, &source.file, progress)?;
        let cancel = OnSignals::listen()?;
        session.claim(&source.station, force).await?;
        // A step by hand is short: where the system refuses, nobody has to read of it each time.
        let _awake = keep_awake(!in_memory, &Silent);
        let catalogue = Catalogue::new(session.links.clone()).beside(&source.file);
        let devices = source.open(&catalogue).await?;
        let outcome = tokio::select! {
            biased;
            reason = cancel.cancelled() => Err(ScanError::Interrupted { reason, readings: 0 }),
            outcome = step(&source, &devices) => outcome,
        };
        match outcome {
            Ok(value) => Ok(value),
            Err(error) => match stop_all(&devices).await {
                Ok(()) => Err(session.explain(session::failure(&error))),
                Err(axes) => {
                    let before = format!("; before that: {error}");
                    Err(session.explain(Failure {
                        kind: FailureKind::Instrument,
                        ..session::failure(&ScanError::NotAtRest { axes, before })
                    }))
                }
            },
        }
    })
}

fn position(pose: Pose) -> Position {
    Position {
        c_deg: pose.c_deg,
        gamma_deg: pose.gamma_deg,
        distance_mm: None,
    }
}

pub(crate) fn device(role: &'static str) -> impl Fn(isolux_device::DeviceError) -> ScanError {
    move |source| ScanError::Device { role, source }
}
