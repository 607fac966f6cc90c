//! The spectrometers as USB devices.
//!
//! Ids and endpoints are those of the instruments (python-seabreeze, `devices.py`); packet sizes follow from their
//! speed. Release numbers and words are made up: no driver may depend on them.

use isolux_darkroom::Instrument;
use isolux_usbip::{Bench, Model, Packing, Speed, Twin};
use tokio::task::JoinSet;

use crate::outlet::Outlet;
use crate::{Serving, VirtualRoom};

/// Room for the longest answer.
const PIPE: usize = 1 << 16;

/// The instrument of `room` as a USB device; none where what plays it has no USB connector.
pub fn device(room: &VirtualRoom, instrument: Instrument) -> Option<Twin> {
    let seed = room.with_world(|world, _| world.room().document().seed % 100_000);
    let maker = "Ocean Optics".to_owned();
    let model = match room.twin(instrument)?.driver {
        // Commands on 0x01, short answers on 0x81, spectra on 0x82; 0x86 is there and silent at this speed.
        "ocean-ooi" => Model {
            id: (0x2457, 0x101E),
            release: 0x0002,
            strings: [maker, "USB2000+".to_owned(), format!("USB2+V{seed:05}")],
            speed: Speed::High,
            endpoints: vec![0x01, 0x81, 0x82, 0x86],
            packing: Packing::Transfers,
        },
        // Its second pair of endpoints is there and silent.
        "ocean-obp" => Model {
            id: (0x2457, 0x4000),
            release: 0x0001,
            strings: [maker, "STS".to_owned(), format!("S{seed:05}")],
            speed: Speed::Full,
            endpoints: vec![0x01, 0x81, 0x02, 0x82],
            packing: Packing::Bytes,
        },
        _ => return None,
    };
    Some(twin(room, model, instrument))
}

/// Offers the instrument over USB/IP on the loopback address, port 0 for a free one; the address that it has once a
/// kernel has attached it as device `1-1`, the port, and what serves it. None where it has no USB connector.
///
/// # Errors
/// The system refuses the port.
pub async fn offer(
    room: &VirtualRoom,
    instrument: Instrument,
    port: u16,
) -> std::io::Result<Option<(Outlet, u16, Serving)>> {
    let (Some(twin), Some(device)) = (room.twin(instrument), device(room, instrument)) else {
        return Ok(None);
    };
    let address = format!("usb:serial={}", device.model().strings[2]);
    let bench = Bench::bind(port, vec![device]).await?;
    let port = bench.address()?.port();
    let mut tasks = JoinSet::new();
    tasks.spawn(bench.serve());
    let outlet = Outlet {
        instrument,
        driver: twin.driver,
        address,
    };
    Ok(Some((outlet, port, Serving::of(tasks))))
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
