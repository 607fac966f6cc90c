"""The native half of the package. What is public stands in ``isolux``."""

from os import PathLike
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union, final, overload

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
        progress: Optional[_Progress] = None,
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
