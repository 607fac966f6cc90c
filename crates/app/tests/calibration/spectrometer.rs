//! What procedures find of a spectroradiometer itself, beside the room's truth, and what its corrections do to a
//! spectrum.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::Failure;
use isolux_app::calibration::spectrometer::{self, Done, Found, Procedure};
use isolux_app::calibration::{AtBench, Instrument};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::Darkroom;
use isolux_record::filter::CutOnFilter;
use isolux_record::lines::{Line, LineList};
use isolux_record::spectra::WavelengthScale;
use isolux_record::{Plan, Run};
use isolux_reduce::{Correction, Options, SpectralResult, on_axis, spectrometer as found_of};
use isolux_spectrum::Spectrum;
use isolux_spectrum::cct::nearest_planckian;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::campaign::normal;
use crate::lab::{Lab, spectral};

const SPECTRUM: &str = "format = \"isolux-plan/1\"\n[[block]]\nname = \"spectrum\"\nkind = \"lit\"\n\
                        instrument = \"spectroradiometer\"\nc_deg = 0\ngamma_deg = 0\nrepeats = 20\n";

impl Lab {
    /// Writes the room once more, changed by `edit`: the same instrument before another lamp.
    fn in_room(&mut self, edit: impl Fn(&mut Darkroom)) {
        let mut room = self.room.document().clone();
        edit(&mut room);
        std::fs::write(self.folder().join("room.toml"), toml::to_string(&room).unwrap()).unwrap();
        self.room = isolux_darkroom::Room::new(room);
    }

    fn find(&self, procedure: &Procedure, name: &str) -> Result<Done, Failure> {
        let control = Control::default();
        let bench = AtBench {
            out: &self.folder().join(name),
            force: None,
            operator: None,
            control: &control,
            progress: &Silent,
        };
        spectrometer::run(procedure, &self.station(), &bench)
    }

    /// The record of the lamp's spectrum on the axis.
    fn spectrum(&self, name: &str) -> Run {
        let source = StationFiles::load(&self.station()).unwrap();
        let plan = Plan::parse(Utf8Path::new("plan.toml"), SPECTRUM).unwrap();
        let out: Utf8PathBuf = self.folder().join(name);
        let job = ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(Target::New(&out), false).unwrap(),
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute().unwrap();
        Run::read(&out).unwrap()
    }

    /// Puts a file that a procedure wrote, and its lines, into the station.
    fn name(&self, done: &Done) {
        let file = done.files[0].as_str();
        std::fs::copy(done.folder.join(file), self.folder().join(file)).unwrap();
        let lines = done.found.station_lines();
        let keys: Vec<&str> = lines.iter().filter_map(|line| line.split(" = ").next()).collect();
        let text = std::fs::read_to_string(self.station()).unwrap();
        let (before, rest) = text.split_once("[spectroradiometer]\n").unwrap();
        let rest: Vec<&str> = rest.lines().collect();
        let end = rest.iter().position(|line| line.starts_with('[')).unwrap_or(rest.len());
        let mut table: Vec<&str> = lines.iter().map(String::as_str).collect();
        table.extend(
            rest[..end]
                .iter()
                .filter(|line| !keys.contains(&line.split(" = ").next().unwrap_or(""))),
        );
        table.extend(&rest[end..]);
        std::fs::write(self.station(), format!("{before}{}\n", table.join("\n"))).unwrap();
    }
}

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

/// Chromaticity, temperature and efficacy of the room's lamp.
fn truth(lab: &Lab) -> (f64, f64, f64, f64) {
    let nm: Vec<f64> = (360..=830).map(f64::from).collect();
    let value = nm.iter().map(|nm| lab.room.spectrum().per_lux(*nm, 1.0)).collect();
    let spectrum = Spectrum::new(nm, value).unwrap();
    let colour = spectrum.chromaticity().unwrap();
    let cct_k = nearest_planckian(colour).unwrap().cct_k;
    (
        colour.x,
        colour.y,
        cct_k,
        spectrum.luminous_integral() / spectrum.integral(),
    )
}

/// The spectrum of a run without some corrections.
fn reduced(run: &Run, off: &[Correction]) -> SpectralResult {
    let options = Options {
        without: off.iter().copied().collect(),
        accept_drift: None,
    };
    on_axis(run, &options).unwrap().unwrap()
}

/// What is outside of U (k = 2) of x, y, CCT and lm/W.
fn outside(of: &SpectralResult, truth: (f64, f64, f64, f64)) -> Vec<String> {
    let (x, y, cct) = (&of.colour.x, &of.colour.y, &of.colour.cct);
    let [x, y, cct] = [x, y, cct].map(|of| of.clone().unwrap());
    let numbers = [
        ("x", x, truth.0),
        ("y", y, truth.1),
        ("CCT", cct, truth.2),
        ("lm/W", of.ler.clone(), truth.3),
    ];
    let off = numbers
        .into_iter()
        .filter(|(_, of, truth)| (of.value - truth).abs() > 2.0 * of.u_of_parts);
    off.map(|(name, of, truth)| format!("{name} {} {truth} {:?}", of.stated(), of.parts))
        .collect()
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
