//! Spectra of two days: `cargo bench -p isolux-two-days --bench spectra [-- NUMBER] [--write FOLDER]`.
//!
//! The first day makes the model of a lamp; on the second its spectrum is read again with one fault in the
//! spectroradiometer, five strengths each, and on NUMBER days (30) without one. Prints a line for each and the shares;
//! `--write` keeps all files.

use std::io::Write as _;

use camino::Utf8PathBuf;
use isolux_darkroom::Darkroom;
use isolux_two_days::case::StatedDiagnosis;
use isolux_two_days::days::Days;
use isolux_two_days::lamps::Lamp;
use isolux_two_days::spectra::{Second, answer};

/// Changes a room by an amount.
type Fault = fn(&mut Darkroom, f64);

/// What is wrong, its effect, and the strengths that are tried.
const FAULTS: [(&str, Fault, [f64; 5]); 5] = [
    (
        "spectro_shift",
        |room, nm| room.injected_effects.spectro_shift.shift_nm = nm,
        [0.02, 0.05, -0.1, 0.2, -0.4],
    ),
    (
        "spectro_bandpass",
        |room, nm| room.injected_effects.spectro_bandpass.fwhm_nm = nm,
        [1.0, 2.0, 3.0, 5.0, 8.0],
    ),
    (
        "spectro_stray",
        |room, share| room.injected_effects.spectro_stray.fraction = share,
        [3e-6, 1e-5, 3e-5, 1e-4, 3e-4],
    ),
    (
        "spectro_2nd",
        |room, share| room.injected_effects.spectro_2nd.fraction = share,
        [1e-3, 3e-3, 1e-2, 2e-2, 5e-2],
    ),
    (
        "light_level",
        |room, rel| room.lamp.flux_lm *= 1.0 + rel,
        [0.005, -0.01, 0.02, -0.05, 0.1],
    ),
];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let count = words.iter().find_map(|word| word.parse().ok()).unwrap_or(30_u64);
    let kept = words.iter().skip_while(|word| *word != "--write").nth(1);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let root = match kept {
        Some(folder) => Utf8PathBuf::from(folder),
        None => Utf8PathBuf::try_from(folder.path().to_owned()).expect("a UTF-8 path"),
    };
    let days = Days::below(&root);
    let mut false_alarms = 0;
    for day in 1..=count {
        let lamp = Lamp::ALL[(day % 3) as usize];
        let seed = 1 + day % 2;
        match answer(&days, &root, (lamp, seed, day), &Second::default()) {
            Ok(stated) => {
                false_alarms += u64::from(stated.verdict != "consistent");
                say(&format!("none {} {seed} {day}: {}", lamp.name(), line(&stated)));
            }
            Err(error) => say(&format!("none {day}: FAILED: {error}")),
        }
    }
    say(&format!("no fault: {false_alarms} of {count} days disagree"));
    let mut day = 10_000;
    for (name, fault, strengths) in FAULTS {
        for strength in strengths {
            day += 1;
            let lamp = Lamp::ALL[(day % 3) as usize];
            match answer(
                &days,
                &root,
                (lamp, 1 + day % 2, day),
                &Second {
                    change: &|room| fault(room, strength),
                    ..Second::default()
                },
            ) {
                Ok(stated) => say(&format!("{name} {strength} {}: {}", lamp.name(), line(&stated))),
                Err(error) => say(&format!("{name} {strength}: FAILED: {error}")),
            }
        }
    }
}

fn line(stated: &StatedDiagnosis) -> String {
    let [given, known, after] = [0, 1, 2].map(|k| stated.gap[k]);
    format!(
        "{} {:?}; gap {given:.2} | {known:.2} | {after:.2}",
        stated.verdict, stated.effects
    )
}

fn say(text: &str) {
    // Whoever closed the output wants no more of it.
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}
