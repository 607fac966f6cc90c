//! Invariants of `docs/architecture.md`: who may reach whom, one version of each direct dependency, permissive
//! licences.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, PackageId};

use crate::systems::sources;

/// Crates that hold what is true whatever instrument or screen is used.
const PURE: &[&str] = &[
    "isolux-document",
    "isolux-units",
    "isolux-photometry",
    "isolux-spectrum",
    "isolux-formats",
    "isolux-record",
    "isolux-model",
    "isolux-sim",
    "isolux-reduce",
    "isolux-conformity",
    "isolux-diagnose",
    "isolux-modulation",
];

/// What a pure crate may not reach: drivers, transports, clocks, async runtimes, screens.
const IMPURE: &[&str] = &[
    "isolux-device",
    "isolux-scan",
    "isolux-app",
    "isolux",
    "isolux-page",
    "isolux-transport",
    "isolux-modbus",
    "isolux-axes",
    "isolux-luxmeter",
    "isolux-spectroradiometer",
    "isolux-virtual",
    "isolux-darkroom",
    "tokio",
    "tokio-serial",
    "serialport",
    "rusb",
    "mio",
    "indicatif",
    "crossterm",
    "clap",
    "axum",
    "chrono",
];

/// Licences that may be linked. The one LGPL part, libusb inside `rusb`, is named in NOTICE.
const LICENCES: &[&str] = &[
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "Zlib",
    "Unicode-3.0",
    "MPL-2.0",
    "BSL-1.0",
    "Unlicense",
    "0BSD",
    "CC0-1.0",
];

struct Workspace {
    metadata: Metadata,
}

impl Workspace {
    fn new() -> Self {
        let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
        Self {
            metadata: MetadataCommand::new()
                .manifest_path(manifest)
                .exec()
                .expect("cargo metadata answers"),
        }
    }

    fn package(&self, id: &PackageId) -> &Package {
        self.metadata
            .packages
            .iter()
            .find(|package| &package.id == id)
            .expect("every id has its package")
    }

    fn member(&self, name: &str) -> Option<&Package> {
        self.metadata
            .workspace_packages()
            .into_iter()
            .find(|package| package.name.as_str() == name)
    }

    /// Everything that `start` links, itself included; dev-dependencies count for `start` alone where `dev` says so.
    fn reach(&self, start: &PackageId) -> BTreeSet<&str> {
        let resolve = self.metadata.resolve.as_ref().expect("metadata resolves dependencies");
        let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            let node = resolve
                .nodes
                .iter()
                .find(|node| &node.id == id)
                .expect("every id has its node");
            for dependency in &node.deps {
                let linked = dependency
                    .dep_kinds
                    .iter()
                    .any(|kind| kind.kind == DependencyKind::Normal);
                if linked {
                    open.push(&dependency.pkg);
                }
            }
        }
        seen.into_iter().map(|id| self.package(id).name.as_str()).collect()
    }
}

/// Invariant 1. Broken by: `tokio.workspace = true` in any of the pure crates.
#[test]
fn the_domain_reaches_no_instrument_clock_or_screen() {
    let workspace = Workspace::new();
    let protocols = workspace.metadata.workspace_packages().into_iter().filter(|package| {
        package
            .manifest_path
            .as_str()
            .replace('\\', "/")
            .contains("/protocols/")
    });
    let pure = PURE.iter().filter_map(|name| workspace.member(name)).chain(protocols);
    let mut checked = 0;
    for package in pure {
        let reach = workspace.reach(&package.id);
        let bad: Vec<_> = IMPURE.iter().filter(|name| reach.contains(**name)).collect();
        assert!(bad.is_empty(), "{} reaches {bad:?}", package.name);
        checked += 1;
    }
    assert!(
        checked > PURE.len(),
        "the pure crates and the protocols are there: {checked}"
    );
}

/// Codecs speak wire words alone; they share the trait that says what a codec is, and what all text lines have in
/// common.
#[test]
fn protocols_depend_on_no_crate_of_the_workspace_but_the_conversation() {
    let workspace = Workspace::new();
    for package in workspace.metadata.workspace_packages() {
        if package
            .manifest_path
            .as_str()
            .replace('\\', "/")
            .contains("/protocols/")
        {
            let own: Vec<_> = workspace
                .reach(&package.id)
                .into_iter()
                .filter(|name| name.starts_with("isolux") && *name != package.name.as_str())
                .filter(|name| !["isolux-conversation", "isolux-protocol-ascii"].contains(name))
                .collect();
            assert!(own.is_empty(), "{} depends on {own:?}", package.name);
        }
    }
}

