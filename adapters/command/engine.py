"""The engine of an entry: it writes a request, starts the command, and reads the result."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from adapters.command.entries import OWN_CLOCK, REQUEST, RESULT, SAMPLES, arguments, variables
from adapters.command.samples import read_trajectory
from adapters.common.landing import landing_text
from adapters.engine import Engine, EngineError, UnsupportedMotionError
from adapters.request import VERSION, Result, run_request
from adapters.trajectory import ENDED, Observable
from scenarios.named_file import UnreadableError, read_named
from scenarios.toml.faults import fault_lines

if TYPE_CHECKING:
    from adapters.command.entries import Entry
    from adapters.engine import Setting
    from adapters.trajectory import Trajectory
    from scenarios import Scene

FILES = {REQUEST: "request.json", SAMPLES: "samples.csv", RESULT: "result.json"}
OUTPUT = "output.log"
MOST_RESULT_B = 1 << 20
LAST_B, LAST_WORDS = 4096, 300  # of what a program printed, that a failure tells


class CommandEngine(Engine):
    """A program that is started for each run, in the working folder of the run."""

    def __init__(self, folder: Path, entry: Entry) -> None:
        """Take the program's entry, and the folder of the file of entries."""
        self.folder, self.entry = folder, entry

    def build(self, scene: Scene, setting: Setting) -> None:
        """Write the request."""
        self.files = tempfile.TemporaryDirectory(dir=Path.cwd(), ignore_cleanup_errors=True)
        self.paths = {name: Path(self.files.name) / file for name, file in FILES.items()}
        self.paths[REQUEST].write_text(json.dumps(run_request(scene, setting)))
        self.torque_bars = [law.bar for law in scene.effects.prescribed_rotation]
        self.line = arguments(self.folder, self.entry, self.paths)

    def simulate(self) -> None:
        """Run the program.

        Raises
        ------
        EngineError
            If it does not start, or ends with another code than 0.
        """
        begun, output = time.perf_counter(), Path(self.files.name) / OUTPUT
        try:
            with output.open("wb") as sink:  # a pipe would wait for children that the program leaves behind
                ended = subprocess.run(
                    self.line, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink, check=False, cwd=self.files.name,
                    env=variables(self.entry),
                )  # fmt: skip
        except OSError as error:
            raise EngineError(f"{self.line[0]} does not start: {error.strerror}") from None
        self.process_s = time.perf_counter() - begun
        with output.open("rb") as printed:
            printed.seek(max(0, output.stat().st_size - LAST_B))
            said = " ".join(printed.read(LAST_B).decode(errors="replace").split())[-LAST_WORDS:]
        self.said = f": {said}" if said else ""
        if ended.returncode:
            how = f"with code {ended.returncode}" if ended.returncode > 0 else f"by signal {-ended.returncode}"
            raise EngineError(f"the program ended {how}{self.said}")

    def read(self) -> Trajectory:
        """Result and samples.

        Raises
        ------
        EngineError
            If either is missing or damaged, or the program says that it failed.
        """
        with self.files:
            return self.read_files()

    def read_files(self) -> Trajectory:
        """Read what the program wrote, before the folder goes; errors as of :meth:`read`."""
        found = self.read_result()
        if found.outcome == "unsupported":
            raise UnsupportedMotionError(found.reason or "the program does not support the scene")
        if found.outcome == "failed":
            raise EngineError(found.reason or "the program says that the run failed")
        table = self.paths[SAMPLES].with_name(found.samples or self.paths[SAMPLES].name)
        trajectory = read_trajectory(table, ended=landing_text(found.ended_s), torque_bars=self.torque_bars)
        counts = {"steps": found.steps, "evaluations": found.evaluations, ENDED: found.ended_s}
        clock = {"process_s": self.process_s} | ({} if found.seconds is None else {OWN_CLOCK: found.seconds})
        info: dict[str, float | str] = {k: float(v) for k, v in (counts | clock).items() if v is not None}
        shown = self.entry.observables  # a single bar's gaps and reactions are empty, and in every table
        gap_m = trajectory.gap_m if Observable.GAP in shown else None
        reaction_N = trajectory.reaction_N
        if Observable.REACTION not in shown and reaction_N is not None and not reaction_N.size:
            reaction_N = None
        return dataclasses.replace(trajectory, info=info, gap_m=gap_m, reaction_N=reaction_N)

    def read_result(self) -> Result:
        """Result as the program wrote it; of a program that writes samples alone, that it passed."""
        if RESULT not in self.entry.command:
            return Result(version=VERSION)
        if not os.path.lexists(self.paths[RESULT]):
            raise EngineError(f"the program ended without a result{self.said}")
        try:
            return Result.model_validate_json(read_named(self.paths[RESULT], MOST_RESULT_B))
        except UnreadableError as error:
            raise EngineError(f"the program's result is damaged: {error}") from None
        except ValidationError as error:
            raise EngineError(f"the program's result is damaged: {fault_lines(error, Result)[0]}") from None
