#!/usr/bin/env bash
# Installs what tests/peers/requirements.txt pins into target/peers-python, unless it is there already. Needs Python 3 with venv.
set -euo pipefail
cd "$(dirname "$0")/../.."
home=target/peers-python
if cmp -s tests/peers/requirements.txt "$home/requirements.txt"; then
  echo "nothing is missing"
  exit 0
fi
python3 -m venv "$home"
"$home/bin/pip" install --quiet --disable-pip-version-check -r tests/peers/requirements.txt
cp tests/peers/requirements.txt "$home/requirements.txt"
