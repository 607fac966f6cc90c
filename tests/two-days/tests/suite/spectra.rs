//! The spectrum of a second day: without a fault it agrees with the model, and a wavelength scale that moved by a
//! twentieth of a nanometre is named, unless another instrument read.

use camino::Utf8Path;
use isolux_two_days::case::StatedDiagnosis;
use isolux_two_days::days::Days;
use isolux_two_days::lamps::Lamp;
use isolux_two_days::spectra::{Second, answer};

#[test]
fn a_wavelength_scale_that_moved_is_named_and_another_instrument_may_differ() {
    let folder = tempfile::tempdir().unwrap();
    let root = Utf8Path::from_path(folder.path()).unwrap();
    let days = Days::below(root);
    let said = |day: u64, shift_nm: f64, other_instrument: bool| -> StatedDiagnosis {
        let second = Second {
            change: &|room| room.injected_effects.spectro_shift.shift_nm = shift_nm,
            other_instrument,
        };
        answer(&days, root, (Lamp::Ring, 1, day), &second).unwrap()
    };
    let faultless = said(1, 0.0, false);
    assert_eq!(faultless.verdict, "consistent", "{faultless:?}");
    let moved = said(2, 0.05, false);
    assert_eq!(moved.verdict, "named", "{moved:?}");
    assert_eq!(moved.effects[0].0, "spectro_shift", "{moved:?}");
    assert!(moved.gap[1] > 1.2 && moved.gap[2] < 1.1, "{moved:?}");
    // Two instruments whose scales are known to 0.1 nm each.
    let other = said(3, 0.1, true);
    assert_eq!(other.verdict, "consistent", "{other:?}");
}
