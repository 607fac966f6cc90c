#!/usr/bin/env bash
# Checks that the workspace builds with the minimum Rust version that Cargo.toml states.
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
rustup toolchain install "$version" --profile minimal --no-self-update
CARGO_TARGET_DIR=target/minimum cargo "+$version" check --workspace --locked
