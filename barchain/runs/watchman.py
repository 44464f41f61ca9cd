"""Watchman of a comparing process: a small process that cleans up after it, however it ends.

The watchman reads a pipe that only the comparing process holds open. A word on the pipe is an orderly end: the folder
is removed. The end of the pipe without a word means that the process was killed: the watchman first kills every
process whose environment names the folder, or that works inside it. It runs in a session of its own, so that a closed
terminal does not end it.
"""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import sys
import tempfile

DONE = b"done"
PROGRAM = r"""
import os, shutil, signal, sys, time
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
folder = sys.argv[1]
orderly = sys.stdin.buffer.read() == b"done"
marked = ("BARCHAIN_TEMPORARY=" + folder).encode()

def belongs(pid):
    try:
        if os.readlink(f"/proc/{pid}/cwd").startswith(folder + "/"):
            return True
        with open(f"/proc/{pid}/environ", "rb") as file:
            return marked in file.read().split(b"\0")
    except OSError:
        return False

def kill_all():
    found = [int(p) for p in os.listdir("/proc") if p.isdigit() and int(p) != os.getpid() and belongs(p)]
    for pid in found:
        try:
            os.kill(pid, signal.SIGKILL)
        except OSError:
            pass
    return found

if not orderly and os.path.isdir("/proc/self"):
    for _ in range(100):
        if not kill_all():
            break
        time.sleep(0.05)
shutil.rmtree(folder, ignore_errors=True)
"""
"""Program of the watchman; it imports nothing but the standard library, to start in some 20 ms"""


class Watchman:
    """A temporary folder, and the process that removes it."""

    def __init__(self) -> None:
        """Make the folder and start the process."""
        self.folder = tempfile.mkdtemp(prefix="barchain-")
        self.process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-c", PROGRAM, self.folder],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip

    def dismiss(self) -> None:
        """End the process in order; it removes the folder first, or was killed and leaves that to its owner."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.write(DONE)
            self.process.stdin.close()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
