"""Goniophotometer scans, photometric files, the light on a camera sensor, and why the two disagree.

What the program ``isolux`` does, as functions and classes. Angles are in degrees, lengths in mm unless a name says
otherwise; every name of a number ends in its unit.
"""

from isolux._diagnosis import Diagnosis, diagnose, predict
from isolux._errors import CheckFailed, InputError, InstrumentError, IsoluxError
from isolux._isolux import (
    Distribution,
    Quantity,
    Reduction,
    Simulation,
    Spectrum,
    __version__,
    read,
    read_all,
    simulate,
)
from isolux._run import Run

__all__ = [
    "CheckFailed",
    "Diagnosis",
    "Distribution",
    "InputError",
    "InstrumentError",
    "IsoluxError",
    "Quantity",
    "Reduction",
    "Run",
    "Simulation",
    "Spectrum",
    "__version__",
    "diagnose",
    "predict",
    "read",
    "read_all",
    "simulate",
]
