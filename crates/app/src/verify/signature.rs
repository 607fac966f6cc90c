//! The signature of a run in minisign's format: of `SHA256SUMS`, which holds every file's SHA-256. The official program
//! checks it too: `minisign -V -m SHA256SUMS -p KEY.pub`.

use std::io::Cursor;
use std::ops::Range;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use camino::Utf8Path;
use isolux_record::document::read_text;
use jiff::Timestamp;
use minisign::{PublicKey, SecretKey, SecretKeyBox, SignatureBox};

use super::ledger::{Ledger, SIGNATURE};
use super::verification::{Signed, Verification};
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::run::record::SUMS;

/// Bytes of a secret key that name the function which makes a key of a password: `Sc`, or two zeros without one.
const PASSWORD: Range<usize> = 2..4;

/// Bytes of a secret key with its own checksum.
const CHECKSUM: Range<usize> = 126..158;

/// The public key in `file`.
///
/// # Errors
/// Bad input (exit 2).
pub(super) fn public_key(file: &Utf8Path) -> Result<PublicKey, Failure> {
    let text = read_text(file).map_err(Failure::bad_input)?;
    let key = minisign::PublicKeyBox::from_string(&text).and_then(minisign::PublicKeyBox::into_public_key);
    key.map_err(|error| {
        Failure::bad_input(format!("{file}: no public key of minisign: {error}"))
            .help("give the file that `minisign -G` has written with the extension .pub")
    })
}

/// The secret key in `file`; `password` is asked for where it has one.
///
/// # Errors
/// Bad input (exit 2); what `password` answers.
pub(super) fn secret_key(
    file: &Utf8Path,
    password: &dyn Fn() -> Result<String, Failure>,
) -> Result<SecretKey, Failure> {
    let text = read_text(file).map_err(Failure::bad_input)?;
    let wrong = |error: minisign::PError| {
        Failure::bad_input(format!("{file}: no secret key of minisign that can be used: {error}"))
            .help("give the file that `minisign -G` has written with the extension .key")
    };
    let bytes = text.lines().nth(1).and_then(|line| STANDARD.decode(line.trim()).ok());
    let bytes = bytes.unwrap_or_default();
    let key = match (bytes.get(PASSWORD), bytes.get(CHECKSUM)) {
        (Some(b"Sc"), _) => SecretKeyBox::from(text).into_secret_key(Some(password()?)),
        // `minisign -G -W` of version 0.11 leaves the checksum out; signing checks the key by its public half.
        (_, Some(sum)) if sum.iter().all(|byte| *byte == 0) => SecretKey::from_bytes(&bytes),
        _ => SecretKeyBox::from(text).into_unencrypted_secret_key(),
    };
    key.map_err(wrong)
}

/// Writes the signature of `listed`, the bytes of the list.
///
/// # Errors
/// Exit 3 when the system gives no random numbers or the disk refuses.
pub(super) fn write(
    target: &Utf8Path,
    listed: &[u8],
    key: &SecretKey,
    verification: &Verification,
) -> Result<(), Failure> {
    let public = PublicKey::from_secret_key(key).map_err(Failure::bad_input)?;
    let now = Timestamp::now();
    let comment = format!(
        "timestamp:{}\tfile:{SUMS}\tverified and signed {:.0} by {}",
        now.as_second(),
        now,
        verification.verified_by
    );
    let signature = minisign::sign(
        Some(&public),
        key,
        Cursor::new(listed),
        Some(&comment),
        Some("signature of a run directory of isolux"),
    )
    .map_err(Failure::instrument)?;
    files::write(target, signature.into_string().as_bytes(), Overwrite::Force)
}

/// Looks at the signature of the list, and checks it where a public key was given.
///
/// # Errors
/// Bad input (exit 2) for a file that cannot be read.
pub(super) fn check(
    run: &Utf8Path,
    public_key: Option<&PublicKey>,
    ledger: &mut Ledger,
) -> Result<Option<Signed>, Failure> {
    let (file, list) = (run.join(SIGNATURE), run.join(SUMS));
    if !file.is_file() {
        if public_key.is_some() {
            ledger.differs(SIGNATURE, None, "is missing: the run is not signed");
        }
        return Ok(None);
    }
    let text = String::from_utf8_lossy(&files::read(&file)?).into_owned();
    let signature = match parsed(&text) {
        Ok(signature) => signature,
        Err(what) => {
            ledger.differs(SIGNATURE, None, format!("is no signature of minisign: {what}"));
            return Ok(None);
        }
    };
    let mut signed = Signed {
        key: number(signature.keynum()),
        comment: signature.trusted_comment().unwrap_or_default(),
        by_this_key: false,
    };
    let Some(public_key) = public_key else {
        ledger.unchecked(SIGNATURE, "no public key was given: --public-key KEY.pub");
        return Ok(Some(signed));
    };
    let list = if list.is_file() {
        files::read(&list)?
    } else {
        Vec::new()
    };
    match minisign::verify(public_key, &signature, Cursor::new(list), true, false, true) {
        Ok(()) => {
            signed.by_this_key = true;
            let because = format!("the signature of the key {}", signed.key);
            ledger.agrees(SUMS, because.clone());
            ledger.agrees(
                SIGNATURE,
                format!("{because}; its first line is a comment that no signature covers"),
            );
        }
        Err(error) => ledger.differs(
            SIGNATURE,
            None,
            format!(
                "is not the signature of this SHA256SUMS by the key {}: {error}",
                number(public_key.keynum())
            ),
        ),
    }
    Ok(Some(signed))
}

/// A signature whose parts are as long as they have to be: the library takes that for granted.
fn parsed(text: &str) -> Result<SignatureBox, String> {
    /// 64 bytes in base 64.
    const GLOBAL: usize = 88;
    match text.lines().nth(3) {
        Some(line) if line.trim().len() == GLOBAL => SignatureBox::from_string(text).map_err(|error| error.to_string()),
        _ => Err("its fourth line is no signature".to_owned()),
    }
}

/// The number of a key as minisign prints it.
fn number(key: &[u8]) -> String {
    hex::encode_upper(key.iter().rev().copied().collect::<Vec<u8>>())
}
