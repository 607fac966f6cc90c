# ---------------------------------------------------------------------------------------------------------------------
# The bench: src/bench.rs, src/bench/.

from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Optional, Union, final

import numpy as np
import numpy.typing as npt

_Path = Union[str, PathLike[str]]

def init(
    folder: _Path,
    *,
    lamp: Optional[_Path] = None,
    plan: Literal["near", "published-10m"] = "near",
    in_motion: bool = False,
    colour: bool = False,
    overwrite: bool = False,
) -> list[Path]:
    """Writes a station, plan, scene and job of the virtual darkroom to start from; the files written.

    :param lamp: a photometric file whose luminaire the room gets, and a plan for it; ``plan`` is then not used. How the
        grid was chosen, and what had to be assumed of the lamp, comes as warnings.
    :param in_motion: the distribution is read while γ moves, by twins that can.
    :param colour: the plan takes spectra over angle.
    :raises InputError: one of the files exists and ``overwrite`` is false (then none is written), or no lamp can be
        made of the photometric file.
    """

def close_benches() -> None:
    """Closes every bench that is open; called at the end of the program.

    :raises InstrumentError: an axis could not be verified at rest.
    """

@final
class Position:
    """Where the axes stand, read back."""

    @property
    def c_deg(self) -> float:
        """C in degrees."""
    @property
    def gamma_deg(self) -> float:
        """γ in degrees, signed."""
    @property
    def distance_mm(self) -> Optional[float]:
        """Distance of the detector in mm, where a rail drives it; after ``move`` and ``home`` where it was moved."""

@final
class LuxReading:
    """One reading of the lux meter, and of the power meter with it."""

    @property
    def illuminance_lx(self) -> Optional[float]:
        """Illuminance in lx after the station's calibration factor; ``None`` out of range or of unsteady light."""
    @property
    def digit_lx(self) -> float:
        """One digit of the display in lx."""
    @property
    def range(self) -> int:
        """The meter's range."""
    @property
    def quality(self) -> Literal["ok", "over_range", "under_range", "unsteady"]:
        """Whether it has a number, and why not."""
    @property
    def voltage_v(self) -> Optional[float]:
        """Voltage of the lamp's supply in V, where the bench has a power meter that gave a number."""
    @property
    def current_a(self) -> Optional[float]:
        """Its current in A."""
    @property
    def power_w(self) -> Optional[float]:
        """Its active power in W."""
    @property
    def power_factor(self) -> Optional[float]:
        """Active power ÷ (voltage · current)."""

@final
class SpectrumReading:
    """One spectrum of the light as it is, with its colorimetry. Arrays are read-only views."""

    @property
    def wavelength_nm(self) -> npt.NDArray[np.float64]:
        """Wavelengths in nm, shape (n,): pixels with a calibration."""
    @property
    def irradiance_w_m2_nm(self) -> npt.NDArray[np.float64]:
        """Spectral irradiance in W/(m² nm), shape (n,)."""
    @property
    def integration_s(self) -> float:
        """Integration time that was found, in s."""
    @property
    def peak_of_saturation(self) -> float:
        """Highest raw counts as a share of saturation."""
    @property
    def saturated_pixels(self) -> int:
        """Pixels at or above saturation: their values are "at least"."""
    @property
    def dark(self) -> Literal["dark_pixels", "shutter"]:
        """What was subtracted as dark."""
    @property
    def detector_c(self) -> Optional[float]:
        """Temperature of the detector in °C, where the instrument states it."""
    @property
    def illuminance_lx(self) -> float:
        """Illuminance by V(λ) and 683 lm/W, in lx."""
    @property
    def irradiance_w_m2(self) -> float:
        """Irradiance over 360–830 nm, in W/m²."""
    @property
    def quantities(self) -> dict[str, Any]:
        """Colorimetry: ``x``, ``y``, ``cct_k``, ``duv``, ``ra``, ``rf``, ``peak_nm``, …; ``None`` where not defined."""

@final
class WarmedUp:
    """The lamp is stable."""

    @property
    def elapsed_s(self) -> float:
        """Seconds since it was switched on."""
    @property
    def spread_rel(self) -> float:
        """(max − min)/mean over the window."""
    @property
    def illuminance_lx(self) -> float:
        """Illuminance at the reference point in lx."""

