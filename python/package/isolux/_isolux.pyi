"""The native half of the package. What is public stands in ``isolux``."""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_AnyPath = Union[str, PathLike[str]]
#: Called with the step, units done and in all where they are counted, and a sentence.
_Progress = Callable[[str, Optional[int], Optional[int], str], Any]

@final
class Distribution:
    """A luminous intensity distribution in candela over C (degrees, full circle) and gamma (degrees, 0 to 180)."""

    def __new__(
        cls, c_deg: NDArray[np.float64], gamma_deg: NDArray[np.float64], intensity_cd: NDArray[np.float64]
    ) -> Distribution:
        """Absolute photometry from arrays: C of the half-planes (n,), gamma (m,), candela (n, m). One half-plane means
        rotational symmetry. Raises ``InputError`` for angles that do not rise or values that are not finite."""
    @property
    def c_deg(self) -> NDArray[np.float64]:
        """Half-planes in degrees, rising within [0, 360), shape (n,); read-only, not a copy."""
    @property
    def gamma_deg(self) -> NDArray[np.float64]:
        """Angles in degrees, rising within [0, 180], shape (m,); read-only, not a copy."""
    @property
    def intensity_cd(self) -> NDArray[np.float64]:
        """Candela of the grid, shape (n, m); read-only, not a copy. Negative values are data."""
    @overload
    def intensity(self, c_deg: float, gamma_deg: float) -> float: ...
    @overload
    def intensity(self, c_deg: ArrayLike, gamma_deg: ArrayLike) -> NDArray[np.float64]:
        """Candela toward (C, gamma) in degrees, bilinear between the directions of the grid; arrays are broadcast.
        Zero beyond the grid's gamma. Raises ``InputError`` for gamma outside 0 to 180."""
    @property
    def flux_lm(self) -> float:
        """Luminous flux in lm: the integral over the grid."""
    def flux_between_lm(self, from_deg: float, to_deg: float) -> float:
        """Luminous flux in lm between two angles gamma in degrees."""
    def zonal_flux_lm(self, step_deg: float = 10.0) -> NDArray[np.float64]:
        """Luminous flux in lm of rings of gamma, each ``step_deg`` wide."""
    def beam_angle_deg(self, c_deg: float = 0.0) -> Optional[float]:
        """Beam angle in degrees (50 % of the maximum, CIE S 017 17-27-097) of the plane through half-plane C; None
        where the intensity does not fall so far."""
    def field_angle_deg(self, c_deg: float = 0.0) -> Optional[float]:
        """Field angle in degrees (10 % of the maximum) of the plane through half-plane C."""
    @property
    def quantities(self) -> Dict[str, Any]:
        """What follows from the distribution, with the keys of ``isolux inspect --json``: zones, UGR, ratings …"""
    @property
    def findings(self) -> List[Dict[str, Any]]:
        """What the reader found: code, severity, line, column, message and fix each."""
    @property
    def header(self) -> Dict[str, Any]:
        """Every field of the file's description."""
    @property
    def file_name(self) -> str:
        """Name of the file."""
    @property
    def is_coloured(self) -> bool:
        """Whether the file holds spectra over angle."""
    def write(
        self,
        path: _AnyPath,
        *,
        force: bool = False,
        edition: Optional[str] = None,
        generation: Optional[str] = None,
        photometry: Optional[str] = None,
        rotate_c_deg: Optional[float] = None,
        symmetrize: Optional[str] = None,
        resample_deg: Optional[Tuple[float, float]] = None,
        scale_flux_lm: Optional[float] = None,
        entries: Optional[Sequence[Tuple[str, str]]] = None,
    ) -> List[Dict[str, Any]]:
        """Writes a file of the format of its extension (.ldt, .ies, .xml, .json …); returns what was lost or assumed.

        ``force`` replaces a file; the other keywords are the options of ``isolux convert``. Raises ``InputError``
        where the format cannot hold the distribution; nothing is written then."""
    def plot(self, ax: Optional[Any] = None) -> Any:
        """A polar diagram on a matplotlib axes, made where none is given; returns the axes. Needs matplotlib."""
    def svg(self, kind: str = "polar") -> str:
        """A picture of the report as SVG: "polar", "cartesian", "isocandela", "isolux" or "solid"."""
    def _repr_svg_(self) -> str: ...
    def _repr_html_(self) -> str: ...

