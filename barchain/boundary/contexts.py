"""Processes that do not import the script that starts them: a script needs no guard, and a child starts faster.

The standard library lets a spawned process import the main module of its parent first, for functions that are defined
there. barchain sends functions of its own modules only.
"""

from __future__ import annotations

import contextlib
import sys
import threading
from multiprocessing.context import ForkServerContext, ForkServerProcess, SpawnContext, SpawnProcess
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from collections.abc import Iterator

LOCK = threading.RLock()


@contextlib.contextmanager
def main_module_hidden() -> Iterator[None]:
    """Hide the file and the name of the main module from the standard library while it describes this process."""
    with LOCK:
        main = sys.modules["__main__"]
        file, spec = vars(main).get("__file__"), main.__spec__
        main.__spec__ = None
        if file is not None:
            del main.__file__
        try:
            yield
        finally:
            main.__spec__ = spec
            if file is not None:
                main.__file__ = file


class Spawned(SpawnProcess):
    """Process with an interpreter of its own."""

    @staticmethod
    def _Popen(process_obj: Any) -> Any:
        with main_module_hidden():
            return SpawnProcess._Popen(process_obj)  # private, the same since Python 3.4


class Forked(ForkServerProcess):
    """Process that a server forks."""

    @staticmethod
    def _Popen(process_obj: Any) -> Any:
        with main_module_hidden():
            return ForkServerProcess._Popen(process_obj)  # private, the same since Python 3.4


class Spawning(SpawnContext):
    """Starts processes with interpreters of their own: loaded engines are not safe to fork."""

    Process: ClassVar[type[SpawnProcess]] = Spawned


class ForkServing(ForkServerContext):
    """Starts processes that a server forks."""

    Process: ClassVar[type[ForkServerProcess]] = Forked


SPAWN = Spawning()
FORK_SERVER = ForkServing()
