#!/usr/bin/env bash
# Licences and advisories, dependencies that nobody uses, spelling, the book's links. Installs the tools that it needs.
set -euo pipefail
cd "$(dirname "$0")/.."
have() { command -v "$1" >/dev/null 2>&1 || cargo install --locked "${2:-$1}"; }
have cargo-deny
cargo deny --workspace check
have cargo-machete
cargo machete
have typos typos-cli
typos
have mdbook
mdbook build docs --dest-dir ../target/book
