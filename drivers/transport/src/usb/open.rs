//! Finding the device that an address means, and claiming its interface.

use std::time::{Duration, Instant};

use rusb::{Device, Direction, Error, TransferType, UsbContext};

use super::address::{UsbAddress, UsbId};
use super::link::{Endpoint, Interface, UsbLink};
use super::profile::UsbProfile;
use crate::users::users_of;
use crate::{Link, LinkError};

/// How long this program's own former link to a device may take to let go of it.
const LET_GO: Duration = Duration::from_secs(1);

/// How long a string descriptor may take.
const STRING: Duration = Duration::from_millis(500);

/// A device that fits an address.
struct Candidate {
    device: Device<rusb::Context>,
    id: UsbId,
    place: String,
    /// Its serial number; an error where it may not be asked.
    serial: Result<Option<String>, Error>,
}

/// The one device that an address means, not opened yet.
pub struct FoundUsb {
    address: UsbAddress,
    profile: UsbProfile,
    chosen: Candidate,
}

/// Finds the device that `address` means among those of `profile`. Blocks while devices are asked for their serial
/// number.
///
/// # Errors
/// [`LinkError`]: USB cannot be used, no such device, more than one.
pub fn find_usb(address: &UsbAddress, profile: &UsbProfile) -> Result<FoundUsb, LinkError> {
    Ok(FoundUsb {
        address: address.clone(),
        profile: *profile,
        chosen: choose(address, profile)?,
    })
}

impl FoundUsb {
    /// Where it is plugged in, as an address: one, whatever the address said that it was found by.
    pub fn place(&self) -> String {
        format!("usb:port={}", self.chosen.place)
    }

    /// Opens it. Blocks while a driver of the kernel is detached.
    ///
    /// # Errors
    /// [`LinkError`]: no permission (with the udev rule that gives it), in use (by whom), not the endpoints that the driver
    /// expects.
    pub fn open(self) -> Result<Box<dyn Link>, LinkError> {
        let Self {
            address,
            profile,
            chosen,
        } = &self;
        let failed = |reason: String, advice: Option<String>| LinkError {
            address: address.to_string(),
            reason,
            advice,
        };
        let refused = |error: Error| refused(address, chosen, error);
        let handle = chosen.device.open().map_err(refused)?;
        // Only what is not configured is configured: doing it again resets data toggles under a device that keeps its
        // own.
        if chosen.device.active_config_descriptor().is_err() {
            handle.set_active_configuration(1).map_err(refused)?;
        }
        // Where the system has no drivers to detach this says so, and there is nothing to detach.
        let _ = handle.set_auto_detach_kernel_driver(true);
        let (number, command, answers) = endpoints(chosen, profile).map_err(|reason| {
            let advice = "check that the driver is the right one for this instrument";
            failed(reason, Some(advice.to_owned()))
        })?;
        claim(&handle, number).map_err(refused)?;
        let link = UsbLink::new(Interface { handle, number }, command, &answers, profile.framing)
            .map_err(|error| failed(error.to_string(), None))?;
        Ok(Box::new(link))
    }
}

fn choose(address: &UsbAddress, profile: &UsbProfile) -> Result<Candidate, LinkError> {
    let failed = |reason: String, advice: &str| LinkError {
        address: address.to_string(),
        reason,
        advice: Some(advice.to_owned()),
    };
    if let Some(id) = address.id
        && !profile.ids.contains(&id)
    {
        let reason = format!(
            "{} is no id of this driver's instruments ({})",
            text(id),
            texts(profile.ids)
        );
        return Err(failed(
            reason,
            "leave the id out, or choose the driver of that instrument",
        ));
    }
    let mut found = candidates(address, profile.ids).map_err(|error| {
        failed(
            format!("USB cannot be used on this computer: {error}"),
            "check that its kernel has USB, and that this program may see /dev/bus/usb (in a container it may not)",
        )
    })?;
    if found.len() > 1 {
        let all: Vec<String> = found.iter().map(named).collect();
        let reason = format!("{} devices fit: {}", found.len(), all.join("; "));
        return Err(failed(reason, "say which, with serial=… or port=…"));
    }
    found.pop().ok_or_else(|| {
        let wanted = match address.id {
            Some(id) => text(id),
            None => texts(profile.ids),
        };
        failed(
            format!("no such USB device ({wanted}) is plugged in"),
            "check the cable; `isolux devices` lists what is there",
        )
    })
}

