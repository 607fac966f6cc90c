//! Whole scans whose spectroradiometer is on USB and whose other instruments are on TCP.

use std::path::Path;

use camino::Utf8Path;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::scan::{self, Place, ScanJob, Target};
use isolux_darkroom::{Darkroom, Instrument, Room};
use isolux_record::Run;
use isolux_record::spectra::DarkSubtraction;
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::twins::Choice;
use isolux_virtual::{VirtualRoom, station};

use super::bridge::{Below, bridge};

/// A room without injected effects whose axes and meter are quick.
const FAST: &str = "[bench]\ndistance_mm = 2000.0\n[injected_effects]\nonly = true\n[luxmeter]\nintegration_s = 0.02\n\
    [axis.c]\nspeed_deg_s = 45.0\naccel_deg_s2 = 400.0\n\
                    [axis.gamma]\nspeed_deg_s = 45.0\naccel_deg_s2 = 400.0\n";

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 0, 90]
gamma_range = [-15, 15, 30]
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
repeats = 2
c_deg = 0
gamma_deg = 0
"#;

/// Irradiance of the first spectrum of a run from 430 nm to 670 nm, pixel by pixel.
fn irradiance(run: &Run) -> Vec<(f64, f64)> {
    let calibration = run.header.spectral.as_ref().unwrap();
    let spectrum = run.spectra[0]
        .irradiance(calibration, DarkSubtraction::Spectrum)
        .unwrap();
    let pixels = run.spectra[0].pixels.iter().zip(spectrum.irradiance_w_m2_nm);
    pixels
        .filter(|(pixel, _)| (430.0..670.0).contains(&pixel.wavelength_nm))
        .map(|(pixel, value)| (pixel.wavelength_nm, value.expect("not saturated")))
        .collect()
}

/// The spectrum that `driver` reads in a scan: over USB in a socket below the bridge, or over TCP.
async fn scanned(driver: &str, usb: Option<(&Path, u8)>) -> Vec<(f64, f64)> {
    let (document, mut choice) = (Darkroom::parse(FAST).unwrap(), Choice::default());
    choice.choose(Instrument::Spectroradiometer, driver).unwrap();
    choice.choose(Instrument::Luxmeter, "gigahertz-p9710").unwrap();
    let room = VirtualRoom::open_with(document.clone(), &choice);
    let mut on_tcp: Vec<Instrument> = room.instruments().collect();
    let on_usb = isolux_virtual::usb::offer(&room, Instrument::Spectroradiometer, 0);
    let (outlet, port, _usb) = on_usb.await.unwrap().unwrap();
    if usb.is_some() {
        on_tcp.retain(|&instrument| instrument != Instrument::Spectroradiometer);
    }
    let (mut outlets, _tcp) = offer(&room, &on_tcp, Offer::Tcp { port: 0 }).await.unwrap();
    if usb.is_some() {
        outlets.push(outlet);
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(folder.path()).unwrap();
    // A meter that converts on request and soon: what is on USB is what counts.
    let text = station::station(&document, &outlets).replace("a_per_lx=3e-10", "a_per_lx=3e-10&integration_ms=100");
    let stable = "\n[lamp.stable]\nleast_s = 0.5\nwindow_s = 0.5\nspread_rel = 0.05\n\n[shutter]";
    std::fs::write(folder.join("station.toml"), text.replacen("\n[shutter]", stable, 1)).unwrap();
    if let Some(calibration) = station::calibration(&Room::new(document), &outlets) {
        std::fs::write(folder.join(station::CALIBRATION_FILE), calibration).unwrap();
    }
    std::fs::write(folder.join("plan.toml"), PLAN).unwrap();
    let [station, plan, run] = ["station.toml", "plan.toml", "run"].map(|name| folder.join(name));
    if let Some((bridge, socket)) = usb {
        let answer = Below::start_in_socket(bridge, port, socket)
            .ask(&format!("scan {station} {plan} {run}"))
            .await;
        assert_eq!(answer, "scanned", "{text}");
    } else {
        let run = run.clone();
        let scan = move || {
            let (source, plan, _) = scan::checked(&station, &plan, false)?;
            ScanJob {
                source: &source,
                plan: &plan,
                place: Place::take(Target::New(&run), false)?,
                force: None,
                operator: None,
                control: &Control::default(),
                progress: &Silent,
            }
            .execute()
        };
        tokio::task::spawn_blocking(scan).await.unwrap().unwrap();
    }
    irradiance(&Run::read(&run).unwrap())
}

async fn agree(driver: &str, socket: u8) {
    let Some(bridge) = bridge() else { return };
    let (usb, tcp) = tokio::join!(scanned(driver, Some((&bridge, socket))), scanned(driver, None));
    assert!(usb.len() > 200, "{} pixels", usb.len());
    let peak = tcp.iter().fold(0.0, |peak: f64, point| peak.max(point.1));
    for (usb, tcp) in usb.iter().zip(&tcp) {
        // The lamp's first minutes and the detector's noise.
        assert!(
            usb.0 == tcp.0 && (usb.1 - tcp.1).abs() < 0.03 * peak,
            "{driver}: {usb:?} {tcp:?}"
        );
    }
}

pub async fn a_scan_with_the_spectrometer_on_usb_reads_what_it_reads_over_tcp() {
    tokio::join!(agree("ocean-ooi", 1), agree("ocean-obp", 2));
}
