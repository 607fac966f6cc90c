#!/usr/bin/env bash
# Writes the API pages of the package into target/doc-python; a warning is an error. `python/tests/run.sh` comes first.
set -euo pipefail
cd "$(dirname "$0")/.."
target/python-clean/bin/python -W error::UserWarning -m pdoc isolux isolux.bluesky --output-directory target/doc-python
