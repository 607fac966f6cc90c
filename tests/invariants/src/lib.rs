//! The rules of `docs/architecture.md`, proved over `cargo metadata`: see `tests/suite/rules.rs`.
