#!/usr/bin/env bash
# The light solvers beside numpy, Mitsuba 3 and Dr.Jit on the published scene, in one run: medians, errors, ratios.
#
#     tests/peers/light.sh [ROUNDS]
#
# Needs Python 3 and an LLVM shared library (Debian: libllvm19; 15 and older lack an instruction that it uses) for Dr.Jit; the rest comes from PyPI into target/peers.
set -eu
cd "$(dirname "$0")/../.."
home=target/peers
if [ ! -x "$home/bin/python" ]; then
  python3 -m venv "$home"
  "$home/bin/pip" install --quiet numpy==2.4.6 mitsuba==3.9.1
fi
cargo bench --quiet -p isolux-sim --bench light --no-run
bench=$(cargo bench -p isolux-sim --bench light --no-run --message-format json 2>/dev/null |
  "$home/bin/python" -c 'import json, sys; print([e["executable"] for e in map(json.loads, sys.stdin) if e.get("executable")][-1])')
# Dr.Jit 1.5 needs an LLVM that can select its minima and maxima: the newest one here.
export DRJIT_LIBLLVM_PATH="${DRJIT_LIBLLVM_PATH:-$(ls /usr/lib/*-linux-gnu/libLLVM*.so* 2>/dev/null | grep -E "(1[6-9]|2[0-9])" | sort -V | tail -1)}"
"$home/bin/python" tests/peers/light.py "$bench" "$home/light" "${1:-3}"
