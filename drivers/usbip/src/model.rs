//! What a device says of itself: its descriptors (USB 2.0, 9.6).

/// Speed of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speed {
    /// 12 Mbit/s, bulk packets of 64 bytes.
    Full,
    /// 480 Mbit/s, bulk packets of 512 bytes.
    High,
}

impl Speed {
    /// Its number in USB/IP (`enum usb_device_speed` of the kernel).
    pub(crate) const fn number(self) -> u32 {
        match self {
            Self::Full => 2,
            Self::High => 3,
        }
    }

    /// Bytes of a bulk packet.
    pub const fn packet(self) -> usize {
        match self {
            Self::Full => 64,
            Self::High => 512,
        }
    }
}

/// How a twin's bytes become transfers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// One frame a transfer, both ways: endpoint, length (u16, low byte first), payload.
    Transfers,
    /// The bytes as they are, to and from the first endpoint of each direction; what the twin writes at once is one
    /// transfer, without an empty packet after full ones.
    Bytes,
}

/// A USB device with one interface of bulk endpoints.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Model {
    /// Vendor and product id.
    pub id: (u16, u16),
    /// Release of the device, binary-coded decimal.
    pub release: u16,
    /// Manufacturer, product and serial number.
    pub strings: [String; 3],
    /// Speed.
    pub speed: Speed,
    /// Addresses of its bulk endpoints; 0x80 and above send to the host.
    pub endpoints: Vec<u8>,
    /// How its bytes become transfers.
    pub packing: Packing,
}

const DEVICE: u8 = 1;
const CONFIGURATION: u8 = 2;
const STRING: u8 = 3;
const INTERFACE: u8 = 4;
const ENDPOINT: u8 = 5;
const QUALIFIER: u8 = 6;
/// English (United States), the one language that everybody asks for.
const LANGUAGE: u16 = 0x0409;

impl Model {
    /// The descriptor that GET_DESCRIPTOR asks for; `None` is refused with a stall.
    pub(crate) fn descriptor(&self, kind: u8, index: u8) -> Option<Vec<u8>> {
        match (kind, index) {
            (DEVICE, 0) => Some(self.device()),
            (CONFIGURATION, 0) => Some(self.configuration()),
            (STRING, index) => self.string(index),
            (QUALIFIER, 0) if self.speed == Speed::High => Some(vec![10, QUALIFIER, 0, 2, 0xFF, 0, 0, 64, 1, 0]),
            _ => None,
        }
    }

    fn device(&self) -> Vec<u8> {
        let (vendor, product) = self.id;
        // USB 2.0, class of the vendor, 64 bytes on endpoint 0.
        let mut bytes = vec![18, DEVICE, 0x00, 0x02, 0xFF, 0, 0, 64];
        for number in [vendor, product, self.release] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend((1..=3).map(|index| {
            if self.strings[index - 1].is_empty() {
                0
            } else {
                index as u8
            }
        }));
        bytes.push(1);
        bytes
    }

    fn configuration(&self) -> Vec<u8> {
        let count = self.endpoints.len();
        let total = (9 + 9 + 7 * count) as u16;
        let mut bytes = vec![9, CONFIGURATION];
        bytes.extend(total.to_le_bytes());
        // One interface, configuration 1, from the bus, 400 mA.
        bytes.extend([1, 1, 0, 0x80, 200]);
        bytes.extend([9, INTERFACE, 0, 0, count as u8, 0xFF, 0, 0, 0]);
        for &address in &self.endpoints {
            let [low, high] = (self.speed.packet() as u16).to_le_bytes();
            bytes.extend([7, ENDPOINT, address, 2, low, high, 0]);
        }
        bytes
    }

    fn string(&self, index: u8) -> Option<Vec<u8>> {
        let words: Vec<u16> = match index {
            0 => vec![LANGUAGE],
            1..=3 => {
                let text = &self.strings[usize::from(index) - 1];
                if text.is_empty() {
                    return None;
                }
                text.encode_utf16().take(126).collect()
            }
            _ => return None,
        };
        let mut bytes = vec![2 + 2 * words.len() as u8, STRING];
        bytes.extend(words.into_iter().flat_map(u16::to_le_bytes));
        Some(bytes)
    }

    /// The endpoint that takes the host's bytes under [`Packing::Bytes`], and the one that gives them.
    pub(crate) fn answers_on(&self) -> Option<u8> {
        self.endpoints.iter().copied().find(|address| address & 0x80 != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptors_have_the_lengths_that_they_say() {
        let model = Model {
            id: (0x2457, 0x101E),
            release: 0x0002,
            strings: ["Ocean Optics".into(), "USB2000+".into(), String::new()],
            speed: Speed::High,
            endpoints: vec![0x01, 0x81, 0x82],
            packing: Packing::Transfers,
        };
        let device = model.descriptor(DEVICE, 0).unwrap();
        assert_eq!((device.len(), usize::from(device[0])), (18, 18));
        assert_eq!(device[8..12], [0x57, 0x24, 0x1E, 0x10]);
        assert_eq!(device[14..17], [1, 2, 0], "no serial number, no string");
        let configuration = model.descriptor(CONFIGURATION, 0).unwrap();
        assert_eq!(usize::from(configuration[2]), configuration.len());
        assert_eq!(configuration[18..25], [7, 5, 0x01, 2, 0, 2, 0]);
        assert_eq!(model.descriptor(STRING, 2).unwrap()[..4], [18, 3, b'U', 0]);
        assert_eq!(model.descriptor(STRING, 3), None);
        assert_eq!(model.descriptor(9, 0), None);
    }
}
