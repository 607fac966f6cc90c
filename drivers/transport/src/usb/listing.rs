//! USB devices that this computer sees. Nothing is sent to any of them.

use std::path::Path;

use rusb::UsbContext as _;

use super::address::UsbId;
use super::open::{WINUSB, place, udev_rule};
use crate::users::users_of;

/// A USB device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsbDevice {
    /// Vendor and product id.
    pub id: (u16, u16),
    /// Manufacturer and product as the device says them.
    pub name: String,
    /// Serial number.
    pub serial: Option<String>,
    /// The socket that it is plugged into, as Linux names it: bus, then the ports of the hubs on the way (`1-2.4`).
    pub port: String,
    /// Whether programs of this user can use it.
    pub access: UsbAccess,
    /// A kernel driver is bound to one of its interfaces (a serial adapter has its port then).
    pub has_driver: bool,
}

/// Whether a USB device can be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UsbAccess {
    /// It can.
    Usable,
    /// This account may not, and what gives it permission.
    Denied {
        /// A udev rule and how to put it in place.
        advice: String,
    },
    /// These programs have it open, as far as the system says.
    InUse(Vec<String>),
}

/// The USB devices of this computer, sorted by id: on Linux by its kernel (`/sys/bus/usb/devices`), elsewhere by
/// libusb, which knows neither names nor serial numbers of devices that are not asked. Empty where the system has no
/// USB.
pub fn usb_devices() -> Vec<UsbDevice> {
    if cfg!(target_os = "linux") {
        devices_below(Path::new("/sys/bus/usb/devices"), Path::new("/dev/bus/usb"))
    } else {
        by_libusb().unwrap_or_default()
    }
}

/// Opens each device and closes it again; nothing is sent.
fn by_libusb() -> Result<Vec<UsbDevice>, rusb::Error> {
    let mut devices = Vec::new();
    for device in rusb::Context::new()?.devices()?.iter() {
        let Ok(descriptor) = device.device_descriptor() else {
            continue;
        };
        if descriptor.class_code() == rusb::constants::LIBUSB_CLASS_HUB {
            continue;
        }
        let id = (descriptor.vendor_id(), descriptor.product_id());
        let access = match device.open() {
            Err(rusb::Error::NotSupported | rusb::Error::NotFound) if cfg!(windows) => UsbAccess::Denied {
                advice: WINUSB.to_owned(),
            },
            Err(rusb::Error::Access) => UsbAccess::InUse(vec!["another program or driver".to_owned()]),
            _ => UsbAccess::Usable,
        };
        devices.push(UsbDevice {
            id,
            name: String::new(),
            serial: None,
            port: place(&device),
            access,
            // A serial adapter without a driver is not in the list of ports; libusb does not say more.
            has_driver: true,
        });
    }
    devices.sort_by(|a, b| (a.id, &a.port).cmp(&(b.id, &b.port)));
    Ok(devices)
}

/// Opens the device's file and closes it again; nothing is sent.
fn access(node: &Path, id: UsbId) -> UsbAccess {
    match std::fs::OpenOptions::new().read(true).write(true).open(node) {
        Err(error) if error.kind() == std::io::ErrorKind::PermissionDenied => {
            UsbAccess::Denied { advice: udev_rule(id) }
        }
        // A file that is not there: a device that was just unplugged, or a container without it. Opening it says so.
        _ => match users_of(&node.display().to_string()) {
            users if users.is_empty() => UsbAccess::Usable,
            users => UsbAccess::InUse(users),
        },
    }
}

fn devices_below(folder: &Path, nodes: &Path) -> Vec<UsbDevice> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let names: Vec<String> = entries
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    let text = |name: &str, file: &str| {
        let text = std::fs::read_to_string(folder.join(name).join(file)).ok()?;
        Some(text.trim().to_owned()).filter(|text| !text.is_empty())
    };
    let mut devices: Vec<UsbDevice> = names
        .iter()
        // "1-2" is a device, "1-2:1.0" one of its interfaces, "usb1" a hub of the computer itself.
        .filter(|name| !name.contains(':') && !name.starts_with("usb"))
        .filter_map(|name| {
            let id = |file| u16::from_str_radix(&text(name, file)?, 16).ok();
            let interface = format!("{name}:");
            let number = |file: &str| text(name, file)?.parse::<u32>().ok();
            let node = format!(
                "{:03}/{:03}",
                number("busnum").unwrap_or(0),
                number("devnum").unwrap_or(0)
            );
            let ids = (id("idVendor")?, id("idProduct")?);
            let words = [text(name, "manufacturer"), text(name, "product")];
            Some(UsbDevice {
                id: ids,
                port: (*name).clone(),
                access: access(&nodes.join(node), ids),
                name: words.into_iter().flatten().collect::<Vec<_>>().join(" "),
                serial: text(name, "serial"),
                has_driver: names
                    .iter()
                    .any(|other| other.starts_with(&interface) && folder.join(other).join("driver").exists()),
            })
        })
        .collect();
    devices.sort_by(|a, b| (a.id, &a.serial).cmp(&(b.id, &b.serial)));
    devices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libusb_knows_the_same_devices_as_the_kernel() {
        let ids = |devices: Vec<UsbDevice>| devices.into_iter().map(|device| device.id).collect::<Vec<_>>();
        // A computer without USB has none; one where libusb is refused says nothing against the kernel.
        if let Ok(found) = by_libusb() {
            assert_eq!(ids(found), ids(usb_devices()));
        }
    }

    #[test]
    fn tells_devices_from_interfaces_and_hubs() {
        let folder = std::env::temp_dir().join(format!("isolux-usb-{}", std::process::id()));
        let write = |path: &str, text: &str| {
            let path = folder.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        for (name, vendor, product) in [
            ("usb1", "1d6b", "0002"),
            ("1-2", "2457", "101e"),
            ("1-3", "0403", "6001"),
        ] {
            write(&format!("{name}/idVendor"), &format!("{vendor}\n"));
            write(&format!("{name}/idProduct"), &format!("{product}\n"));
        }
        write("1-2/manufacturer", "Ocean Optics Inc.\n");
        write("1-2/serial", "USB2+H16355\n");
        write("1-3:1.0/driver/x", "");
        write("1-2:1.0/bInterfaceNumber", "00\n");
        let found = devices_below(&folder, Path::new("/no/such/folder"));
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].id, found[0].has_driver), ((0x0403, 0x6001), true));
        assert_eq!((found[1].id, found[1].has_driver), ((0x2457, 0x101e), false));
        assert_eq!((found[1].port.as_str(), &found[1].access), ("1-2", &UsbAccess::Usable));
        assert_eq!(
            (found[1].name.as_str(), found[1].serial.as_deref()),
            ("Ocean Optics Inc.", Some("USB2+H16355"))
        );
        assert_eq!(
            devices_below(Path::new("/no/such/folder"), Path::new("/no/such/folder")),
            []
        );
    }
}
