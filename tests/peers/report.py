#!/usr/bin/env python3
"""Every number of a day's report computed again from luminaire.raw.ldt or .ldt, luminaire.spd and budget.json. Not needed
to build.

    pip install colour-science numpy    # BSD-3-Clause
    python tests/peers/report.py DAY/results

The statements of the report are those of report.json. Exit 1 if a number is not the one that comes out here to the digits
that it is stated with.
"""

import json
import math
import re
import sys
import warnings
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
import colour  # noqa: E402


def ldt(path):
    """C and γ in degrees, intensities in cd (planes × angles), by the line numbers of EULUMDAT."""
    lines = path.read_text(encoding="latin-1").splitlines()
    symmetry, planes, _, angles = int(lines[2]), int(lines[3]), float(lines[4]), int(lines[5])
    sets = int(lines[25])
    start = 26 + 6 * sets + 10
    numbers = [float(text) for text in lines[start : start + planes + angles]]
    c, gamma = np.array(numbers[:planes]), np.array(numbers[planes:])
    rows = [float(text) for text in lines[start + planes + angles :] if text.strip()]
    flux = float(lines[26 + 2 * sets])
    table = np.array(rows).reshape(-1, angles) * flux / 1000.0
    assert symmetry == 0 and len(table) == planes, "a file of every half-plane is needed"
    return c, gamma, table


class Distribution:
    """Linear in C and γ, integrated exactly in γ and by the mean of the planes in C."""

    def __init__(self, path):
        self.c, self.gamma, self.cd = ldt(path)

    def zone(self, low, high):
        """lm between two angles γ, 0.01° midpoints."""
        edges = np.linspace(low, high, int(round((high - low) * 100)) + 1)
        middle = 0.5 * (edges[1:] + edges[:-1])
        mean = np.mean([np.interp(middle, self.gamma, plane) for plane in self.cd], axis=0)
        return float(np.sum(2 * np.pi * mean * np.sin(np.radians(middle)) * np.radians(edges[1] - edges[0])))

    def plane(self, c):
        return self.cd[int(np.argmin(np.abs(self.c - c % 360)))]

    def at(self, c, gamma):
        """Linear between the planes."""
        angles = np.append(self.c, 360.0)
        table = np.vstack([self.cd, self.cd[:1]])
        return float(np.interp(c, angles, [np.interp(gamma, self.gamma, row) for row in table]))


