//! The documentation holds together: every page of the book is in its summary, every relative link leads somewhere.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// Targets of `[text](target)` outside of code, without anchors, web addresses left out.
fn links(markdown: &str) -> Vec<String> {
    let mut links = Vec::new();
    let mut fenced = false;
    for line in markdown.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if fenced || line.starts_with("    ") {
            continue;
        }
        for (at, _) in line.match_indices("](") {
            let target = line[at + 2..].split(')').next().unwrap_or_default();
            let target = target.split('#').next().unwrap_or_default();
            if !target.is_empty() && !target.contains("://") {
                links.push(target.to_owned());
            }
        }
    }
    links
}

fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.sort();
    pages
}

#[test]
fn every_relative_link_leads_somewhere() {
    let root = root();
    let mut files: Vec<PathBuf> = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"]
        .iter()
        .map(|name| root.join(name))
        .collect();
    for folder in ["docs", "docs/src", "docs/decisions"] {
        files.extend(pages(&root.join(folder)));
    }
    let dead: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let text = std::fs::read_to_string(file).unwrap();
            let folder = file.parent().unwrap().to_owned();
            let name = file.strip_prefix(&root).unwrap().display().to_string();
            links(&text)
                .into_iter()
                .filter(move |link| !folder.join(link).exists())
                .map(move |link| format!("{name} → {link}"))
        })
        .collect();
    assert!(dead.is_empty(), "links that lead nowhere: {dead:#?}");
}

#[test]
fn every_file_that_a_page_includes_is_there() {
    let folder = root().join("docs/src");
    let mut included = 0;
    for page in pages(&folder) {
        let text = std::fs::read_to_string(&page).unwrap();
        for part in text.split("{{#include ").skip(1) {
            let path = part.split("}}").next().unwrap_or_default();
            assert!(folder.join(path).is_file(), "{}: {path}", page.display());
            included += 1;
        }
    }
    assert!(
        included > 0,
        "no page includes a file: is the form of the directive another one?"
    );
}

#[test]
fn every_page_of_the_book_is_in_its_summary() {
    let folder = root().join("docs/src");
    let summary = std::fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<String> = links(&summary).into_iter().collect();
    let missing: Vec<String> = pages(&folder)
        .iter()
        .map(|page| page.file_name().unwrap().to_string_lossy().into_owned())
        .filter(|page| page != "SUMMARY.md" && !listed.contains(page))
        .collect();
    assert!(missing.is_empty(), "pages that no reader finds: {missing:?}");
}
