#!/usr/bin/env bash
# Builds the wheel, installs it into an environment of its own, and runs the tests and notebooks of the package there,
# without Rust on the path. `bash python/tests/run.sh [PROFILE]`: dev (with what `cargo test` has built) or release.
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-dev}
features=pyo3/extension-module
if [ "$profile" = dev ]; then
  features+=,as-tested
fi
tools=target/python-tools
clean=target/python-clean
rm -rf "$clean" target/wheels

if [ ! -x "$tools/bin/maturin" ]; then
  python3 -m venv "$tools"
  "$tools/bin/pip" install --quiet --disable-pip-version-check maturin==1.16.0
fi
"$tools/bin/maturin" build --locked --manifest-path python/Cargo.toml --profile "$profile" --features "$features" \
  --compatibility linux --out target/wheels

python3 -m venv "$clean"
"$clean/bin/pip" install --quiet --disable-pip-version-check target/wheels/isolux-*.whl -r python/tests/requirements.txt
cd python/tests
# What a user of the wheel has: no cargo, no rustc.
PATH="$OLDPWD/$clean/bin:/usr/bin:/bin" "$OLDPWD/$clean/bin/python" -m pytest -q -p no:cacheprovider -n 2
