"""The devices for bluesky, in a RunEngine of the registry's, on the twins."""

from __future__ import annotations

import math
import os
import signal
import sys
import time
from collections import defaultdict
from pathlib import Path

import isolux
import numpy as np
import pytest
from served import PLAN, Served, rows, when_moving

bp = pytest.importorskip("bluesky.plans")
pytest.importorskip("ophyd_async")
import bluesky.plan_stubs as bps  # noqa: E402
from bluesky import RunEngine  # noqa: E402
from bluesky.protocols import Flyable, Locatable, Readable, Stoppable, Triggerable, check_supports  # noqa: E402
from bluesky.utils import FailedStatus, RunEngineInterrupted  # noqa: E402
from isolux.bluesky import Axis, LuxMeter, PlanFlyer, Spectroradiometer  # noqa: E402


@pytest.fixture
def engine():
    engine = RunEngine(call_returns_result=True)
    engine.documents = defaultdict(list)
    engine.subscribe(lambda name, document: engine.documents[name].append(document))
    return engine


def data(engine: RunEngine, key: str) -> list:
    """The values of a key, of events and of whole pages of them."""
    single = [event["data"][key] for event in engine.documents["event"] if key in event["data"]]
    pages = [page["data"][key] for page in engine.documents["event_page"] if key in page["data"]]
    return single + [value for page in pages for value in page]


def test_the_devices_are_what_the_protocols_ask_for():
    with isolux.Bench() as bench:
        for device, protocols in (
            (Axis(bench, "gamma"), (Locatable, Readable, Stoppable)),
            (LuxMeter(bench), (Readable, Triggerable)),
            (Spectroradiometer(bench), (Readable, Triggerable)),
            (PlanFlyer(bench, "plan.toml", "run"), (Flyable, Stoppable)),
        ):
            for protocol in protocols:
                check_supports(device, protocol)
        with pytest.raises(ValueError, match="'c' or 'gamma'"):
            Axis(bench, "beta")


def test_a_scan_of_bluesky_reads_what_a_scan_of_isolux_reads(engine: RunEngine, tmp_path: Path):
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    with isolux.Bench() as bench:
        bench.scan(tmp_path / "plan.toml", tmp_path / "run").result()
    own = [float(row["illuminance_lx"]) for row in rows(tmp_path / "run") if row["role"] == "point"]
    with isolux.Bench() as bench:
        bench.home()
        bench.move(distance_mm=3700.0)
        bench.warm_up()
        gamma, lux = Axis(bench, "gamma"), LuxMeter(bench)
        engine(bp.scan([lux], gamma, 0, 40, 5))
    assert np.allclose(data(engine, "gamma"), [0, 10, 20, 30, 40], atol=0.01)
    assert set(data(engine, "lux-quality")) == {"ok"}
    # One seed and one lamp that is stable, read at other moments: the noise of the twin (0.08 %) and its digit differ.
    u_lx = np.hypot(8e-4 * np.array(own), data(engine, "lux-digit")[0] / np.sqrt(12))
    assert np.all(np.abs(np.array(data(engine, "lux")) - own) < 3 * np.sqrt(2) * u_lx)
    keys = engine.documents["descriptor"][0]["data_keys"]
    assert (keys["gamma"]["units"], keys["lux"]["units"], keys["lux-digit"]["units"]) == ("deg", "lx", "lx")
    assert keys["gamma"]["source"] == "isolux://virtual darkroom#gamma_deg"
    assert engine.documents["stop"][0]["exit_status"] == "success"


def test_a_spectrum_and_both_axes_are_read_with_their_units(engine: RunEngine):
    with isolux.Bench() as bench:
        bench.home()
        bench.switch(lamp=True, shutter=True)
        c, gamma, spectrum = Axis(bench, "c"), Axis(bench, "gamma"), Spectroradiometer(bench)
        engine(bp.list_grid_scan([spectrum], c, [0, 90], gamma, [0, 30]))
    assert np.allclose(data(engine, "c"), [0, 0, 90, 90], atol=0.01)
    light = data(engine, "spectrum-illuminance")
    assert light[0] > light[1] > 0 and light[0] == pytest.approx(light[2], rel=0.05)
    keys = engine.documents["descriptor"][0]["data_keys"]
    assert keys["spectrum"]["units"] == "W/(m² nm)" and keys["spectrum-wavelength"]["units"] == "nm"
    assert all(len(spectrum) == keys["spectrum"]["shape"][0] for spectrum in data(engine, "spectrum"))


