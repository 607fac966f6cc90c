//! `isolux devices`: the drivers there are, the ports found, and what is missing.

use isolux_transport::{PortState, UsbAccess, UsbModel, found_ports, usb_devices};
use serde::Serialize;

use crate::Failure;
use crate::instruments::catalogue;

/// What this program and this computer have.
#[derive(Debug, Serialize)]
pub struct Devices {
    /// The drivers of this program.
    pub drivers: Vec<DriverFacts>,
    /// The serial ports of this computer.
    pub ports: Vec<Port>,
    /// USB devices that are instruments or serial adapters.
    pub usb: Vec<Usb>,
}

/// A driver.
#[derive(Debug, Serialize)]
pub struct DriverFacts {
    /// Name in `open = "name:target"`.
    pub name: &'static str,
    /// The instruments.
    pub speaks_to: &'static str,
    /// Kinds of device that it opens.
    pub kinds: Vec<&'static str>,
    /// Examples of `open`, one a kind.
    pub examples: Vec<String>,
    /// What it has been seen to work with.
    pub seen_with: &'static str,
}

/// A serial port.
#[derive(Debug, Serialize)]
pub struct Port {
    /// The target in `open = "driver:path"`.
    pub path: String,
    /// What it says of itself.
    pub description: String,
    /// USB ids, `vvvv:pppp`.
    pub usb: Option<String>,
    /// Serial number of the adapter.
    pub serial: Option<String>,
    /// It can be opened for reading and writing.
    pub usable: bool,
    /// What is missing.
    pub missing: Option<String>,
    /// What to do about it.
    pub remedy: Option<String>,
}

/// A USB device of interest.
#[derive(Debug, Serialize)]
pub struct Usb {
    /// `vvvv:pppp`.
    pub id: String,
    /// What it is.
    pub what: String,
    /// Serial number.
    pub serial: Option<String>,
    /// What is missing.
    pub missing: Option<String>,
    /// What to do about it.
    pub remedy: Option<String>,
}

/// Looks at ports and USB devices; sends nothing to any of them.
///
/// # Errors
/// Exit 3 when the system does not list its ports.
pub fn devices() -> Result<Devices, Failure> {
    let drivers = catalogue::drivers().map(|driver| {
        let examples = catalogue::examples(driver);
        DriverFacts {
            name: driver.name,
            speaks_to: driver.speaks_to,
            kinds: examples.iter().map(|(kind, _)| kind.name()).collect(),
            examples: examples.into_iter().map(|(_, example)| example).collect(),
            seen_with: driver.seen_with,
        }
    });
    let ports = found_ports().map_err(Failure::instrument)?.into_iter().map(|port| {
        let (usable, missing, remedy) = match port.state {
            PortState::Usable => (true, None, None),
            PortState::Unusable { reason, advice } => (false, Some(reason), advice),
        };
        let usb = port.usb.map(|(vendor, product)| format!("{vendor:04x}:{product:04x}"));
        Port {
            path: port.path,
            description: port.description,
            usb,
            serial: port.serial,
            usable,
            missing,
            remedy,
        }
    });
    let usb = usb_devices().into_iter().filter_map(|device| {
        let id = format!("{:04x}:{:04x}", device.id.0, device.id.1);
        let (what, missing, remedy) = match known(device.id)? {
            Known::Instrument(model, None) => (
                model.to_owned(),
                Some("a driver of this program".to_owned()),
                Some("use the maker's software, or another instrument".to_owned()),
            ),
            Known::Instrument(model, Some(driver)) => {
                let named = match &device.serial {
                    Some(serial) => format!("serial={serial}"),
                    None => format!("port={}", device.port),
                };
                let what = format!("{model}, open = \"{driver}:usb:{named}\"");
                match device.access.clone() {
                    UsbAccess::Usable => (what, None, None),
                    UsbAccess::Denied { advice } => (
                        what,
                        Some("permission: this account may not use it".to_owned()),
                        Some(advice),
                    ),
                    UsbAccess::InUse(users) => {
                        let advice = "close that program, then start again".to_owned();
                        (
                            what,
                            Some(format!("it is in use: {} has it open", users.join(", "))),
                            Some(advice),
                        )
                    }
                }
            }
            Known::SerialAdapter { .. } if device.has_driver => return None,
            Known::SerialAdapter { chip, module } => {
                let what = format!("{chip} serial adapter");
                (
                    what,
                    Some("its kernel driver: no port".to_owned()),
                    Some(format!("sudo modprobe {module}")),
                )
            }
        };
        let what = if device.name.is_empty() {
            what
        } else {
            format!("{what} ({})", device.name)
        };
        Some(Usb {
            id,
            what,
            serial: device.serial,
            missing,
            remedy,
        })
    });
    Ok(Devices {
        drivers: drivers.collect(),
        ports: ports.collect(),
        usb: usb.collect(),
    })
}

enum Known {
    /// Its model, and the driver that opens it where there is one.
    Instrument(&'static str, Option<&'static str>),
    SerialAdapter {
        chip: &'static str,
        module: &'static str,
    },
}

/// Instruments that no driver speaks to yet.
const WITHOUT_DRIVER: &[UsbModel] = &[UsbModel {
    id: (0x2457, 0x1022),
    model: "Ocean Optics USB4000 or Flame-T",
}];

/// What a USB id stands for, where it is of interest.
fn known(id: (u16, u16)) -> Option<Known> {
    for driver in catalogue::drivers() {
        if let Some(found) = driver.usb.iter().find(|usb| usb.id == id) {
            return Some(Known::Instrument(found.model, Some(driver.name)));
        }
    }
    if let Some(found) = WITHOUT_DRIVER.iter().find(|usb| usb.id == id) {
        return Some(Known::Instrument(found.model, None));
    }
    Some(match id {
        (0x0403, _) => Known::SerialAdapter {
            chip: "FTDI",
            module: "ftdi_sio",
        },
        (0x10C4, 0xEA60 | 0xEA70 | 0xEA71) => Known::SerialAdapter {
            chip: "CP210x",
            module: "cp210x",
        },
        (0x067B, _) => Known::SerialAdapter {
            chip: "Prolific",
            module: "pl2303",
        },
        (0x1A86, 0x7523 | 0x5523) => Known::SerialAdapter {
            chip: "CH340",
            module: "ch341",
        },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_drivers_whatever_the_computer_has() {
        let found = devices().unwrap();
        assert!(found.drivers.len() == catalogue::drivers().count() && found.drivers.len() > 2);
        for (facts, driver) in found.drivers.iter().zip(catalogue::drivers()) {
            assert_eq!((facts.name, facts.kinds.len()), (driver.name, facts.examples.len()));
            assert!(facts.kinds.len() >= driver.examples.len());
        }
        assert!(known((0x2457, 0x4000)).is_some(), "a model that a driver names");
        for port in &found.ports {
            assert_eq!(port.usable, port.missing.is_none(), "{port:?}");
        }
    }

    #[test]
    fn the_package_gives_access_to_every_instrument_on_usb() {
        let rules = include_str!("../../../../packaging/70-isolux.rules");
        for (vendor, product) in catalogue::drivers().flat_map(|driver| driver.usb).map(|usb| usb.id) {
            let rule = format!("ATTR{{idVendor}}==\"{vendor:04x}\", ATTR{{idProduct}}==\"{product:04x}\"");
            assert!(rules.contains(&rule), "{rule}");
        }
    }
}
