"""Exceptions: what happened, where, and what to do."""

from __future__ import annotations

from typing import Optional, Tuple


class IsoluxError(Exception):
    """A use case ended without its result.

    ``message`` says what happened and where (file, line, register, frame), ``help`` what to do about it.
    """

    def __init__(self, message: str, help: Optional[str] = None) -> None:
        super().__init__(message if help is None else f"{message}\n{help}")
        self.message = message
        self.help = help

    def __reduce__(self) -> Tuple[type, Tuple[str, Optional[str]]]:
        return type(self), (self.message, self.help)


class InputError(IsoluxError, ValueError):
    """Bad input: a file, a number or an option that cannot be used. Nothing was written."""


class CheckFailed(IsoluxError):
    """The answer is no: a drift beyond its limit, a finding that is an error, a discrepancy that stays unexplained."""


class InstrumentError(IsoluxError, RuntimeError):
    """An instrument or the operating system failed, or an axis could not be verified at rest."""


class Interrupted(IsoluxError):
    """A step or a scan was ended on demand: by ``stop()`` or ``close()`` of its bench.

    What moves was stopped and verified at rest first; what a scan has read stays, and ``resume=True`` goes on with it.
    """
