"""Pictures with matplotlib, for those who draw with it anyway."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np


def _axes(ax: Optional[Any], **options: Any) -> Any:
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt  # type: ignore[unused-ignore]
    except ImportError as error:
        raise ImportError("plot() needs matplotlib: pip install 'isolux[plot]'") from error
    return plt.subplots(subplot_kw=options)[1]


def polar(distribution: Any, ax: Optional[Any] = None) -> Any:
    """Candela over gamma of the planes C0–C180 and C90–C270, gamma 0 downwards."""
    ax = _axes(ax, projection="polar")
    ax.set_theta_zero_location("S")
    ax.set_theta_direction(1)
    gamma_deg = distribution.gamma_deg
    for c_deg, style in ((0.0, "-"), (90.0, "--")):
        right = distribution.intensity(c_deg, gamma_deg)
        left = distribution.intensity(c_deg + 180.0, gamma_deg)
        angle = np.radians(np.concatenate([-gamma_deg[::-1], gamma_deg]))
        ax.plot(angle, np.concatenate([left[::-1], right]), style, label=f"C{c_deg:.0f}–C{c_deg + 180:.0f}")
    ax.set_ylabel("")
    ax.set_title("luminous intensity in cd")
    ax.legend(loc="lower right")
    return ax


def spectrum(spectrum: Any, ax: Optional[Any] = None) -> Any:
    """Values over wavelength."""
    ax = _axes(ax)
    ax.plot(spectrum.wavelength_nm, spectrum.value)
    ax.set_xlabel("wavelength in nm")
    ax.set_ylabel(" in ".join(part for part in (spectrum.quantity, spectrum.unit) if part) or "value")
    return ax


def sensor_map(simulation: Any, ax: Optional[Any] = None) -> Any:
    """The light on the sensor, x to the right and y upwards."""
    ax = _axes(ax)
    width, height = simulation.facts["size_mm"]
    extent = (-width / 2, width / 2, -height / 2, height / 2)
    image = ax.imshow(simulation.irradiance, origin="lower", extent=extent)
    ax.figure.colorbar(image, ax=ax, label=simulation.unit)
    ax.set_xlabel("x in mm")
    ax.set_ylabel("y in mm")
    return ax
