"""The end of the program: every bench that is open stops its axes, verifies that they rest, and is closed."""

from __future__ import annotations

import atexit
import signal
import sys
import threading

from isolux._isolux import close_benches

atexit.register(close_benches)


def watch() -> None:
    """Makes SIGTERM and SIGHUP end the program as ``sys.exit`` does, where nobody has said what else they do."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _leave)


def _leave(number: int, _frame: object) -> None:
    sys.exit(128 + number)
