//! What procedures find of a spectroradiometer itself, beside the room's truth, and what its corrections do to a
//! spectrum.

mod linearity;
mod lines;
mod scatter;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::Failure;
use isolux_app::calibration::AtBench;
use isolux_app::calibration::spectrometer::{self, Done, Procedure};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::Darkroom;
use isolux_record::{Plan, Run};
use isolux_reduce::{Correction, Options, SpectralResult, on_axis};
use isolux_spectrum::Spectrum;
use isolux_spectrum::cct::nearest_planckian;

use crate::calibration::lab::Lab;

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
