//! What a driver says of itself to the catalogue.

use std::sync::Arc;

use isolux_device::{Factories, Kind, OpenError, Target};

use crate::{LineSettings, Ports, Probe};

/// A driver: its name, what it speaks to, and how its devices are opened. The catalogue is a list of these; nothing
/// outside that list knows an instrument by its name.
#[derive(Clone, Copy)]
pub struct Driver {
    /// Name in `open = "name:target"`.
    pub name: &'static str,
    /// The instruments, for people.
    pub speaks_to: &'static str,
    /// Examples of `open`, one a kind of device that it opens.
    pub examples: &'static [(Kind, &'static str)],
    /// What it has been seen to work with.
    pub seen_with: &'static str,
    /// USB devices that it speaks to.
    pub usb: &'static [UsbModel],
    /// Questions by which its instruments can be found on a port, each harmless to every other instrument.
    pub identify: &'static [Probe],
    /// Reads an address as opening it would, and opens nothing: what it uses behind its link, and how the line is set.
    pub place: fn(&Target, Kind) -> Result<Place, OpenError>,
    /// Full scale and last digit of every range that the display of a lux meter has, in lx; empty where they are not
    /// known.
    pub display_lx: fn(&Target) -> Vec<(f64, f64)>,
    /// What opens its devices, on the ports of a session.
    pub factories: fn(Arc<Ports>) -> Factories,
}

/// A model by its USB ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UsbModel {
    /// Vendor and product.
    pub id: (u16, u16),
    /// The model, for people.
    pub model: &'static str,
}

/// What a target uses behind its link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Which of the things there, for people: `axis 2 of device 1`. Two targets on one port with the same words are the
    /// same thing. Empty where the link leads to one thing only.
    pub channel: String,
    /// Settings of the line.
    pub line: LineSettings,
}

/// The display of a meter whose digits are not known, and of what is no meter.
pub const fn no_display(_: &Target) -> Vec<(f64, f64)> {
    Vec::new()
}
