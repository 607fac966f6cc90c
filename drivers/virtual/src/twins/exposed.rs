//! What falls on a spectrometer in one exposure, as the room's spectroradiometer or in the place of its lux meter.

use isolux_darkroom::spectrograph::Exposure;
use isolux_darkroom::{Instrument, Room};

use crate::world::World;

/// Exposures of an instrument in the place of the lux meter draw their noise from here on.
const OF_LUX_METER: u64 = 1 << 32;

/// Far from the lamp a lens stands before it in place of the diffuser: so many times the counts.
pub(super) const LENS: f64 = 20.0;

/// The room as a spectrometer in the place of `instrument` sees it.
pub(super) fn seen(world: &World, instrument: Instrument) -> Room {
    if instrument != Instrument::Luxmeter {
        return world.room().clone();
    }
    let mut document = world.room().document().clone();
    document.spectroradiometer.counts_per_s *= LENS;
    Room::new(document)
}

/// Air to detector: the electronics' own heat, K.
const SELF_HEATING_C: f64 = 4.0;

/// Temperature of the detector at `at_s`, °C.
pub(super) fn detector_c(world: &World, at_s: f64) -> f64 {
    world.temperature_c(at_s) + SELF_HEATING_C
}

/// When an exposure of so long begins and ends that is asked for at `asked_s`, s.
pub(super) fn window_s(
    world: &World,
    instrument: Instrument,
    asked_s: f64,
    integration_s: f64,
    index: u64,
) -> (f64, f64) {
    if instrument != Instrument::Luxmeter {
        return (asked_s, asked_s + integration_s);
    }
    let room = world.room();
    let from_s = asked_s + room.meter_latency_s(index);
    (from_s, from_s + room.document().luxmeter.by_its_clock_s(integration_s))
}

/// Exposure number `index` in that window.
pub(super) fn exposure(world: &World, instrument: Instrument, (from_s, to_s): (f64, f64), index: u64) -> Exposure {
    let in_place_of_meter = instrument == Instrument::Luxmeter;
    Exposure {
        illuminance_lx: if in_place_of_meter {
            world.meter_lx(from_s, to_s)
        } else {
            world.spectroradiometer_lx(from_s, to_s)
        },
        lines_lx: if in_place_of_meter {
            0.0
        } else {
            world.line_lamp_lx(from_s, to_s)
        },
        phosphor: world.spectroradiometer_phosphor(0.5 * (from_s + to_s)),
        integration_s: to_s - from_s,
        detector_c: detector_c(world, from_s),
        index: if in_place_of_meter { OF_LUX_METER + index } else { index },
    }
}
