"""The record of a scan as tables, and what it is reduced to."""

from __future__ import annotations

import functools
from os import PathLike
from typing import Any, Optional, Union

import numpy as np

from isolux import _isolux
from isolux._isolux import Reduction
from isolux._tables import one_dimensional, structured


class Run(_isolux.Run):
    """A run directory: what a scan recorded, whole or broken off.

    Raises ``InputError`` for a folder that is no run, or whose files are not as they were recorded.
    """

    @functools.cached_property
    def readings(self) -> np.ndarray:
        """One record a reading of the lux meter, with the columns of ``readings.csv``.

        ``illuminance_lx`` is NaN where ``quality`` is not ``"ok"``; times are in seconds since the run began.
        """
        return structured(self._reading_columns())

    @functools.cached_property
    def spectra(self) -> np.ndarray:
        """One record a spectrum; ``wavelength_nm``, ``counts``, ``dark_counts`` and ``irradiance_w_m2_nm`` hold one
        value a pixel, the last one in W/m²/nm, NaN where a pixel was saturated."""
        return structured(self._spectrum_columns())

    def to_pandas(self) -> Any:
        """The readings as a ``pandas.DataFrame``. Needs pandas."""
        import pandas  # type: ignore[import-untyped,unused-ignore]

        return pandas.DataFrame(one_dimensional(self.readings))

    def to_arrow(self) -> Any:
        """The readings as a ``pyarrow.Table``. Needs pyarrow."""
        import pyarrow  # type: ignore[import-untyped,unused-ignore]

        return pyarrow.table(one_dimensional(self.readings))

    def reduce(
        self,
        *,
        dark: bool = True,
        ambient: bool = True,
        stray: bool = True,
        spectral_mismatch: bool = True,
        linearity: bool = True,
        temperature: bool = True,
        cosine: bool = True,
        fatigue: bool = True,
        inverse_square: bool = True,
        drift: bool = True,
        spectral_dark: bool = True,
        wavelengths: bool = True,
        bandpass: bool = True,
        scatter: bool = True,
        spectral_linearity: bool = True,
        smoothing: bool = True,
        model: Optional[Union[str, "PathLike[str]"]] = None,
        accept_drift: Optional[str] = None,
        out: Optional[Union[str, "PathLike[str]"]] = None,
        force: bool = False,
    ) -> Reduction:
        """Distribution, spectrum and uncertainty budget of the run; each correction can be left out.

        ``model``: a model whose bench effects are taken out. ``accept_drift``: why a drift beyond the limits of the
        plan is accepted. ``out``: a folder for the result files, as ``isolux reduce --out`` writes them; without it
        nothing is written.

        Raises ``CheckFailed`` for a drift, an unstable reference or a closing half-plane beyond the limits of the
        plan, ``InputError`` for a record that gives no distribution.
        """
        corrections = {
            "dark": dark,
            "ambient": ambient,
            "stray": stray,
            "spectral_mismatch": spectral_mismatch,
            "linearity": linearity,
            "temperature": temperature,
            "cosine": cosine,
            "fatigue": fatigue,
            "inverse_square": inverse_square,
            "drift": drift,
            "spectral_dark": spectral_dark,
            "wavelengths": wavelengths,
            "bandpass": bandpass,
            "scatter": scatter,
            "spectral_linearity": spectral_linearity,
            "smoothing": smoothing,
        }
        without = [name for name, applied in corrections.items() if not applied]
        return self._reduce(
            without, out=out, force=force, model=model, accept_drift=accept_drift
        )