@final
class Spectrum:
    """A spectrum: values over wavelengths in nm."""

    def __new__(
        cls,
        wavelength_nm: NDArray[np.float64],
        value: NDArray[np.float64],
        *,
        quantity: Optional[str] = None,
        unit: Optional[str] = None,
    ) -> Spectrum:
        """A spectrum from arrays of one length: wavelengths in nm, rising, and values. Raises ``InputError``."""
    @property
    def wavelength_nm(self) -> NDArray[np.float64]:
        """Wavelengths in nm, rising, shape (n,); read-only, not a copy."""
    @property
    def value(self) -> NDArray[np.float64]:
        """One value a wavelength in ``unit``, shape (n,); read-only, not a copy."""
    @property
    def quantity(self) -> Optional[str]:
        """What the values are, where the file says so."""
    @property
    def unit(self) -> Optional[str]:
        """Unit of the values, where the file says so."""
    @property
    def series(self) -> List[str]:
        """Names of the series of a file with several."""
    @property
    def ler_lm_per_w(self) -> Optional[float]:
        """Luminous efficacy of the radiation in lm/W."""
    @property
    def cct_k(self) -> Optional[float]:
        """Correlated colour temperature in K; None where there is none."""
    @property
    def duv(self) -> Optional[float]:
        """Distance from the Planckian locus in CIE 1960 (u, v)."""
    @property
    def ra(self) -> Optional[float]:
        """General colour rendering index (CIE 13.3)."""
    @property
    def quantities(self) -> Dict[str, Any]:
        """What follows from the spectrum, with the keys of ``isolux inspect --json``: x, y, Ra, R1–R15, Rf, Rg …"""
    @property
    def findings(self) -> List[Dict[str, Any]]:
        """What the reader found: code, severity, line, column, message and fix each."""
    @property
    def header(self) -> Dict[str, Any]:
        """Every other field of the file."""
    @property
    def file_name(self) -> str:
        """Name of the file."""
    def write(
        self,
        path: _AnyPath,
        *,
        force: bool = False,
        series: Optional[str] = None,
        step_nm: Optional[float] = None,
        interpolation: str = "sprague",
    ) -> List[Dict[str, Any]]:
        """Writes a file of the format of its extension (.spdx, .spd, .csv, .json …); returns what was lost or assumed.

        ``step_nm`` resamples, by "sprague" (CIE 167, even spacing) or "linear". Raises ``InputError``."""
    def plot(self, ax: Optional[Any] = None) -> Any:
        """Values over wavelength on a matplotlib axes, made where none is given; returns the axes. Needs matplotlib."""
    def svg(self, kind: str = "spectrum") -> str:
        """A picture of the report as SVG: "spectrum", "cie1931", "cie1976", "tm30" or "tm30_bins"."""
    def _repr_svg_(self) -> str: ...
    def _repr_html_(self) -> str: ...

