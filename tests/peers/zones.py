#!/usr/bin/env python3
"""Zones of outdoor luminaires (IES TM-15-11) of `isolux inspect` beside sums over tables that another program reads. Not
needed to build.

    pip install eulumdat-py numpy       # MIT
    python tests/peers/zones.py target/release/isolux FILE.ldt…

The sums are by the midpoint rule, 0.1° × 0.5°, of the table that eulumdat-py gives, linear in C and γ. Street side: C90.
Exit 1 if a zone differs by more than 0.01 % of the flux.
"""

import json
import subprocess
import sys

import numpy as np
from pyldt import LdtReader

LIMIT = 1e-4
ZONES = {"l": (0, 30), "m": (30, 60), "h": (60, 80), "vh": (80, 90)}
STREET = 90.0


def sums(path):
    """Zones in lm by name, and the flux."""
    ldt = LdtReader.read(path)
    head = ldt.header
    per_klm = np.array(ldt.intensities, dtype=float)
    if per_klm.shape[0] == 1:
        per_klm = np.repeat(per_klm, 4, axis=0)
        planes = np.array([0.0, 90.0, 180.0, 270.0])
    else:
        planes = np.array(head.c_angles[: per_klm.shape[0]], dtype=float)
    candela = per_klm * head.lamp_flux[0] / 1000.0 * head.conv_factor
    gammas = np.array(head.g_angles, dtype=float)
    c = np.arange(0.25, 360.0, 0.5)
    gamma = np.arange(0.05, 180.0, 0.1)
    rows = np.array([np.interp(gamma, gammas, row, right=0.0) for row in candela])
    rows[:, gamma > gammas[-1]] = 0.0
    light = np.array([np.interp(c, planes, column, period=360.0) for column in rows.T]).T
    lumens = light * np.sin(np.radians(gamma)) * np.radians(0.1) * np.radians(0.5)
    forward = np.abs((c - STREET + 180.0) % 360.0 - 180.0) < 90.0
    part = lambda side, a, b: lumens[np.ix_(side, (gamma > a) & (gamma < b))].sum()
    zones = {f"f{name}": part(forward, *edges) for name, edges in ZONES.items()}
    zones |= {f"b{name}": part(~forward, *edges) for name, edges in ZONES.items()}
    every = np.ones_like(forward)
    zones |= {"ul": part(every, 90, 100), "uh": part(every, 100, 180)}
    return zones, lumens.sum()


def main():
    isolux, *files = sys.argv[1:]
    worst, count = 0.0, 0
    for path in files:
        asked = [isolux, "inspect", "--json", "--street-side", str(STREET), path]
        answer = subprocess.run(asked, capture_output=True, text=True, check=False)
        ours = json.loads(answer.stdout.splitlines()[0])["quantities"].get("outdoor")
        if ours is None:
            print(f"{path}: not classified")
            continue
        zones, flux = sums(path)
        apart = {name: (ours[f"{name}_lm"] or 0.0) - lm for name, lm in zones.items()}
        name = max(apart, key=lambda zone: abs(apart[zone]))
        worst, count = max(worst, abs(apart[name]) / flux), count + 1
        print(f"{path}: largest {name.upper()} {apart[name]:+.3f} lm of {flux:.1f} lm")
    print(f"{count} files, largest difference {worst:.1e} of the flux")
    return int(worst > LIMIT)


if __name__ == "__main__":
    sys.exit(main())
