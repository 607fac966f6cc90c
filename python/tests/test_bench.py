"""A bench that stays open, in the virtual darkroom: in memory and virtual time, and over TCP in real time."""

from __future__ import annotations

import gc
import os
import re
import signal
import subprocess
import sys
import threading
import tomllib
from pathlib import Path

import isolux
import numpy as np
import pytest
from served import PLAN, Served, rows, when_moving

COUNTS_PER_DEG = 12800 / 3

unix = pytest.mark.skipif(sys.platform == "win32", reason="the system has no such signals and no fork")


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    file = tmp_path / "plan.toml"
    file.write_text(PLAN, encoding="utf-8")
    return file


@pytest.fixture
def served(tmp_path: Path):
    with Served(tmp_path) as twins:
        yield twins


def stopped(run: Path) -> dict:
    return tomllib.loads((run / "run.toml").read_text(encoding="utf-8"))["stopped"]


def test_the_virtual_darkroom_reads_in_two_lines():
    with isolux.Bench() as bench:
        reading = bench.read()
    assert reading.quality == "ok" and reading.digit_lx > 0 and reading.power_w is None


def test_axes_home_move_and_say_where_they_are():
    with isolux.Bench() as bench:
        assert bench.station is None and bench.in_memory and not bench.closed
        assert bench.home() == bench.move(0, 0)
        at = bench.move(c_deg=90, gamma_deg=-30)
        assert abs(at.c_deg - 90) < 0.01 and abs(at.gamma_deg + 30) < 0.01
        bench.move(gamma_deg=10)
        assert abs(bench.position.c_deg - 90) < 0.01, "what is not given stays"
        assert bench.move(distance_mm=3700.0).distance_mm == pytest.approx(3700.0, abs=0.1)


def test_light_follows_the_lamp_and_the_square_of_the_distance():
    with isolux.Bench() as bench:
        bench.home()
        dark = bench.read().illuminance_lx
        assert bench.switch(lamp=True, shutter=True, baffle=False) == {"lamp": True, "shutter": True, "baffle": False}
        seen = []
        stable = bench.warm_up(lambda step, done, total, words: seen.append((step, done, total)))
        assert seen[0] == ("warm up", 0, 1800) and seen[-1][1] == 1800
        assert stable.elapsed_s >= 1800 and stable.spread_rel < 0.005
        far = bench.read().illuminance_lx
        assert dark < 0.1 < far and far == pytest.approx(stable.illuminance_lx, rel=0.01)
        bench.move(distance_mm=5000.0)
        assert bench.read().illuminance_lx == pytest.approx(4 * far, rel=0.02)


def test_a_spectrum_is_arrays_with_the_light_of_their_sum():
    with isolux.Bench() as bench:
        bench.home()
        bench.switch(lamp=True, shutter=True)
        taken = bench.spectrum()
    wavelength, irradiance = taken.wavelength_nm, taken.irradiance_w_m2_nm
    assert wavelength.shape == irradiance.shape and wavelength.dtype == np.float64
    assert not irradiance.flags.writeable
    visible = (wavelength >= 360) & (wavelength <= 830)
    total = np.sum(np.diff(wavelength[visible]) * (irradiance[visible][1:] + irradiance[visible][:-1]) / 2)
    assert total == pytest.approx(taken.irradiance_w_m2, rel=1e-3)
    assert 5000 < taken.quantities["cct_k"] < 7000 and taken.saturated_pixels == 0


def test_what_cannot_be_done_is_refused_before_anything_moves():
    with isolux.Bench() as bench:
        bench.home()
        for refused in ({"gamma_deg": 400.0}, {"distance_mm": 1.0}, {"c_deg": float("nan")}):
            with pytest.raises(isolux.InputError, match="outside"):
                bench.move(**refused)
        with pytest.raises(isolux.InputError, match=r"no \[supply\]"):
            bench.switch(supply=True)
        assert (bench.position.c_deg, bench.position.gamma_deg) == (0, 0)
    with pytest.raises(isolux.InputError, match="closed"):
        bench.read()
    bench.close()
    with pytest.raises(isolux.InputError, match=r"nowhere\.toml"):
        isolux.Bench("nowhere.toml")


def test_an_exception_in_the_block_closes_the_bench_and_goes_on():
    with pytest.raises(ZeroDivisionError), isolux.Bench() as bench:
        bench.home()
        _ = 1 / 0
    assert bench.closed


