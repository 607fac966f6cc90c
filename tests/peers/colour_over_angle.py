#!/usr/bin/env python3
"""Colour over angle of `isolux reduce` beside integrals of our own and colour-science.

    pip install 'numpy<2.3' colour-science==0.4.7
    python tests/peers/colour_over_angle.py path/to/isolux

Not needed to build. Scans the virtual darkroom's lamp of one LED, whose light has a closed form that is written down a second
time here, in virtual time, and compares three ways:

1. the lamp itself: its spectrum integrated over the sphere, 1.2 million directions, against every number of the budget with
   its U (k = 2);
2. the program's own spectra of the directions and its distribution, integrated here: Φ_λ, the average of LM-79, Δu′v′;
3. every direction's chromaticity from its file.

Prints each difference, and exits 1 where one passes its limit.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import warnings
import xml.etree.ElementTree as ET

import numpy as np

warnings.filterwarnings("ignore")
import colour  # noqa: E402

NM = np.arange(360.0, 831)
ROOM = {
    "flux_lm": "420.0", "ring_diameter_mm": "[0.0]", "leds_per_ring": "[1]", "exponent": "1.6", "ellipticity_rel": "0.06",
    "ellipticity_azimuth_deg": "20.0", "flux_spread_rel": "0.0", "aim_spread_deg": "0.0", "phosphor_rise_rel": "0.45",
    "phosphor_lean_rel": "0.1", "phosphor_lean_azimuth_deg": "70.0",
}  # fmt: skip
BLOCK = """
[[block]]
name = "colour"
kind = "lit"
instrument = "spectroradiometer"
c_deg = [0, 90]
gamma_range = [-90, 90, 10]
repeats = 4
"""


def number(key):
    return float(ROOM[key])


def intensity(c, g):
    """cd towards C, γ in radians: cosⁿ γ times the ellipse of the lens."""
    n, e, a = number("exponent"), number("ellipticity_rel"), np.radians(number("ellipticity_azimuth_deg"))
    cos = np.maximum(np.cos(g), 0.0)
    return number("flux_lm") * (n + 1) / (2 * np.pi) * cos**n * (1 + e * np.sin(g) ** 2 * np.cos(2 * (c - a)))


def phosphor(c, g):
    lean, a = number("phosphor_lean_rel"), np.radians(number("phosphor_lean_azimuth_deg"))
    return 1 + number("phosphor_rise_rel") * np.sin(g) ** 2 + lean * np.sin(g) * np.cos(c - a)


def skewed(nm, peak, below, above):
    return np.exp(-0.5 * ((nm - peak) / np.where(nm < peak, below, above)) ** 2)


CHIP = skewed(NM, 457.0, 9.5, 12.0)
PHOSPHOR = 0.74 * (0.58 * skewed(NM, 533.0, 31.0, 46.0) + 0.42 * skewed(NM, 612.0, 38.0, 46.0))


SHAPE = colour.SpectralShape(360, 830, 1)
OBSERVER = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(SHAPE)
CMFS = OBSERVER.values


def of_colour(s):
    """The numbers of a spectrum by colour-science."""
    sd = colour.SpectralDistribution(dict(zip(NM, s)))
    xyz = colour.sd_to_XYZ(sd, OBSERVER, method="Integration")
    x, y = colour.XYZ_to_xy(xyz)
    cct, duv = colour.temperature.uv_to_CCT_Ohno2013(colour.UCS_to_uv(colour.XYZ_to_UCS(xyz)), OBSERVER)
    u_prime, v_prime = colour.xy_to_Luv_uv([x, y])
    cri = colour.colour_rendering_index(sd, additional_data=True)
    tm = colour.colour_fidelity_index(sd, additional_data=True, method="ANSI/IES TM-30-18")
    return {
        "x": x, "y": y, "u_prime": u_prime, "v_prime": v_prime, "cct": float(cct), "duv": float(duv), "ra": cri.Q_a,
        "r9": cri.Q_as[9].Q_a, "rf": tm.R_f, "rg": tm.R_g, "efficacy": lumens(s) / s.sum(),
    }  # fmt: skip


def lumens(s):
    return 683.0 * np.sum(s * CMFS[:, 1])


def xy(s):
    xyz = s @ CMFS
    return xyz[:2] / xyz.sum()


def uv(xy):
    x, y = xy
    d = -2 * x + 12 * y + 3
    return np.array([4 * x / d, 9 * y / d])


def light(p):
    """The spectrum of one lumen with p times the phosphor's part."""
    s = CHIP + p * PHOSPHOR
    return s / lumens(s)


def exact_total():
    """W/nm of the lamp, midpoints in C and γ."""
    c = np.radians((np.arange(720) + 0.5) * 0.5)
    g = np.radians((np.arange(1800) + 0.5) * 0.05)
    cc, gg = np.meshgrid(c, g)
    weight = intensity(cc, gg) * np.sin(gg)
    weight *= number("flux_lm") / weight.sum()
    p = phosphor(cc, gg)
    per = weight / (lumens(CHIP) + p * lumens(PHOSPHOR))
    return per.sum() * CHIP + (per * p).sum() * PHOSPHOR


