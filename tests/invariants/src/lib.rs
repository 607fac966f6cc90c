//! The house rules of `docs/architecture.md`, proved over `cargo metadata`: see `tests/house.rs`.
