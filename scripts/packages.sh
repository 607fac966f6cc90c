#!/usr/bin/env bash
# Installs the Debian packages that building and testing need and that a fresh Debian 12 with a Rust toolchain may lack.
# Run as root, or with sudo at hand; does nothing where everything is there.
set -euo pipefail
# mbpoll and Python packages (tests/peers/python.sh) speak Modbus and SCPI with us, and umockdev shows libusb the twins of
# USB instruments (tests/interoperability); chromium, driven from node, looks at the local page (tests/browser);
# minisign checks signatures of runs and makes some (crates/cli/tests/suite/verify.rs).
needed=(gcc:gcc pkg-config:pkg-config mbpoll:mbpoll python3:python3 node:nodejs npm:npm chromium:chromium minisign:minisign)
missing=()
for entry in "${needed[@]}"; do
  command -v "${entry%%:*}" >/dev/null 2>&1 || missing+=("${entry##*:}")
done
pkg-config --exists umockdev-1.0 2>/dev/null || missing+=(libumockdev-dev umockdev)
python3 -c "import ensurepip, venv" 2>/dev/null || missing+=(python3-venv)
[ "${#missing[@]}" -eq 0 ] && { echo "nothing is missing"; exit 0; }
run=()
[ "$(id -u)" -eq 0 ] || run=(sudo)
"${run[@]}" apt-get update -qq
"${run[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}"