def test_a_scan_is_an_iterator_of_what_the_record_holds(plan: Path, tmp_path: Path):
    run = tmp_path / "run"
    with isolux.Bench() as bench:
        scan = bench.scan(plan, out=run)
        with pytest.raises(isolux.InputError, match="a scan is on"):
            bench.read()
        events = list(scan)
        summary = scan.result()
        assert bench.read().quality == "ok", "the bench is open for the next step"
    kinds = [event.kind for event in events]
    assert kinds.index("homed") < kinds.index("stable") < kinds.index("reading") < kinds.index("stopped")
    read = [event for event in events if event.kind == "reading"]
    assert [event.done for event in read] == [1, 2, 3, 4, 5] and {event.total for event in read} == {5}
    assert all(event.state == "scanning" and "lx" in event.sentence for event in read)
    assert read[0].remaining_s > read[-1].remaining_s == 0
    recorded = rows(run)
    for event, row in zip(read, recorded, strict=True):
        assert event.illuminance_lx == float(row["illuminance_lx"]) == event.facts["illuminance_lx"]
        assert (event.c_deg, event.gamma_deg) == (float(row["c_deg"]), float(row["gamma_deg"]))
    assert (summary.points, summary.readings, summary.run) == (5, 5, str(run))
    assert stopped(run)["how"] == "completed"


def test_whoever_leaves_a_scan_early_leaves_it_where_it_is_and_goes_on_later(plan: Path, tmp_path: Path):
    run = tmp_path / "run"
    with isolux.Bench() as bench:
        for event in bench.scan(plan, run):
            if event.kind == "reading" and event.done == 2:
                break
        del event
        end = stopped(run)
        assert (end["how"], end["axes_at_rest"]) == ("interrupted", True)
        before = [row["point"] for row in rows(run)]
        assert len(before) < 5, "a virtual bench does not run ahead of whoever iterates"
        with pytest.raises(isolux.InputError, match="not empty"):
            bench.scan(plan, run)
        bench.scan(plan, run, resume=True).result()
    points = [row["point"] for row in rows(run) if row["role"] == "point"]
    assert points == sorted(set(points), key=int) and len(points) == 5
    assert stopped(run)["how"] == "completed"


def test_a_scan_that_is_closed_or_stopped_says_so(plan: Path, tmp_path: Path):
    with isolux.Bench() as bench:
        with bench.scan(plan, tmp_path / "closed") as scan:
            next(scan)
        assert scan.ended and stopped(tmp_path / "closed")["how"] == "interrupted"
        with pytest.raises(isolux.Interrupted):
            scan.result()
        scan = bench.scan(plan, tmp_path / "stopped")
        bench.stop()
        with pytest.raises(isolux.Interrupted, match="stop"):
            scan.result()


def test_a_scan_that_cannot_begin_is_refused_by_the_call(plan: Path, tmp_path: Path):
    with isolux.Bench() as bench:
        with pytest.raises(isolux.InputError, match=r"other\.toml"):
            bench.scan(tmp_path / "other.toml", tmp_path / "run")
        plan.write_text(PLAN.replace("[0, 40, 10]", "[0, 400, 10]"), encoding="utf-8")
        with pytest.raises(isolux.InputError, match=r"plan\.toml:\d+"):
            bench.scan(plan, tmp_path / "run")
        assert not (tmp_path / "run").exists()


def test_a_person_is_asked_for_what_no_instrument_does(tmp_path: Path):
    isolux.init(tmp_path / "day")
    station = tmp_path / "day" / "station.toml"
    text, found = re.subn(r"(\[shutter\]\n)open = .*", r'\1prompt = "cap the detector"', station.read_text("utf-8"))
    assert found == 1
    station.write_text(text, "utf-8")
    plan = tmp_path / "capped.toml"
    plan.write_text(PLAN.replace('kind = "lit"', 'kind = "capped"').replace("[0, 40, 10]", "[0, 10, 10]"), "utf-8")
    prompts = []

    def ask(prompt: str) -> str:
        prompts.append(prompt)
        return "Ada"

    with isolux.Bench(station) as bench:
        with pytest.raises(isolux.InputError, match="nobody is there"):
            bench.scan(plan, tmp_path / "run")
        asked = [event for event in bench.scan(plan, tmp_path / "run", ask=ask) if event.kind == "asked"]
        assert prompts and all("cap the detector" in prompt for prompt in prompts)
        assert {event.facts["who"] for event in asked} == {"Ada"}
        with pytest.raises(isolux.CheckFailed, match="cap the detector"):
            bench.scan(plan, tmp_path / "declined", ask=lambda prompt: None).result()


def test_a_folder_to_start_from_is_written_once(tmp_path: Path):
    written = isolux.init(tmp_path / "day", in_motion=True)
    assert tmp_path / "day" / "station.toml" in written and tmp_path / "day" / "plan.toml" in written
    assert 'mode = "sweep"' in (tmp_path / "day" / "plan.toml").read_text(encoding="utf-8")
    with isolux.Bench(tmp_path / "day" / "station.toml") as bench:
        assert bench.in_memory and bench.read().quality == "ok"
    with pytest.raises(isolux.InputError, match="exists"):
        isolux.init(tmp_path / "day")
    with pytest.raises(isolux.InputError, match="near"):
        isolux.init(tmp_path / "other", plan="far")


