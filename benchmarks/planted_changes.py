"""Changes that are planted on purpose, each on a night of its own after the same earlier nights.

    python benchmarks/planted_changes.py --folder planted

Each planted change is real: other sources of barchain, or another release of a library, in an environment of its own.
The table tells whether the night told the change, in the right direction, and which part it named as the culprit.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from barchain.nightly.attribution.environments import installed_tree, pinned_environment, run_in
from barchain.nightly.errors import PinnedEnvironmentError

EARLIER = 2
LIMIT_S = 400.0
NEEDED = (
    "fsspec", "threadpoolctl", "junitparser", "packaging", "pypi-simple", "uv", "mujoco", "pin", "heyoka",
)  # fmt: skip
ENGINES = (
    "reference", "reference-fast", "exudyn", "pymunk", "rebound", "heyoka", "mujoco", "pinocchio", "scipy-dop853",
)  # fmt: skip
PLAN = """
name = "planted"
minutes = 5
[[comparison]]
name = "core"
scenes = ["paper/fig05", "basics/two_bars_free", "basics/kepler_circular"]
engines = {engines}
"""
WRAP = """

def _plant(kind):
    import dataclasses
    import numpy as np
    from adapters.engine import Setting
    build, read = kind.build, kind.read

    def planted_build(self, scene, setting):
        return build(self, scene, Setting(setting.parameter, setting.value * {factor}))

    def planted_read(self):
        found = read(self)
        {change}
        return found

    kind.build, kind.read = planted_build, planted_read


_plant({engine})
"""
SIGN = "found = dataclasses.replace(found, reaction_N=-found.reaction_N)"
LATE = "found = dataclasses.replace(found, angle_rad=np.vstack([found.angle_rad[:1], found.angle_rad[:-1]]))"
STEP = 'found = dataclasses.replace(found, info=found.info | {"steps": found.info["steps"] + 1})'
LAST_BIT = "found = dataclasses.replace(found, angle_rad=found.angle_rad * (1.0 + 2.0**-52))"


@dataclass(frozen=True)
class Plant:
    """One planted change."""

    name: str
    culprit: str
    """Part that must be named"""
    told: str
    """Direction of at least one change: ``worse``, ``changed``.

    ``quiet``: only bits differ. ``differs``: anything is told. ``same``: nothing may be told.
    """
    file: str = ""
    old: str = ""
    new: str = ""
    """Text in the place of `old`; appended where `old` is empty"""
    pin: str = ""
    variable: tuple[str, str] | None = None
    """Environment variable of the night"""
    one_core: bool = False
    """Whether the night may use one processor only: another machine class"""
    engines: tuple[str, ...] = ENGINES
    """Engines of the night: those that the change can touch, and one that it can't"""

    @property
    def plan(self) -> str:
        """Plan of the night."""
        return PLAN.format(engines=json.dumps(list(self.engines)))


def wrapped(
    name: str, package: str, file: str, engine: str, told: str, *, factor: float = 1.0, change: str = "pass"
) -> Plant:
    """Change of an adapter that wraps one engine."""
    text = WRAP.format(factor=factor, change=change, engine=engine)
    own = "scipy-dop853" if package == "ode_solvers" else package
    return Plant(
        f"{engine}: {name}", f"adapter:{package}", told, f"adapters/{package}/{file}.py", "", text,
        engines=(own, "reference-fast"),
    )  # fmt: skip


def stepped(package: str, file: str, engine: str) -> list[Plant]:
    """Mistakes of an engine of equal steps."""
    return [
        wrapped("half the steps", package, file, engine, "worse", factor=0.5),
        wrapped("a sign of the reactions", package, file, engine, "worse", change=SIGN),
        wrapped("angles a sample late", package, file, engine, "worse", change=LATE),
        wrapped("one step more", package, file, engine, "changed", change=STEP),
    ]


