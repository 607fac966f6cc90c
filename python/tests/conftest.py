"""What the tests share: the program of the wheel, and a day on the virtual bench."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

# Tests that a shell started in the background have SIGINT ignored, and so would every program that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

PROGRAM = Path(sys.executable).with_name("isolux")


def isolux(*words, cwd):
    """Runs the program that the wheel installed."""
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def day(tmp_path_factory):
    """A day on the virtual bench, as `isolux run` makes it."""
    folder = tmp_path_factory.mktemp("bench")
    isolux("run", cwd=folder)
    return folder / "day"


@pytest.fixture(autouse=True, scope="session")
def no_toolchain():
    """The wheel needs no Rust: what is tested here may not find one."""
    assert "cargo" not in os.environ.get("PATH", ""), "take Rust out of PATH: a user of the wheel has none"


def pytest_sessionfinish(session):
    """As the tests in Rust: with ISOLUX_NO_SKIP nothing may be skipped for want of a package."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("ISOLUX_NO_SKIP") and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