def rings(gammas):
    """Ω of LM-79 for each γ of a half-plane's quarter of the circle."""
    half = np.radians(0.5 * np.diff(gammas))
    g = np.radians(gammas)
    low = np.concatenate(([0.0], g[1:] - half))
    high = np.concatenate((g[:-1] + half, [g[-1] + half[-1]]))
    return 2 * np.pi * (np.cos(low) - np.cos(high)) / 4


def average(gammas, at):
    """x and y of LM-79 over four half-planes; `at` gives (x, y) and cd of a direction, or none."""
    total, whole = np.zeros(2), 0.0
    for c in (0.0, 90.0, 180.0, 270.0):
        for gamma, omega in zip(gammas, rings(gammas)):
            found = at(0.0 if gamma == 0 else c, gamma)
            if found is not None:
                weight = omega * found[1]
                total, whole = total + weight * np.array(found[0]), whole + weight
    return total / whole


def day(binary, folder):
    """A scan of the room; the folder of its results."""
    run = lambda *arguments: subprocess.run([binary, *arguments], check=True, capture_output=True, cwd=folder)  # noqa: E731
    run("init", "d")
    run("init", "--room", "d/room.toml")
    room = folder / "d/room.toml"
    lines = room.read_text().splitlines()
    for i, line in enumerate(lines):
        key = line.split(" = ")[0]
        if key in ROOM and lines[:i].count("[room]") == 0:
            lines[i] = f"{key} = {ROOM[key]}"
    room.write_text("\n".join(lines) + "\n")
    station = folder / "d/station.toml"
    text = station.read_text().replace('name = "virtual darkroom"', 'name = "virtual darkroom"\ndarkroom = "room.toml"')
    station.write_text(text.replace("diameter_mm = 73.0", "diameter_mm = 5.0"))
    plan = folder / "d/plan.toml"
    plan.write_text(plan.read_text().replace("# Detector capped", BLOCK.lstrip() + "\n# Detector capped"))
    run("scan", "d/station.toml", "d/plan.toml", "--out", "d/run")
    run("reduce", "d/run")
    return folder / "d/run/results"


def spectrum_of(path):
    nm, value = [], []
    for element in ET.parse(path).iter():
        if element.tag.split("}")[-1] == "SpectralData":
            nm.append(float(element.get("wavelength")))
            value.append(float(element.text))
    return np.interp(NM, nm, value, left=0.0, right=0.0)


class Check:
    def __init__(self):
        self.wrong = []

    def within(self, what, got, expected, limit):
        off = abs(got - expected)
        print(f"{what:34} {got:.6g}  {expected:.6g}  off {off:.2g} of {limit:.2g}")
        if not off <= limit:
            self.wrong.append(what)


