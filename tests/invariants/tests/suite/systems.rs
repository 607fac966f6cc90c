//! What the program does on Unix alone it does in another way, or refuses, on Windows: beside each other, in one file.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::path::{Path, PathBuf};

/// Of what stands for Unix, what stands for the rest.
const PAIRS: [(&str, &[&str]); 2] = [
    ("#[cfg(unix)]", &["#[cfg(not(unix))]", "#[cfg(windows)]"]),
    ("#[cfg_attr(unix, path", &["#[cfg_attr(windows, path"]),
];

/// The Rust files in a folder and below it.
pub fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn what_is_for_unix_alone_has_its_counterpart() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for members in ["crates", "protocols", "drivers"] {
        for member in std::fs::read_dir(root.join(members)).unwrap() {
            let source = member.unwrap().path().join("src");
            if source.is_dir() {
                sources(&source, &mut files);
            }
        }
    }
    let mut seen = 0;
    let mut alone = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        // What follows is the file's own tests.
        let program = text.split("\n#[cfg(test)]").next().unwrap_or_default();
        for (unix, others) in PAIRS {
            if program.contains(unix) {
                seen += 1;
                if !others.iter().any(|other| program.contains(other)) {
                    alone.push(format!("{}: {unix}", file.display()));
                }
            }
        }
    }
    assert!(alone.is_empty(), "without a branch for Windows: {alone:#?}");
    assert!(seen >= 4, "is it written in another way now?");
}
