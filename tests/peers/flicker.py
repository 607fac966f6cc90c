#!/usr/bin/env python3
"""SVM, PstLM, depth and index of `isolux flicker` beside SciPy. Not needed to build.

    tests/peers/python.sh
    target/peers-python/bin/python tests/peers/flicker.py target/release/isolux

Waveforms of several shapes are written as CSV and evaluated by both; SciPy's chain is built of its own filters, its SVM
of the Fourier series of whole periods. Exit 1 if a limit is passed.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy import signal

# Relative differences; of values below a tenth, of a tenth. Components closer than 5 Hz are one to isolux.
LIMITS = {"SVM": 5e-3, "PstLM": 5e-4, "depth": 2e-3, "index": 2e-3}


def pst_lm(light, rate):
    x = light / light.mean() - 1
    x = signal.lfilter(*signal.bilinear([1, 0], [1, 2 * np.pi * 0.05], rate), x)
    analog = [
        signal.butter(6, 2 * np.pi * 35, analog=True, output="zpk"),
        signal.tf2zpk([0.041661, 44.758, 2715.6, 29839, 0], [1, 196.32, 11781, 534820, 3505380]),
    ]
    for zpk in analog:
        x = signal.sosfilt(signal.zpk2sos(*signal.bilinear_zpk(*zpk, rate)), x)
    levels = 1.101603155e6 * signal.lfilter(*signal.bilinear([1], [0.3, 1], rate), x * x)
    levels = levels[int(20 * rate):]

    def mean(*percents):
        return np.mean([np.percentile(levels, 100 - percent) for percent in percents])

    return np.sqrt(
        0.0314 * mean(0.1) + 0.0525 * mean(0.7, 1, 1.5) + 0.0657 * mean(2.2, 3, 4)
        + 0.28 * mean(6, 8, 10, 13, 17) + 0.08 * mean(30, 50, 80)
    )


def svm(light, rate):
    """Of a record of whole periods."""
    frequency = np.fft.rfftfreq(light.size, 1 / rate)
    amplitude = 2 * np.abs(np.fft.rfft(light)) / light.size / light.mean()
    threshold = 1 / (1 + np.exp(-0.00518 * (frequency - 306.6))) + 20 * np.exp(-frequency / 10)
    within = (frequency > 0) & (frequency <= 2000)
    return np.sum((amplitude[within] / threshold[within]) ** 3.7) ** (1 / 3.7)


def ours(isolux, light, rate):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "light.csv"
        path.write_text(f"# sample_rate_hz = {rate}\nvalue\n" + "\n".join(f"{value:.9f}" for value in light) + "\n")
        answer = subprocess.run([isolux, "flicker", "--json", "--dark", "0", path], capture_output=True, text=True)
    return json.loads(answer.stdout)["modulation"]


def main():
    isolux = sys.argv[1]
    rate, seconds = 4000, 180
    t = np.arange(rate * seconds) / rate
    shapes = {
        "sine 100 Hz": 1 + 0.3 * np.sin(2 * np.pi * 100 * t),
        "|sin| 120 Hz": 0.2 + np.abs(np.sin(np.pi * 120 * t)),
        "sine 8.8 Hz": 1 + 0.00448 * np.sin(2 * np.pi * 8.8 * t),
        "square 2 Hz": 1 + 0.01 * signal.square(2 * np.pi * 2 * t + 0.1),
        "100 Hz and 10 Hz": 1 + 0.2 * np.sin(2 * np.pi * 100 * t) + 0.01 * np.sin(2 * np.pi * 10 * t),
        "trapezoid 400 Hz": 1 + np.clip(0.9 * signal.sawtooth(2 * np.pi * 400 * t, 0.5), -0.5, 0.5),
    }
    worst = dict.fromkeys(LIMITS, 0.0)
    for name, light in shapes.items():
        found = ours(isolux, light, rate)
        pairs = {
            "SVM": (found["svm"]["quantity"]["value"], svm(light[:rate * 5], rate)),
            "PstLM": (found["pst_lm"]["quantity"]["value"], pst_lm(light, rate)),
            "depth": (
                0.01 * found["modulation_depth"]["value"],
                (light.max() - light.min()) / (light.max() + light.min()),
            ),
            "index": (
                found["flicker_index"]["value"],
                np.maximum(light - light.mean(), 0).sum() / light.sum(),
            ),
        }
        text = []
        for quantity, (one, other) in pairs.items():
            apart = abs(one - other) / max(abs(other), 0.1)
            worst[quantity] = max(worst[quantity], apart)
            text.append(f"{quantity} {one:.5f} {other:.5f}")
        print(f"{name}: {', '.join(text)}")
    print("largest difference:", ", ".join(f"{who} {value:.1e}" for who, value in worst.items()))
    return int(any(worst[who] > limit for who, limit in LIMITS.items()))


if __name__ == "__main__":
    sys.exit(main())
