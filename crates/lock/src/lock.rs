//! The lock itself: taking it, keeping it, losing it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, SystemTime};

use crate::holder::{FORMAT_LINE, Holder, ProcessState};
use crate::system;

/// How often a holder gives a sign of life.
const SIGN_EVERY: Duration = Duration::from_secs(1);

/// A holder that gave no sign of life for so long does not answer.
pub const SILENT_AFTER: Duration = Duration::from_secs(5);

/// A holder may be in the middle of writing its name, and a look at a lock holds it for a moment.
const TRIES: u32 = 10;
const BETWEEN_TRIES: Duration = Duration::from_millis(10);

/// More than any lock file of this program.
const LONGEST: u64 = 64 << 10;

/// A lock that this process holds, until it is dropped or somebody takes it over.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: File,
    /// What the file says as long as it is ours.
    text: String,
    /// Ends the thread that gives signs of life.
    _alive: Sender<()>,
}

/// A lock that another process holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Held {
    /// Who; none where it does not say.
    pub holder: Option<Holder>,
    /// Since when it gave no sign of life.
    pub silent: Duration,
}

impl Held {
    /// Whether the holder is there and works: only `stop` may pass it.
    pub fn works(&self) -> bool {
        self.silent < SILENT_AFTER
    }
}

impl std::fmt::Display for Held {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.holder {
            Some(holder) => write!(f, "{holder}")?,
            None => f.write_str("a process that does not say who it is")?,
        }
        if !self.works() {
            write!(f, ", which gave no sign of life for {} s", self.silent.as_secs())?;
        }
        Ok(())
    }
}