@final
class ScanEvent:
    """Something that happened in a scan, and how far it is."""

    @property
    def kind(self) -> str:
        """``began``, ``homed``, ``lamp``, ``warm_up``, ``stable``, ``block``, ``reading``, ``spectrum``, ``sweep``,
        ``note``, ``stopped``, …: the names of events.jsonl."""
    @property
    def time_utc(self) -> str:
        """When, UTC, RFC 3339, by the clock of the bench."""
    @property
    def state(self) -> Optional[str]:
        """``homing``, ``warming_up``, ``scanning``, ``paused``, ``resuming``, ``completed``, ``interrupted`` or
        ``failed``; ``None`` before the first of them."""
    @property
    def sentence(self) -> Optional[str]:
        """It in words, where there are any."""
    @property
    def done(self) -> int:
        """Points of the plan that are done."""
    @property
    def total(self) -> int:
        """Points of the plan."""
    @property
    def remaining_s(self) -> Optional[float]:
        """Estimated time that is left in s of the bench's clock, where it is known."""
    @property
    def c_deg(self) -> Optional[float]:
        """Of a reading: C in degrees, read back."""
    @property
    def gamma_deg(self) -> Optional[float]:
        """Of a reading: γ in degrees, signed, read back."""
    @property
    def illuminance_lx(self) -> Optional[float]:
        """Of a reading: illuminance in lx; ``None`` where it has no number, and ``quality`` says why."""
    @property
    def quality(self) -> Optional[str]:
        """Of a reading: ``ok``, ``over_range``, ``under_range``, ``unsteady``, …"""
    @property
    def facts(self) -> dict[str, Any]:
        """Everything that is known of it, as in events.jsonl; of a reading its row of readings.csv."""

@final
class ScanSummary:
    """What a scan came to."""

    @property
    def run(self) -> str:
        """The run directory."""
    @property
    def points(self) -> int:
        """Points of the plan."""
    @property
    def readings(self) -> int:
        """Readings recorded in this session."""
    @property
    def spectra(self) -> int:
        """Spectra recorded in this session."""
    @property
    def without_number(self) -> int:
        """Readings without a number: over or under range, failed."""
    @property
    def unsettled(self) -> int:
        """Points whose light did not settle."""
    @property
    def retries(self) -> int:
        """Answers that were lost or damaged and asked again."""
    @property
    def visits_again(self) -> int:
        """Visits that were made again: an axis or output was not as it was left, or readings did not agree."""
    @property
    def duration_s(self) -> float:
        """How long it took, in s of the bench's clock."""
    @property
    def warm_up_s(self) -> Optional[float]:
        """Seconds until the lamp was stable, where it was warmed up."""

