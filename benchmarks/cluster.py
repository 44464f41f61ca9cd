"""Cost of a Dask scheduler for small calls, and throughput against the number of workers.

Scheduler, workers and the processes beside them run on this machine. Their processor time is read from the system, as a
busy machine changes it less than the wall time. Calls of the first part do nothing; calls of the second part wait for a
tenth of a second, so that two workers are faster than one on a busy machine too.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import psutil

from barchain.runs.call import Call
from barchain.runs.executors import DaskCluster, LocalProcesses

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.runs.executors import Executor

CALLS = 5_000
WAITS, WAIT_S = 200, 0.1
LIMIT_S, PATIENT_S = 600.0, 300.0


def nothing(number: int) -> bytes:
    """Answer at once."""
    return number.to_bytes(8, "little")


def wait(number: int) -> bytes:
    """Answer after a while."""
    time.sleep(WAIT_S)
    return nothing(number)


@contextlib.contextmanager
def cluster(workers: int) -> Iterator[tuple[str, dict[str, psutil.Process]]]:
    """Address of a scheduler with its workers, and its processes by name."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    scheduler = ["scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    worker = ["worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
    commands = {"scheduler": scheduler} | {f"worker {k + 1}": worker for k in range(workers)}
    with tempfile.TemporaryDirectory() as folder:
        started = {name: start(command, folder) for name, command in commands.items()}
        try:
            while not listens(port):
                time.sleep(0.5)
            yield address, {name: psutil.Process(process.pid) for name, process in started.items()}
        finally:
            for process in started.values():
                process.terminate()
                process.wait()


def listens(port: int) -> bool:
    """Whether something accepts connections."""
    with contextlib.suppress(OSError):
        socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
        return True
    return False


def start(command: list[str], folder: str) -> subprocess.Popen[bytes]:
    """Process of Dask, which finds this module."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])}
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{command[0]}", *command[1:]],
        cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def seconds_of(process: psutil.Process) -> float:
    """Processor time of a process, without its children."""
    times = process.cpu_times()
    return float(times.user + times.system)


def timed(executor: Executor, call: Call, count: int) -> float:
    """Wall time of `count` calls, s; a first one, which starts the processes, is not counted."""
    with executor.session() as session:
        for _ in range(4):
            session.submit(-1, Call(call.function, (0,), LIMIT_S))
        list(session.answers())
        start_s = time.perf_counter()
        for k in range(count):
            session.submit(k, Call(call.function, (k,), LIMIT_S))
        found = {key: answer.content for key, answer in session.answers()}
        took_s = time.perf_counter() - start_s
    assert found == {k: nothing(k) for k in range(count)}
    return took_s


def cost(executor: Executor, count: int, title: str, processes: dict[str, psutil.Process]) -> None:
    """Print wall time and processor time of calls that do nothing."""
    watched = {"client": psutil.Process()} | processes
    before = {name: seconds_of(process) for name, process in watched.items()}
    took_s = timed(executor, Call(nothing, (), LIMIT_S), count)
    used = {name: 1e3 * (seconds_of(process) - before[name]) / count for name, process in watched.items()}
    shares = ", ".join(f"{name} {ms:.3f}" for name, ms in used.items())
    print(
        f"{title}: {count} calls in {took_s:.1f} s, {1e3 * took_s / count:.3f} ms each; processor, ms: {shares}",
        flush=True,
    )


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--calls", type=int, default=CALLS)
    parser.add_argument(
        "--workers", type=int, nargs="*", default=(1, 2), help="numbers of workers whose throughput is shown"
    )
    given = parser.parse_args()
    for workers in given.workers:
        with cluster(workers) as (address, _):
            took_s = timed(DaskCluster(address, PATIENT_S), Call(wait, (), LIMIT_S), WAITS)
        print(f"{workers} workers: {WAITS / took_s:.2f} calls of {WAIT_S:g} s in a second", flush=True)
    cost(LocalProcesses(2), given.calls, "processes of this machine", {})
    with cluster(2) as (address, processes):
        cost(DaskCluster(address, PATIENT_S), given.calls, "cluster", processes)


if __name__ == "__main__":  # by its name, so that other processes can import the functions
    importlib.import_module(Path(__file__).stem).main()
