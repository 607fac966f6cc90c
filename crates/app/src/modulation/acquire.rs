//! A record of light from an instrument, kept as `waveform.csv`.

use std::fmt::Write as _;
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::Darkroom;
use isolux_device::{Identity, Target, VoltageRecord};
use isolux_transport::SystemLinks;
use isolux_virtual::Instrument;
use isolux_virtual::twins::Choice;

use super::FILES;
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::instruments::catalogue::{Catalogue, open_failure};
use crate::instruments::session::{self, Session};

/// What is recorded.
#[derive(Debug, Clone)]
pub struct Acquisition<'a> {
    /// `driver:target` of the recorder.
    pub open: &'a str,
    /// Length of the record, s.
    pub duration_s: f64,
    /// Least sample rate, Hz.
    pub least_rate_hz: f64,
    /// Folder for `waveform.csv`.
    pub out: &'a Utf8Path,
    /// Whether a file there may be replaced.
    pub overwrite: Overwrite,
}

/// Records, and writes `waveform.csv`, whose name comes back. In memory it is the built-in darkroom with its lamp on.
///
/// # Errors
/// Bad input (exit 2) for a wrong address or length and a file that exists, exit 3 when the instrument fails.
pub fn acquire(request: &Acquisition<'_>, progress: &dyn Progress) -> Result<Utf8PathBuf, Failure> {
    let file = request.out.join("waveform.csv");
    // What would be refused after the record is refused before it.
    for name in FILES {
        files::refuse_existing(&request.out.join(name), request.overwrite)?;
    }
    files::refuse_existing(&file, request.overwrite)?;
    for (what, value) in [("--duration", request.duration_s), ("--rate", request.least_rate_hz)] {
        if !(1e-3..=1e9).contains(&value) {
            return Err(Failure::bad_input(format!("{what} {value}: 0.001 to 1e9 are possible")));
        }
    }
    let target = Target::parse(request.open).map_err(open_failure)?;
    let in_memory = target.link().starts_with("memory:");
    let (identity, record, at) = session::run(in_memory, async {
        let session = if in_memory {
            lit_room()?
        } else {
            Session::of_links(SystemLinks::default())
        };
        let catalogue = Catalogue::new(session.links.clone());
        let recorder = catalogue.waveform_recorder(request.open).await.map_err(open_failure)?;
        progress.event(Event::Began {
            step: "record",
            total: None,
        });
        let at = jiff::Timestamp::now();
        let duration = Duration::from_secs_f64(request.duration_s);
        let record = recorder.record(duration, request.least_rate_hz).await;
        let record = record.map_err(|error| Failure::instrument(&error))?;
        let count = record.voltage_v.len();
        progress.event(Event::Ended(&format!("{count} samples at {} Hz", record.rate_hz)));
        Ok((recorder.identity().clone(), record, at))
    })?;
    // Virtual time has no date.
    let at = (!in_memory).then_some(at);
    files::write(
        &file,
        csv(request.open, &identity, &record, at).as_bytes(),
        request.overwrite,
    )?;
    Ok(file)
}

fn lit_room() -> Result<Session, Failure> {
    let mut choice = Choice::default();
    choice.add(Instrument::Oscilloscope);
    let mut document = Darkroom::built_in().map_err(Failure::bad_input)?;
    document.lamp.on_at_start = true;
    Session::in_room(document, &choice)
}

fn csv(open: &str, identity: &Identity, record: &VoltageRecord, at: Option<jiff::Timestamp>) -> String {
    let mut text = format!("# recorder = {open}\n# model = {}\n", identity.model);
    for (key, value) in [("serial", &identity.serial), ("firmware", &identity.firmware)] {
        if let Some(value) = value {
            let _ = writeln!(text, "# {key} = {value}");
        }
    }
    if let Some(at) = at {
        let _ = writeln!(text, "# began_utc = {at:.0}");
    }
    let (low, high) = record.range_v;
    // The recorder gives the interval, to seven digits or so.
    let rate_hz = (1e6 * record.rate_hz).round() / 1e6;
    let _ = writeln!(text, "# sample_rate_hz = {rate_hz}\n# range = {low} {high}\nvoltage_V");
    // To a hundredth of the converter's step.
    let digits = (2.0 - record.step_v.log10().floor()).clamp(0.0, 12.0) as usize;
    for value in &record.voltage_v {
        let _ = writeln!(text, "{value:.digits$}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FailureKind;
    use crate::front_end::progress::Silent;
    use crate::modulation::{LightModulation, of};

    #[test]
    fn the_built_in_lamp_is_steady_and_its_file_says_where_it_comes_from() {
        let keep = tempfile::tempdir().unwrap();
        let request = Acquisition {
            open: "scpi-scope:memory:oscilloscope?profile=ds1000z&channel=1",
            duration_s: 1.2,
            least_rate_hz: 20e3,
            out: Utf8Path::from_path(keep.path()).unwrap(),
            overwrite: Overwrite::Never,
        };
        let waveform = acquire(&request, &Silent).unwrap();
        let text = std::fs::read_to_string(&waveform).unwrap();
        for line in [
            "# model = RIGOL TECHNOLOGIES DS1054Z",
            "# serial = DS1ZA000000001",
            "# sample_rate_hz = 100000",
        ] {
            assert!(text.lines().any(|known| known == line), "{line} in {}", &text[..300]);
        }
        let found = of(&LightModulation {
            waveform,
            sample_rate_hz: None,
            dark: Some(0.004),
            exposures_ms: Vec::new(),
            line_time_us: None,
        })
        .unwrap();
        // 6 mV of noise and steps of 20 mV on 1 V.
        let noise = (0.006_f64.powi(2) + 0.02_f64.powi(2) / 12.0).sqrt();
        assert!((found.noise_rel / noise - 1.0).abs() < 0.2, "{}", found.noise_rel);
        assert!(found.svm.quantity.unwrap().value < 0.02 && found.pst_lm.why_not.is_some());
        assert_eq!(acquire(&request, &Silent).unwrap_err().kind, FailureKind::BadInput);
        let wrong = Acquisition {
            open: "zaber:memory:axes",
            overwrite: Overwrite::Force,
            ..request
        };
        assert!(acquire(&wrong, &Silent).unwrap_err().message.contains("scpi-scope"));
    }
}
