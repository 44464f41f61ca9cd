"""Engines whose run ends the process of their comparison, and others on the way to it; as a program, a comparison."""

import os
import signal
import subprocess
import sys
import time

import psutil

MODULE = "tests.boundary.command_killers"
SLEEP = ["sleep", "613"]
"""Child of an engine, in a session of its own"""


def command_and_below() -> list[int]:
    """Processes from the comparison down to the parent of this one."""
    chain = psutil.Process().parents()[::-1]
    first = next(k for k, p in enumerate(chain) if MODULE in p.cmdline())
    return [p.pid for p in chain[first:]]


def kill(pids: list[int]) -> None:
    for pid in pids:
        os.kill(pid, signal.SIGKILL)
    time.sleep(600.0)


if __name__ == "__main__":
    from adapters.registry import Registration
    from barchain.studies.comparison.run import run_comparison

    name, out = sys.argv[1:]
    registered = {name: Registration(f"{MODULE}:{name}")}
    run_comparison(["basics/two_bars_free"], out=out, time_limit_s=60.0, registered=registered)
else:
    from adapters.reference.numpy_engines import Reference

    class KillsCommand(Reference):
        def simulate(self) -> None:
            subprocess.Popen(SLEEP, start_new_session=True)
            kill(command_and_below()[:1])

    class KillsAllAbove(Reference):
        def simulate(self) -> None:
            subprocess.Popen(SLEEP, start_new_session=True)
            kill(command_and_below())

    class KillsFromParentOn(Reference):
        def simulate(self) -> None:
            subprocess.Popen(SLEEP, start_new_session=True, env={})
            kill(command_and_below()[::-1])