/// Invariant 2: the twins' truth shares no physics with what is tested on it.
#[test]
fn no_driver_reaches_the_model_and_the_darkroom_shares_no_physics() {
    let workspace = Workspace::new();
    let physics = [
        "isolux-model",
        "isolux-sim",
        "isolux-reduce",
        "isolux-diagnose",
        "isolux-photometry",
        "isolux-formats",
        "isolux-modulation",
    ];
    for package in workspace.metadata.workspace_packages() {
        if package.manifest_path.as_str().replace('\\', "/").contains("/drivers/") {
            let reach = workspace.reach(&package.id);
            let bad: Vec<_> = physics.iter().filter(|name| reach.contains(**name)).collect();
            assert!(bad.is_empty(), "{} reaches {bad:?}", package.name);
        }
    }
    for name in ["isolux-darkroom", "isolux-virtual"] {
        let room = workspace
            .member(name)
            .expect("the virtual darkroom is a member of the workspace");
        assert!(
            !workspace.reach(&room.id).contains("isolux-app"),
            "{name} reaches the composition root"
        );
    }
    // The other way round: the diagnosis and its physics may not look at the truth, not even in their tests.
    for name in [
        "isolux-model",
        "isolux-sim",
        "isolux-diagnose",
        "isolux-reduce",
        "isolux-modulation",
    ] {
        let Some(package) = workspace.member(name) else {
            continue;
        };
        let bad = package
            .dependencies
            .iter()
            .find(|d| d.name.contains("darkroom") || d.name.contains("virtual"));
        assert!(bad.is_none(), "{name} names {bad:?}");
    }
}

/// Invariant 3.
#[test]
fn front_ends_reach_the_rest_through_app_alone() {
    let workspace = Workspace::new();
    for (name, reaches) in [
        ("isolux", ["isolux-app", "isolux-page"].as_slice()),
        ("isolux-page", &["isolux-app"]),
        ("isolux-python", &["isolux", "isolux-app"]),
    ] {
        let Some(front) = workspace.member(name) else { continue };
        let own: Vec<_> = front
            .dependencies
            .iter()
            .filter(|d| d.kind == DependencyKind::Normal && d.name.starts_with("isolux"))
            .map(|d| d.name.as_str())
            .collect();
        assert_eq!(own, reaches, "{name}");
    }
}

/// The arrows: photometry, spectrum ← formats ← model ← sim, reduce ← diagnose ← report ← app.
#[test]
fn arrows_point_one_way() {
    let workspace = Workspace::new();
    let forbidden: &[(&str, &[&str])] = &[
        (
            "isolux-units",
            &["isolux-photometry", "isolux-spectrum", "isolux-formats", "isolux-model"],
        ),
        (
            "isolux-photometry",
            &["isolux-spectrum", "isolux-formats", "isolux-model", "isolux-record"],
        ),
        (
            "isolux-spectrum",
            &["isolux-photometry", "isolux-formats", "isolux-model", "isolux-record"],
        ),
        ("isolux-formats", &["isolux-model", "isolux-record", "isolux-sim"]),
        (
            "isolux-record",
            &["isolux-model", "isolux-sim", "isolux-reduce", "isolux-diagnose"],
        ),
        ("isolux-model", &["isolux-sim", "isolux-reduce", "isolux-diagnose"]),
        (
            "isolux-reduce",
            &["isolux-sim", "isolux-conformity", "isolux-diagnose", "isolux-report"],
        ),
        ("isolux-conformity", &["isolux-sim", "isolux-diagnose", "isolux-report"]),
        ("isolux-diagnose", &["isolux-report"]),
        ("isolux-modulation", &["isolux-diagnose", "isolux-report"]),
        (
            "isolux-report",
            &[
                "isolux-app",
                "isolux-scan",
                "isolux-device",
                "isolux-transport",
                "tokio",
            ],
        ),
        ("isolux-sim", &["isolux-reduce", "isolux-diagnose", "isolux-report"]),
        ("isolux-device", &["isolux-model", "isolux-scan"]),
        (
            "isolux-scan",
            &[
                "isolux-model",
                "isolux-sim",
                "isolux-reduce",
                "isolux-diagnose",
                "isolux-virtual",
            ],
        ),
    ];
    for (name, banned) in forbidden {
        let Some(package) = workspace.member(name) else {
            continue;
        };
        let reach = workspace.reach(&package.id);
        let bad: Vec<_> = banned.iter().filter(|other| reach.contains(**other)).collect();
        assert!(bad.is_empty(), "{name} reaches {bad:?}");
    }
}

