"""Devices of ophyd-async over one bench, for the RunEngine of bluesky (``pip install isolux[bluesky]``).

The axes are movables, the meters readables, a plan of isolux is a flyer. All devices of a :class:`isolux.Bench` share
its instruments: its steps follow one another, so C and γ that are set together move one after the other. The bench
works on threads, the loop of the RunEngine stays free.

Keys of documents: the name of the device for its number, ``NAME-…`` for what belongs to it; units are in the
descriptors.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncIterator
from os import PathLike
from typing import Any, Optional, Union

from ophyd_async.core import AsyncStatus, Device

from isolux import Bench, Interrupted, LuxReading, Scan, ScanEvent, SpectrumReading

__all__ = ["Axis", "LuxMeter", "PlanFlyer", "Spectroradiometer"]

_NUMBER = {"dtype": "number", "shape": []}


def _reading(values: dict[str, Any], at: float) -> dict[str, Any]:
    return {key: {"value": value, "timestamp": at} for key, value in values.items()}


def _number(value: Optional[float]) -> float:
    """What has no number is NaN: documents of bluesky know no other."""
    return math.nan if value is None else value


class _BenchDevice(Device):
    """What all devices of a bench are."""

    def __init__(self, bench: Bench, name: str) -> None:
        self._bench = bench
        self._success = True
        super().__init__(name)

    @property
    def hints(self) -> dict[str, Any]:
        """The field that is plotted."""
        return {"fields": [self.name]}

    def _source(self, part: str) -> str:
        return f"isolux://{self._bench.station or 'virtual darkroom'}#{part}"

    async def stop(self, success: bool = True) -> None:
        """Ends every step of the bench, stops the axes and verifies that they rest.

        With ``success`` the step that was ended counts as done: the RunEngine stops devices so at a pause.

        :raises isolux.InstrumentError: an axis could not be verified at rest.
        """
        self._success = success
        await asyncio.to_thread(self._bench.stop)

    async def _until_ended(self, step: Any, *arguments: Any) -> None:
        self._success = True
        try:
            await asyncio.to_thread(step, *arguments)
        except Interrupted:
            if not self._success:
                raise


class Axis(_BenchDevice):
    """C or γ of the bench in degrees: movable, locatable, readable, stoppable.

    :param coordinate: ``"c"`` or ``"gamma"``.
    """

    def __init__(self, bench: Bench, coordinate: str, name: str = "") -> None:
        if coordinate not in ("c", "gamma"):
            raise ValueError(f"coordinate is {coordinate!r}, and an axis is 'c' or 'gamma'")
        self._key = f"{coordinate}_deg"
        self._setpoint_deg: Optional[float] = None
        super().__init__(bench, name or coordinate)

    @AsyncStatus.wrap
    async def set(self, value: float) -> None:
        """Moves there; done when the axis rests within its tolerance.

        :param value: target in degrees, γ signed.
        :raises isolux.InputError: it is outside the limits of the axis; nothing was moved.
        """
        self._setpoint_deg = float(value)
        await self._until_ended(self._move, self._setpoint_deg)

    def _move(self, target_deg: float) -> None:
        self._bench.move(**{self._key: target_deg})

    async def _position_deg(self) -> float:
        position = await asyncio.to_thread(lambda: self._bench.position)
        return position.c_deg if self._key == "c_deg" else position.gamma_deg

    async def locate(self) -> dict[str, float]:
        """Where it was sent (where it stands, before it was sent anywhere) and where it stands, in degrees."""
        readback = await self._position_deg()
        setpoint = readback if self._setpoint_deg is None else self._setpoint_deg
        return {"setpoint": setpoint, "readback": readback}

    async def read(self) -> dict[str, Any]:
        """Where it stands, read back, in degrees."""
        return _reading({self.name: await self._position_deg()}, time.time())

    async def describe(self) -> dict[str, Any]:
        """Keys and units of :meth:`read`."""
        return {self.name: {"source": self._source(self._key), "units": "deg", **_NUMBER}}


class LuxMeter(_BenchDevice):
    """The lux meter, and the power meter with it: triggered, then read."""

    def __init__(self, bench: Bench, name: str = "lux") -> None:
        self._taken: Optional[tuple[LuxReading, float]] = None
        super().__init__(bench, name)

    @AsyncStatus.wrap
    async def trigger(self) -> None:
        """Takes a new reading, with lamp, shutter and baffle as they are."""
        await self._take()

    async def _take(self) -> tuple[LuxReading, float]:
        self._taken = await asyncio.to_thread(self._bench.read), time.time()
        return self._taken

    async def read(self) -> dict[str, Any]:
        """The reading that was triggered last: lx (NaN without a number), quality, and the supply line."""
        reading, at = self._taken or await self._take()
        values: dict[str, Any] = {
            self.name: _number(reading.illuminance_lx),
            f"{self.name}-digit": reading.digit_lx,
            f"{self.name}-quality": reading.quality,
        }
        for key, (value, _) in self._supply(reading).items():
            values[key] = value
        return _reading(values, at)

    async def describe(self) -> dict[str, Any]:
        """Keys and units of :meth:`read`."""
        reading, _ = self._taken or await self._take()
        source = self._source("luxmeter")
        keys: dict[str, Any] = {
            self.name: {"source": source, "units": "lx", **_NUMBER},
            f"{self.name}-digit": {"source": source, "units": "lx", **_NUMBER},
            f"{self.name}-quality": {"source": source, "dtype": "string", "shape": []},
        }
        for key, (_, units) in self._supply(reading).items():
            keys[key] = {"source": self._source("powermeter"), "units": units, **_NUMBER}
        return keys

    def _supply(self, reading: LuxReading) -> dict[str, tuple[float, str]]:
        line = {
            "voltage": (reading.voltage_v, "V"),
            "current": (reading.current_a, "A"),
            "power": (reading.power_w, "W"),
        }
        return {f"{self.name}-{key}": (value, units) for key, (value, units) in line.items() if value is not None}


class Spectroradiometer(_BenchDevice):
    """The spectroradiometer: triggered, then read."""

    def __init__(self, bench: Bench, name: str = "spectrum") -> None:
        self._taken: Optional[tuple[SpectrumReading, float]] = None
        super().__init__(bench, name)

    @property
    def hints(self) -> dict[str, Any]:
        """A number is plotted, not the spectrum."""
        return {"fields": [f"{self.name}-illuminance"]}

    @AsyncStatus.wrap
    async def trigger(self) -> None:
        """Takes a spectrum with the integration time that its light needs."""
        await self._take()

    async def _take(self) -> tuple[SpectrumReading, float]:
        self._taken = await asyncio.to_thread(self._bench.spectrum), time.time()
        return self._taken

    async def read(self) -> dict[str, Any]:
        """The spectrum that was triggered last, shape (pixels,), with its wavelengths and colorimetry."""
        reading, at = self._taken or await self._take()
        values = {
            self.name: reading.irradiance_w_m2_nm,
            f"{self.name}-wavelength": reading.wavelength_nm,
            f"{self.name}-integration": reading.integration_s,
            f"{self.name}-illuminance": reading.illuminance_lx,
            f"{self.name}-cct": _number(reading.quantities["cct_k"]),
        }
        return _reading(values, at)

    async def describe(self) -> dict[str, Any]:
        """Keys, shapes and units of :meth:`read`."""
        reading, _ = self._taken or await self._take()
        source = self._source("spectroradiometer")
        array = {"dtype": "array", "dtype_numpy": "<f8", "shape": [len(reading.wavelength_nm)]}
        return {
            self.name: {"source": source, "units": "W/(m² nm)", **array},
            f"{self.name}-wavelength": {"source": source, "units": "nm", **array},
            f"{self.name}-integration": {"source": source, "units": "s", **_NUMBER},
            f"{self.name}-illuminance": {"source": source, "units": "lx", **_NUMBER},
            f"{self.name}-cct": {"source": source, "units": "K", **_NUMBER},
        }


class PlanFlyer(_BenchDevice):
    """A plan of isolux, at rest or in motion, carried out by its own engine: flyable, collectable.

    Two streams are collected: ``NAME`` has the readings at rest, ``NAME_sweeps`` one event for each sweep. What was
    read in motion lies in the run directory, whose name is in both: what light belongs to which γ is found by its
    reduction.

    :param plan: the plan file.
    :param out: the run directory to write.
    """

    def __init__(
        self, bench: Bench, plan: Union[str, PathLike[str]], out: Union[str, PathLike[str]], name: str = "scan"
    ) -> None:
        self._plan, self._out = plan, out
        self._scan: Optional[Scan] = None
        self._events: list[tuple[ScanEvent, float]] = []
        super().__init__(bench, name)

    @AsyncStatus.wrap
    async def kickoff(self) -> None:
        """Begins the scan; done when its run directory is made."""
        self._events = []
        self._scan = await asyncio.to_thread(self._bench.scan, self._plan, self._out)

    @AsyncStatus.wrap
    async def complete(self) -> None:
        """Done when the scan has ended: the axes rest and the record is whole."""
        if self._scan is None:
            raise RuntimeError(f"{self.name} was not kicked off")
        await self._until_ended(self._follow, self._scan)

    def _follow(self, scan: Scan) -> None:
        self._events.extend((event, time.time()) for event in scan if event.kind in ("reading", "sweep"))

    async def describe_collect(self) -> dict[str, Any]:
        """Keys and units of what is collected, by stream."""
        source = self._source("scan")
        angle, light = {"units": "deg", **_NUMBER}, {"units": "lx", **_NUMBER}
        text = {"dtype": "string", "shape": []}
        count = {"dtype": "integer", "shape": []}
        streams = {
            self.name: {
                "c": angle,
                "gamma": angle,
                "illuminance": light,
                "quality": text,
                "kind": text,
                "role": text,
                "run": text,
            },
            f"{self.name}_sweeps": {
                "sweep-index": count,
                "sweep-c-from": angle,
                "sweep-c-to": angle,
                "sweep-gamma-from": angle,
                "sweep-gamma-to": angle,
                "sweep-conversions": count,
                "sweep-run": text,
            },
        }
        return {
            stream: {f"{self.name}-{key}": {"source": source, **what} for key, what in keys.items()}
            for stream, keys in streams.items()
        }

    async def collect(self) -> AsyncIterator[dict[str, Any]]:
        """The events of the scan, as partial event documents."""
        for event, at in self._events:
            data = {f"{self.name}-{key}": value for key, value in self._row(event).items()}
            yield {"time": at, "data": data, "timestamps": dict.fromkeys(data, at)}

    def _row(self, event: ScanEvent) -> dict[str, Any]:
        facts, run = event.facts, str(self._out)
        if event.kind == "sweep":
            (c_from, c_to), (gamma_from, gamma_to) = facts["c_deg"], facts["gamma_deg"]
            return {
                "sweep-index": facts["index"],
                "sweep-c-from": c_from,
                "sweep-c-to": c_to,
                "sweep-gamma-from": gamma_from,
                "sweep-gamma-to": gamma_to,
                "sweep-conversions": facts["conversions"],
                "sweep-run": run,
            }
        return {
            "c": event.c_deg,
            "gamma": event.gamma_deg,
            "illuminance": _number(event.illuminance_lx),
            "quality": event.quality,
            "kind": facts["kind"],
            "role": facts["role"],
            "run": run,
        }
