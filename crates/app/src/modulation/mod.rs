//! `flicker`: what a record of light over time says, of a file or as an instrument records it.

mod acquire;
mod words;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_modulation::{Camera, Form, Given, Modulation, Source, Waveform, evaluate};
pub use isolux_record::LightModulation;
use isolux_report::plots::{light_over_frequency, light_over_time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::acquire::{Acquisition, acquire};
use crate::Failure;
use crate::files::{self, Overwrite};

/// The file of results.
const RESULT: &str = "modulation.json";
/// The files that are written.
pub(crate) const FILES: [&str; 3] = ["modulation-waveform.svg", "modulation-spectrum.svg", RESULT];

/// What is evaluated, and how.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The file and what is stated about it.
    pub light: LightModulation,
    /// Largest SVM that is allowed; none: not judged.
    pub limit_svm: Option<f64>,
    /// Largest PstLM that is allowed; none: not judged.
    pub limit_pst: Option<f64>,
    /// Folder for the figures and `modulation.json`.
    pub out: Option<&'a Utf8Path>,
    /// Whether files there may be replaced.
    pub overwrite: Overwrite,
}

/// What the evaluation of a waveform gives; the content of `flicker --json` and of `modulation.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evaluated {
    /// The file.
    pub waveform: String,
    /// What it says.
    pub modulation: Modulation,
    /// Each limit that was stated.
    pub verdicts: Vec<Verdict>,
}

/// A number beside its limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// What it is.
    pub quantity: String,
    /// The limit.
    pub limit: f64,
    /// Whether the number is not above the limit; false too where there is no number.
    pub passes: bool,
    /// Whether the limit lies outside of the number's expanded uncertainty (k = 2); none where that is not known.
    pub beyond_doubt: Option<bool>,
}

impl Verdict {
    fn of(quantity: &str, limit: f64, given: &Given) -> Self {
        let found = given.quantity.as_ref();
        Self {
            quantity: quantity.to_owned(),
            limit,
            passes: found.is_some_and(|found| found.value <= limit),
            beyond_doubt: found.and_then(|found| Some((found.value - limit).abs() > 2.0 * found.u?)),
        }
    }
}

/// Evaluates a file.
///
/// # Errors
/// Bad input (exit 2) for a file that is no waveform of light, and for files that exist and may not be replaced.
pub fn run(request: &Request<'_>) -> Result<(Evaluated, Vec<Utf8PathBuf>), Failure> {
    let modulation = of(&request.light)?;
    let limits = [
        ("SVM", request.limit_svm, &modulation.svm),
        ("PstLM", request.limit_pst, &modulation.pst_lm),
    ];
    let verdicts = limits
        .into_iter()
        .filter_map(|(name, limit, given)| Some(Verdict::of(name, limit?, given)))
        .collect();
    let evaluated = Evaluated {
        waveform: request.light.waveform.to_string(),
        modulation,
        verdicts,
    };
    let written = match request.out {
        Some(out) => write(out, &evaluated, request.overwrite)?,
        None => Vec::new(),
    };
    Ok((evaluated, written))
}

/// What the file that a job or a person names says.
///
/// # Errors
/// Bad input (exit 2) with the file, its line and what to do.
pub(crate) fn of(light: &LightModulation) -> Result<Modulation, Failure> {
    let file = &light.waveform;
    light
        .check()
        .map_err(|fault| Failure::bad_input(format!("{file}: {fault}")))?;
    let source = Source {
        rate_hz: light.sample_rate_hz,
        dark: light.dark,
    };
    let camera = Camera {
        exposures_s: light.exposures_ms.iter().map(|ms| 1e-3 * ms).collect(),
        line_time_s: light.line_time_us.map(|us| 1e-6 * us),
    };
    let waveform = Waveform::parse(&files::read(file)?, source);
    waveform
        .and_then(|waveform| evaluate(&waveform, &camera))
        .map_err(|error| Failure::bad_input(format!("{file}: {error}")))
}

/// Writes the result and its figures; the files that were written.
///
/// # Errors
/// As [`files::write`].
pub(crate) fn write(out: &Utf8Path, evaluated: &Evaluated, overwrite: Overwrite) -> Result<Vec<Utf8PathBuf>, Failure> {
    let json = serde_json::to_string_pretty(evaluated).map_err(Failure::instrument)? + "\n";
    let title = Utf8Path::new(&evaluated.waveform).file_name().unwrap_or_default();
    let modulation = &evaluated.modulation;
    let contents = [
        light_over_time(modulation, title),
        light_over_frequency(modulation, title),
        json,
    ];
    let (mut pending, mut written) = (Vec::new(), Vec::new());
    for (name, content) in FILES.into_iter().zip(contents) {
        let path = out.join(name);
        pending.push(files::prepare(&path, content.as_bytes(), overwrite)?);
        written.push(path);
    }
    files::publish(pending)?;
    Ok(written)
}

/// The name under which a day keeps its waveform.
pub(crate) fn kept_name(bytes: &[u8]) -> &'static str {
    match Form::of(bytes) {
        Form::Csv => "light-modulation.csv",
        Form::Wav => "light-modulation.wav",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(folder: &Utf8Path, amplitude: f64) -> LightModulation {
        let waveform = folder.join("light.csv");
        let value = |k: i32| 1.0 + amplitude * (std::f64::consts::TAU * 100.0 * f64::from(k) / 20e3).sin();
        let lines: Vec<String> = (0..20_000).map(|k| value(k).to_string()).collect();
        std::fs::write(&waveform, lines.join("\n")).unwrap();
        LightModulation {
            waveform,
            sample_rate_hz: Some(20e3),
            dark: Some(0.0),
            exposures_ms: vec![2.0],
            line_time_us: Some(20.0),
        }
    }

    #[test]
    fn a_file_is_judged_by_its_limits_and_nothing_is_replaced_unasked() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        let out = folder.join("out");
        let request = Request {
            light: light(folder, 0.1),
            limit_svm: Some(0.4),
            limit_pst: Some(1.0),
            out: Some(&out),
            overwrite: Overwrite::Never,
        };
        let (evaluated, written) = run(&request).unwrap();
        assert_eq!(written.len(), 3);
        let stored: Evaluated = files::read_json(&out.join(RESULT)).unwrap();
        assert_eq!(stored, evaluated);
        let [svm, pst] = &evaluated.verdicts[..] else { panic!() };
        // 0.39 of 0.4, and one second has no PstLM.
        assert!(svm.passes && svm.beyond_doubt == Some(true), "{svm:?}");
        assert!(!pst.passes && pst.beyond_doubt.is_none());
        let words = evaluated.stated().join("\n");
        for word in [
            "10.0",
            "SVM",
            "not given: a record of 1 s",
            "rolling shutter",
            "PstLM ≤ 1: FAILS",
        ] {
            assert!(words.contains(word), "{word} in {words}");
        }
        assert!(run(&request).unwrap_err().message.contains("modulation-waveform.svg"));
        let mut bad = light(folder, 0.1);
        bad.exposures_ms = vec![-1.0];
        assert!(of(&bad).unwrap_err().message.contains("exposures_ms"));
        std::fs::write(&bad.waveform, "1\n2\nx\n").unwrap();
        bad.exposures_ms.clear();
        let failure = of(&bad).unwrap_err();
        assert!(failure.message.contains("light.csv: line 3: \"x\""), "{failure}");
    }
}