@final
class Simulation:
    """A map of the light on a sensor, with its bound and facts; ``numpy.asarray`` gives the map."""

    @property
    def irradiance(self) -> NDArray[np.float64]:
        """Mean of each pixel in ``unit``, shape (ny, nx), row 0 at the smallest y; read-only, not a copy."""
    def __array__(self, dtype: Optional[Any] = None, copy: Optional[bool] = None) -> NDArray[Any]: ...
    @property
    def unit(self) -> str:
        """"W/m²", or "lx" where the luminaire has no spectrum and no efficacy."""
    @property
    def mean(self) -> float:
        """Mean over the sensor, in ``unit``."""
    @property
    def u_mean_numeric(self) -> float:
        """Inverse: bound on the error of the quadrature of the mean; direct: its standard error by ray counting."""
    @property
    def pixel_error_bound(self) -> Optional[Dict[str, float]]:
        """What the error of no pixel exceeds: "absolute" in ``unit`` and "relative"; None for the direct method."""
    @property
    def facts(self) -> Dict[str, Any]:
        """All facts, with the keys of ``result.json``."""
    @property
    def signal_dn(self) -> Optional[NDArray[np.uint16]]:
        """Digital numbers of one exposure, shape (ny, nx), where the scene has a camera."""
    @property
    def x_mm(self) -> NDArray[np.float64]:
        """Middles of the pixels along x in mm, shape (nx,)."""
    @property
    def y_mm(self) -> NDArray[np.float64]:
        """Middles of the pixels along y in mm, shape (ny,)."""
    def plot(self, ax: Optional[Any] = None) -> Any:
        """The map on a matplotlib axes, made where none is given; returns the axes. Needs matplotlib."""
    def write(self, out: _AnyPath, *, force: bool = False) -> None:
        """Writes ``irradiance.npy`` (float32), ``irradiance.png`` and ``result.json`` as ``isolux simulate`` does."""
    def _repr_png_(self) -> bytes: ...

@final
class Quantity:
    """A number with its unit and standard uncertainty; ``float`` gives the number, ``str`` states it with U (k = 2)."""

    @property
    def value(self) -> float:
        """The number, in ``unit``."""
    @property
    def unit(self) -> str:
        """Its unit."""
    @property
    def u(self) -> Optional[float]:
        """Standard uncertainty (k = 1); None where ``missing`` says what is not known."""
    @property
    def parts(self) -> Dict[str, float]:
        """The known parts of the uncertainty by name; they add in squares."""
    @property
    def missing(self) -> List[str]:
        """What was neither measured nor stated, one phrase each."""
    def __float__(self) -> float: ...

@final
class Reduction:
    """What a run was reduced to, in memory."""

    @property
    def flux(self) -> Quantity:
        """Luminous flux in lm."""
    @property
    def i_max(self) -> Quantity:
        """Largest intensity in cd."""
    @property
    def i_max_deg(self) -> Tuple[float, float]:
        """Its direction (C, gamma) in degrees."""
    @property
    def ler(self) -> Optional[Quantity]:
        """Luminous efficacy of the radiation in lm/W, where a spectrum was taken."""
    @property
    def irradiance_on_axis(self) -> Optional[Quantity]:
        """Irradiance on the axis in W/m² at the distance of the spectrum, where one was taken."""
    @property
    def cct(self) -> Optional[Quantity]:
        """Correlated colour temperature in K, where a spectrum was taken."""
    @property
    def sensor_irradiance(self) -> Optional[Quantity]:
        """Mean irradiance in W/m² of a sensor of 24.576 mm by the inverse square law, where a spectrum was taken."""
    @property
    def distribution(self) -> Distribution:
        """The distribution, negative values included, every digit kept."""
    @property
    def spectrum(self) -> Optional[Spectrum]:
        """The spectrum on the axis in W/m²/nm, where one was taken."""
    @property
    def notes(self) -> List[str]:
        """What a person should know, one sentence each."""
    @property
    def without(self) -> List[str]:
        """Names of the corrections that were left out."""
    @property
    def budget(self) -> Dict[str, Any]:
        """Uncertainty budget, with the keys of ``budget.json``."""
    @property
    def file_names(self) -> List[str]:
        """Names of the result files."""
    def file(self, name: str) -> bytes:
        """The bytes of one result file, such as "luminaire.ldt"."""

class Run:
    """The native half of ``isolux.Run``."""

    def __new__(cls, path: _AnyPath) -> Run: ...
    @property
    def path(self) -> str:
        """The folder."""
    @property
    def header(self) -> Dict[str, Any]:
        """What stands in ``run.toml``: station, plan, instruments, sessions."""
    @property
    def notices(self) -> List[str]:
        """What a person should know of the record, one sentence each."""
    def _reading_columns(self) -> Dict[str, Any]: ...
    def _spectrum_columns(self) -> Dict[str, Any]: ...
    def _reduce(
        self,
        without: Sequence[str],
        *,
        out: Optional[_AnyPath] = None,
        force: bool = False,
        model: Optional[_AnyPath] = None,
        accept_drift: Optional[str] = None,
    ) -> Reduction: ...

