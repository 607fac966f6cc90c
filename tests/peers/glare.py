#!/usr/bin/env python3
"""UGR tables of `isolux inspect` beside those of another program and beside published ones. Not needed to build.

    pip install eulumdat-ugr            # MIT; brings eulumdat-py and eulumdat-luminance
    git clone https://github.com/123VincentB/eulumdat-ugr REFERENCES
    python tests/peers/glare.py target/release/isolux REFERENCES

REFERENCES/data/input holds eleven luminaires, REFERENCES/data/reference the tables that Relux and DIALux print for them
and, for the eleventh, the uncorrected table of CIE 190:2010. That one is for luminaires 1 H apart, all others for 0.25 H;
it is compared with the package, which is compared with isolux at 0.25 H. Exit 1 if a limit is passed.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from eulumdat_ugr import UgrCalculator
from pyldt import LdtReader

# Largest distances, in UGR. Relux rounds spots below 10 to "<10.0"; DIALux lies below Relux in small rooms.
LIMITS = {"package": 0.55, "Relux": 0.45, "Dialux": 1.05}


def printed(path):
    """A table of 19 rooms × 10 columns; what is no number ("<10.0") is left out."""
    rows = []
    for line in path.read_text(encoding="utf-8-sig").splitlines():
        if line.strip():
            cells = line.replace(";", ",").split(",")
            rows.append([float(cell) if cell.strip()[0] not in "<>" else np.nan for cell in cells])
    return np.array(rows)


def ours(isolux, path):
    answer = subprocess.run([isolux, "inspect", "--json", path], capture_output=True, text=True, check=False)
    table = json.loads(answer.stdout)["quantities"]["ugr"]
    return np.array([a + b for a, b in zip(table["crosswise"], table["endwise"])], dtype=float)


def main():
    isolux, references = sys.argv[1], Path(sys.argv[2]) / "data"
    worst = dict.fromkeys(LIMITS, 0.0)
    for path in sorted((references / "input").glob("sample_*.ldt")):
        number = path.stem.split("_")[1]
        table = ours(isolux, path)
        others = {"package": UgrCalculator.compute(LdtReader.read(str(path))).values}
        for program in ("Relux", "Dialux"):
            others[program] = printed(references / "reference" / f"ugr_table_{number}_{program}.csv")
        text = []
        for who, other in others.items():
            apart = table - other
            worst[who] = max(worst[who], float(np.nanmax(np.abs(apart))))
            text.append(f"{who} {np.nanmean(apart):+.2f} ({np.nanmin(apart):+.2f} … {np.nanmax(apart):+.2f})")
        print(f"{path.name}: {', '.join(text)}")
    eleventh = LdtReader.read(str(references / "input" / "sample_11.ldt"))
    published = printed(references / "reference" / "ugr_table_11_cie190.csv")
    apart = UgrCalculator.compute(eleventh, _shr=1.0).values - published
    print(f"package at 1 H beside CIE 190: {np.nanmin(apart):+.2f} … {np.nanmax(apart):+.2f}")
    print("largest distance:", ", ".join(f"{who} {value:.2f}" for who, value in worst.items()))
    return int(any(worst[who] > limit for who, limit in LIMITS.items()))


if __name__ == "__main__":
    sys.exit(main())
