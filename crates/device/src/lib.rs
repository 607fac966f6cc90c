//! What the bench asks of its instruments, and nothing more.
//!
//! Narrow, object-safe traits: [`Axis`], [`LuxMeter`], [`Spectroradiometer`], [`Switch`] (lamp, shutter, baffle),
//! [`Thermometer`], [`PowerMeter`] and [`WaveformRecorder`]. Every method takes `&self`: a handle talks by messages to
//! the one task that owns the bus, so `stop` can be called while another task waits for a move. Deadlines and times of
//! measurement are [`tokio::time::Instant`]s, so that a whole day can run with the clock paused.
//!
//! A handle that is dropped in the middle of a call leaves its bus usable: the owner finishes or drains the exchange.

pub mod awake;
mod axis;
mod axis_scale;
mod error;
mod factory;
mod identity;
mod luxmeter;
mod power;
mod spectroradiometer;
mod switch;
mod thermometer;
mod waveform;

pub use axis::{Axis, AxisPosition, AxisSettings, InvalidSettings, Motion};
pub use axis_scale::{AxisScale, Coordinate, InvalidScale, Sense};
pub use error::{DeviceError, ErrorKind};
pub use factory::{
    AxisFactory, Factories, Kind, LuxMeterFactory, OpenError, PowerMeterFactory, SpectroradiometerFactory,
    SwitchFactory, Target, ThermometerFactory, WaveformRecorderFactory,
};
pub use identity::Identity;
pub use luxmeter::{Caution, Conversions, LuxMeter, LuxMeterProperties, LuxOutcome, LuxRange, LuxReading, LuxSample};
pub use power::{PowerMeter, PowerReading, Quantity};
pub use spectroradiometer::{LinearisationError, RawSpectrum, Spectroradiometer, SpectroradiometerProperties};
pub use switch::Switch;
pub use thermometer::{TemperatureReading, Thermometer};
pub use waveform::{VoltageRecord, WaveformRecorder};
