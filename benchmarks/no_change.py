"""Nights without a change: false alarms of a short plan on this machine, some nights beside other programs.

    python benchmarks/no_change.py --folder quiet --nights 60 --beside 20

All nights run the same sources in the same environment, so that each change that a night tells is a false alarm. The
script goes on where it was interrupted. `benchmarks/nights_until_told.py` then plants slow-downs in the times of the
history that these nights leave.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

PLAN = """
name = "short"
minutes = {minutes}

[[selftest]]
name = "alarm"
faults = 8

[[comparison]]
name = "core"
scenes = ["paper/fig13", "basics/two_bars_free"]
share = 3

[[cost]]
name = "cost"
scenes = ["paper/fig13"]
engines = ["reference-fast", "heyoka", "mujoco"]
share = 4

[[scaling]]
name = "memory"
engines = ["reference-fast", "mujoco"]
bars = [20]
"""
BUSY = 3
"""Programs beside a night, on two processors"""


def spin() -> None:
    """Keep a processor busy."""
    while True:
        pass


@contextmanager
def beside(programs: int) -> Iterator[None]:
    """Other programs that keep processors busy."""
    busy = [multiprocessing.Process(target=spin, daemon=True) for _ in range(programs)]
    for each in busy:
        each.start()
    try:
        yield
    finally:
        for each in busy:
            each.kill()
            each.join()


def night(folder: Path, number: int) -> Path:
    """Run a night; its facts as they are kept for this number."""
    out, kept = folder / "nights", folder / f"night-{number:03d}.json"
    line = (
        sys.executable, "-m", "barchain", "-q", "nightly", "--plan", str(folder / "plan.toml"),
        "--out", str(out), "--fail-on", "never",
    )  # fmt: skip
    subprocess.run(line, check=True, stdout=subprocess.DEVNULL)
    kept.write_bytes((out / "nightly.json").read_bytes())
    return kept


def told(path: Path) -> str:
    """Result of a night in one line."""
    facts = json.loads(path.read_text("utf-8"))
    missing = sum(c["became"] == "missing" for c in facts["changes"])
    return (
        f"{facts['night']['state']}, {facts['night']['figures']} figures, {facts['counts']['judged']} judged, "
        f"{len(facts['changes'])} changes ({missing} of them missing figures), "
        f"{facts['counts']['same']} numerically the same"
    )


def main() -> None:
    """Run all nights and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--nights", type=int, default=60)
    parser.add_argument("--minutes", type=float, default=4.0, help="budget of a night")
    parser.add_argument("--beside", type=int, default=20, help="nights of these that run beside other programs")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    (asked.folder / "plan.toml").write_text(PLAN.format(minutes=asked.minutes), "utf-8")
    changes = judged = 0
    for number in range(asked.nights):
        kept = asked.folder / f"night-{number:03d}.json"
        loaded = (number + 1) * asked.beside // asked.nights > number * asked.beside // asked.nights
        began = time.monotonic()
        if not kept.is_file():
            with beside(BUSY if loaded else 0):
                night(asked.folder, number)
        facts = json.loads(kept.read_text("utf-8"))
        changes, judged = changes + len(facts["changes"]), judged + facts["counts"]["judged"]
        where = "beside others" if loaded else "alone"
        print(f"{number + 1:3d}  {time.monotonic() - began:5.1f} s  {where}: {told(kept)}", flush=True)
    print(f"{changes} false alarms in {asked.nights} nights; {judged} figures judged")


if __name__ == "__main__":
    main()
