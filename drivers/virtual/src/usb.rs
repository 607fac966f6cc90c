//! The spectrometers as USB devices.
//!
//! Ids and endpoints are those of the instruments (python-seabreeze, `devices.py`); packet sizes follow from their speed.
//! Release numbers and words are made up: no driver may depend on them.

use isolux_darkroom::document::Instrument;
use isolux_usbip::{Model, Packing, Speed, Twin};

use crate::VirtualRoom;

/// Room for the longest answer.
const PIPE: usize = 1 << 16;

/// An Ocean Optics USB2000+ in `room`: high speed, commands on 0x01, short answers on 0x81, spectra on 0x82.
pub fn usb2000_plus(room: &VirtualRoom) -> Twin {
    let serial = room.with_world(|world, _| format!("USB2+V{:05}", world.room().document().seed % 100_000));
    let model = Model {
        id: (0x2457, 0x101E),
        release: 0x0002,
        strings: ["Ocean Optics".to_owned(), "USB2000+".to_owned(), serial],
        speed: Speed::High,
        endpoints: vec![0x01, 0x81, 0x82, 0x86],
        packing: Packing::Transfers,
    };
    twin(room, model, Instrument::Spectroradiometer)
}

fn twin(room: &VirtualRoom, model: Model, instrument: Instrument) -> Twin {
    let room = room.clone();
    Twin::new(model, move || {
        let (host, stream) = tokio::io::duplex(PIPE);
        let room = room.clone();
        tokio::spawn(async move { room.serve(instrument, stream).await });
        host
    })
}
