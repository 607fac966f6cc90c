//! `isolux verify`: whether a run directory still is what was recorded and computed, file by file.
//!
//! Three things speak for a file: a checksum that the record or the results keep of it, the result that is computed
//! again from the record, and the list `SHA256SUMS` that `--sign` writes and signs. A file for which none
//! of them speaks is listed as not checked.

mod again;
mod compare;
mod ledger;
mod manifest;
mod outside;
mod provenance;
mod record;
mod results;
mod signature;
mod verification;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::{RunError, RunHeader, RunLock};

use self::ledger::{Ledger, SIGNATURE};
pub use self::verification::{Difference, FileVerdict, Signed, State, Verification};
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::Progress;
use crate::instruments::bench::PROGRAM;

/// What is verified, and with what.
#[derive(Debug, Clone)]
pub struct VerifyRequest<'a> {
    /// The run directory.
    pub run: &'a Utf8Path,
    /// Public key in minisign's format.
    pub public_key: Option<&'a Utf8Path>,
    /// A station file that should be the one of the run, with the calibration that it names.
    pub station: Option<&'a Utf8Path>,
}

/// Verifies the run directory.
///
/// # Errors
/// Bad input (exit 2) for what is no run or no key; exit 3 for a run that another process is writing, and when the disk
/// refuses. A file that differs is no error: [`Verification::agrees`] says so.
pub fn run(request: &VerifyRequest<'_>, progress: &dyn Progress) -> Result<Verification, Failure> {
    verified(request, true, progress)
}

/// Verifies; without what an earlier signature says, unless `listed`.
fn verified(request: &VerifyRequest<'_>, listed: bool, progress: &dyn Progress) -> Result<Verification, Failure> {
    let run = request.run;
    if !run.join("run.toml").is_file()
        && let Err(error @ RunError::NoRun { .. }) = RunHeader::read(run)
    {
        return Err(Failure::bad_input(error));
    }
    if let Some(held) = RunLock::held(run) {
        return Err(
            Failure::instrument(format!("{run} is in use by {held}: its record is not complete"))
                .help("wait until it ends"),
        );
    }
    let public_key = request.public_key.map(signature::public_key).transpose()?;
    let mut ledger = Ledger::of(run)?;
    let recorded = record::check(run, &mut ledger)?;
    let header = recorded.as_ref().map(|run| &run.header);
    if let Some(station) = request.station {
        outside::check(station, header, &mut ledger)?;
    }
    let folders = results::folders(&ledger);
    let mut reduced_by = Vec::new();
    for folder in folders {
        reduced_by.extend(results::check(run, recorded.as_ref(), &folder, &mut ledger, progress)?);
    }
    let mut signed = None;
    if listed {
        signed = signature::check(run, public_key.as_ref(), &mut ledger)?;
        let by_this_key = signed.as_ref().is_some_and(|signed| signed.by_this_key);
        manifest::check(run, by_this_key, &mut ledger)?;
    }
    Ok(ledger.verdict(
        run,
        PROGRAM,
        header.map(|header| header.program.clone()),
        reduced_by,
        signed,
    ))
}

/// Verifies the run directory and, where nothing differs, writes the list of its files with their SHA-256 and the
/// signature of that list. `password` is asked for where the key has one.
///
/// # Errors
/// As [`run()`]; "no" (exit 1) where something differs, and nothing is written then; bad input (exit 2) for a key that
/// cannot be used, and for a signature that exists and may not be replaced.
pub fn sign(
    request: &VerifyRequest<'_>,
    key: &Utf8Path,
    password: &dyn Fn() -> Result<String, Failure>,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<(Verification, Utf8PathBuf), Failure> {
    let target = request.run.join(SIGNATURE);
    files::refuse_existing(&target, overwrite)?;
    let key = signature::secret_key(key, password)?;
    // What an earlier signature lists is of an earlier state of the run; it stays until this one takes its place.
    let verification = verified(request, false, progress)?;
    if !verification.agrees {
        return Ok((verification, target));
    }
    let listed = manifest::write(request.run)?;
    signature::write(&target, &listed, &key, &verification)?;
    Ok((
        self::run(
            &VerifyRequest {
                public_key: None,
                ..request.clone()
            },
            progress,
        )?,
        target,
    ))
}