@final
class Scan:
    """A scan that is on: an iterator of its events.

    Whoever leaves it early (``break``, an exception, ``del``, Ctrl-C) ends the scan where it is: what moves is stopped
    and verified at rest, what was read stays, and ``resume=True`` goes on later. A virtual bench in memory waits for
    whoever iterates, a real one does not. It is a context manager as well.
    """

    @property
    def run(self) -> str:
        """The run directory."""
    @property
    def ended(self) -> bool:
        """Whether the scan has ended, well or not."""
    def result(self) -> ScanSummary:
        """Waits until the scan has ended, without its events; what it came to.

        :raises CheckFailed: a check of the plan's limits failed.
        :raises InstrumentError: an instrument failed, or an axis could not be verified at rest.
        :raises Interrupted: ``close`` or ``Bench.stop`` has ended it.
        """
    def close(self) -> None:
        """Ends the scan where it is, as leaving the iterator does.

        :raises InstrumentError: an axis could not be verified at rest.
        """
    def __iter__(self) -> Iterator[ScanEvent]: ...
    def __next__(self) -> ScanEvent:
        """:raises StopIteration: the scan has ended; else as :meth:`result`."""
    def __enter__(self) -> Scan: ...
    def __exit__(
        self,
        kind: Optional[type[BaseException]],
        exception: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None: ...

@final
class Bench:
    """The instruments of a station, open from here to ``close``.

    Every way there stops the axes and verifies that they rest: the end of the ``with`` block, an exception, Ctrl-C,
    SIGTERM, ``del``, the end of the program. What a signal raises in a call is raised after that. Calls may come from
    any thread; the steps follow one another, and the interpreter is free meanwhile.

    :param station: the station file; ``None``: the built-in virtual darkroom in memory, where hours pass in seconds.
    :param force: the reason for which the instruments may be taken over from a process that does not answer.
    :raises InputError: file and line of what the station has wrong. Nothing was opened.
    :raises InstrumentError: an instrument does not open, or belongs to another process or bench.
    """

    def __new__(cls, station: Optional[_Path] = None, *, force: Optional[str] = None) -> Bench: ...
    @property
    def station(self) -> Optional[str]:
        """The station file; ``None``: the built-in virtual darkroom."""
    @property
    def in_memory(self) -> bool:
        """Whether the whole bench is virtual, in virtual time: none passes between two calls."""
    @property
    def closed(self) -> bool:
        """Whether it is closed; then every other call raises :class:`InputError`."""
    @property
    def notes(self) -> list[str]:
        """What was said while it was opened."""
    @property
    def position(self) -> Position:
        """Where the axes stand, read back from the instruments, and the detector where a rail drives it.

        :raises InstrumentError: an axis does not answer.
        """
    def home(self) -> Position:
        """Finds the reference of both axes, γ first. Moves them.

        :raises InstrumentError: an axis failed; both were stopped.
        """
    def move(
        self,
        c_deg: Optional[float] = None,
        gamma_deg: Optional[float] = None,
        *,
        distance_mm: Optional[float] = None,
    ) -> Position:
        """Moves axes and detector and waits until they rest where they were sent; what is not given stays.

        :param c_deg: C in degrees.
        :param gamma_deg: γ in degrees, signed.
        :param distance_mm: distance of the detector in mm, where a rail drives it.
        :raises InputError: outside the limits of the station, or no rail. Nothing was moved.
        :raises InstrumentError: an axis failed or rests elsewhere; all were stopped.
        :raises Interrupted: ``stop`` or ``close`` in another thread has ended it.
        """
    def read(self) -> LuxReading:
        """One new reading of the lux meter, and of the power meter with it, with lamp, shutter and baffle as they are.

        :raises InstrumentError: the meter does not answer.
        """
    def spectrum(self) -> SpectrumReading:
        """One spectrum with the integration time that its light needs, with lamp, shutter and baffle as they are.

        :raises InputError: the station has no spectroradiometer, or nothing to make its dark with.
        :raises InstrumentError: it does not answer, or its light is outside what it can expose.
        """
    def switch(
        self,
        *,
        lamp: Optional[bool] = None,
        shutter: Optional[bool] = None,
        baffle: Optional[bool] = None,
        supply: Optional[bool] = None,
    ) -> dict[str, bool]:
        """Switches outputs, one after the other, and reads each back: ``True`` is lit, open, in the beam, feeding.

        :raises InputError: the station does not have the output or leaves it to a person. Nothing was switched.
        """
    def warm_up(
        self, progress: Optional[Callable[[str, Optional[int], Optional[int], str], object]] = None
    ) -> WarmedUp:
        """Switches the lamp on, opens the path, goes to the reference point and waits until the lamp is stable.

        :param progress: called with the step, seconds done and in all, and a sentence.
        :raises CheckFailed: it does not become stable.
        """
    def scan(
        self,
        plan: _Path,
        out: _Path,
        *,
        resume: bool = False,
        reread: bool = False,
        ask: Optional[Callable[[str], Optional[str]]] = None,
    ) -> Scan:
        """Begins to carry out a plan into a run directory; no other step is done meanwhile.

        :param out: the run directory; new or empty, or with ``resume`` one that broke off.
        :param reread: as ``resume``, for a damaged record: what is whole stays, the rest is read again.
        :param ask: the person beside the bench: called with what is to be done, returns who has done it, or ``None``.
        :raises InputError: file and line of what the plan asks and the bench does not have. Nothing was moved.
        """
    def stop(self) -> Position:
        """Ends what other threads do here, stops everything that moves and verifies that it rests; where.

        :raises InstrumentError: an axis could not be verified at rest.
        """
    def close(self) -> None:
        """Stops everything that moves, verifies that it rests, and closes the instruments. Once is enough.

        :raises InstrumentError: an axis could not be verified at rest.
        """
    def __enter__(self) -> Bench: ...
    def __exit__(
        self,
        kind: Optional[type[BaseException]],
        exception: Optional[BaseException],
        traceback: Optional[TracebackType],
    ) -> None: ...

# ---------------------------------------------------------------------------------------------------------------------
# Both halves.

__version__: str

def run_program(words: list[str]) -> int:
    """Runs the program ``isolux`` with ``words``, its own name first, and returns its exit code."""
