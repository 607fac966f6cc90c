//! One writer a run directory, across processes.

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_lock::{Held, Lock, LockError};

use crate::disk;

/// Name of the lock file in a run directory. It is removed when its holder ends; one that is left behind by a process
/// that was killed locks nothing.
pub(crate) const LOCK_FILE: &str = ".lock";

/// Why a run directory could not be locked.
#[derive(Debug, thiserror::Error)]
pub enum RunLockError {
    /// Another process writes it.
    #[error("{path} is in use by {held}")]
    InUse {
        /// The folder.
        path: Utf8PathBuf,
        /// Who writes it.
        held: Held,
    },
    /// The folder could not be made, or not locked.
    #[error("{path}: {message}")]
    Refused {
        /// The folder.
        path: Utf8PathBuf,
        /// What the system said.
        message: String,
    },
}

/// This process is the one that writes a run directory, until the last clone is dropped.
#[derive(Debug, Clone)]
pub struct RunLock(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    path: Utf8PathBuf,
    lock: Option<Lock>,
    /// The folder was made for the lock.
    made: bool,
}

impl RunLock {
    /// Name of the lock file in a run directory.
    pub const FILE: &str = LOCK_FILE;

    /// Locks the run directory `path`, which is made where there is none. With `force` also from a process that gave no
    /// sign of life for a while; that process, if there was one.
    ///
    /// # Errors
    /// [`RunLockError`].
    pub fn take(path: &Utf8Path, force: bool) -> Result<(Self, Option<Held>), RunLockError> {
        let refused = |error: &dyn std::fmt::Display| RunLockError::Refused {
            path: path.to_owned(),
            message: error.to_string(),
        };
        let made = !path.is_dir();
        if made {
            disk::create_folder(path).map_err(|error| refused(&error))?;
        }
        let file = path.join(LOCK_FILE);
        let file = file.as_std_path();
        let taken = if force {
            Lock::take_over(file)
        } else {
            Lock::take(file).map(|lock| (lock, None))
        };
        match taken {
            Ok((lock, from)) => {
                let (path, lock) = (path.to_owned(), Some(lock));
                Ok((Self(Arc::new(Inner { path, lock, made })), from))
            }
            Err(LockError::Held(held)) => Err(RunLockError::InUse {
                path: path.to_owned(),
                held,
            }),
            Err(error) => Err(refused(&error)),
        }
    }

    /// Who writes the run directory `path` now; none where nobody does.
    pub fn held(path: &Utf8Path) -> Option<Held> {
        Lock::held(path.join(LOCK_FILE).as_std_path())
    }

    /// The folder.
    pub fn path(&self) -> &Utf8Path {
        &self.0.path
    }

    /// Whether this process still is the one that writes it: not once another has taken it over.
    pub fn is_ours(&self) -> bool {
        self.0.lock.as_ref().is_some_and(Lock::is_ours)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        drop(self.lock.take());
        if self.made {
            // Succeeds for an empty folder alone: nothing came of the run.
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_writes_a_run_and_what_came_to_nothing_leaves_no_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().join("run")).unwrap();
        let (lock, from) = RunLock::take(&path, false).unwrap();
        assert!(from.is_none() && lock.is_ours());
        for force in [false, true] {
            let error = RunLock::take(&path, force).unwrap_err();
            assert!(matches!(error, RunLockError::InUse { .. }), "its holder works");
            assert!(
                error.to_string().contains(&format!("pid {}", std::process::id())),
                "{error}"
            );
        }
        let clone = lock.clone();
        drop(lock);
        assert!(RunLock::held(&path).is_some() && clone.is_ours());
        drop(clone);
        assert!(!path.exists());
        let (lock, _) = RunLock::take(&path, false).unwrap();
        std::fs::write(path.join("run.toml"), "").unwrap();
        drop(lock);
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 1);
    }
}
