//! Which programs have a port open, as far as the system says.

/// The processes that have the file at `path` open, as `name (pid N)`: those of this user, or all for root. Empty where
/// the system has no `/proc`.
pub(crate) fn users_of(path: &str) -> Vec<String> {
    let (Ok(real), Ok(processes)) = (std::fs::canonicalize(path), std::fs::read_dir("/proc")) else {
        return Vec::new();
    };
    let numbers = processes
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let has_it_open = |pid: &u32| {
        let files = std::fs::read_dir(format!("/proc/{pid}/fd"));
        let mut links = files.into_iter().flatten().flatten();
        links.any(|link| std::fs::read_link(link.path()).is_ok_and(|target| target == real))
    };
    numbers
        .filter(has_it_open)
        .map(|pid| {
            let name = std::fs::read_to_string(format!("/proc/{pid}/comm"));
            let name = name.unwrap_or_else(|_| "a program".to_owned());
            format!("{} (pid {pid})", name.trim())
        })
        .collect()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn we_have_our_own_file_open() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let users = users_of(file.path().to_str().unwrap());
        let us = format!("(pid {})", std::process::id());
        assert!(users.len() == 1 && users[0].ends_with(&us), "{users:?}");
        assert!(users_of("/no/such/file").is_empty());
    }
}
