//! A virtual bench under a standard lamp, in a folder of its own.

use std::cell::Cell;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::calibration::{self, CalibrationRequest, Done, Instrument, Outcome, SpectralFactors};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::{Event, Progress, Silent};
use isolux_app::{Failure, init};
use isolux_darkroom::certificate::{self, Stated};
use isolux_darkroom::{Darkroom, Room};

pub struct Lab {
    _keep: tempfile::TempDir,
    folder: Utf8PathBuf,
    pub room: Room,
}

impl Lab {
    /// The bench that `init --standard` writes, its room with `seed` and changed by `edit`, its certificate of that
    /// room.
    pub fn new(seed: u64, edit: impl FnOnce(&mut Darkroom)) -> Self {
        let memory = Utf8Path::new("/dev/shm");
        let keep = if memory.is_dir() {
            tempfile::tempdir_in(memory)
        } else {
            tempfile::tempdir()
        }
        .unwrap();
        let folder = Utf8PathBuf::try_from(keep.path().to_owned()).unwrap();
        init::with_standard(&folder, &init::Instruments::default(), Overwrite::Never).unwrap();
        let file = folder.join("room.toml");
        let mut room = Darkroom::parse(&std::fs::read_to_string(&file).unwrap()).unwrap();
        room.seed = seed;
        edit(&mut room);
        std::fs::write(&file, toml::to_string(&room).unwrap()).unwrap();
        // The days of the certificate are around today.
        let text = std::fs::read_to_string(folder.join("standard.toml")).unwrap();
        let day = |key: &str| {
            let (_, rest) = text.split_once(&format!("{key} = \"")).unwrap();
            rest[..10].to_owned()
        };
        let stated = Stated {
            days: (day("issued"), day("expires")),
            ..Stated::default()
        };
        let written = certificate::write(&room, &stated, "standard.csv");
        std::fs::write(folder.join("standard.toml"), written.document).unwrap();
        std::fs::write(folder.join("standard.csv"), written.table).unwrap();
        Self {
            _keep: keep,
            folder,
            room: Room::new(room),
        }
    }

    pub fn station(&self) -> Utf8PathBuf {
        self.folder.join("station.toml")
    }

    pub fn standard(&self) -> Utf8PathBuf {
        self.folder.join("standard.toml")
    }

    /// Replaces text of a file, which must be there.
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let file = self.folder.join(name);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{name}: {from}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
    }

    pub fn folder(&self) -> &Utf8Path {
        &self.folder
    }

    pub fn run(&self, instrument: Instrument) -> Utf8PathBuf {
        self.folder.join(instrument.role())
    }

    pub fn calibrate(&self, instrument: Instrument) -> Result<Done, Failure> {
        self.calibrate_with(instrument, &Control::default(), &Silent)
    }

    pub fn calibrate_with(
        &self,
        instrument: Instrument,
        control: &Control,
        progress: &dyn Progress,
    ) -> Result<Done, Failure> {
        calibration::run(&CalibrationRequest {
            instrument,
            station: &self.station(),
            standard: &self.standard(),
            out: &self.run(instrument),
            valid_days: 365,
            force: None,
            operator: None,
            control,
            progress,
        })
    }

    /// Puts the lines that a calibration prints into the station, in place of what it has, and the factors beside it.
    pub fn paste(&self, done: &Done) {
        let lines = done.calibration.station_lines();
        let keys: Vec<&str> = lines.iter().filter_map(|line| line.split(" = ").next()).collect();
        let text = std::fs::read_to_string(self.station()).unwrap();
        let mut table = String::new();
        let mut written = String::new();
        for line in text.lines() {
            if line.starts_with('[') {
                line.clone_into(&mut table);
            }
            let key = line.split(" = ").next().unwrap_or("");
            if table == lines[0] && line != lines[0] && keys.contains(&key) {
                continue;
            }
            written += &format!("{line}\n");
            if line == lines[0] {
                written += &(lines[1..].join("\n") + "\n");
            }
        }
        std::fs::write(self.station(), written).unwrap();
        let factors = done.folder.join("spectroradiometer.csv");
        if factors.is_file() {
            std::fs::copy(factors, self.folder.join("spectroradiometer.csv")).unwrap();
        }
    }
}

pub fn spectral(done: &Done) -> &SpectralFactors {
    match &done.calibration.outcome {
        Outcome::Spectroradiometer(factors) => factors,
        Outcome::Luxmeter(_) => panic!("{done:?}"),
    }
}

/// Ends the scan after so many steps of it.
pub struct EndsAfter<'a> {
    left: Cell<u32>,
    control: &'a Control,
}

impl<'a> EndsAfter<'a> {
    pub fn readings(count: u32, control: &'a Control) -> Self {
        Self {
            left: Cell::new(count),
            control,
        }
    }
}

impl Progress for EndsAfter<'_> {
    fn event(&self, event: Event<'_>) {
        if let Event::At { done, .. } = event
            && done > 0
        {
            self.left.set(self.left.get().saturating_sub(1));
            if self.left.get() == 0 {
                self.control.cancel.cancel("the test ends it");
            }
        }
    }
}