/// Invariant 4. Broken by: any AGPL or GPL crate anywhere below a member.
#[test]
fn every_linked_licence_is_permissive() {
    let workspace = Workspace::new();
    let resolve = workspace
        .metadata
        .resolve
        .as_ref()
        .expect("metadata resolves dependencies");
    let mut refused = Vec::new();
    for node in &resolve.nodes {
        let package = workspace.package(&node.id);
        let licence = package.license.as_deref().unwrap_or("");
        if !permitted(licence) {
            refused.push(format!("{} {}: {licence:?}", package.name, package.version));
        }
    }
    assert!(refused.is_empty(), "{refused:#?}");
}

/// Whether an SPDX expression can be satisfied with permitted licences alone.
fn permitted(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ").replace(['(', ')'], " ");
    // "(A OR B) AND C": every AND part needs one permitted alternative. Without its brackets OR binds weaker, so the
    // parts are read from the AND outwards, which is how every expression in the lock file is meant.
    expression
        .split(" AND ")
        .all(|part| part.split(" OR ").any(|licence| LICENCES.contains(&licence.trim())))
}

#[test]
fn licence_expressions_are_read_as_meant() {
    assert!(
        permitted("MIT OR Apache-2.0")
            && permitted("Unlicense/MIT")
            && permitted("(Apache-2.0 OR MIT) AND BSD-3-Clause")
    );
    assert!(!permitted("AGPL-3.0-or-later") && !permitted("MIT AND GPL-3.0") && !permitted(""));
}

/// One version of each direct dependency, written once in the workspace.
#[test]
fn each_direct_dependency_has_one_version() {
    let workspace = Workspace::new();
    let mut versions: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for package in workspace.metadata.workspace_packages() {
        for dependency in &package.dependencies {
            versions
                .entry(dependency.name.as_str())
                .or_default()
                .insert(dependency.req.to_string());
        }
    }
    let several: Vec<_> = versions
        .iter()
        .filter(|(_, requirements)| requirements.len() > 1)
        .collect();
    assert!(several.is_empty(), "{several:?}");
}

/// `cargo run`, as the README has it, finds one program.
#[test]
fn one_program_is_run() {
    let workspace = Workspace::new();
    let programs: Vec<String> = workspace
        .metadata
        .workspace_default_packages()
        .iter()
        .flat_map(|package| &package.targets)
        .filter(|target| target.is_bin())
        .map(|target| target.name.clone())
        .collect();
    assert_eq!(programs, ["isolux"]);
}

/// Every member inherits the shared lints, edition and licence.
#[test]
fn members_share_lints_edition_and_licence() {
    let workspace = Workspace::new();
    for package in workspace.metadata.workspace_packages() {
        let manifest = std::fs::read_to_string(&package.manifest_path).expect("a member has its manifest");
        assert!(
            manifest.contains("[lints]\nworkspace = true"),
            "{} does not share the lints",
            package.name
        );
        assert_eq!(
            package.license.as_deref(),
            Some("MIT OR Apache-2.0"),
            "{}",
            package.name
        );
        assert_eq!(
            package.rust_version.as_ref().map(ToString::to_string).as_deref(),
            Some("1.92.0"),
            "{}",
            package.name
        );
        assert!(package.description.is_some(), "{} says what it is", package.name);
    }
}

/// Every example of a library's documentation and every test beside its code is run. Broken by: an example in a
/// library with `doctest = false`, or a test in one with `test = false`.
#[test]
fn every_example_and_every_test_of_a_library_is_run() {
    let workspace = Workspace::new();
    let (mut examples_run, mut tests_run) = (0, 0);
    for package in workspace.metadata.workspace_packages() {
        let Some(lib) = package.targets.iter().find(|target| target.is_lib()) else {
            continue;
        };
        examples_run += usize::from(lib.doctest);
        tests_run += usize::from(lib.test);
        let mut files = Vec::new();
        let folder = lib.src_path.parent().expect("a file is in a folder");
        sources(folder.as_std_path(), &mut files);
        for file in files {
            let text = std::fs::read_to_string(&file).expect("a source file");
            let has = |begins: &[&str]| {
                let mut lines = text.lines().map(str::trim_start);
                lines.any(|line| begins.iter().any(|begin| line.starts_with(begin)))
            };
            assert!(
                lib.doctest || !has(&["/// ```", "//! ```"]),
                "{}: its example is not run, {} has `doctest = false`",
                file.display(),
                package.name
            );
            assert!(
                lib.test || !has(&["#[test]", "#[tokio::test"]),
                "{}: its test is not run, {} has `test = false`",
                file.display(),
                package.name
            );
        }
    }
    assert!(
        examples_run >= 5 && tests_run >= 30,
        "{examples_run} and {tests_run} libraries"
    );
}