/// The devices that fit. One whose serial number is not known fits every serial number: the driver asks it later.
fn candidates(address: &UsbAddress, ids: &[UsbId]) -> Result<Vec<Candidate>, Error> {
    let context = rusb::Context::new()?;
    let mut found = Vec::new();
    for device in context.devices()?.iter() {
        let Ok(descriptor) = device.device_descriptor() else {
            continue;
        };
        let id = (descriptor.vendor_id(), descriptor.product_id());
        let place = place(&device);
        let fits = match address.id {
            Some(wanted) => id == wanted,
            None => ids.contains(&id),
        };
        if !fits || address.port.as_ref().is_some_and(|port| *port != place) {
            continue;
        }
        let serial = serial(&device, &descriptor);
        if let (Some(wanted), Ok(Some(serial))) = (&address.serial, &serial)
            && wanted != serial
        {
            continue;
        }
        found.push(Candidate {
            device,
            id,
            place,
            serial,
        });
    }
    // Where one says that it is the wanted one, those that say nothing are not meant.
    if address.serial.is_some() && found.iter().any(|one| matches!(one.serial, Ok(Some(_)))) {
        found.retain(|one| matches!(one.serial, Ok(Some(_))));
    }
    Ok(found)
}

fn serial(device: &Device<rusb::Context>, descriptor: &rusb::DeviceDescriptor) -> Result<Option<String>, Error> {
    if descriptor.serial_number_string_index().is_none() {
        return Ok(None);
    }
    let handle = device.open()?;
    let Some(&language) = handle.read_languages(STRING)?.first() else {
        return Ok(None);
    };
    let text = handle.read_serial_number_string(language, descriptor, STRING)?;
    Ok(Some(text.trim_matches(['\0', ' ']).to_owned()).filter(|text| !text.is_empty()))
}

/// Bus and ports, as Linux names them: `1-2.4`.
pub(super) fn place(device: &Device<rusb::Context>) -> String {
    let ports = device.port_numbers().unwrap_or_default();
    let ports: Vec<String> = ports.iter().map(u8::to_string).collect();
    if ports.is_empty() {
        // A system that knows no ports: the number that it gave the device.
        return format!("{}-#{}", device.bus_number(), device.address());
    }
    format!("{}-{}", device.bus_number(), ports.join("."))
}

fn endpoints(chosen: &Candidate, profile: &UsbProfile) -> Result<(u8, Endpoint, Vec<Endpoint>), String> {
    let configuration = chosen.device.active_config_descriptor();
    let configuration = configuration.map_err(|error| format!("the device has no configuration: {error}"))?;
    for interface in configuration.interfaces() {
        let Some(setting) = interface.descriptors().find(|setting| setting.setting_number() == 0) else {
            continue;
        };
        let endpoint = |address: u8, direction: Direction| {
            setting
                .endpoint_descriptors()
                .find(|one| one.address() == address && one.direction() == direction)
                .filter(|one| one.transfer_type() == TransferType::Bulk)
                .map(|one| Endpoint {
                    address,
                    packet: usize::from(one.max_packet_size() & 0x7FF),
                })
                .filter(|one| one.packet > 0)
        };
        let answers: Vec<Endpoint> = profile
            .answers
            .iter()
            .filter_map(|address| endpoint(*address, Direction::In))
            .collect();
        if let Some(command) = endpoint(profile.command, Direction::Out)
            && answers.len() == profile.answers.len()
        {
            return Ok((interface.number(), command, answers));
        }
    }
    let wanted: Vec<String> = std::iter::once(&profile.command)
        .chain(profile.answers)
        .map(|address| format!("0x{address:02x}"))
        .collect();
    Err(format!(
        "{} has not the bulk endpoints {}",
        named(chosen),
        wanted.join(", ")
    ))
}