def tolerant(package: str, file: str, engine: str, factor: float = 3.0) -> list[Plant]:
    """Mistakes of an engine with a tolerance.

    Heyoka's order follows from its tolerance, and its step from the order: a factor of 3 changes no bit.
    """
    return [
        wrapped(f"tolerance times {factor:g}", package, file, engine, "worse", factor=factor),
        wrapped("a sign of the reactions", package, file, engine, "worse", change=SIGN),
        wrapped("angles a sample late", package, file, engine, "worse", change=LATE),
    ]


SOURCES = [
    *stepped("mujoco", "adapter", "Mujoco"),
    *stepped("exudyn", "adapter", "Exudyn"),
    *stepped("pymunk", "adapter", "Pymunk"),
    *tolerant("heyoka", "adapter", "Heyoka", 100.0),
    *tolerant("pinocchio", "adapter", "Pinocchio"),
    wrapped("tolerance times 3", "ode_solvers", "adapter", "ScipyDop853", "worse", factor=3.0),
    wrapped("angles a sample late", "rebound", "adapter", "Rebound", "worse",
            change="found = dataclasses.replace(found, com_m=np.vstack([found.com_m[:1], found.com_m[:-1]]))"),
    wrapped("last bit of the angles", "mujoco", "adapter", "Mujoco", "quiet", change=LAST_BIT),
    wrapped("last bit of the angles", "exudyn", "adapter", "Exudyn", "quiet", change=LAST_BIT),
    Plant("reference: last bit of the gravity torque", "reference", "quiet", "reference_impl/model/gravity.py",
          "3.0 * model.mu_m3_s2 * seen.real", "3.0000000000000004 * model.mu_m3_s2 * seen.real"),
    Plant("reference: gravity torque 1e-6 larger", "reference", "worse", "reference_impl/model/gravity.py",
          "3.0 * model.mu_m3_s2 * seen.real", "3.000003 * model.mu_m3_s2 * seen.real"),
    Plant("mujoco: lost order", "adapter:mujoco", "worse", "adapters/mujoco/chain.py",
          "mj.mjtIntegrator.mjINT_RK4", "mj.mjtIntegrator.mjINT_EULER",
          engines=("mujoco", "reference-fast")),
]  # fmt: skip
WHEELS = [
    Plant("mujoco 3.2.7", "engine:mujoco", "differs", pin="mujoco==3.2.7", engines=("mujoco", "reference-fast")),
    Plant("mujoco 3.3.0", "engine:mujoco", "same", pin="mujoco==3.3.0", engines=("mujoco", "reference-fast")),
    Plant("heyoka 7.10.1", "engine:heyoka", "differs", pin="heyoka==7.10.1", engines=("heyoka", "reference-fast")),
    Plant("pinocchio 3.4.0", "engine:pin", "differs", pin="pin==3.4.0", engines=("pinocchio", "reference-fast")),
    Plant("pymunk 6.11.1", "engine:pymunk", "same", pin="pymunk==6.11.1", engines=("pymunk", "reference-fast")),
    Plant("exudyn 1.11.0", "engine:exudyn", "worse", pin="exudyn==1.11.0", engines=("exudyn", "reference-fast")),
    Plant("rebound 4.4.0", "engine:rebound", "same", pin="rebound==4.4.0", engines=("rebound", "reference-fast")),
    Plant(
        "scipy 1.15.3", "library:scipy", "same", pin="scipy==1.15.3", engines=("scipy-dop853", "reference", "exudyn")
    ),
    Plant("numpy 2.0.2", "library:numpy", "same", pin="numpy==2.0.2"),
    Plant("numpy 2.3.5", "library:numpy", "same", pin="numpy==2.3.5"),
    Plant(
        "BLAS with the kernels of another processor", "blas", "differs", variable=("OPENBLAS_CORETYPE", "Sandybridge")
    ),
    Plant("another machine class: one processor", "machine", "same", one_core=True),
]
"""Other releases, and whether their numbers differ here by `barchain releases` and by comparing trajectories"""


