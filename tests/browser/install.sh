#!/usr/bin/env bash
# Installs what tests/browser/package-lock.json pins into target/browser, unless it is there already. Needs node and npm; the
# browser is Debian's chromium (scripts/packages.sh), none is downloaded.
set -euo pipefail
cd "$(dirname "$0")/../.."
home=target/browser
if cmp -s tests/browser/package-lock.json "$home/installed.json"; then
  echo "nothing is missing"
  exit 0
fi
mkdir -p "$home"
cp tests/browser/package.json tests/browser/package-lock.json "$home/"
npm ci --prefix "$home" --ignore-scripts --no-audit --no-fund --silent
cp tests/browser/package-lock.json "$home/installed.json"
