//! A lock of the kernel on the open file (`flock`), which asks nobody who does not ask for it.

use std::fs::{File, Metadata, OpenOptions, Permissions, TryLockError};
use std::io;
use std::os::unix::fs::{FileExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::Path;

use rustix::fs::OFlags;

/// For a file that is opened to be locked: a link is not followed, and a pipe that somebody put there does not wait for
/// its other end.
pub(crate) fn for_owner(options: &mut OpenOptions) -> &mut OpenOptions {
    for_reader(options)
}

/// For a file that is only looked at.
pub(crate) fn for_reader(options: &mut OpenOptions) -> &mut OpenOptions {
    options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
}

/// Locks a file that was opened [`for_owner`].
pub(crate) fn try_lock(file: &File) -> Result<(), TryLockError> {
    file.try_lock()
}

/// Whether a file could not be opened because another process has locked it: never, a lock does not concern opening.
pub(crate) fn is_held(_: &io::Error) -> bool {
    false
}

/// The file at `path`, and whether it could be locked.
pub(crate) fn look(path: &Path) -> Option<(File, Result<(), TryLockError>)> {
    let file = for_reader(OpenOptions::new().read(true)).open(path).ok()?;
    let locked = file.try_lock_shared();
    Some((file, locked))
}

/// The next user of this computer must be able to lock the file, whatever the umask of this one is.
pub(crate) fn for_everybody(file: &File) -> io::Result<()> {
    file.set_permissions(Permissions::from_mode(0o666))
}

/// Whether a file has more names than the one that it was opened by. None is left of one that was removed since, which
/// the caller finds out.
pub(crate) fn has_more_names(data: &Metadata) -> bool {
    data.nlink() > 1
}

/// Whether `file` is what stands at `path`.
pub(crate) fn is_at(file: &File, path: &Path) -> bool {
    let (Ok(ours), Ok(there)) = (file.metadata(), std::fs::symlink_metadata(path)) else {
        return false;
    };
    (ours.dev(), ours.ino()) == (there.dev(), there.ino())
}

/// Writes without moving the place where another thread reads.
pub(crate) fn write_at_start(file: &File, bytes: &[u8]) -> io::Result<()> {
    file.write_all_at(bytes, 0)
}

/// Fills `bytes`.
pub(crate) fn read_at_start(file: &File, bytes: &mut [u8]) -> io::Result<()> {
    file.read_exact_at(bytes, 0)
}

/// Name of this computer.
pub(crate) fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

/// Sends SIGTERM.
pub(crate) fn ask_to_end(pid: u32) -> Result<(), String> {
    use rustix::process::{Pid, Signal, kill_process};
    let process = i32::try_from(pid).ok().and_then(Pid::from_raw);
    let process = process.ok_or_else(|| format!("{pid} is no process number"))?;
    kill_process(process, Signal::TERM).map_err(|error| error.to_string())
}

/// The first of the folders where all may make files, and none may remove those of others (the sticky bit).
pub(crate) fn shared_folder() -> Option<&'static Path> {
    let everybody_may_write = |folder: &&Path| {
        std::fs::metadata(folder).is_ok_and(|data| data.is_dir() && data.permissions().mode() & 0o1002 == 0o1002)
    };
    ["/run/lock", "/var/lock", "/tmp"]
        .into_iter()
        .map(Path::new)
        .find(everybody_may_write)
}