def test_an_axis_refuses_what_is_outside_its_limits(engine: RunEngine):
    with isolux.Bench() as bench:
        bench.home()
        gamma = Axis(bench, "gamma")
        with pytest.raises(FailedStatus) as raised:
            engine(bps.mv(gamma, 400))
        assert isinstance(raised.value.__cause__, isolux.InputError), "nothing was moved"
        assert bench.position.gamma_deg == 0


def test_a_plan_of_isolux_is_flown(engine: RunEngine, tmp_path: Path):
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    with isolux.Bench() as bench:
        engine(bp.fly([PlanFlyer(bench, tmp_path / "plan.toml", tmp_path / "run")]))
    recorded = rows(tmp_path / "run")
    assert data(engine, "scan-illuminance") == [float(row["illuminance_lx"]) for row in recorded]
    assert data(engine, "scan-gamma") == [float(row["gamma_deg"]) for row in recorded]
    assert set(data(engine, "scan-run")) == {str(tmp_path / "run")}
    streams = {descriptor["name"]: descriptor["data_keys"] for descriptor in engine.documents["descriptor"]}
    assert streams["scan"]["scan-illuminance"]["units"] == "lx" and streams["scan"]["scan-c"]["units"] == "deg"


SWEEPS = """format = "isolux-plan/1"
name = "two half-planes in motion"
[[block]]
name = "distribution"
kind = "lit"
mode = "sweep"
c_range = [0, 90, 90]
gamma_range = [-180, 180, 2]
distance_mm = 3700.0
"""


def test_a_plan_in_motion_is_flown_with_an_event_for_each_sweep(engine: RunEngine, tmp_path: Path):
    isolux.init(tmp_path / "day", in_motion=True)
    (tmp_path / "sweeps.toml").write_text(SWEEPS, encoding="utf-8")
    with isolux.Bench(tmp_path / "day" / "station.toml") as bench:
        engine(bp.fly([PlanFlyer(bench, tmp_path / "sweeps.toml", tmp_path / "run")]))
    swept = sorted(int(file.stem) for file in (tmp_path / "run" / "sweeps").glob("*.csv"))
    assert data(engine, "scan-sweep-index") == swept and len(swept) >= 5
    assert all(count > 100 for count in data(engine, "scan-sweep-conversions"))
    assert len(data(engine, "scan-illuminance")) == len(rows(tmp_path / "run"))


def test_an_abort_in_the_middle_leaves_the_axes_at_rest(engine: RunEngine, tmp_path: Path):
    with Served(tmp_path) as twins, isolux.Bench(twins.station) as bench:
        bench.home()
        seen, gamma = twins.axis(2), Axis(bench, "gamma")
        thread = when_moving(seen, lambda: engine.abort("the test asks for it"))
        with pytest.raises(RunEngineInterrupted):
            engine(bp.list_scan([], gamma, [150]))
        thread.join()
        assert seen.rests()
        assert 0 < bench.position.gamma_deg < 100
        assert engine.documents["stop"][0]["exit_status"] == "abort"
        engine(bps.mv(gamma, 0))
        assert bench.position.gamma_deg == pytest.approx(0, abs=0.01)


@pytest.mark.skipif(sys.platform == "win32", reason="the system has no such signal")
def test_ctrl_c_pauses_with_the_axes_at_rest_and_the_plan_goes_on(engine: RunEngine, tmp_path: Path):
    with Served(tmp_path) as twins, isolux.Bench(twins.station) as bench:
        bench.home()
        seen, gamma = twins.axis(2), Axis(bench, "gamma")

        def twice() -> None:
            # Once asks for a pause at the next checkpoint, twice for one at once; bluesky counts none within 0.1 s.
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.12)
            os.kill(os.getpid(), signal.SIGINT)

        thread = when_moving(seen, twice)
        with pytest.raises(RunEngineInterrupted):
            engine(bp.list_scan([], gamma, [120]))
        thread.join()
        assert engine.state == "paused" and seen.rests()
        assert 0 < bench.position.gamma_deg < 100
        engine.resume()
        assert bench.position.gamma_deg == pytest.approx(120, abs=0.01)
        assert engine.documents["stop"][0]["exit_status"] == "success"
        assert not math.isnan(data(engine, "gamma")[0])
