"""The package as a user finds it: types, docstrings, and the program."""

import subprocess
import sys
from pathlib import Path

import isolux
from conftest import PROGRAM


def test_the_program_comes_with_the_package():
    said = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout
    assert said == f"isolux {isolux.__version__}\n"
    refused = subprocess.run([PROGRAM, "simulate"], capture_output=True, text=True)
    assert refused.returncode == 2 and "required" in refused.stderr


def test_everything_public_has_a_docstring():
    for name in isolux.__all__:
        thing = getattr(isolux, name)
        if name.startswith("__"):
            continue
        assert thing.__doc__, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                if not member.startswith("_"):
                    assert value.__doc__, f"{name}.{member}"


def test_the_stubs_are_those_of_the_native_module(tmp_path):
    # PyO3 makes this one.
    made = tmp_path / "made.txt"
    made.write_text("isolux._isolux.__all__\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "isolux._isolux", "--ignore-disjoint-bases", "--allowlist", made],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_is_typed_as_it_says():
    package = Path(isolux.__file__).parent
    assert (package / "py.typed").is_file()
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "-p", "isolux"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
