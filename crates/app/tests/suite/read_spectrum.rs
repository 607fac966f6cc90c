//! `read --spectrum` over real links: two instruments, one with dark pixels and one that needs the shutter, see one
//! light.

use camino::Utf8PathBuf;
use isolux_app::FailureKind;
use isolux_app::manual::spectrum::{self, Reading};
use isolux_darkroom::{Darkroom, Room};
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::station::{calibration, station};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Switches, VirtualRoom};

/// Reads a lit room whose spectroradiometer answers `driver`; the reading, the light at its entrance in lx, and whether
/// the shutter is open afterwards.
fn read(driver: &str, edit: fn(String) -> String) -> (Result<Reading, isolux_app::Failure>, f64, bool) {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("station.toml")).unwrap();
    let (written, ready) = std::sync::mpsc::channel();
    let (done, finished) = tokio::sync::oneshot::channel::<()>();
    let (driver, file) = (driver.to_owned(), path.clone());
    let serving = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .unwrap();
        runtime.block_on(async {
            let mut choice = Choice::default();
            choice.choose(Instrument::Spectroradiometer, &driver).unwrap();
            let document = Darkroom::default();
            let room = VirtualRoom::open_with(document.clone(), &choice);
            let illuminated = Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            };
            room.with_world(|world, now_s| world.set_switches(illuminated, now_s));
            let instruments: Vec<_> = room.instruments().collect();
            let (outlets, _serving) = offer(&room, &instruments, Offer::Tcp { port: 0 }).await.unwrap();
            std::fs::write(&file, edit(station(&document, &outlets))).unwrap();
            if let Some(text) = calibration(&Room::new(document), &outlets) {
                std::fs::write(file.with_file_name("spectroradiometer.csv"), text).unwrap();
            }
            written.send(()).unwrap();
            finished.await.unwrap();
            let lux = room.with_world(|world, now_s| world.spectroradiometer_lx(now_s - 0.2, now_s));
            (lux, room.with_world(|world, _| world.switches().shutter_open))
        })
    });
    ready.recv().unwrap();
    let reading = spectrum::read(&path, None, &isolux_app::front_end::progress::Silent);
    done.send(()).unwrap();
    let (lux, open) = serving.join().unwrap();
    (reading, lux, open)
}

#[test]
fn dark_pixels_and_the_shutter_give_the_same_spectrum() {
    let (by_pixels, lux, _) = read("ocean-ooi", |text| text);
    let by_pixels = by_pixels.unwrap();
    let (by_shutter, _, open) = read("ocean-obp", |text| text);
    let by_shutter = by_shutter.unwrap();
    assert_eq!(
        (by_pixels.dark, by_shutter.dark, open),
        ("dark_pixels", "shutter", true)
    );
    for reading in [&by_pixels, &by_shutter] {
        // Bandpass, stray light and noise of the room's spectrometer are in it.
        assert!(
            (reading.illuminance_lx / lux - 1.0).abs() < 0.02,
            "{} lx, {lux} lx",
            reading.illuminance_lx
        );
        assert!((0.4..0.95).contains(&reading.peak_of_saturation) && reading.saturated_pixels == 0);
        assert_eq!(reading.wavelength_nm.len(), reading.irradiance_w_m2_nm.len());
    }
    let cct = |reading: &Reading| reading.quantities.cct_k.unwrap();
    assert!(
        (cct(&by_pixels) / cct(&by_shutter) - 1.0).abs() < 0.01,
        "{} {}",
        cct(&by_pixels),
        cct(&by_shutter)
    );
}

#[test]
fn without_a_shutter_there_is_no_dark_and_no_reading() {
    let without = |text: String| {
        let from = text.find("[shutter]").unwrap();
        let to = from + text[from..].find("\n\n").unwrap();
        text[..from].to_owned() + &text[to..]
    };
    let (refused, ..) = read("ocean-obp", without);
    let failure = refused.unwrap_err();
    assert_eq!(failure.kind, FailureKind::BadInput);
    assert!(failure.message.contains("shutter"), "{}", failure.message);
}