def test_a_folder_for_a_lamp_says_how_its_plan_was_chosen(tmp_path: Path):
    lamp = Path(__file__).parents[2] / "crates" / "formats" / "tests" / "golden" / "lorl-zero.ldt"
    with pytest.warns(UserWarning, match="half-planes"):
        written = isolux.init(tmp_path / "lamp", lamp=lamp)
    with isolux.Bench(tmp_path / "lamp" / "station.toml") as bench:
        assert bench.in_memory and tmp_path / "lamp" / "plan.toml" in written


def test_a_second_bench_on_the_same_instruments_is_refused(served: Served):
    bench = isolux.Bench(served.station)
    assert not bench.in_memory
    with pytest.raises(isolux.InstrumentError, match="in use"):
        isolux.Bench(served.station)
    del bench
    gc.collect()
    isolux.Bench(served.station).close()


@unix
def test_ctrl_c_stops_the_axes_before_it_is_raised(served: Served):
    axis = served.axis(2)
    with isolux.Bench(served.station) as bench:
        bench.home()
        thread = when_moving(axis, lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            bench.move(gamma_deg=150)
        assert axis.rests()
        thread.join()
        assert 0 < bench.position.gamma_deg < 100, "it stopped on its way"


def test_stop_ends_the_move_of_another_thread(served: Served):
    axis = served.axis(2)
    with isolux.Bench(served.station) as bench:
        bench.home()
        at = []
        thread = when_moving(axis, lambda: at.append(bench.stop()))
        with pytest.raises(isolux.Interrupted, match="stop"):
            bench.move(gamma_deg=150)
        assert axis.rests()
        thread.join()
        assert 0 < at[0].gamma_deg < 100


def test_an_axis_that_cannot_be_verified_at_rest_is_an_error_of_close(served: Served):
    with pytest.raises(isolux.InstrumentError, match="could not be verified at rest"), isolux.Bench(served.station):
        served.__exit__()


MOVES_WHILE_THE_PROGRAM_ENDS = """
import sys, threading
import isolux
bench = isolux.Bench(sys.argv[1])
bench.home()
def move():
    try:
        bench.move(gamma_deg=150)
    except isolux.Interrupted as error:
        print(error, flush=True)
threading.Thread(target=move, daemon=True).start()
print("moves", flush=True)
sys.stdin.readline()
"""


@unix
@pytest.mark.parametrize("how", ["end", "SIGTERM", "Ctrl-C"])
def test_a_program_that_ends_stops_the_axes_first(served: Served, how: str):
    axis = served.axis(2)
    command = [sys.executable, "-c", MOVES_WHILE_THE_PROGRAM_ENDS, str(served.station)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout.readline() == "moves\n"
        axis.until_moving()
        if how == "end":
            program.stdin.write("\n")
            program.stdin.flush()
        else:
            program.send_signal(signal.SIGTERM if how == "SIGTERM" else signal.SIGINT)
        code = program.wait()
        assert axis.rests()
        _, position = axis.look()
        assert 0 < position < 100 * COUNTS_PER_DEG
        assert code == {"end": 0, "SIGTERM": 128 + signal.SIGTERM, "Ctrl-C": -signal.SIGINT}[how]


def test_threads_may_share_a_bench():
    with isolux.Bench() as bench:
        bench.home()
        targets = [10.0, 20.0, 30.0, 40.0]
        found = {}
        threads = [
            threading.Thread(target=lambda to=to: found.update({to: bench.move(gamma_deg=to).gamma_deg}))
            for to in targets
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert all(abs(found[to] - to) < 0.01 for to in targets), "each has the answer to its own step"


def test_the_interpreter_is_free_while_a_bench_works(served: Served):
    with isolux.Bench(served.station) as bench:
        bench.home()
        counted = 0
        thread = threading.Thread(target=bench.move, kwargs={"gamma_deg": 20.0})
        thread.start()
        while thread.is_alive():
            counted += 1
        assert counted > 1000


@unix
def test_a_fork_has_no_bench(plan: Path, tmp_path: Path):
    with isolux.Bench() as bench:
        scan = bench.scan(plan, tmp_path / "run")
        child = os.fork()
        if child == 0:
            refused = 0
            for use in (lambda: bench.position, lambda: next(scan)):
                try:
                    use()
                except isolux.InputError:
                    refused += 1
            # These do nothing here, and wait for nothing.
            scan.close()
            bench.close()
            os._exit(refused)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 2
        assert scan.result().readings == 5
