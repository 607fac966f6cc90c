//! Which USB device an address means: `usb:`, `usb:2457:101e`, `usb:serial=USB2+H16355`,
//! `usb:2457:101e?serial=…&port=1-2`.

use std::fmt;

use crate::LinkError;

/// Vendor and product id.
pub type UsbId = (u16, u16);

/// A USB device by what is known of it. Nothing given: the one that the driver's ids fit.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UsbAddress {
    /// Its ids.
    pub id: Option<UsbId>,
    /// Serial number in its descriptors.
    pub serial: Option<String>,
    /// The socket it is plugged into, as Linux names it: bus, then the ports of the hubs on the way (`1-2.4`).
    pub port: Option<String>,
}

impl UsbAddress {
    /// Reads an address; `None` where it does not begin with `usb:`.
    ///
    /// # Errors
    /// [`LinkError`] for an id that is not two hexadecimal numbers, an unknown key, an empty value, or a key given
    /// twice.
    pub fn parse(address: &str) -> Result<Option<Self>, LinkError> {
        let Some(rest) = address.strip_prefix("usb:") else {
            return Ok(None);
        };
        let wrong = |reason: String| LinkError {
            address: address.to_owned(),
            reason,
            advice: Some("write usb:, usb:serial=NUMBER, usb:2457:101e or usb:2457:101e?serial=NUMBER".to_owned()),
        };
        let (head, query) = rest.split_once('?').unwrap_or((rest, ""));
        let mut found = Self::default();
        let (id, pairs) = if head.contains('=') { ("", head) } else { (head, "") };
        if !id.is_empty() {
            let number = |text: &str| u16::from_str_radix(text, 16).ok().filter(|_| text.len() == 4);
            let both = id
                .split_once(':')
                .and_then(|(vendor, product)| Some((number(vendor)?, number(product)?)));
            found.id = Some(both.ok_or_else(|| wrong(format!("\"{id}\" is no vendor and product id, as 2457:101e")))?);
        }
        for pair in pairs.split('&').chain(query.split('&')).filter(|pair| !pair.is_empty()) {
            let place = match pair.split_once('=') {
                Some(("serial", value)) if !value.is_empty() => (&mut found.serial, value),
                Some(("port", value)) if !value.is_empty() => (&mut found.port, value),
                Some(("serial" | "port", _)) => return Err(wrong(format!("\"{pair}\" has no value"))),
                _ => return Err(wrong(format!("\"{pair}\" is neither serial=… nor port=…"))),
            };
            if place.0.replace(place.1.to_owned()).is_some() {
                return Err(wrong(format!("\"{pair}\": the key is given twice")));
            }
        }
        Ok(Some(found))
    }
}

impl fmt::Display for UsbAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("usb:")?;
        let mut before = "";
        if let Some((vendor, product)) = self.id {
            write!(f, "{vendor:04x}:{product:04x}")?;
            before = "?";
        }
        for (key, value) in [("serial", &self.serial), ("port", &self.port)] {
            if let Some(value) = value {
                write!(f, "{before}{key}={value}")?;
                before = "&";
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_say_as_much_as_is_known() {
        for (text, id, serial, port) in [
            ("usb:", None, None, None),
            ("usb:serial=USB2+H16355", None, Some("USB2+H16355"), None),
            ("usb:2457:101e", Some((0x2457, 0x101E)), None, None),
            (
                "usb:2457:101e?serial=S1&port=1-2.4",
                Some((0x2457, 0x101E)),
                Some("S1"),
                Some("1-2.4"),
            ),
            ("usb:port=3-1", None, None, Some("3-1")),
        ] {
            let found = UsbAddress::parse(text).unwrap().unwrap();
            let expected = UsbAddress {
                id,
                serial: serial.map(str::to_owned),
                port: port.map(str::to_owned),
            };
            assert_eq!(found, expected, "{text}");
            assert_eq!(found.to_string(), text);
        }
        assert_eq!(UsbAddress::parse("/dev/ttyUSB0"), Ok(None));
    }

    #[test]
    fn what_is_none_is_refused_with_its_words() {
        for (text, word) in [
            ("usb:2457", "2457"),
            ("usb:2457:10g1", "10g1"),
            ("usb:24571:01e", "no vendor"),
            ("usb:serial=", "no value"),
            ("usb:2457:101e?baud=9600", "baud"),
            ("usb:serial=a&serial=b", "twice"),
            ("usb:S1", "S1"),
        ] {
            let error = UsbAddress::parse(text).unwrap_err();
            assert!(error.reason.contains(word), "{text}: {error}");
        }
    }
}
