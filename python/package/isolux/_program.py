"""The program ``isolux`` of the command line."""

from __future__ import annotations

import signal
import sys

from isolux._isolux import run_program


def main() -> int:
    """Runs the program with the words of the command line and returns its exit code."""
    # The program answers Ctrl-C itself: it stops the axes first.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run_program(["isolux", *sys.argv[1:]])
