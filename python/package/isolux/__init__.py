"""Goniophotometer scans, photometric files, the light on a camera sensor, and why the two disagree.

What the program ``isolux`` does, as functions and classes. Angles are in degrees, lengths in mm unless a name says
otherwise; every name that carries a number ends in its unit.
"""

from isolux._errors import CheckFailed, InputError, InstrumentError, Interrupted, IsoluxError
from isolux._isolux import (
    Bench,
    LuxReading,
    Position,
    Scan,
    ScanEvent,
    ScanSummary,
    SpectrumReading,
    WarmedUp,
    __version__,
    init,
)

__all__ = [
    "Bench",
    "CheckFailed",
    "InputError",
    "InstrumentError",
    "Interrupted",
    "IsoluxError",
    "LuxReading",
    "Position",
    "Scan",
    "ScanEvent",
    "ScanSummary",
    "SpectrumReading",
    "WarmedUp",
    "__version__",
    "init",
]
