"""Goniophotometer scans, photometric files, the light on a camera sensor, and why the two disagree.

What the program ``isolux`` does, as functions and classes. Angles are in degrees, lengths in mm unless a name says
otherwise; every name of a number ends in its unit.
"""

from isolux._diagnosis import Diagnosis, diagnose, predict
from isolux._errors import CheckFailed, InputError, InstrumentError, Interrupted, IsoluxError
from isolux._isolux import (
    Bench,
    Distribution,
    LuxReading,
    Position,
    Quantity,
    Reduction,
    Scan,
    ScanEvent,
    ScanSummary,
    Simulation,
    Spectrum,
    SpectrumReading,
    WarmedUp,
    __version__,
    init,
    read,
    read_all,
    simulate,
)
from isolux._run import Run

__all__ = [
    "Bench",
    "CheckFailed",
    "Diagnosis",
    "Distribution",
    "InputError",
    "InstrumentError",
    "Interrupted",
    "IsoluxError",
    "LuxReading",
    "Position",
    "Quantity",
    "Reduction",
    "Run",
    "Scan",
    "ScanEvent",
    "ScanSummary",
    "Simulation",
    "Spectrum",
    "SpectrumReading",
    "WarmedUp",
    "__version__",
    "diagnose",
    "init",
    "predict",
    "read",
    "read_all",
    "simulate",
]
