"""How much a command says besides its results: the options -q and -v of `barchain`."""

from __future__ import annotations

from contextvars import ContextVar
from enum import IntEnum


class Verbosity(IntEnum):
    """Amount of output on standard error."""

    QUIET = -1
    """Errors only"""
    NORMAL = 0
    """Progress and notes"""
    VERBOSE = 1
    """Every verdict on a terminal too, and the traceback of an error"""


CHOSEN: ContextVar[Verbosity] = ContextVar("verbosity", default=Verbosity.NORMAL)


def choose(*, quiet: bool, verbose: bool) -> None:
    """Set the verbosity of this command."""
    CHOSEN.set(Verbosity(int(verbose) - int(quiet)))


def quiet() -> bool:
    """Whether progress and notes are left out."""
    return CHOSEN.get() is Verbosity.QUIET


def verbose() -> bool:
    """Whether every verdict and every traceback is printed."""
    return CHOSEN.get() is Verbosity.VERBOSE
