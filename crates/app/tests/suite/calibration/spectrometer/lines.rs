//! Wavelength scale and bandpass, from a line lamp.

use isolux_app::calibration::spectrometer::{Done, Found, Procedure};
use isolux_app::instruments::bench::StationFiles;
use isolux_record::Run;
use isolux_record::lines::{Line, LineList};
use isolux_record::spectra::WavelengthScale;
use isolux_reduce::{Correction, spectrometer as found_of};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::{outside, reduced, truth};
use crate::calibration::campaign::normal;
use crate::calibration::lab::Lab;

fn mercury() -> Procedure {
    Procedure::lines("mercury_argon").unwrap()
}

fn scale(done: &Done) -> &WavelengthScale {
    match &done.found {
        Found::Wavelengths(scale) => scale,
        _ => panic!("{done:?}"),
    }
}

/// A bench whose instrument has a wavelength error and a bandpass of its own, before a mercury lamp.
fn before_mercury(seed: u64) -> Lab {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Lab::new(seed, |room| {
        room.spectroradiometer.line_lamp_lx = 100.0;
        room.spectroradiometer.wavelength_error_nm = [0.5, 0.3, 0.2].map(|size| size * normal(&mut random));
        room.injected_effects.spectro_bandpass.fwhm_nm = 2.0 + 0.3 * normal(&mut random).abs();
    })
}

#[test]
fn the_wavelength_scale_and_the_bandpass_of_seeded_rooms_are_found_within_u() {
    let (mut outside, mut all) = (Vec::new(), 0);
    for seed in 1..=6 {
        let lab = before_mercury(seed);
        let done = lab.find(&mercury(), "lines").unwrap();
        let scale = scale(&done);
        assert!(scale.line.len() >= 8 && scale.u_nm(550.0) < 0.05, "{scale:?}");
        for nm in [435.8335, 546.075, 763.5106, 912.2967] {
            assert!(
                scale.line.iter().any(|line| line.wavelength_nm == nm),
                "seed {seed}: {nm} nm"
            );
        }
        assert!(scale.u_fwhm_nm < 0.03 * scale.fwhm_nm, "{}", scale.u_fwhm_nm);
        let truth = &lab.room.document().spectroradiometer;
        for stated_nm in [420.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0] {
            let off = scale.true_nm(stated_nm) - truth.true_nm(stated_nm);
            all += 1;
            if off.abs() > 2.0 * scale.u_nm(stated_nm) {
                outside.push(format!(
                    "seed {seed} {stated_nm} nm: {off} nm, u {}",
                    scale.u_nm(stated_nm)
                ));
            }
            assert!(
                off.abs() < 0.05,
                "seed {seed}: {off} at {stated_nm} nm, it was {}",
                truth.true_nm(stated_nm)
            );
        }
        let fwhm_nm = lab.room.document().injected_effects.spectro_bandpass.fwhm_nm;
        let off = scale.fwhm_nm - fwhm_nm;
        assert!(
            off.abs() < 2.0 * scale.u_fwhm_nm + 0.03,
            "{} {fwhm_nm} {}",
            scale.fwhm_nm,
            scale.u_fwhm_nm
        );
        // The file is what was found, and the diary has it.
        let file = done.folder.join("wavelengths.toml");
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(&WavelengthScale::parse(&file, &text).unwrap(), scale);
        assert_eq!(isolux_app::history::read(&lab.station()).unwrap().len(), 4);
    }
    assert!(outside.len() * 8 < all, "{outside:#?}");
}

#[test]
fn a_spectrum_is_outside_of_u_without_the_scale_and_the_bandpass_and_inside_with_them() {
    let mut lab = Lab::new(4, |room| {
        room.spectroradiometer.line_lamp_lx = 100.0;
        room.spectroradiometer.wavelength_error_nm = [0.8, 0.2, -0.1];
        room.spectroradiometer.gain_error_rel = 0.0;
        room.injected_effects.spectro_bandpass.fwhm_nm = 5.0;
        room.lamp.temperature_k = 0.0;
    });
    let done = lab.find(&mercury(), "lines").unwrap();
    lab.in_room(|room| room.spectroradiometer.line_lamp_lx = 0.0);
    let nothing = lab.find(&mercury(), "nothing").unwrap_err();
    assert!(nothing.message.contains("no line of mercury_argon"), "{nothing}");
    let truth = truth(&lab);
    // A shape that is known as well as the room knows it.
    lab.edit("station.toml", "u_shape_rel = 0.004", "u_shape_rel = 0.0002");
    lab.edit("station.toml", "u_wavelength_nm = 0.1", "u_wavelength_nm = 0.05");
    let without = lab.spectrum("without");
    assert!(!outside(&reduced(&without, &[]), truth).is_empty());
    lab.name(&done);
    let run = lab.spectrum("with");
    let with = reduced(&run, &[]);
    assert_eq!(outside(&with, truth), Vec::<String>::new());
    assert!(with.colour.cct.as_ref().unwrap().parts["bandpass"] > 0.0);
    // Each of the two is a switch, and what is switched off is missing in the uncertainty.
    for off in [Correction::Wavelengths, Correction::Bandpass] {
        let less = reduced(&run, &[off]);
        assert!(!outside(&less, truth).is_empty(), "{off}");
        assert!(
            less.colour.cct.unwrap().missing[0].contains("not corrected for the"),
            "{off}"
        );
    }
    // The line of the station is the scale's own.
    let u_nm = run.header.station.spectroradiometer().unwrap().u_wavelength_nm.unwrap();
    assert!(u_nm < 0.05, "{u_nm}");
}