class Report:
    """Compares statements with numbers."""

    def __init__(self, folder):
        self.stated = json.loads((folder / "report.json").read_text())
        self.seen, self.wrong = set(), []

    def check(self, key, number, slack=0.51):
        """The first number of a statement, to its last digit."""
        text = self.stated.get(key)
        if text is None:
            return
        found = re.search(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", text)
        stated = found.group()
        digits = len(stated.split(".")[1]) if "." in stated else 0
        # Whole numbers of tables are rounded to three digits.
        place = 10.0**-digits
        if digits == 0 and abs(number) >= 1000 and stated.endswith("0"):
            place = 10.0 ** (len(stated.strip("-")) - len(stated.strip("-").rstrip("0")))
        self.seen.add(key)
        if abs(float(stated) - number) > slack * place:
            self.wrong.append(f"{key}: {text}, here {number:.6g}")

    def starting(self, start):
        return [key for key in self.stated if key.startswith(start)]


def light(report, folder, budget):
    raw = folder / "luminaire.ldt"
    of = Distribution(raw)
    total = of.zone(0, 180)
    report.check("luminous flux", budget["flux"]["value"])
    for low, high in ((0, 30), (0, 40), (0, 60), (60, 90)):
        # A file has four digits of an intensity: 0.1 lm of these sums, 0.01 % of shares.
        report.check(f"Luminous flux · zone {low}–{high}° · flux", of.zone(low, high), 1.6)
        report.check(f"Luminous flux · zone {low}–{high}° · of the total", 100 * of.zone(low, high) / total, 0.6)
    for name, low, high in (
        ("lower hemisphere, γ 0–90°", 0, 90),
        ("upper hemisphere, γ 90–180°", 90, 180),
        ("in a cone of 90°", 0, 45),
        ("in a cone of 120°", 0, 60),
    ):
        report.check(f"Luminous flux · {name} · flux", of.zone(low, high), 1.6)
        report.check(f"Luminous flux · {name} · of the total", 100 * of.zone(low, high) / total, 0.6)
    peak = of.cd.max()
    start = "Luminous intensity distribution · Beam and field · "
    for pair, c in (("C0–C180", 0), ("C90–C270", 90)):
        curve = np.append(of.plane(c + 180)[:0:-1], of.plane(c))
        angle = np.append(-of.gamma[:0:-1], of.gamma)
        half = 0.5 * curve.max()
        above = np.nonzero(curve >= half)[0]
        def edge(a, b):
            return angle[a] + (half - curve[a]) / (curve[b] - curve[a]) * (angle[b] - angle[a])
        left, right = edge(above[0] - 1, above[0]), edge(above[-1] + 1, above[-1])
        beam = right - left
        report.check(f"{start}{pair} · beam angle (50 %)", beam, 3)
        report.check(f"{start}{pair} · largest intensity, half-plane", curve.max())
        for metres in range(1, 6):
            width = metres * (math.tan(math.radians(right)) - math.tan(math.radians(left)))
            report.check(f"{start}{metres} m · width in {pair}", width)
            report.check(f"{start}{metres} m · illuminance on the axis", of.at(0, 0) / metres**2)
    report.check("largest luminous intensity", peak)
    area = math.pi * 73.0**2 / 4
    for key in report.starting("Glare · γ"):
        gamma, c = (float(text) for text in re.findall(r"(\d+)°", key))
        report.check(key, of.at(c, gamma) / (area * 1e-6 * math.cos(math.radians(gamma))), 1.1)
    for key in report.starting("Table of luminous intensity"):
        found = re.findall(r"(-?\d+(?:\.\d+)?)°?", key.split(" · ", 1)[1])
        if len(found) == 2:
            gamma, c = (float(text) for text in found)
            report.check(key, of.at(c, gamma))


def colours(report, folder):
    rows = [line.split() for line in (folder / "luminaire.spd").read_text().splitlines() if line[:1].isdigit()]
    data = {float(row[0]): float(row[1]) for row in rows}
    of = colour.SpectralDistribution(data).interpolate(colour.SpectralShape(360, 830, 1))
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(of.shape)
    xyz = np.array([np.sum(of.values * cmfs.values[:, k]) for k in range(3)])
    x, y = xyz[:2] / xyz.sum()
    u, v = colour.xy_to_Luv_uv([x, y])
    start = "Spectrum and colour · "
    for key, number in ((f"{start}x (CIE 1931)", x), (f"{start}y (CIE 1931)", y), (f"{start}u′ (CIE 1976)", u), (f"{start}v′ (CIE 1976)", v)):
        report.check(key, number)
    cct, duv = colour.temperature.uv_to_CCT_Ohno2013(colour.xy_to_UCS_uv([x, y]))
    report.check("correlated colour temperature", cct, 1.1)
    report.check(f"{start}correlated colour temperature", cct, 1.1)
    for key in ("Duv", f"{start}Duv, from the Planckian locus"):
        report.check(key, duv)
    cri = colour.colour_rendering_index(of, additional_data=True)
    for key in ("Ra", f"{start}Ra (CIE 13.3)"):
        report.check(key, cri.Q_a, 3)
    for number in range(1, 15):
        report.check(f"{start}Special colour rendering indices (CIE 13.3) · Ri · R{number}", cri.Q_as[number].Q_a, 0.7)
    tm30 = colour.quality.colour_fidelity_index_ANSIIESTM3018(of, additional_data=True)
    for key in ("Rf (TM-30)", f"{start}Rf (TM-30, CIE 224)"):
        report.check(key, tm30.R_f, 3)
    for key in ("Rg (TM-30)", f"{start}Rg (TM-30)"):
        report.check(key, tm30.R_g, 3)
    for number in range(16):
        base = f"{start}Special colour rendering indices (CIE 13.3) · "
        report.check(f"{base}Rf,h · {number + 1}", tm30.R_fs[number], 1.1)
        report.check(f"{base}chroma shift in % · {number + 1}", 100 * tm30.R_cs[number] if abs(tm30.R_cs[number]) < 1 else tm30.R_cs[number], 1.1)
    report.check(f"{start}peak wavelength", max(data, key=data.get), 1.1)


def budgets(report, budget):
    """Squares of the parts, shares, the expanded uncertainty."""
    for title, key in (
        ("Luminous flux", "flux"),
        ("Largest luminous intensity", "i_max"),
        ("Correlated colour temperature", "cct"),
        ("Luminous efficacy of radiation", "efficacy"),
    ):
        quantity = budget[key]
        parts = sorted(quantity["parts"].values())
        u = math.sqrt(sum(part * part for part in parts))
        unit = quantity["unit"]
        start = next(iter(report.starting(f"Corrections and uncertainty · {title}:")), "").split(" · ")[:2]
        start = " · ".join(start)
        report.check(f"{start} · combined standard uncertainty u, k = 1 · u in {unit}", u)
        report.check(f"{start} · combined standard uncertainty u, k = 1 · relative", 100 * u / abs(quantity["value"]))
        report.check(f"{start} · expanded uncertainty U, k = 2 · u in {unit}", 2 * u)
        report.check(f"{start} · expanded uncertainty U, k = 2 · relative", 200 * u / abs(quantity["value"]))
        stated = [report.stated[row] for row in report.starting(start) if row.endswith(f"· u in {unit}") and " = " not in row.rsplit(" · ", 2)[1]]
        numbers = sorted(0.0 if "<" in text else float(text) for text in stated)
        for text, part in zip(numbers, parts):
            if abs(text - part) > 0.06 * max(part, 1e-4) + 1e-4:
                report.wrong.append(f"{title}: a part is stated as {text}, budget.json has {part}")
        report.seen.update(row for row in report.starting(start) if row.endswith(f"· u in {unit}"))


def main():
    folder = Path(sys.argv[1])
    report = Report(folder)
    budget = json.loads((folder / "budget.json").read_text())
    light(report, folder, budget)
    colours(report, folder)
    budgets(report, budget)
    print(f"{len(report.seen)} statements computed again, {len(report.wrong)} differ")
    for line in report.wrong:
        print(" ", line)
    return 1 if report.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