def night(tree: Path, folder: Path, history: Path, plant: Plant | None = None) -> str:
    """Run a night in an environment; the reason of a failure, or an empty text."""
    pins = (plant.pin,) if plant and plant.pin else ()
    variables = dict([plant.variable]) if plant and plant.variable else {}
    try:
        environment = pinned_environment(pins, also=NEEDED)
    except PinnedEnvironmentError as error:
        return str(error)
    line = ("-m", "barchain", "-q", "nightly", "--plan", str(folder / "plan.toml"), "--out", str(history),
            "--fail-on", "never")  # fmt: skip
    cores = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(cores)} if plant and plant.one_core else cores)
        with patch.dict(os.environ, variables):
            return run_in(environment.python, tree, line, limit_s=LIMIT_S, folder=folder).reason
    finally:
        os.sched_setaffinity(0, cores)


def planted_tree(plant: Plant, target: Path) -> Path:
    """Sources with a planted change."""
    tree = installed_tree(target)
    if plant.file:
        path = tree / plant.file
        text = path.read_text("utf-8")
        if plant.old and text.count(plant.old) != 1:
            raise SystemExit(f"{plant.name}: {plant.old!r} stands {text.count(plant.old)} times in {plant.file}")
        path.write_text(text.replace(plant.old, plant.new) if plant.old else text + plant.new, "utf-8")
    return tree


def verdict(plant: Plant, facts: dict) -> tuple[bool, bool | None, str]:  # type: ignore[type-arg]
    """Whether the night told the change, whether the culprit is right, and what was told."""
    changes = [c for c in facts["changes"] if not c["irreproducible"]]
    deterministic = [c for c in changes if c["kind"] in {"error", "count", "verdict", "value"}]
    bits = [c for c in changes if c["kind"] == "bits"]
    directions = {c["direction"] for c in deterministic}
    named = [{s["name"] for s in c["suspects"]} for c in changes]
    right = all(names == {plant.culprit} for names in named) if named else None
    words = f"{len(bits)} bits, " + ", ".join(
        f"{sum(c['direction'] == d for c in deterministic)} {d}" for d in ("worse", "better", "changed")
    )
    if plant.told == "quiet":
        return bool(bits) and "worse" not in directions, right, words
    if plant.told == "differs":
        return bool(changes), right, words
    if plant.told == "same":
        return not facts["changes"], right, words
    return plant.told in directions, right, words


def in_words(plant: Plant, ok: bool) -> str:
    """Expected finding, and whether it came."""
    if plant.told == "same":
        return "nothing to tell, nothing told" if ok else "FALSE ALARM"
    return "told" if ok else "MISSED"


def main() -> None:
    """Plant all changes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    folder = parser.parse_args().folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "plan.toml").write_text(PLAN.format(engines=json.dumps(list(ENGINES))), "utf-8")
    base, tree = folder / "base", folder / "tree"
    if not base.exists():
        installed_tree(tree)
        for _ in range(EARLIER):
            reason = night(tree, folder, base)
            if reason:
                raise SystemExit(reason)
    told = right = judged = 0
    plants = [*SOURCES, *WHEELS]
    for k, plant in enumerate(plants):
        own = folder / f"plant-{k}"
        history = own / "nights"
        if not (history / "told").is_file():
            shutil.rmtree(own, ignore_errors=True)
            shutil.copytree(base, history)
            (own / "plan.toml").write_text(plant.plan, "utf-8")
            reason = night(planted_tree(plant, own / "tree"), own, history, plant)
            shutil.rmtree(own / "tree", ignore_errors=True)
            if reason:
                print(f"| {plant.name} | could not be planted: {reason} | | |", flush=True)
                continue
            (history / "told").touch()
        facts = json.loads((history / "nightly.json").read_text("utf-8"))
        ok, culprit, words = verdict(plant, facts)
        told += ok
        judged += culprit is not None
        right += culprit is True
        others = sorted({s["name"] for c in facts["changes"] for s in c["suspects"]} - {plant.culprit})
        named = "right" if culprit else "none named" if culprit is None else f"also {', '.join(others)}"
        print(f"| {plant.name} | {in_words(plant, ok)} | {words} | {named} |", flush=True)
    print(f"{told} of {len(plants)} as expected; culprit right in {right} of {judged}")


if __name__ == "__main__":
    main()
