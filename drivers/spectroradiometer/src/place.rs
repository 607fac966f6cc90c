//! Where an instrument without options of its own stands.

use isolux_device::{OpenError, Target};
use isolux_transport::{LineSettings, Place, UsbAddress};

/// One instrument a link, by USB or on a serial line of these settings.
pub(crate) fn usb_place(target: &Target, line: LineSettings) -> Result<Place, OpenError> {
    target.only(&[])?;
    UsbAddress::parse(target.link()).map_err(|error| target.wrong(error.reason))?;
    Ok(Place {
        channel: String::new(),
        line,
    })
}