/// Why a lock could not be taken.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Somebody else has it.
    #[error("in use by {0}")]
    Held(Held),
    /// Something else stands where the lock file belongs.
    #[error("{path} is no lock file of this program; remove it", path = path.display())]
    NotALock {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot lock {path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl Lock {
    /// Takes the lock at `path`, or says at once who has it. What a process that is gone has left is no hindrance.
    ///
    /// # Errors
    /// [`LockError`].
    pub fn take(path: &Path) -> Result<Self, LockError> {
        let io = |source| LockError::Io {
            path: path.to_owned(),
            source,
        };
        let mut tries = 0;
        loop {
            let held = match open(path) {
                Ok((file, made_now)) => match system::try_lock(&file) {
                    Ok(()) if system::is_at(&file, path) => return Self::begin(path, file, own_text()).map_err(io),
                    // The former holder has removed the file in between.
                    Ok(()) => None,
                    Err(TryLockError::WouldBlock) => Some(held(&file)),
                    // A file system without locks: whoever made the file has it, and what a dead process left has to
                    // be taken over by a person.
                    Err(TryLockError::Error(_)) if made_now => return Self::begin(path, file, own_text()).map_err(io),
                    Err(TryLockError::Error(_)) => return Err(LockError::Held(held(&file))),
                },
                Err(LockError::Held(held)) => Some(held),
                Err(error) => return Err(error),
            };
            tries += 1;
            if let Some(held) = held {
                // A process of which nothing is known may have ended, and the lock be that of a look at it.
                let known = held
                    .holder
                    .as_ref()
                    .is_some_and(|holder| matches!(holder.state(), ProcessState::Runs | ProcessState::Stopped));
                if known || tries >= TRIES {
                    return Err(LockError::Held(held));
                }
            } else if tries >= TRIES {
                return Err(io(io::Error::other("the file changes all the time")));
            }
            std::thread::sleep(BETWEEN_TRIES);
        }
    }

    /// As [`take`](Self::take), also from a holder that gave no sign of life for [`SILENT_AFTER`]; that holder, if
    /// there was one.
    ///
    /// # Errors
    /// [`LockError::Held`] when the holder works.
    pub fn take_over(path: &Path) -> Result<(Self, Option<Held>), LockError> {
        match Self::take(path) {
            Ok(lock) => Ok((lock, None)),
            Err(LockError::Held(held)) if !held.works() => Ok((Self::replace(path)?, Some(held))),
            Err(error) => Err(error),
        }
    }

    /// Takes the lock from whoever has it, even from a process that works: for stopping what moves, and nothing else.
    ///
    /// # Errors
    /// What the system says.
    pub fn seize(path: &Path) -> Result<Self, LockError> {
        match Self::take(path) {
            Err(LockError::Held(_)) => Self::replace(path),
            other => other,
        }
    }

    /// Who holds the lock at `path` now; none where it is free.
    pub fn held(path: &Path) -> Option<Held> {
        let (file, locked) = system::look(path)?;
        match locked {
            Ok(()) => None,
            Err(TryLockError::WouldBlock) => Some(held(&file)),
            Err(TryLockError::Error(_)) => Some(held(&file)).filter(|held| held.holder.is_some()),
        }
    }

    /// Whether this process still holds it. It does not once another has replaced the file or written its own name into
    /// it: then nothing that the lock stands for may be touched any more.
    pub fn is_ours(&self) -> bool {
        system::is_at(&self.file, &self.path) && read(&self.file).is_ok_and(|text| text == self.text)
    }

    /// Who has taken it over from this process, as far as that can be known.
    pub fn taken_by(&self) -> Option<Holder> {
        let file = system::for_reader(OpenOptions::new().read(true))
            .open(&self.path)
            .ok()?;
        Holder::parse(&read(&file).ok()?)
    }

    /// A new file in place of the one that another process has locked.
    fn replace(path: &Path) -> Result<Self, LockError> {
        let io = |source| LockError::Io {
            path: path.to_owned(),
            source,
        };
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{}", std::process::id()));
        let new = PathBuf::from(name);
        let _ = std::fs::remove_file(&new);
        let (file, _) = open(&new)?;
        match system::try_lock(&file) {
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => return Err(LockError::Held(held(&file))),
        }
        // Named before it is in place, so that nobody finds it nameless.
        let text = own_text();
        let renamed = write(&file, &text).and_then(|()| std::fs::rename(&new, path));
        if let Err(error) = renamed {
            let _ = std::fs::remove_file(&new);
            // In the shared folder only its owner and root may replace a file, but everybody may write to it.
            return if error.kind() == io::ErrorKind::PermissionDenied {
                Self::overwrite(path)
            } else {
                Err(io(error))
            };
        }
        Self::begin(path, file, text).map_err(io)
    }

    /// Writes the name of this process over that of the holder, who finds by it that it has lost the lock.
    fn overwrite(path: &Path) -> Result<Self, LockError> {
        let (file, _) = open(path)?;
        Self::begin(path, file, own_text()).map_err(|source| LockError::Io {
            path: path.to_owned(),
            source,
        })
    }

    fn begin(path: &Path, file: File, text: String) -> io::Result<Self> {
        write(&file, &text)?;
        let (alive, end) = channel::<()>();
        let sign = file.try_clone()?;
        std::thread::spawn(move || {
            while end.recv_timeout(SIGN_EVERY) == Err(RecvTimeoutError::Timeout) {
                let _ = system::write_at_start(&sign, &FORMAT_LINE.as_bytes()[..1]);
            }
        });
        Ok(Self {
            path: path.to_owned(),
            file,
            text,
            _alive: alive,
        })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.is_ours() {
            // Of another user's file in the shared folder the name alone can be removed.
            if std::fs::remove_file(&self.path).is_err() {
                let _ = self.file.set_len(0);
            }
        }
        let _ = self.file.unlock();
    }
}

/// Opens the lock file, or makes it; the second says whether it was made now.
///
/// No link is followed, and nothing that is not a lock file is ever written to: in a folder where all may write,
/// somebody may have put a trap. `O_CREAT` is used for a new file alone, because Linux refuses it on an existing file
/// of another user there (fs.protected_regular), even to root.
fn open(path: &Path) -> Result<(File, bool), LockError> {
    let io = |source| LockError::Io {
        path: path.to_owned(),
        source,
    };
    for _ in 0..TRIES {
        let mut options = OpenOptions::new();
        match system::for_owner(options.read(true).write(true)).open(path) {
            Ok(file) => {
                if !is_lock_file(&file).map_err(io)? {
                    return Err(LockError::NotALock { path: path.to_owned() });
                }
                return Ok((file, false));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) if system::is_held(&error) => return Err(LockError::Held(held_at(path))),
            // ELOOP: a link stands there.
            Err(_) if path.is_symlink() => return Err(LockError::NotALock { path: path.to_owned() }),
            Err(error) => return Err(io(error)),
        }
        let mut options = OpenOptions::new();
        match system::for_owner(options.read(true).write(true).create_new(true)).open(path) {
            Ok(file) => {
                system::for_everybody(&file).map_err(io)?;
                return Ok((file, true));
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(io(error)),
        }
    }
    Err(io(io::Error::other("the file comes and goes")))
}

/// A regular file with one name that is empty or begins as a lock file does.
fn is_lock_file(file: &File) -> io::Result<bool> {
    let data = file.metadata()?;
    if system::has_more_names(&data) || !data.is_file() || data.len() > LONGEST {
        return Ok(false);
    }
    let text = read(file).unwrap_or_default();
    let format = FORMAT_LINE.as_bytes();
    let common = text.len().min(format.len());
    Ok(text.as_bytes()[..common] == format[..common])
}

/// What the lock file of this process says: no other lock, of this process or another, says the same.
fn own_text() -> String {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("{}# lock {number} of this process\n", Holder::this_process().to_text())
}

fn held_at(path: &Path) -> Held {
    let file = system::for_reader(OpenOptions::new().read(true)).open(path);
    file.map_or_else(
        |_| Held {
            holder: None,
            silent: Duration::ZERO,
        },
        |file| held(&file),
    )
}

fn held(file: &File) -> Held {
    let modified = file.metadata().and_then(|data| data.modified()).ok();
    Held {
        holder: read(file).ok().and_then(|text| Holder::parse(&text)),
        // A clock that was set back makes no sign of life old.
        silent: modified
            .and_then(|then| SystemTime::now().duration_since(then).ok())
            .unwrap_or_default(),
    }
}

fn write(file: &File, text: &str) -> io::Result<()> {
    file.set_len(0)?;
    system::write_at_start(file, text.as_bytes())
}

/// What a lock file says.
pub(crate) fn read(file: &File) -> io::Result<String> {
    let mut bytes = vec![0; file.metadata()?.len().min(LONGEST) as usize];
    system::read_at_start(file, &mut bytes)?;
    String::from_utf8(bytes).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.lock");
        (folder, path)
    }

    fn make_old(path: &Path) {
        let mut options = OpenOptions::new();
        options.write(true);
        #[cfg(windows)]
        // FILE_WRITE_ATTRIBUTES alone, which nobody who holds a file can keep to himself.
        std::os::windows::fs::OpenOptionsExt::access_mode(&mut options, 0x100);
        let file = options.open(path).unwrap();
        file.set_modified(SystemTime::now() - 2 * SILENT_AFTER).unwrap();
    }

    #[test]
    fn one_holds_it_and_the_next_is_told_who() {
        let (_keep, path) = scratch();
        let first = Lock::take(&path).unwrap();
        let Err(LockError::Held(held)) = Lock::take(&path) else {
            panic!("held twice");
        };
        assert_eq!(held.holder.as_ref().unwrap().pid, std::process::id());
        assert!(held.works());
        assert_eq!(Lock::held(&path).unwrap().holder, held.holder);
        assert!(
            matches!(Lock::take_over(&path), Err(LockError::Held(_))),
            "its holder works"
        );
        assert!(first.is_ours());
        drop(first);
        assert_eq!(Lock::held(&path), None);
        assert!(!path.exists());
        Lock::take(&path).unwrap();
    }

    #[test]
    fn what_a_dead_process_left_is_no_hindrance() {
        let (_keep, path) = scratch();
        let dead = Holder {
            process_start: Some(1),
            ..Holder::this_process()
        };
        std::fs::write(&path, dead.to_text()).unwrap();
        assert_eq!(Lock::held(&path), None);
        let lock = Lock::take(&path).unwrap();
        assert_eq!(
            lock.taken_by().unwrap().process_start,
            Holder::this_process().process_start
        );
    }

    #[test]
    fn a_silent_holder_loses_it_and_knows() {
        let (_keep, path) = scratch();
        let silent = Lock::take(&path).unwrap();
        make_old(&path);
        let (next, held) = Lock::take_over(&path).unwrap();
        assert!(!held.unwrap().works());
        assert!(!silent.is_ours() && next.is_ours());
        // What the loser does on its way out leaves the new owner's lock alone.
        drop(silent);
        assert!(next.is_ours() && matches!(Lock::take(&path), Err(LockError::Held(_))));
        let stop = Lock::seize(&path).unwrap();
        assert!(stop.is_ours() && !next.is_ours());
    }

    #[cfg(unix)]
    #[test]
    fn a_holder_whose_file_cannot_be_replaced_loses_it_by_what_it_says() {
        let (_keep, path) = scratch();
        let owner = Lock::take(&path).unwrap();
        let stop = Lock::overwrite(&path).unwrap();
        assert!(!owner.is_ours() && stop.is_ours());
        drop(stop);
        assert!(!owner.is_ours());
        drop(owner);
        Lock::take(&path).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_trap_is_not_written_to() {
        let (keep, path) = scratch();
        let precious = keep.path().join("precious");
        std::fs::write(&precious, "mine").unwrap();
        std::os::unix::fs::symlink(&precious, &path).unwrap();
        assert!(matches!(Lock::take(&path), Err(LockError::NotALock { .. })));
        std::fs::remove_file(&path).unwrap();
        std::fs::hard_link(&precious, &path).unwrap();
        assert!(matches!(Lock::take(&path), Err(LockError::NotALock { .. })));
        std::fs::remove_file(&path).unwrap();
        std::fs::copy(&precious, &path).unwrap();
        assert!(matches!(Lock::take(&path), Err(LockError::NotALock { .. })));
        assert_eq!(std::fs::read_to_string(&precious).unwrap(), "mine");
        std::fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink(keep.path().join("nowhere"), &path).unwrap();
        assert!(matches!(Lock::take(&path), Err(LockError::NotALock { .. })));
    }
}
