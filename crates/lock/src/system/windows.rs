//! A file that is open for writing and lets nobody else write.
//!
//! The lock of Windows on the bytes of a file (`LockFileEx`) would keep everybody from reading who holds it. A file
//! that is opened without sharing its writing does not: others read it, and who opens it to write is refused
//! (ERROR_SHARING_VIOLATION) until the process has ended, however it ended. Its deletion is shared, so that it can be
//! replaced under its holder.

use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::os::windows::fs::{FileExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

/// Constants of `CreateFileW`.
const FILE_SHARE_READ: u32 = 0x1;
const FILE_SHARE_DELETE: u32 = 0x4;
const FILE_FLAG_OPEN_REPARSE_POINT: u32 = 0x0020_0000;

const ERROR_SHARING_VIOLATION: i32 = 32;
const ERROR_HANDLE_EOF: i32 = 38;

/// For a file that is opened to be locked, which opening it does; a link is not followed.
pub(crate) fn for_owner(options: &mut OpenOptions) -> &mut OpenOptions {
    for_reader(options).share_mode(FILE_SHARE_READ | FILE_SHARE_DELETE)
}

/// For a file that is only looked at: lets others read, write and delete it.
pub(crate) fn for_reader(options: &mut OpenOptions) -> &mut OpenOptions {
    options.custom_flags(FILE_FLAG_OPEN_REPARSE_POINT)
}

/// A file that was opened [`for_owner`] is locked.
#[expect(clippy::unnecessary_wraps, reason = "other systems lock here")]
pub(crate) fn try_lock(_: &File) -> Result<(), TryLockError> {
    Ok(())
}

/// Whether a file could not be opened because another process has locked it, or looks at it in this moment.
pub(crate) fn is_held(error: &io::Error) -> bool {
    error.raw_os_error() == Some(ERROR_SHARING_VIOLATION)
}

/// The file at `path`, and whether it could be locked.
pub(crate) fn look(path: &Path) -> Option<(File, Result<(), TryLockError>)> {
    match for_owner(OpenOptions::new().read(true)).open(path) {
        Ok(file) => Some((file, Ok(()))),
        Err(error) if is_held(&error) => {
            let file = for_reader(OpenOptions::new().read(true)).open(path).ok()?;
            Some((file, Err(TryLockError::WouldBlock)))
        }
        Err(_) => None,
    }
}

/// The folder gives the rights: [`shared_folder`].
#[expect(clippy::unnecessary_wraps, reason = "other systems set permissions here")]
pub(crate) fn for_everybody(_: &File) -> io::Result<()> {
    Ok(())
}

/// The standard library does not say it on this system; a file that has them and begins as a lock file does would be
/// taken for one.
pub(crate) fn has_more_names(_: &Metadata) -> bool {
    false
}

/// Whether `file` is what stands at `path`: no two locks write the same text.
pub(crate) fn is_at(file: &File, path: &Path) -> bool {
    let Ok(there) = for_reader(OpenOptions::new().read(true)).open(path) else {
        return false;
    };
    matches!((crate::lock::read(file), crate::lock::read(&there)), (Ok(ours), Ok(there)) if ours == there)
}

/// Writes at a place of its own, not where another thread left the file.
pub(crate) fn write_at_start(file: &File, bytes: &[u8]) -> io::Result<()> {
    let mut written = 0;
    while written < bytes.len() {
        match file.seek_write(&bytes[written..], written as u64)? {
            0 => return Err(io::ErrorKind::WriteZero.into()),
            count => written += count,
        }
    }
    Ok(())
}

/// Fills `bytes`.
pub(crate) fn read_at_start(file: &File, bytes: &mut [u8]) -> io::Result<()> {
    let mut read = 0;
    while read < bytes.len() {
        match file.seek_read(&mut bytes[read..], read as u64) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => read += count,
            Err(error) if error.raw_os_error() == Some(ERROR_HANDLE_EOF) => {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Name of this computer.
pub(crate) fn host() -> String {
    std::env::var("COMPUTERNAME").unwrap_or_default()
}

/// No process can ask another to end, as Ctrl-C would, unless both have the same console.
pub(crate) fn ask_to_end(pid: u32) -> Result<(), String> {
    Err(format!(
        "Windows has no signal that asks a process to end; press Ctrl-C in the window of process {pid}"
    ))
}

/// The folder of the files that all users share; nothing where the system names none.
pub(crate) fn shared_folder() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("PUBLIC")?);
    folder.is_dir().then_some(folder)
}
