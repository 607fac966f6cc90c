#!/usr/bin/env python3
"""Colorimetry of `isolux inspect --json` beside colour-science and luxpy, on spectra that are hard on purpose.

    pip install 'numpy<2.3' colour-science==0.4.7 luxpy==1.12.5 matplotlib
    python tests/peers/spectra.py path/to/isolux [folder with more spectra as .csv: wavelength_nm,value]

Not needed to build. Each spectrum is handed to the libraries at 1 nm, by the rule that isolux integrates by (decision 0004)
written a second time here; so a difference is a difference of method, not of interpolation. Prints the largest distance to the
interval that the two libraries span, for every quantity, and exits 1 where it passes the limit.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np

warnings.filterwarnings("ignore")
import colour  # noqa: E402
import luxpy as lx  # noqa: E402

LIMIT = {
    "x": 1e-5, "y": 1e-5, "cct_k": 2.0, "duv": 2e-5, "ra": 0.1, "rf": 0.02, "rg": 0.02,
    "ler_lm_per_w": 0.5, "dominant_nm": 0.1, "purity": 1e-3, "sp_ratio": 5e-3, "r": 0.5, "rf_hue": 0.05,
}  # fmt: skip
NEEDS_CCT = {"cct_k", "duv", "ra", "r", "rf", "rg", "rf_hue"}


def spectra():
    """Name → (wavelengths, values)."""
    rng = np.random.default_rng(7)
    nm1, nm10, nm05 = np.arange(360.0, 831), np.arange(380.0, 781, 10), np.arange(360.0, 830.1, 0.5)
    gauss = lambda nm, mu, fwhm: np.exp(-4 * np.log(2) * ((nm - mu) / fwhm) ** 2)  # noqa: E731
    white = lambda nm, b: gauss(nm, 452, 22) * b + gauss(nm, 555, 110) + 0.35 * gauss(nm, 620, 90)  # noqa: E731
    planck = lambda nm, t: (nm * 1e-9) ** -5.0 / np.expm1(1.4388e-2 / (nm * 1e-9 * t))  # noqa: E731
    out = {}
    for mu in (405, 450, 470, 505, 530, 590, 625, 660):
        out[f"narrow LED {mu}"] = (nm1, gauss(nm1, mu, 18.0))
    for mu in (445, 532, 589, 638):
        out[f"laser {mu}"] = (nm05, gauss(nm05, mu, 2.0))
    out["RGB lasers"] = (nm05, gauss(nm05, 457, 2.0) * 0.9 + gauss(nm05, 532, 2.0) + gauss(nm05, 638, 2.0) * 1.6)
    for b in (0.4, 0.8, 1.3, 2.0, 3.0):
        out[f"white LED {b}"] = (nm1, white(nm1, b))
    out["white LED 10 nm"] = (nm10, white(nm10, 0.9))
    out["white LED 0.5 nm"] = (nm05, white(nm05, 0.9))
    out["white LED with negative noise"] = (nm1, white(nm1, 0.9) + rng.normal(0, 0.01, nm1.size))
    uneven = np.sort(rng.uniform(361, 829, 160))
    out["white LED uneven"] = (uneven, white(uneven, 1.1))
    for t in (1600, 2700, 3999, 4001, 4500, 4999, 5001, 9000, 20000):
        out[f"Planck {t}"] = (nm1, planck(nm1, t) / planck(560.0, t))
    out["filtered daylight"] = (nm10, planck(nm10, 6500) / planck(560.0, 6500) * (0.5 + 0.5 * np.tanh((nm10 - 470) / 40)))
    out["greenish fluorescent"] = (
        nm05, 0.12 * white(nm05, 0.6) + 0.8 * gauss(nm05, 436, 3) + 1.4 * gauss(nm05, 546, 3) + 0.7 * gauss(nm05, 611, 4),
    )
    return out


def per_nm(nm, v):
    """At 360 … 830 nm: the values there; in a nanometre with a point between its ends, integrals with the ±1 nm triangle."""
    out = np.zeros(471)
    value = lambda at: np.interp(at, nm, v, left=0.0, right=0.0)  # noqa: E731
    fine = lambda a: bool(np.any((nm > a) & (nm < a + 1)))  # noqa: E731
    for a in range(359, 831):
        ends = [k for k in (a, a + 1) if 360 <= k <= 830]
        if not fine(a):
            for k in ends:
                # Exact integrals end where the data end; the sum at 1 nm counts half a nanometre more.
                beyond = nm[-1] <= a or nm[0] >= a + 1
                if not (beyond and fine(a - 1 if nm[-1] <= a else a + 1)):
                    out[k - 360] += 0.5 * value(k)
            continue
        bends = np.unique(np.concatenate(([a, a + 1], nm[(nm > a) & (nm < a + 1)])))
        bends = bends[(bends >= nm[0]) & (bends <= nm[-1])]
        low, width = bends[:-1], np.diff(bends)
        for node, weight in ((0.5 - 3**-0.5 / 2, 0.5), (0.5 + 3**-0.5 / 2, 0.5)):  # Gauss, exact for a cubic
            at = low + node * width
            for k in ends:
                out[k - 360] += np.sum(weight * width * value(at) * (1 - np.abs(at - k)))
    return out


def of_isolux(binary, files):
    done = subprocess.run([binary, "inspect", "--json", *files], capture_output=True, text=True, check=False)
    return [json.loads(line) for line in done.stdout.splitlines()]


def of_colour(nm, v):
    sd = colour.SpectralDistribution(dict(zip(nm, v)))
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(colour.SpectralShape(360, 830, 1))
    xyz = colour.sd_to_XYZ(sd, cmfs, method="Integration")
    x, y = colour.XYZ_to_xy(xyz)
    k = {"x": x, "y": y}
    cct, duv = colour.temperature.uv_to_CCT_Ohno2013(colour.UCS_to_uv(colour.XYZ_to_UCS(xyz)), cmfs)
    k["cct_k"], k["duv"] = float(cct), float(duv)
    k["ler_lm_per_w"] = colour.luminous_efficacy(
        sd, colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"].copy().align(colour.SpectralShape(360, 830, 1))
    )
    e = np.array([1 / 3, 1 / 3])
    # Its dominant wavelength is a whole number of nm, so only luxpy judges that.
    k["purity"] = float(colour.excitation_purity([x, y], e))
    if abs(duv) < 0.05:
        cri = colour.colour_rendering_index(sd, additional_data=True)
        k["ra"] = cri.Q_a
        k["r"] = [cri.Q_as[i].Q_a for i in range(1, 15)]
        tm = colour.colour_fidelity_index(sd, additional_data=True, method="ANSI/IES TM-30-18")
        k["rf"], k["rg"], k["rf_hue"] = tm.R_f, tm.R_g, list(tm.R_fs)
    sc = colour.SDS_LEFS["CIE 1951 Scotopic Standard Observer"].copy().align(
        colour.SpectralShape(360, 830, 1), extrapolator_kwargs={"method": "Constant", "left": 0, "right": 0}
    )
    ph = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"].copy().align(colour.SpectralShape(360, 830, 1))
    k["sp_ratio"] = 1700 * np.sum(sc.values * v) / (683 * np.sum(ph.values * v))
    return k


def of_luxpy(nm, v):
    spd = np.vstack([nm, v])
    xyz = lx.spd_to_xyz(spd, cieobs="1931_2", relative=False)
    Yxy = lx.xyz_to_Yxy(xyz)[0]
    k = {"x": Yxy[1], "y": Yxy[2]}
    cct, duv = lx.xyz_to_cct(xyz, cieobs="1931_2", out="cct,duv", mode="ohno2014")
    k["cct_k"], k["duv"] = float(np.squeeze(cct)), float(np.squeeze(duv))
    k["ler_lm_per_w"] = float(np.squeeze(lx.spd_to_ler(spd, cieobs="1931_2")))
    _, dominant, purity = lx.xyz_to_Ydlep(xyz, cieobs="1931_2", xyzw=np.full((1, 3), 100.0))[0]
    k["dominant_nm"], k["purity"] = (float(dominant) if dominant > 0 else None), float(purity)
    if abs(k["duv"]) < 0.05:
        k["ra"] = float(np.squeeze(lx.cri.spd_to_ciera(spd)))
        k["r"] = [float(x) for x in np.squeeze(lx.cri.spd_to_cri(spd, cri_type="ciera-14", out="Rfi"))]
        rf, rg, rfh = lx.cri.spd_to_cri(spd, cri_type="iesrf-tm30-18", out="Rf,Rg,Rfhj")
        k["rf"], k["rg"] = float(np.squeeze(rf)), float(np.squeeze(rg))
        k["rf_hue"] = [float(x) for x in np.squeeze(rfh)]
    return k


def distance(value, peers):
    """How far outside the interval of the peers."""
    peers = [p for p in peers if p is not None and np.isfinite(p)]
    if value is None or not peers:
        return None
    return max(min(peers) - value, value - max(peers), 0.0)


def main():
    binary = sys.argv[1]
    todo = spectra()
    for file in sorted(pathlib.Path(sys.argv[2]).glob("*.csv")) if len(sys.argv) > 2 else []:
        data = np.genfromtxt(file, delimiter=",", comments="#", skip_header=0)
        data = data[np.isfinite(data).all(axis=1)]
        todo[file.name] = (data[:, 0], data[:, 1])
    worst = {key: (0.0, "", None, None) for key in LIMIT}
    compared = dict.fromkeys(LIMIT, 0)
    missing = []
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for i, (nm, v) in enumerate(todo.values()):
            file = pathlib.Path(folder) / f"{i:03}.csv"
            file.write_text("wavelength_nm,value\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(nm.tolist(), v.tolist())))
            files.append(str(file))
        ours = of_isolux(binary, files)
    grid = np.arange(360.0, 831)
    for (name, (nm, v)), own in zip(todo.items(), ours):
        if not own["readable"]:
            missing.append(f"{name}: not read: {own['findings']}")
            continue
        at_1_nm = per_nm(nm, v)
        peers = []
        for library in (of_colour, of_luxpy):
            try:
                peers.append(library(grid, at_1_nm))
            except Exception as error:  # a library that gives up on a spectrum is no judge of it
                print(f"{library.__name__}: {name}: {type(error).__name__}: {error}"[:160])
        for key, limit in LIMIT.items():
            value = own["quantities"][key]
            lists = isinstance(value, list)
            wide = [p[key] for p in peers if p.get(key) is not None]
            # Beyond 0.05 from the locus there is no colour temperature (CIE 15): isolux gives null where the libraries go on.
            if value is None and key in NEEDS_CCT and own["quantities"]["cct_k"] is None:
                continue
            if value is None or not wide:
                if (value is None) != (not wide):
                    missing.append(f"{name}: {key}: isolux {value}, peers {wide}"[:150])
                continue
            n = min([len(value), *map(len, wide)]) if lists else 1
            for k in range(n):
                d = distance(value[k] if lists else value, [p[k] if lists else p for p in wide])
                if d is None:
                    continue
                compared[key] += 1
                if d > worst[key][0]:
                    worst[key] = (d, name, value[k] if lists else value, [p[k] if lists else p for p in wide])
                if d > limit:
                    missing.append(f"{name}: {key}[{k}]: isolux {value[k] if lists else value}, peers {[p[k] if lists else p for p in wide]}")
    for key, (d, name, value, peers) in worst.items():
        print(f"{key:14} {compared[key]:4} values, largest distance {d:.3g} (limit {LIMIT[key]}) {name} {value} {peers}")
    print(f"{len(todo)} spectra")
    for line in missing:
        print("differs:", line)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
