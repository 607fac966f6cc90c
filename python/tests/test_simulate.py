"""The light on a sensor: to the last digit what the program writes, in the memory of one map, and interruptible."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

import isolux
import numpy as np
import pytest
from conftest import isolux as program


def without_clock(facts):
    # The program also says which of its options change what it assumes.
    findings = [finding.split("; --")[0] for finding in facts["findings"]]
    return {**facts, "elapsed_s": None, "findings": findings}


@pytest.mark.parametrize(
    ("words", "keywords"),
    [
        ([], {}),
        (["--distance-mm", "700", "--sensor-mm", "20,10"], {"distance_mm": 700.0, "sensor_mm": (20.0, 10.0)}),
        (["--set", "sensor.tilt_x_deg=10"], {"changes": {"sensor.tilt_x_deg": 10}}),
        (
            ["--method", "direct", "--rays", "2e6", "--seed", "3"],
            {"method": "direct", "rays": 2e6, "seed": 3},
        ),
    ],
)
def test_the_map_is_that_of_the_program_to_the_last_digit(day, tmp_path, words, keywords):
    program("simulate", day, "--pixels", "96,64", "--out", tmp_path / "lit", *words, cwd=day.parent)
    mine = isolux.simulate(day, pixels=(96, 64), **keywords)
    written = np.load(tmp_path / "lit/irradiance.npy")
    assert mine.irradiance.shape == written.shape == (64, 96)
    assert mine.irradiance.dtype == np.float64 and mine.unit == "W/m²"
    np.testing.assert_array_equal(mine.irradiance.astype(np.float32), written)
    facts = json.loads((tmp_path / "lit/result.json").read_text())
    assert without_clock(mine.facts) == without_clock(facts)
    mine.write(tmp_path / "mine")
    assert (tmp_path / "mine/irradiance.npy").read_bytes() == (tmp_path / "lit/irradiance.npy").read_bytes()
    assert (tmp_path / "mine/irradiance.png").read_bytes() == mine._repr_png_()


def test_a_distribution_in_memory_is_lit_as_its_file(day):
    ldt, spdx = day / "results/luminaire.ldt", day / "results/luminaire.spdx"
    emitter = {"shape": "disc", "diameter_mm": 1.0}
    of_file = isolux.simulate(ldt, pixels=64, spectrum=spdx, emitter=emitter)
    in_memory = isolux.simulate(isolux.read(ldt), pixels=64, spectrum=isolux.read(spdx), emitter=emitter)
    np.testing.assert_array_equal(of_file.irradiance, in_memory.irradiance)
    assert isolux.simulate(isolux.read(ldt), pixels=8).unit == "lx"
    with pytest.raises(isolux.InputError, match="luminaire.distribution"):
        isolux.simulate(isolux.read(ldt), pixels=8, changes={"luminaire.distribution": "other.ldt"})


def test_a_lambertian_point_gives_the_inverse_square_law():
    gamma_deg = np.linspace(0.0, 90.0, 901)
    lambertian = isolux.Distribution(np.array([0.0]), gamma_deg, np.cos(np.radians(gamma_deg))[None, :])
    lit = isolux.simulate(lambertian, distance_mm=1000.0, sensor_mm=200.0, pixels=101)
    # E = I(γ)·cos γ / d² with I = cos γ and d = 1 m / cos γ.
    x, y = np.meshgrid(lit.x_mm / 1000.0, lit.y_mm / 1000.0)
    cos = 1.0 / np.sqrt(1.0 + x**2 + y**2)
    np.testing.assert_allclose(lit.irradiance, cos**4, rtol=2e-5)
    assert lit.mean == pytest.approx(lit.irradiance.mean(), rel=1e-9)


def peak_kib():
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_the_map_of_2048_squared_is_not_copied(day):
    """Asking for the array must not cost another map of 32 MiB."""
    lit = isolux.simulate(day, pixels=2048)
    assert lit.irradiance.nbytes == 2048 * 2048 * 8
    before = peak_kib()
    arrays = [lit.irradiance, np.asarray(lit), lit.irradiance.T]
    assert peak_kib() - before < 2 * 1024
    assert all(np.shares_memory(array, lit.irradiance) for array in arrays)
    with pytest.raises(ValueError):
        arrays[1][0, 0] = 1.0


def test_other_threads_go_on_meanwhile(day):
    longest_s = [0.0]
    done = threading.Event()

    def tick():
        last = time.monotonic()
        while not done.is_set():
            now = time.monotonic()
            longest_s[0] = max(longest_s[0], now - last)
            last = now

    ticking = threading.Thread(target=tick)
    ticking.start()
    began = time.monotonic()
    try:
        isolux.simulate(day, method="direct", sampling="traced", rays=5e8, pixels=64)
    finally:
        done.set()
        ticking.join()
    # With the interpreter lock held the other thread would stand still for all of it.
    assert longest_s[0] < 0.5 * (time.monotonic() - began)


INTERRUPTED = """
import isolux, sys, time
print("ready", flush=True)
try:
    isolux.simulate(sys.argv[1], method="direct", sampling="traced", rays=1e12, pixels=64)
except KeyboardInterrupt:
    print(time.monotonic(), flush=True)
    began = time.process_time()
    time.sleep(0.5)
    # The solver has ended: what it still takes is little.
    print(time.process_time() - began)
"""


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_an_interrupt_ends_the_solver_at_once(day):
    late = []
    for _ in range(3):
        child = subprocess.Popen(
            [sys.executable, "-c", INTERRUPTED, day], stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        assert child.stdout.readline() == "ready\n"
        time.sleep(1.0)
        sent = time.monotonic()
        child.send_signal(signal.SIGINT)
        out, _ = child.communicate(timeout=60)
        at, still_s = map(float, out.split())
        late.append(at - sent)
        assert still_s < 0.3 and child.returncode == 0
    # The best of three: the machine may be busy with other things.
    assert min(late) < 0.1, late


def test_progress_is_called_and_its_exception_ends_the_work(day):
    said = []
    isolux.simulate(day, pixels=16, progress=lambda *step: said.append(step))
    assert said and said[0][0] == "simulate"

    def refuse(*_):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        isolux.simulate(day, pixels=16, progress=refuse)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"pixels": 0}, "pixels"),
        ({"distance_mm": -5.0}, "distance_mm"),
        ({"rays": 5.0}, "direct"),
        ({"accuracy": "best"}, "standard"),
        ({"changes": {"sensor.no_such_key": 1}}, "no_such_key"),
        ({"pixels": 10**6}, "memory"),
    ],
)
def test_bad_input_is_refused(day, keywords, message):
    with pytest.raises(ValueError, match=message):
        isolux.simulate(day, **keywords)
