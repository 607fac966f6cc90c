//! Linearity, from integration times.

use isolux_app::calibration::Instrument;
use isolux_app::calibration::spectrometer::{Found, Procedure};
use isolux_record::Run;
use isolux_reduce::spectrometer as found_of;

use crate::calibration::lab::{Lab, spectral};

/// Counts of full scale less what the polynomial of the instrument makes of them, as a bend is left of `loss` beside
/// the one of which it knows: counts = linear·(1 − loss·linear/full).
fn left_of(known: f64, loss: f64, linear: f64) -> f64 {
    let shown = linear * (1.0 - loss * linear);
    // The root of shown = x·(1 − known·x).
    2.0 * shown / (1.0 + (1.0 - 4.0 * known * shown).sqrt()) / linear
}

#[test]
fn an_instrument_that_is_bent_is_found_and_can_be_calibrated_afterwards() {
    let lab = Lab::new(13, |room| room.spectroradiometer.nonlinearity_error = 0.03);
    let done = lab.find(&Procedure::Linearity, "linearity").unwrap();
    let Found::Linearity(linearity) = &done.found else {
        panic!("{done:?}")
    };
    for linear in [0.1, 0.3, 0.5, 0.7] {
        let truth = left_of(0.04, 0.07, linear);
        let x = truth * linear;
        let off = linearity.divisor(x) / truth - 1.0;
        assert!(
            off.abs() < 2.0 * linearity.u_rel(x),
            "{linear}: {off} {}",
            linearity.u_rel(x)
        );
        assert!(off.abs() < 0.002, "{linear}: {off}");
    }
    // Without it there is no factor.
    assert!(lab.calibrate(Instrument::Spectroradiometer).is_err());
    std::fs::remove_dir_all(lab.run(Instrument::Spectroradiometer)).unwrap();
    lab.name(&done);
    let calibrated = lab.calibrate(Instrument::Spectroradiometer).unwrap();
    let factors = spectral(&calibrated);
    assert!(factors.nonlinearity_rel < 0.002, "{}", factors.nonlinearity_rel);
    let counts_per_s = lab.room.document().spectroradiometer.counts_per_s;
    let mut outside = 0;
    for nm in [450.0, 555.0, 650.0] {
        let place = factors.wavelength_nm.partition_point(|at| *at < nm);
        let truth = 1.0 / (isolux_darkroom::spectrograph::responsivity(nm) * counts_per_s);
        let off = factors.factor_w_m2_nm[place] / truth - 1.0;
        outside += usize::from(off.abs() > 2.0 * factors.u_rel_at(place));
    }
    assert_eq!(outside, 0);
}

#[test]
fn no_linearity_from_a_record_that_does_not_show_it() {
    let lab = Lab::new(14, |_| {});
    lab.find(&Procedure::Linearity, "linearity").unwrap();
    let run = Run::read(&lab.folder().join("linearity")).unwrap();
    let refused = |edit: &dyn Fn(&mut Run), expected: &str| {
        let mut run = run.clone();
        edit(&mut run);
        let error = found_of::linearity(&run).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    };
    let brighter = |run: &mut Run, number: usize, by: f64| {
        for pixel in &mut run.spectra[number].pixels {
            pixel.counts += by * (pixel.counts - pixel.dark_counts);
        }
    };
    refused(&|run| brighter(run, 6, 0.03), "the light changed by +3.");
    // One integration time that is not what the instrument says.
    refused(
        &|run| brighter(run, 4, 0.02),
        "more than a polynomial of the counts explains",
    );
    refused(
        &|run| drop(run.spectra.drain(3..6)),
        "linearity needs from 15 % or below",
    );
    refused(
        &|run| run.spectra[2].pixels[900].saturated = true,
        "spectra/002.csv: saturated at",
    );
}
