#!/usr/bin/env python3
"""Absolute candela of `isolux convert` beside independent readers from PyPI.

    python3 -m venv .venv && .venv/bin/pip install numpy eulumdat-py==1.0.0 photompy==0.3.1
    .venv/bin/python tests/peers/intensities.py target/release/isolux FOLDER…

Reads every .ldt and .ies below the folders with isolux and with a peer (`pyldt` for EULUMDAT, `photompy` for LM-63),
compares the planes that both have at their common angles, and prints what differs. Exit 1 if anything does.
Files that only one of the two reads are counted, not judged. Every file that isolux reads is also written by it, as EULUMDAT
and as LM-63 of both editions, and the peer's reading of that is compared with the light of the source.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np

warnings.filterwarnings("ignore")


def isolux(program, path, folder):
    target = pathlib.Path(folder) / "x.json"
    target.unlink(missing_ok=True)
    subprocess.run([program, "convert", str(path), str(target), "--json"], capture_output=True, check=False)
    return json.loads(target.read_text()) if target.exists() else None


def eulumdat(path):
    """cd/klm of pyldt, expanded by itself, to candela by line 26c of the first set and line 24."""
    from pyldt import LdtReader

    ldt = LdtReader.read(path)
    header = ldt.header
    factor = header.lamp_flux[0] / 1000 * (header.conv_factor or 1)
    rows = np.array(ldt.intensities, float) * factor
    return np.array(header.c_angles, float), np.array(header.g_angles, float), rows


def lm63(path):
    """photompy's values as stored, times multiplier and ballast factor; its rows are the file's horizontal angles."""
    from photompy import IESFile

    ies = IESFile.read(str(path), strict=False)
    header, raw = ies.header, ies.photometry
    factor = header.multiplier * header.ballast_factor
    if any(year in str(header.version) for year in ("86", "91")):
        factor *= header.future_use
    return np.array(raw.phis, float), np.array(raw.thetas, float), np.array(raw.values, float) * factor


def compare(document, peer):
    c_deg, gamma_deg, rows = peer
    ours = np.array(document["intensity_cd"])
    own_c, own_gamma = np.array(document["c_deg"]), np.array(document["gamma_deg"])
    if not np.array_equal(own_gamma, gamma_deg):
        return f"γ differ: {own_gamma[[0, -1]]} × {len(own_gamma)} and {gamma_deg[[0, -1]]} × {len(gamma_deg)}"
    peak, worst, at = np.abs(ours).max(), 0.0, None
    for c, row in zip(c_deg, rows):
        match = [0] if len(own_c) == 1 else np.flatnonzero(np.abs((own_c - c + 180) % 360 - 180) < 1e-6)
        if len(match) == 0:
            return f"no plane at C {c}"
        if c == 360 and c_deg[0] == 0:
            continue
        off = np.abs(ours[match[0]] - row).max()
        if off > worst:
            worst, at = off, c
    return None if worst <= 1e-6 * peak else f"C {at}: {worst:g} cd apart, peak {peak:g} cd"


def written(program, path, document, folder):
    """What the peers read out of what isolux writes: (target, problem or None, None where the peer does not read it)."""
    for target, reader, options in (
        ("x.ldt", eulumdat, []),
        ("x.ies", lm63, []),
        ("x2019.ies", lm63, ["--edition", "2019"]),
    ):
        copy = pathlib.Path(folder) / target
        copy.unlink(missing_ok=True)
        subprocess.run([program, "convert", str(path), str(copy), *options], capture_output=True, check=False)
        try:
            peer = reader(copy)
        except Exception:
            yield target, False, None
            continue
        yield target, True, compare(document, peer)


def main():
    program, folders = sys.argv[1], sys.argv[2:]
    copies = {True: 0, False: 0}
    same = only_isolux = only_peer = neither = resampled = 0
    different = []
    with tempfile.TemporaryDirectory() as folder:
        for root in folders:
            for path in sorted(pathlib.Path(root).rglob("*")):
                reader = {".ldt": eulumdat, ".ies": lm63}.get(path.suffix.lower())
                if reader is None or not path.is_file():
                    continue
                document = isolux(program, path, folder)
                if document is not None:
                    for target, read, problem in written(program, path, document, folder):
                        copies[read] += 1
                        if problem or not read:
                            different.append((path, f"as {target}: {problem or 'not read by the peer'}"))
                try:
                    peer = reader(path)
                except Exception:  # a peer that fails in any way has not read the file
                    peer = None
                if document is None or peer is None:
                    neither += document is None and peer is None
                    only_isolux += document is not None and peer is None
                    only_peer += document is None and peer is not None
                    if document is None and peer is not None:
                        print(f"only the peer reads {path}")
                    continue
                if document.get("resampled"):
                    resampled += 1
                    continue
                problem = compare(document, peer)
                if problem:
                    different.append((path, problem))
                else:
                    same += 1
    for path, problem in different:
        print(f"{path}: {problem}")
    print(f"of what isolux wrote, {copies[True]} were read by the peer, {copies[False]} not")
    print(f"{same} the same within 1e-6 of the peak, {len(different)} different, {resampled} resampled (types A, B),")
    print(f"{only_isolux} read by isolux alone, {only_peer} by the peer alone, {neither} by neither")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