def own_integral(directions, grid, spectra):
    """Σ I·e over the sphere: harmonics of four half-planes over C, lines over γ; the distribution bilinear."""
    cs, gs, cd = grid
    fine_g = np.radians((np.arange(1800) + 0.5) * 0.1)
    fine_c = np.radians((np.arange(360) + 0.5) * 1.0)
    order = np.unique(gs)
    around = np.append(cs, 360.0)
    cells = np.vstack([cd, cd[:1]])
    total = np.zeros(NM.size)
    known = {}
    for (c, g), s in zip(directions, spectra):
        for plane in (0.0, 90.0, 180.0, 270.0) if g == 0 else (c,):
            known.setdefault(plane, []).append((g, s / lumens(s)))
    along = {}
    for plane, nodes in known.items():
        nodes.sort(key=lambda node: node[0])
        at = np.array([g for g, _ in nodes])
        values = np.array([s for _, s in nodes])
        weights = np.array([np.interp(np.degrees(fine_g), at, np.eye(at.size)[k]) for k in range(at.size)])
        along[plane] = (weights, values)
    row = lambda k: np.interp(np.degrees(fine_g), order, cells[k], left=0.0, right=0.0)  # noqa: E731
    rows = np.array([row(k) for k in range(cells.shape[0])])
    for c in fine_c:
        k = np.searchsorted(around, np.degrees(c)) - 1
        t = (np.degrees(c) - around[k]) / (around[k + 1] - around[k])
        light = ((1 - t) * rows[k] + t * rows[k + 1]) * np.sin(fine_g)
        for plane, (weights, values) in along.items():
            d = c - np.radians(plane)
            total += (1 + 2 * np.cos(d) + np.cos(2 * d)) / 4 * ((weights @ light) @ values)
    return total * np.radians(0.1) * np.radians(1.0)


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    check = Check()
    with tempfile.TemporaryDirectory() as folder:
        results = day(binary, pathlib.Path(folder))
        budget = json.loads((results / "budget.json").read_text())
        found = budget["colour_over_angle"]
        with open(results / "luminaire.directions.csv", encoding="utf-8") as file:
            grid = [(float(r["c_deg"]), float(r["gamma_deg"]), float(r["intensity_cd"])) for r in csv.DictReader(file)]
        name = lambda d: f"colour/c{d['c_deg']:05.1f}_g{d['gamma_deg']:05.1f}.spdx"  # noqa: E731
        spectra = [spectrum_of(results / name(d)) for d in found["directions"]]
        with open(results / "luminaire.flux.csv", encoding="utf-8") as file:
            rows = [[float(cell) for cell in row.values()] for row in csv.DictReader(file)]
    flux = np.array(rows)

    print("1. the lamp itself, with U (k = 2)")
    total = exact_total()
    peers = of_colour(total)
    mine = found["total"]
    for key, value in peers.items():
        check.within(f"total {key}", mine[key]["value"], value, 2 * mine[key]["u"])
    check.within("radiant flux, W", mine["radiant_flux"]["value"], total.sum(), 2 * mine["radiant_flux"]["u"])
    for nm in (430, 457, 500, 560, 620, 700):
        k = int(np.argmin(abs(flux[:, 0] - nm)))
        check.within(f"spectral flux at {nm} nm, W/nm", flux[k, 1], total[nm - 360], 2 * flux[k, 2])
    gammas = np.arange(0.0, 91, 10)
    of_lamp = lambda c, g: (xy(light(phosphor(np.radians(c), np.radians(g)))), intensity(np.radians(c), np.radians(g)))  # noqa: E731
    mean = average(gammas, of_lamp)
    mine = found["average_lm79"]
    check.within("LM-79 x", mine["x"]["value"], mean[0], 2 * mine["x"]["u"])
    check.within("LM-79 y", mine["y"]["value"], mean[1], 2 * mine["y"]["u"])
    away = []
    for d in found["directions"]:
        at, cd = of_lamp(d["c_deg"], d["gamma_deg"])
        if cd >= 0.1 * intensity(0.0, 0.0):
            away.append(np.hypot(*(uv(at) - uv(mean))))
    delta = found["delta_u_prime_v_prime"]
    check.within("Δu′v′", delta["value"]["value"], max(away), 2 * delta["value"]["u"])
    print(f"the two averages differ by {np.hypot(*(uv(mean) - uv(xy(total)))):.2e} in u′v′")

    print("2. the program's own directions, integrated here")
    cs, gs = np.unique([c for c, _, _ in grid]), np.unique([g for _, g, _ in grid])
    cd = np.zeros((cs.size, gs.size))
    for c, g, value in grid:
        cd[np.searchsorted(cs, c), np.searchsorted(gs, g)] = value
    at = [(d["c_deg"], d["gamma_deg"]) for d in found["directions"]]
    own = own_integral(at, (cs, gs, cd), spectra)
    # Ra and R9 as far as the libraries differ from each other (spectra.py).
    limits = {"x": 5e-6, "y": 5e-6, "cct": 0.5, "duv": 1e-5, "ra": 0.1, "r9": 0.5, "rf": 0.02, "rg": 0.02, "efficacy": 0.02}
    peers, mine = of_colour(own), found["total"]
    for key, limit in limits.items():
        check.within(f"total {key}", mine[key]["value"], peers[key], limit)
    check.within("radiant flux, W", mine["radiant_flux"]["value"], own.sum(), 2e-4 * own.sum())
    lookup = {d: (xy(s), e["intensity_cd"]) for d, s, e in zip(at, spectra, found["directions"])}
    mean = average(gammas, lambda c, g: lookup.get((c, g)))
    check.within("LM-79 x", found["average_lm79"]["x"]["value"], mean[0], 1e-6)
    check.within("LM-79 y", found["average_lm79"]["y"]["value"], mean[1], 1e-6)
    peak = cd.max()
    away = [np.hypot(*(uv(of) - uv(mean))) for of, value in lookup.values() if value >= 0.1 * peak]
    check.within("Δu′v′ as read", delta["read"], max(away), 1e-6)
    check.within("directions that count", delta["directions"], len(away), 0)

    print("3. every direction")
    worst = max(np.hypot(*(uv(xy(s)) - [d["u_prime"], d["v_prime"]])) for s, d in zip(spectra, found["directions"]))
    check.within("u′v′ of a direction's file", worst, 0.0, 1e-6)
    outside = [d for d in found["directions"]
               if abs(d["v_prime"] - uv(of_lamp(d["c_deg"], d["gamma_deg"])[0])[1]) > 2 * d["u_v_prime"]]  # fmt: skip
    check.within("directions outside U", len(outside), 0, 0.2 * len(at))
    for what in check.wrong:
        print("differs:", what)
    return 1 if check.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
