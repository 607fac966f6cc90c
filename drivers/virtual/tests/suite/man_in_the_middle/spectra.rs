//! The attack on spectroradiometers.

use std::time::Duration;

use isolux_darkroom::Room;
use isolux_darkroom::spectrograph::{Exposure, PIXELS, linearity_coefficients};
use isolux_device::{Spectroradiometer, SpectroradiometerProperties};
use isolux_virtual::twins::{Choice, TwinKind};
use isolux_virtual::{AxisName, VirtualRoom};

use super::{Tally, address, bench_of, factories, illuminated, opened, put, soon, switch_to};

/// Takes spectra of the light of many angles, with several integration times, and opens the instrument again.
pub async fn attack(twin: &TwinKind, choice: &Choice, salt: u64) {
    let spectro_at = address(twin, "spectroradiometer");
    let mut bench = bench_of(illuminated(), choice, salt, 6000);
    let mut tally = Tally::new(spectro_at.to_string(), bench.seed);
    switch_to(&bench.room, true, false);
    // The same room with electronics that add nothing of their own.
    let mut quiet = illuminated();
    quiet.spectroradiometer.read_noise_counts = 0.0;
    quiet.spectroradiometer.electrons_per_count = 1e12;
    let quiet = Room::new(quiet);
    let middle = bench.middle.clone();
    let open = async || {
        let factory = factories(twin, &middle).spectroradiometer.unwrap();
        factory.open_spectroradiometer(&spectro_at).await
    };
    let mut spectro = opened(&mut tally, open).await;
    properties(&mut tally, &bench.room, spectro.as_ref());
    while bench.middle.exchanges() < bench.wanted {
        let dice = &mut bench.dice;
        if dice.chance(0.02) {
            drop(spectro);
            spectro = opened(&mut tally, open).await;
            properties(&mut tally, &bench.room, spectro.as_ref());
        }
        let time = Duration::from_millis([5, 20, 60, 150][dice.below(4)]);
        if spectro.set_integration_time(time).await.is_err() {
            tally.errors += 1;
            continue;
        }
        for _ in 0..4 {
            put(&bench.room, AxisName::Gamma, dice.between(0.0, 60.0).round());
            let capped = dice.chance(0.2);
            switch_to(&bench.room, !capped, false);
            for _ in 0..=dice.below(3) {
                match spectro.acquire(soon()).await {
                    Ok(raw) => {
                        let exposure = bench.room.with_world(|world, now_s| Exposure {
                            illuminance_lx: world.spectroradiometer_lx(now_s - 1e-3, now_s),
                            phosphor: 1.0,
                            lines_lx: 0.0,
                            integration_s: time.as_secs_f64(),
                            detector_c: world.temperature_c(now_s) + 4.0,
                            index: 0,
                        });
                        let truth = quiet.exposure_counts(&exposure);
                        let truth = Detector::of(spectro.properties()).counts(&truth);
                        let wrong = worst(&quiet, spectro.properties(), &raw.counts, &truth);
                        tally.value(wrong.is_none() && raw.integration_time == time, || {
                            let (pixel, sigmas) = wrong.unwrap_or_default();
                            let (found, truth) = (raw.counts[pixel], truth[pixel]);
                            format!("pixel {pixel}: {found} counts instead of {truth} ({sigmas:.1} σ) in {time:?}")
                        });
                    }
                    Err(_) => tally.errors += 1,
                }
            }
        }
    }
    tally.end(&bench.middle);
}

/// How the instrument sees what the room's spectrometer sees.
struct Detector {
    /// Pixels of the room's spectrometer in one of its own.
    fine: usize,
    /// Counts of the room's spectrometer in one of its own.
    scale: f64,
}

impl Detector {
    fn of(properties: &SpectroradiometerProperties) -> Self {
        Self {
            fine: PIXELS / properties.wavelength_nm.len(),
            scale: 65_536.0 / (f64::from(properties.full_scale_counts) + 1.0),
        }
    }

    /// The place of its pixel among the fine ones.
    fn place(&self, pixel: usize) -> f64 {
        (pixel * self.fine) as f64 + 0.5 * (self.fine as f64 - 1.0)
    }

    fn counts(&self, fine: &[u16]) -> Vec<f64> {
        let mean = |group: &[u16]| group.iter().copied().map(f64::from).sum::<f64>() / group.len() as f64;
        fine.chunks(self.fine).map(|group| mean(group) / self.scale).collect()
    }
}

/// The pixel furthest from the truth, if it is further than a pair of exposures lets pass: six standard deviations of
/// the difference (8.5 of one exposure), and five of the exposure that it was compared with.
fn worst(room: &Room, properties: &SpectroradiometerProperties, counts: &[u16], truth: &[f64]) -> Option<(usize, f64)> {
    let detector = Detector::of(properties);
    let offset = room.document().spectroradiometer.offset_counts;
    let sigmas = |pixel: usize| {
        let light = (truth[pixel] * detector.scale - offset).max(0.0);
        let sigma = 18.0_f64.hypot((light / 1.6).sqrt()) / (detector.fine as f64).sqrt();
        ((f64::from(counts[pixel]) - truth[pixel]).abs() * detector.scale - 3.0) / sigma
    };
    let worst = (0..truth.len()).max_by(|a, b| sigmas(*a).total_cmp(&sigmas(*b)))?;
    (sigmas(worst) > 13.5).then(|| (worst, sigmas(worst)))
}

/// What the instrument stores is what the driver found.
fn properties(tally: &mut Tally, room: &VirtualRoom, spectro: &dyn Spectroradiometer) {
    let found = spectro.properties();
    let detector = Detector::of(found);
    room.with_world(|world, _| {
        let (room, instrument) = (world.room(), &world.room().document().spectroradiometer);
        let wavelengths = found.wavelength_nm.iter().enumerate().all(|(pixel, nm)| {
            let truth = instrument.nm_at(detector.place(pixel));
            (nm - truth).abs() < 1e-3
        });
        let powers = std::iter::successors(Some(1.0), |power| Some(power * detector.scale));
        let linearity = found
            .nonlinearity
            .iter()
            .zip(linearity_coefficients(instrument).iter().zip(powers))
            .all(|(found, (truth, power))| (found - truth * power).abs() <= 1e-6 * (truth * power).abs());
        // The STS stores them by area and width of a pixel, which its coefficients give to 0.1 %.
        let factors = found.irradiance_factor.as_ref().is_some_and(|factors| {
            factors.iter().enumerate().all(|(pixel, factor)| {
                let fine = pixel * detector.fine..(pixel + 1) * detector.fine;
                let mean = fine.map(|fine| room.calibration(fine)).sum::<f64>() / detector.fine as f64;
                (factor - mean * detector.scale).abs() <= 1e-3 * mean * detector.scale
            })
        });
        let number = format!("{:05}", room.document().seed);
        let serial = spectro
            .identity()
            .serial
            .as_ref()
            .is_some_and(|serial| serial.ends_with(&number));
        let counts = f64::from(found.saturation_counts) + 1.0;
        let saturation = counts == (f64::from(instrument.saturation_counts) + 1.0) / detector.scale;
        let right = wavelengths && linearity && factors && serial && saturation;
        tally.value(right, || {
            format!(
                "{wavelengths} {linearity} {factors} {serial} {saturation}: {:?}",
                spectro.identity()
            )
        });
    });
}
