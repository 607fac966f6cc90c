//! Where locks of what belongs to the whole computer lie.

use std::path::PathBuf;

use crate::system;

/// The folder that all users of this computer share. It does not depend on who asks: root and everybody else must meet
/// there, so neither the user's own temporary folder nor what one of them happens to be able to write decides.
pub fn shared_folder() -> PathBuf {
    system::shared_folder().map_or_else(std::env::temp_dir, Into::into)
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
