"""What the tests of a bench share: a plan, and the virtual darkroom served over TCP in real time."""

from __future__ import annotations

import re
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

PLAN = """format = "isolux-plan/1"
name = "five directions"
[[block]]
name = "distribution"
kind = "lit"
c_deg = 0
gamma_range = [0, 40, 10]
distance_mm = 3700.0
"""

PROGRAM = [sys.executable, "-c", "import sys; from isolux._program import main; sys.exit(main())"]


def rows(run: Path) -> list[dict[str, str]]:
    """The rows of readings.csv."""
    import csv

    with open(run / "readings.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


class Served:
    """Twins on the loopback address, until the end of the ``with`` block."""

    def __init__(self, folder: Path) -> None:
        self.station = folder / "station.toml"
        words = ["virtual", "darkroom", "--tcp", "0", "--station-out", str(self.station)]
        self._process = subprocess.Popen([*PROGRAM, *words], stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> Served:
        # The station is written before the twins are listed.
        assert self._process.stdout.readline().startswith("axes")
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()

    def axis(self, number: int) -> Axis:
        """Looks at an axis over a connection of its own: 1 is C, 2 is γ."""
        port = re.search(r"zaber:tcp://127.0.0.1:(\d+)\?axis=1", self.station.read_text(encoding="utf-8"))
        return Axis(int(port.group(1)), number)


class Axis:
    """An axis of the twin, seen past the program under test."""

    def __init__(self, port: int, number: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._lines = self._socket.makefile("r", newline="\n")
        self._number = number

    def look(self) -> tuple[bool, int]:
        """Whether it moves, and its position in microsteps."""
        self._socket.sendall(f"/1 {self._number} get pos\n".encode())
        while True:
            words = self._lines.readline().split()
            # The controller may say things of its own accord.
            if words and words[0].startswith("@"):
                return words[3] == "BUSY", int(words[5].partition(":")[0])

    def until_moving(self) -> None:
        """Waits until it is on its way."""
        deadline = time.monotonic() + 30
        while True:
            busy, position = self.look()
            if busy and position > 4000:
                return
            assert time.monotonic() < deadline, "the axis did not move"

    def rests(self) -> bool:
        """Whether it stands still."""
        first, second = self.look(), self.look()
        return not first[0] and not second[0] and first[1] == second[1]


def when_moving(axis: Axis, act: object) -> threading.Thread:
    """Calls ``act`` from another thread as soon as the axis is on its way."""

    def watch() -> None:
        axis.until_moving()
        act()

    thread = threading.Thread(target=watch)
    thread.start()
    return thread
