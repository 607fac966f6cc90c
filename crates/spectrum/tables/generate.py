#!/usr/bin/env python3
"""Writes the colorimetric tables of this crate from colour-science 0.4.7 (BSD-3-Clause). Needs: pip install colour-science==0.4.7.

    python3 tables/generate.py            (in crates/spectrum)
"""
import gzip, os
import colour, colour.quality.cfi2017 as cfi
from colour.colorimetry import SpectralShape
from colour.quality.datasets.tcs import SDS_TCS

here = os.path.dirname(os.path.abspath(__file__))
S1 = SpectralShape(360, 830, 1)
S5 = SpectralShape(360, 830, 5)

def rows(values, fmt="{:.9g}"):
    out, line = [], "    "
    for v in values:
        v = 0.0 if abs(v) < 1e-12 else float(v)
        t = fmt.format(v)
        if "." not in t and "e" not in t: t += ".0"
        if len(line) + len(t) > 116: out.append(line.rstrip()); line = "    "
        line += t + ", "
    out.append(line.rstrip())
    return "\n".join(out)

def table(name, doc, values):
    return f"/// {doc}\n#[rustfmt::skip]\npub(crate) const {name}: [f64; {len(values)}] = [\n{rows(values)}\n];\n"

cmf10 = colour.MSDS_CMFS["CIE 1964 10 Degree Standard Observer"].copy().align(S1).values
vs = colour.SDS_LEFS["CIE 1951 Scotopic Standard Observer"]
scot = [float(vs[w]) if 380 <= w <= 780 else 0.0 for w in range(360, 831)]
d = colour.MSDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES if hasattr(colour, "MSDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES") else None
if d is None:
    from colour.colorimetry.datasets.illuminants.sds_d_illuminant_series import SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES as d
out = ['''//! Tables that the indices need, written by `tables/generate.py` from colour-science 0.4.7 (BSD-3-Clause). Do not edit.
''']
for i, n in enumerate("XYZ"):
    out.append(table(f"{n}10_BAR", f"CIE 1964 {n.lower()}̄₁₀(λ), 10° observer, 360–830 nm at 1 nm (ISO/CIE 11664-1).", cmf10[:, i]))
out.append(table("V_PRIME", "Scotopic V′(λ), 360–830 nm at 1 nm (ISO/CIE 23539; zero outside 380–780 nm).", scot))
for n in ("S0", "S1", "S2"):
    sd = d[n]
    wl = list(range(300, 831, 5)) if sd.shape.interval == 5 else list(range(300, 831, 10))
    out.append(table(f"DAYLIGHT_{n}", f"Component {n} of CIE daylight, {wl[0]}–{wl[-1]} nm at {wl[1]-wl[0]} nm (CIE 15:2018, linear between).", [float(sd[w]) for w in wl]))
samples = list(SDS_TCS["CIE 1995"].values())[:14] + [list(SDS_TCS["CIE 2024"].values())[-1]]
flat = []
for s in samples:
    w = list(s.wavelengths)
    flat.append([float(s.values[w.index(x)]) if x in w else (float(s.values[0]) if x < w[0] else float(s.values[-1])) for x in range(360, 831, 5)])
doc = "Spectral radiance factors of the test-colour samples 1–14 (CIE 13.3) and 15 (Japanese complexion, CIE.DS.7chm7z5h),\n/// 360–830 nm at 5 nm (linear between, the end values held outside their own range)."
out.append(f"/// {doc}\n#[rustfmt::skip]\npub(crate) const TEST_COLOURS: [[f64; {len(flat[0])}]; 15] = [\n" + "\n".join(f"[\n{rows(f)}\n]," for f in flat) + "\n];\n")
open(os.path.join(here, "../src/tables.rs"), "w").write("\n".join(out))


t1 = cfi.load_TCS_CIE2017(SpectralShape(380, 780, 1))
open(os.path.join(here, "cfi_2017_1nm.csv"), "w").write("\n".join(",".join("{:.9g}".format(v) for v in t1.values[:, i]) for i in range(99)) + "\n")
