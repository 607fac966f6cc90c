//! The instruments of a bench, opened, and the person beside it.

use async_trait::async_trait;
use isolux_device::{Axis, Identity, LuxMeter, PowerMeter, Spectroradiometer, Switch, Thermometer};
use isolux_record::run::DeviceRecord;
use isolux_record::spectra::SpectralCalibration;
use isolux_record::{ReadingKind, Station};
use isolux_units::Millimetre;

/// Every instrument that a scan uses.
pub struct Devices {
    /// Turns the luminaire about its optical axis.
    pub axis_c: Box<dyn Axis>,
    /// Turns the optical axis away from the detector.
    pub axis_gamma: Box<dyn Axis>,
    /// Reads illuminance.
    pub meter: Box<dyn LuxMeter>,
    /// Reads spectra.
    pub spectro: Option<CalibratedSpectro>,
    /// Reads the lamp's supply line.
    pub power: Option<Box<dyn PowerMeter>>,
    /// Lamp, or the supply that feeds it; on = lit.
    pub lamp: Option<TwoState>,
    /// Cap of the detectors; on = open.
    pub shutter: Option<TwoState>,
    /// Baffle; on = in the beam.
    pub baffle: Option<TwoState>,
    /// The detector's carriage, where it is driven.
    pub rail: Option<Box<dyn Axis<Millimetre>>>,
    /// The room's thermometer.
    pub ambient: Option<Box<dyn Thermometer>>,
}

/// A spectroradiometer with what turns its counts into irradiance.
pub struct CalibratedSpectro {
    /// The instrument.
    pub device: Box<dyn Spectroradiometer>,
    /// Spectral irradiance of one linear count per second at each pixel, W/m²/nm.
    pub factor_w_m2_nm: Vec<f64>,
    /// Everything else.
    pub calibration: SpectralCalibration,
}

/// Something that an instrument or a person switches.
pub enum TwoState {
    /// An instrument.
    Device(Box<dyn Switch>),
    /// A person, asked with these words.
    Person(String),
}

/// What a person is asked to do, in words and in facts.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorRequest {
    /// The words.
    pub prompt: String,
    /// What the detector is to see afterwards.
    pub kind: ReadingKind,
    /// Where the detector is to stand afterwards.
    pub distance_mm: f64,
}

/// The person beside the bench.
#[async_trait]
pub trait Operator: Send + Sync {
    /// Asks, waits until it is done, and says who did it.
    ///
    /// # Errors
    /// The reason for which it was not done.
    async fn carry_out(&self, request: &OperatorRequest) -> Result<String, String>;
}

/// Nobody is there: every request is declined.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nobody;

#[async_trait]
impl Operator for Nobody {
    async fn carry_out(&self, _: &OperatorRequest) -> Result<String, String> {
        Err("nobody is there to do it".to_owned())
    }
}

impl Devices {
    /// The identities of all instruments, in a fixed order.
    pub fn records(&self, station: &Station) -> Vec<DeviceRecord> {
        let mut records = vec![
            record("axis.c", &station.axis_c().open, self.axis_c.identity()),
            record("axis.gamma", &station.axis_gamma().open, self.axis_gamma.identity()),
            record("luxmeter", &station.luxmeter().open, self.meter.identity()),
        ];
        if let (Some(spectro), Some(settings)) = (&self.spectro, station.spectroradiometer()) {
            records.push(record("spectroradiometer", &settings.open, spectro.device.identity()));
        }
        if let (Some(meter), Some(settings)) = (&self.power, station.powermeter()) {
            records.push(record("powermeter", &settings.open, meter.identity()));
        }
        let lamp = station.lamp_switch().and_then(|lamp| lamp.open);
        let lamp_role = if station.supply().is_some() { "supply" } else { "lamp" };
        let open = |access: Option<&isolux_record::station::Access>| access.and_then(|access| access.open.clone());
        for (role, device, open) in [
            (lamp_role, &self.lamp, lamp),
            ("shutter", &self.shutter, open(station.shutter())),
            ("baffle", &self.baffle, open(station.baffle())),
        ] {
            match device {
                Some(TwoState::Device(device)) => {
                    records.push(record(role, open.as_deref().unwrap_or_default(), device.identity()));
                }
                Some(TwoState::Person(_)) => records.push(DeviceRecord {
                    role: role.to_owned(),
                    open: "prompt".to_owned(),
                    model: "a person".to_owned(),
                    serial: None,
                    firmware: None,
                }),
                None => {}
            }
        }
        if let (Some(rail), Some(driven)) = (
            &self.rail,
            station.rail().and_then(isolux_record::station::Rail::driven),
        ) {
            records.push(record("rail", driven.open, rail.identity()));
        }
        if let (Some(thermometer), Some(open)) = (&self.ambient, open(station.ambient())) {
            records.push(record("ambient", &open, thermometer.identity()));
        }
        records
    }
}

fn record(role: &str, open: &str, identity: &Identity) -> DeviceRecord {
    DeviceRecord {
        role: role.to_owned(),
        open: open.to_owned(),
        model: identity.model.clone(),
        serial: identity.serial.clone(),
        firmware: identity.firmware.clone(),
    }
}
