#!/usr/bin/env bash
# Runs every fuzz target for so many seconds (60 unless told). Needs a nightly toolchain and cargo-fuzz.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo run -q -p isolux-fuzz --example corpus
for target in $(cargo +nightly fuzz list); do
  printf '\n== %s\n' "$target"
  cargo +nightly fuzz run "$target" -- -max_total_time="${1:-60}" -rss_limit_mb=4096
done
