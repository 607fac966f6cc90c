//! Light scattered inside, from a long-pass filter.

use isolux_app::calibration::spectrometer::{Found, Procedure};
use isolux_record::Run;
use isolux_record::filter::CutOnFilter;
use isolux_reduce::{Correction, spectrometer as found_of};

use super::{outside, reduced, truth};
use crate::calibration::lab::Lab;

fn glass(lab: &Lab) -> CutOnFilter {
    let file = lab.folder().join("filter.toml");
    CutOnFilter::parse(&file, &std::fs::read_to_string(&file).unwrap()).unwrap()
}

/// A bench under a filament whose instrument scatters, behind a filter.
fn behind_a_filter(seed: u64, scatter_rel: f64) -> Lab {
    Lab::new(seed, |room| {
        room.spectroradiometer.scatter_rel = scatter_rel;
        room.spectroradiometer.filter_cut_on_nm = 515.0;
        room.spectroradiometer.gain_error_rel = 0.0;
        room.injected_effects.spectro_bandpass.fwhm_nm = 0.0;
    })
}

#[test]
fn light_that_is_scattered_inside_takes_a_spectrum_outside_of_u_and_the_filter_brings_it_back() {
    let mut lab = behind_a_filter(6, 0.01);
    let done = lab.find(&Procedure::CutOn(glass(&lab)), "scatter").unwrap();
    let Found::Scatter(scatter) = &done.found else {
        panic!("{done:?}")
    };
    let (share, u) = (scatter.share_rel[0][0], scatter.u_share_rel[0][0]);
    assert!((share - 0.01).abs() < 2.0 * u, "{scatter:?}");
    assert!((share - 0.01).abs() < 0.0005 && u < 0.003, "{scatter:?}");
    lab.in_room(|room| {
        room.spectroradiometer.filter_cut_on_nm = 0.0;
        room.lamp.temperature_k = 0.0;
    });
    let truth = truth(&lab);
    lab.edit("station.toml", "u_shape_rel = 0.004", "u_shape_rel = 0.0002");
    let without = lab.spectrum("without");
    assert!(
        outside(&reduced(&without, &[]), truth)
            .iter()
            .any(|of| of.starts_with("lm/W"))
    );
    lab.name(&done);
    let run = lab.spectrum("with");
    let with = reduced(&run, &[]);
    assert_eq!(outside(&with, truth), Vec::<String>::new());
    assert!(with.ler.parts["scatter"] > 0.0 && with.irradiance.parts["scatter"] > 0.0);
    let less = reduced(&run, &[Correction::Scatter]);
    assert!(
        !outside(&less, truth).is_empty() && less.ler.u.is_none(),
        "{:?}",
        less.ler
    );
}

#[test]
fn no_scattered_light_from_a_record_that_does_not_show_it() {
    let lab = behind_a_filter(7, 0.004);
    let filter = glass(&lab);
    lab.find(&Procedure::CutOn(filter.clone()), "scatter").unwrap();
    let run = Run::read(&lab.folder().join("scatter")).unwrap();
    let refused = |edit: &dyn Fn(&mut Run), filter: &CutOnFilter, expected: &str| {
        let mut run = run.clone();
        edit(&mut run);
        let error = found_of::scatter(&run, filter).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    };
    let same = |_: &mut Run| {};
    let with = |edit: &dyn Fn(&mut CutOnFilter)| {
        let mut other = filter.clone();
        edit(&mut other);
        other
    };
    refused(
        &same,
        &with(&|of| of.cut_on_nm = 590.0),
        "cuts on at 590 nm, and the light in the spectrum at 5",
    );
    refused(&same, &with(&|of| of.opaque_below_nm = 345.0), "pixels below 345 nm");
    refused(
        &same,
        &with(&|of| of.opaque_below_nm = 508.0),
        "below 508 nm, where virtual OG515 is opaque",
    );
    refused(
        &|run| run.spectra[0].pixels[900].saturated = true,
        &filter,
        "spectra/000.csv: saturated at",
    );
    refused(
        &|run| run.spectra.truncate(1),
        &filter,
        "fewer than two spectra of light behind a filter",
    );
    let brighter = |run: &mut Run| {
        for pixel in &mut run.spectra[1].pixels {
            pixel.counts += 0.05 * (pixel.counts - pixel.dark_counts);
        }
    };
    refused(&brighter, &filter, "the light changed by +5.");
}
