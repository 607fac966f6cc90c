//! A station file and the calibration that it names, beside those that the run was recorded with.

use camino::Utf8Path;
use isolux_record::RunHeader;
use isolux_record::disk::sha256;
use isolux_record::spectra::SpectralCorrections;

use super::ledger::Ledger;
use crate::Failure;
use crate::instruments::bench::StationFiles;

/// Compares the station file `file`, and the calibration that it names, with what run.toml holds of them.
///
/// # Errors
/// Bad input (exit 2) for a station that cannot be read.
pub(super) fn check(file: &Utf8Path, header: Option<&RunHeader>, ledger: &mut Ledger) -> Result<(), Failure> {
    let given = StationFiles::load(file)?;
    let Some(header) = header else {
        ledger.unchecked(
            file.as_str(),
            "run.toml, which holds the station of the run, cannot be relied on",
        );
        return Ok(());
    };
    let text = |station| toml::to_string(station).map_err(Failure::instrument);
    let (then, now) = (text(&header.station)?, text(&given.station)?);
    let because = "it says what run.toml holds of it";
    if then == now {
        ledger.agrees(file.as_str(), because);
    } else {
        let lines: Vec<&str> = then.lines().collect();
        let others = now.lines().filter(|line| !lines.contains(line));
        let what = match others.collect::<Vec<_>>().as_slice() {
            [] => "says less than the station of the run".to_owned(),
            other => format!("is not the station of the run: `{}`", other.join("`, `")),
        };
        ledger.differs(file.as_str(), None, what);
    }
    if let (Some((calibration, text)), Some(spectral)) = (&given.calibration, &header.spectral) {
        if sha256(text.as_bytes()) == spectral.sha256 {
            ledger.agrees(calibration.as_str(), "its SHA-256 in run.toml");
        } else {
            ledger.differs(
                calibration.as_str(),
                None,
                "is not the calibration of the run: run.toml holds another SHA-256 of it",
            );
        }
    }
    if let (Some(now), Some(then)) = (&given.luxmeter, &header.luxmeter) {
        let curves = [
            (
                given.station.responsivity(file),
                Some(&now.responsivity),
                Some(&then.responsivity),
            ),
            (
                given.station.calibration_light(file),
                now.calibration_light.as_ref(),
                then.calibration_light.as_ref(),
            ),
        ];
        for (path, now, then) in curves {
            let (Some(path), Some(now), Some(then)) = (path, now, then) else {
                continue;
            };
            if now.sha256 == then.sha256 {
                ledger.agrees(path.as_str(), "its SHA-256 in run.toml");
            } else {
                let what = "is not the curve of the run: run.toml holds another SHA-256 of it";
                ledger.differs(path.as_str(), None, what);
            }
        }
    }
    if let Some(spectral) = &header.spectral {
        corrections(&given.corrections, &spectral.corrections, ledger);
    }
    Ok(())
}

/// What the laboratory has found of the spectroradiometer, which run.toml holds whole.
fn corrections(given: &SpectralCorrections, then: &SpectralCorrections, ledger: &mut Ledger) {
    let key = |key: &str| format!("spectroradiometer.{key}");
    for (name, _) in given.made() {
        let same = match name {
            "wavelengths" => given.wavelengths == then.wavelengths,
            "scatter" => given.scatter == then.scatter,
            _ => given.linearity == then.linearity,
        };
        if same {
            ledger.agrees(&key(name), "it is what run.toml holds of it");
        } else {
            ledger.differs(
                &key(name),
                None,
                "is not the correction of the run: run.toml holds another",
            );
        }
    }
}