def read(
    path: _AnyPath,
    *,
    columns: Optional[Tuple[int, int]] = None,
    isym3_c90_first: bool = False,
    apply_future_use: bool = False,
) -> Any:
    """The one distribution or spectrum (``Distribution`` or ``Spectrum``) in a file of any known format.

    ``columns``: of a table, those of wavelengths and values, counted from 1. ``isym3_c90_first``: EULUMDAT symmetry 3
    stored with C90 first. ``apply_future_use``: IES 1995 and 2002, multiply by the field kept for future use.
    Raises ``InputError`` with every error of the reader where nothing could be read; other findings are in
    ``findings``."""

def read_all(
    path: _AnyPath,
    *,
    columns: Optional[Tuple[int, int]] = None,
    isym3_c90_first: bool = False,
    apply_future_use: bool = False,
) -> List[Any]:
    """All distributions and spectra of a file: a container, or a model with several. As ``read``."""

def simulate(
    luminaire: Union[_AnyPath, Distribution],
    *,
    distance_mm: Optional[float] = None,
    sensor_mm: Optional[Union[float, Tuple[float, float]]] = None,
    pixels: Optional[Union[int, Tuple[int, int]]] = None,
    spectrum: Optional[Union[_AnyPath, Spectrum]] = None,
    emitter: Optional[Dict[str, Any]] = None,
    accuracy: Optional[str] = None,
    method: str = "inverse",
    sampling: Optional[str] = None,
    rays: Optional[float] = None,
    seed: Optional[int] = None,
    luminous_area: bool = False,
    changes: Optional[Dict[str, Any]] = None,
    progress: Optional[_Progress] = None,
) -> Simulation:
    """The light of a luminaire on a sensor, by quadrature with a bound on its error, or by rays.

    ``luminaire``: a scene, a model, a run folder, a photometric file, or a ``Distribution``. Where it names no sensor:
    24.576 mm, 2048 pixels, 500 mm. ``distance_mm``: of the sensor's centre along gamma = 0. ``sensor_mm``, ``pixels``:
    one number for both sides, or (along x, along y). ``spectrum``: in place of the model's; without spectrum and
    efficacy the map is in lx. ``emitter``: what the light leaves, such as ``{"shape": "disc", "diameter_mm": 1.0}``.
    ``accuracy``: "standard" or "reference". ``method="direct"`` draws ``rays`` (2e9) by ``sampling`` ("thinned",
    "traced", "expected") from ``seed`` (1). ``changes``: keys of the scene file, such as
    ``{"sensor.tilt_x_deg": 5.0}``; optics and camera are keys as well.

    The interpreter lock is free meanwhile, and Ctrl-C ends the solver. Raises ``InputError`` for a scene that cannot
    be lit."""

def run_program(words: Sequence[str]) -> int:
    """Runs the program ``isolux`` with ``words``, its own name first, and returns its exit code."""

def _diagnose(
    model: _AnyPath,
    observations: Sequence[_AnyPath],
    out: _AnyPath,
    *,
    held_out: Optional[_AnyPath] = None,
    seed: int = 1,
    accept: bool = False,
    force: bool = False,
    progress: Optional[_Progress] = None,
) -> Tuple[Dict[str, Any], List[str], Optional[str]]: ...
def _predict(
    model: _AnyPath, observations: _AnyPath
) -> Tuple[Dict[str, Any], Dict[str, List[str]], str, NDArray[np.float64]]: ...

# The bench.

def init(
    folder: _AnyPath,
    *,
    lamp: Optional[_AnyPath] = None,
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
    def wavelength_nm(self) -> NDArray[np.float64]:
        """Wavelengths in nm, shape (n,): pixels with a calibration."""
    @property
    def irradiance_w_m2_nm(self) -> NDArray[np.float64]:
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

    def __new__(cls, station: Optional[_AnyPath] = None, *, force: Optional[str] = None) -> Bench: ...
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
        plan: _AnyPath,
        out: _AnyPath,
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
