"""Dask schedulers and workers in processes of their own, which tests kill or damage."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

START_S = 60.0
ONCE = """
import barchain.runs.cluster.on_dask_worker as beside_worker
if not hasattr(beside_worker, 'real'):  # Dask imports a preload twice
    beside_worker.real = beside_worker.answer_call
"""
SLOW = f"""
import time
{ONCE}
def slowly(*given):
    time.sleep(0.5)
    return beside_worker.real(*given)
beside_worker.answer_call = slowly
"""
DIES = f"""
import os
{ONCE}
beside_worker.answer_call = lambda *given: os._exit(3)
"""
LACKS_BARCHAIN = "import sys; sys.modules['barchain'] = None"
OTHER_HOST = """
from barchain.runs import same_code, worker
same_code.digest_of = lambda *names: 'other'
worker.main()
"""
OTHER_SOURCES = f"""
import sys
import barchain.runs.pool as workers
workers.COMMAND = [sys.executable, "-c", {OTHER_HOST!r}]
"""
OTHER_DASK = """
import distributed.versions as versions
if not hasattr(versions, 'real'):
    versions.real = versions._version_cached
versions._version_cached = lambda name: '2020.1.0' if name == 'distributed' else versions.real(name)
"""


class LocalCluster:
    """A scheduler and its workers."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen[bytes]]()
        self.file = folder / "scheduler.json"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")
        until = time.monotonic() + START_S
        while not listens(self.port):
            assert time.monotonic() < until
            time.sleep(0.1)

    def start(self, kind: str, *options: str) -> subprocess.Popen[bytes]:
        """Start a process of Dask in a group of its own, which imports what the tests import."""
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{kind}", *options],
            cwd=self.folder, env=environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self.processes.append(process)
        return process

    def worker(self, preload: str = "", *options: str) -> subprocess.Popen[bytes]:
        """Start a worker that runs some code first."""
        file = self.folder / f"preload_{len(self.processes)}.py"
        file.write_text(preload, encoding="utf-8")
        return self.start("worker", self.address, "--nthreads", "1", "--no-dashboard", "--preload", str(file), *options)

    def close(self) -> None:
        """Kill every process."""
        for process in self.processes:
            kill(process)


def listens(port: int) -> bool:
    """Whether something accepts connections."""
    with contextlib.suppress(OSError):
        socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
        return True
    return False


def kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process with its group, and wait for it."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@contextlib.contextmanager
def listener(answer: bytes) -> Iterator[str]:
    """Address that accepts connections, sends some bytes and waits."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        kept = []

        def serve() -> None:
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = server.accept()
                    connection.sendall(answer)
                    kept.append(connection)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        try:
            yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        finally:
            server.shutdown(socket.SHUT_RDWR)
            for connection in kept:
                connection.close()
            thread.join()
