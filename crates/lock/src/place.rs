//! Where locks of what belongs to the whole computer lie.

use std::path::{Path, PathBuf};

/// The folder that all users of this computer share. It does not depend on who asks: root and everybody else must meet
/// there, so neither the user's own temporary folder nor what one of them happens to be able to write decides.
pub fn shared_folder() -> PathBuf {
    ["/run/lock", "/var/lock", "/tmp"]
        .into_iter()
        .map(Path::new)
        .find(|folder| everybody_may_write(folder))
        .map_or_else(std::env::temp_dir, Path::to_owned)
}

/// The name of the lock file of `thing`, the same for everybody who means that thing.
pub fn file_name(thing: &str) -> String {
    let mut name = "isolux.".to_owned();
    for byte in thing.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'-' => name.push(char::from(byte)),
            other => name.push_str(&format!("%{other:02x}")),
        }
    }
    name + ".lock"
}

/// Whether all may make files there, and none may remove those of others (the sticky bit).
#[cfg(unix)]
fn everybody_may_write(folder: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::metadata(folder).is_ok_and(|data| data.is_dir() && data.permissions().mode() & 0o1002 == 0o1002)
}

#[cfg(not(unix))]
fn everybody_may_write(_: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_files_in_the_folder_and_differ_where_the_things_differ() {
        let things = [
            "serial:/dev/ttyUSB0",
            "serial:/dev/tty_USB0",
            "tcp:localhost:4001",
            "../../etc/passwd",
        ];
        let names: std::collections::BTreeSet<_> = things.map(file_name).into();
        assert_eq!(names.len(), things.len());
        assert!(names.iter().all(|name| !name.contains('/')), "{names:?}");
        assert!(shared_folder().is_dir());
    }
}