#[test]
fn a_file_of_another_instrument_is_refused_and_one_that_is_not_there_named() {
    let lab = before_mercury(3);
    let done = lab.find(&mercury(), "lines").unwrap();
    lab.name(&done);
    let own = scale(&done).made.instrument.clone();
    lab.edit("wavelengths.toml", &own, "USB2000+ of a neighbour");
    let refused = lab.find(&mercury(), "again").unwrap_err();
    assert!(
        refused
            .message
            .contains("spectroradiometer.wavelengths: the file is of USB2000+ of a neighbour"),
        "{refused}"
    );
    std::fs::remove_file(lab.folder().join("wavelengths.toml")).unwrap();
    let refused = StationFiles::load(&lab.station()).unwrap_err();
    assert!(
        refused.message.contains("station.toml:") && refused.message.contains("wavelengths"),
        "{refused}"
    );
}

#[test]
fn no_scale_from_a_record_that_does_not_show_it() {
    let lab = before_mercury(5);
    lab.find(&mercury(), "lines").unwrap();
    let run = Run::read(&lab.folder().join("lines")).unwrap();
    let list = LineList::mercury_argon();
    let refused = |edit: &dyn Fn(&mut Run), list: &LineList, expected: &str| {
        let mut run = run.clone();
        edit(&mut run);
        let error = found_of::wavelengths(&run, list).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    };
    let line = |wavelength_nm, strength_rel| Line {
        wavelength_nm,
        strength_rel,
    };
    let of = |lamp: &str, line: Vec<Line>| LineList {
        lamp: lamp.to_owned(),
        line,
        ..list.clone()
    };
    let same = |_: &mut Run| {};
    refused(&|run| run.header.stopped = None, &list, "not finished");
    refused(&|run| run.spectra.truncate(1), &list, "fewer than two spectra");
    refused(
        &|run| run.spectra[1].pixels[600].saturated = true,
        &list,
        "spectra/001.csv: saturated at",
    );
    let darker = |run: &mut Run, share: f64, number: usize| {
        for pixel in &mut run.spectra[number].pixels {
            pixel.counts = pixel.dark_counts + share * (pixel.counts - pixel.dark_counts);
        }
    };
    refused(
        &|run| (0..2).for_each(|number| darker(run, 0.0, number)),
        &list,
        "no line of mercury_argon",
    );
    refused(&|run| darker(run, 0.7, 1), &list, "the light changed by -30.");
    // Neon has nothing where mercury shines.
    let neon = of(
        "neon",
        vec![line(585.2488, 0.5), line(640.2248, 1.0), line(703.2413, 0.8)],
    );
    refused(&same, &neon, "neon has");
    // A list without the strongest line of the lamp.
    let mut other = list.clone();
    other.line.retain(|line| (line.wavelength_nm - 546.075).abs() > 1.0);
    refused(&same, &other, "mercury_argon has no line there");
    // A wrong number in the list: its line is there, but the scale is not smooth.
    let mut wrong = list.clone();
    wrong
        .line
        .iter_mut()
        .filter(|line| line.wavelength_nm == 546.075)
        .for_each(|line| line.wavelength_nm = 546.575);
    refused(&same, &wrong, "off a smooth scale");
    // Mercury alone has three lines by themselves.
    refused(
        &line_lamp_of_mercury_alone,
        &list,
        "3 lines of mercury_argon stand alone",
    );
    let mut blended = list.clone();
    for line in list.line {
        blended.line.push(Line {
            wavelength_nm: line.wavelength_nm + 0.9,
            strength_rel: line.strength_rel,
        });
    }
    blended.line.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
    refused(&same, &blended, "are blended");
}

/// Takes the light above 560 nm away.
fn line_lamp_of_mercury_alone(run: &mut Run) {
    for pixel in run.spectra.iter_mut().flat_map(|spectrum| &mut spectrum.pixels) {
        if pixel.wavelength_nm > 560.0 {
            pixel.counts = pixel.dark_counts;
        }
    }
}
