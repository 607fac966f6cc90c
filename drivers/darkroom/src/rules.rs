//! Values that no room can have.

use isolux_document as document;
use isolux_document::bounds::within;

use crate::document::{Darkroom, FORMAT};
use crate::fault::{Fault, FaultKind, Instrument};
use crate::parts::{Axis, Lamp, Spectroradiometer};

impl Darkroom {
    /// The first value that no room can have.
    pub(crate) fn check(&self) -> Result<(), document::Fault> {
        require("format", self.format == FORMAT, &format!("must be \"{FORMAT}\""))?;
        lamp(&self.lamp)?;
        self.room.check("room")?;
        self.bench.check("bench")?;
        for (path, axis) in [("axis.c", &self.axis.c), ("axis.gamma", &self.axis.gamma)] {
            axis.check(path)?;
            positions(path, axis)?;
        }
        self.luxmeter.check("luxmeter")?;
        self.spectroradiometer.check("spectroradiometer")?;
        wavelengths(&self.spectroradiometer)?;
        self.powermeter.check("powermeter")?;
        self.camera.check("camera")?;
        self.injected_effects.check()?;
        self.fault.iter().try_for_each(fault)
    }
}

fn require(key: &str, holds: bool, rule: &str) -> Result<(), document::Fault> {
    if holds {
        return Ok(());
    }
    Err(document::Fault::new(key, rule))
}

fn lamp(lamp: &Lamp) -> Result<(), document::Fault> {
    lamp.check("lamp")?;
    require(
        "lamp.luminous_diameter_mm",
        lamp.luminous_diameter_mm.is_none() || lamp.table.is_some(),
        "belongs to a lamp with a `table`; rings of LEDs have `ring_diameter_mm`",
    )?;
    require(
        "lamp.table",
        lamp.table.is_none() || lamp.luminous_diameter_mm.is_some(),
        "needs `luminous_diameter_mm`, the diameter of what shines; 0 is a point",
    )?;
    require(
        "lamp.temperature_k",
        lamp.temperature_k == 0.0 || lamp.temperature_k >= 1500.0,
        "is 0 for LEDs, or 1500 to 4000 K of a filament",
    )?;
    let rings = lamp.ring_diameter_mm.len();
    require(
        "lamp.ring_diameter_mm",
        (1..=100).contains(&rings),
        "needs between 1 and 100 rings",
    )?;
    for diameter_mm in &lamp.ring_diameter_mm {
        within("lamp.ring_diameter_mm", *diameter_mm, 0.0..=1000.0, " mm")?;
    }
    require(
        "lamp.leds_per_ring",
        lamp.leds_per_ring.len() == rings,
        "needs one number for each ring of `ring_diameter_mm`",
    )?;
    require(
        "lamp.leds_per_ring",
        lamp.leds_per_ring.iter().all(|n| (1..=1000).contains(n)),
        "must lie between 1 and 1000 on each ring",
    )
}

fn positions(path: &str, axis: &Axis) -> Result<(), document::Fault> {
    let [low, high] = axis.limit_deg;
    require(
        &format!("{path}.limit_deg"),
        -3600.0 <= low && low < high && high <= 3600.0,
        "must be [lower, higher], both within -3600 and 3600",
    )?;
    within(&format!("{path}.start_deg"), axis.start_deg, low..=high, "°")
}

fn wavelengths(spectro: &Spectroradiometer) -> Result<(), document::Fault> {
    for error_nm in spectro.wavelength_error_nm {
        within("spectroradiometer.wavelength_error_nm", error_nm, -20.0..=20.0, " nm")?;
    }
    let rising = (0..2048).map(|pixel| spectro.nm_at(f64::from(pixel)));
    require(
        "spectroradiometer.wavelength_nm",
        rising.clone().zip(rising.skip(1)).all(|(a, b)| a < b),
        "must rise from pixel 0 to pixel 2047",
    )
}

fn fault(fault: &Fault) -> Result<(), document::Fault> {
    within("fault.at_s", fault.at_s, 0.0..=1e7, " s")?;
    within("fault.delay_s", fault.delay_s, 0.0..=1e5, " s")?;
    within("fault.for_s", fault.for_s, 0.0..=1e7, " s")?;
    within("fault.probability", fault.probability, 0.0..=1.0, "")?;
    let (fits, who) = match (fault.kind, fault.instrument) {
        (FaultKind::Alarm | FaultKind::Stall, instrument) => {
            (matches!(instrument, Instrument::Axes | Instrument::Outputs), "axes")
        }
        (FaultKind::Saturate, instrument) => (
            matches!(instrument, Instrument::Luxmeter | Instrument::Spectroradiometer),
            "luxmeter or spectroradiometer",
        ),
        _ => (true, ""),
    };
    let rule = format!("is no fault of the {}: it is one of {who}", fault.instrument.name());
    require("fault.kind", fits, &rule)
}
