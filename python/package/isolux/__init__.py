"""Goniophotometer scans, photometric files, the light on a camera sensor, and why the two disagree.

What the program ``isolux`` does, as functions and classes. Angles are in degrees, lengths in mm unless a name says
otherwise; every name that carries a number ends in its unit.
"""

from isolux._errors import CheckFailed, InputError, InstrumentError, IsoluxError
from isolux._isolux import __version__

__all__ = ["CheckFailed", "InputError", "InstrumentError", "IsoluxError", "__version__"]