/// Claims the interface; waits a little for a link of this program that was just dropped.
fn claim(handle: &rusb::DeviceHandle<rusb::Context>, number: u8) -> Result<(), Error> {
    let until = Instant::now() + LET_GO;
    loop {
        match handle.claim_interface(number) {
            Err(Error::Busy) if Instant::now() < until => std::thread::sleep(Duration::from_millis(20)),
            result => return result,
        }
    }
}

fn refused(address: &UsbAddress, chosen: &Candidate, error: Error) -> LinkError {
    let Candidate { device, id, .. } = chosen;
    let node = format!("/dev/bus/usb/{:03}/{:03}", device.bus_number(), device.address());
    let name = named(chosen);
    let (reason, advice) = match error {
        Error::Access if cfg!(target_os = "linux") => (
            format!("{name}: this account may not use it ({node})"),
            Some(udev_rule(*id)),
        ),
        Error::Access => (
            format!("{name}: another program or driver has it"),
            Some("close that program, then start again".to_owned()),
        ),
        Error::Busy => {
            let us = format!("(pid {})", std::process::id());
            let users: Vec<String> = users_of(&node)
                .into_iter()
                .filter(|user| !user.ends_with(&us))
                .collect();
            let who = match &users[..] {
                [] => "another program".to_owned(),
                some => some.join(", "),
            };
            (
                format!("{name} is in use: {who} has it"),
                Some("close that program, then start again".to_owned()),
            )
        }
        Error::NoDevice => (
            format!("{name} was unplugged"),
            Some("check the cable, then start again".to_owned()),
        ),
        Error::NotSupported | Error::NotFound if cfg!(windows) => (
            format!("{name} has no driver that lets programs use it"),
            Some(WINUSB.to_owned()),
        ),
        other => (format!("{name}: {other}"), None),
    };
    LinkError {
        address: address.to_string(),
        reason,
        advice,
    }
}

/// What lets programs use a device on Windows.
pub(super) const WINUSB: &str = "give it the driver WinUSB, for example with Zadig";

/// What gives the users at this computer access to a device.
pub(crate) fn udev_rule((vendor, product): UsbId) -> String {
    format!(
        "as root: echo 'SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"{vendor:04x}\", ATTR{{idProduct}}==\"{product:04x}\", \
         MODE=\"0660\", GROUP=\"plugdev\", TAG+=\"uaccess\"' > /etc/udev/rules.d/70-isolux-{vendor:04x}-{product:04x}.rules \
         && udevadm control --reload; then unplug the device and plug it in again"
    )
}

fn named(candidate: &Candidate) -> String {
    let serial = match &candidate.serial {
        Ok(Some(serial)) => format!(", serial {serial}"),
        Ok(None) => ", no serial number".to_owned(),
        Err(_) => ", serial number not readable".to_owned(),
    };
    format!("{} at port {}{serial}", text(candidate.id), candidate.place)
}

fn text((vendor, product): UsbId) -> String {
    format!("{vendor:04x}:{product:04x}")
}

fn texts(ids: &[UsbId]) -> String {
    ids.iter().map(|id| text(*id)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UsbFraming;

    const PROFILE: UsbProfile = UsbProfile {
        ids: &[(0x2457, 0x101E)],
        command: 0x01,
        answers: &[0x81, 0x82],
        framing: UsbFraming::Transfers,
    };

    #[test]
    fn a_computer_without_the_device_says_so() {
        // With USB or without: one message, no panic.
        let nowhere = UsbAddress {
            serial: Some("no such serial".to_owned()),
            ..UsbAddress::default()
        };
        let error = find_usb(&nowhere, &PROFILE).err().unwrap();
        assert!(error.reason.contains("USB") && error.advice.is_some(), "{error}");
        let other = UsbAddress {
            id: Some((0x1234, 0x5678)),
            ..UsbAddress::default()
        };
        let error = find_usb(&other, &PROFILE).err().unwrap();
        assert!(
            error.reason.contains("1234:5678") && error.reason.contains("2457:101e"),
            "{error}"
        );
    }

    #[test]
    fn the_rule_names_the_device() {
        let rule = udev_rule((0x2457, 0x101E));
        assert!(
            rule.contains("ATTR{idVendor}==\"2457\", ATTR{idProduct}==\"101e\""),
            "{rule}"
        );
    }
}
