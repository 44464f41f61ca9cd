"""Scenes and engines of a stability study, pairs left to a full one, settings, and the outcomes recorded of them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting, steps_between_samples
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import COMPILED, ENGINES, engines, find_engine
from barchain.runs.job import Job, Role
from reports.results.reading import brief, damaged
from reports.results.stability import Stability
from reports.results.writing import write_atomically
from scenarios import load_scene, scene_names
from scenarios.named_file import UnreadableError
from scenarios.size_limits import LimitError
from scenarios.toml.reading import read_text, tables_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from adapters.engine import Declarations
    from adapters.registry import Registration
    from barchain.studies.stability.rules import Finding
    from scenarios import Scene

HARD = "hard/"
HUGE = "huge"  # tag of scenes that take hours, and are run where they are named
LONG = "long"  # tag of scenes whose drifts are followed over time

SOLUTION_LIMIT_S = (
    600.0  # a reference solution is run four times, at its tightest and at close samples; without it nothing is judged
)
COARSER_RTOL, COARSER_STEPS = 100.0, 0.25  # two decades of a request; two halvings of a step
PLAIN_RTOL = 1e-3  # SciPy's default; its default absolute tolerance of 1e-6 is a thousandth of it, as the adapter takes
EXACT_RTOL = 1e-14  # of the compiled reference: its sums are compensated from here on
SCIPY = re.compile("scipy-.*")
"""SciPy's solvers, on compiled rates and on rates in NumPy"""

NUMPY_RATES = frozenset({"reference", "reference-absolute"})
"""Engines that evaluate rates in NumPy: hundreds of orbits take them minutes a run"""
MOST_BARS_COMPILED = 200  # heyoka compiles 1000 bars for minutes, at each setting


def hard_scenes() -> list[str]:
    """Names of the hard scenes that are run where none is named."""
    return [name for name in scene_names() if name.startswith(HARD) and HUGE not in load_scene(name).tags]


def default_engines(*, full: bool = False) -> dict[str, Registration]:
    """Engines that take part where none is named: those of the default set, and SciPy's solvers.

    The solvers run on compiled rates; on rates in NumPy in a full study, and where the kernel is missing.
    """
    found = {name: r for name, r in engines().items() if not r.missing and (r.by_default or SCIPY.fullmatch(name))}
    compiled = set() if full else {f"{name}-numpy" for name in found}
    return {name: r for name, r in found.items() if name not in compiled}


def chosen_engines(names: Iterable[str] | None, *, full: bool = False) -> dict[str, Registration]:
    """Engines by name, or the default ones."""
    return {name: find_engine(name) for name in dict.fromkeys(names)} if names else default_engines(full=full)


def left_to_a_full_study(scenes: Iterable[Scene], names: Iterable[str]) -> frozenset[tuple[str, str]]:
    """Pairs that take long and are known: recorded time-outs, and :func:`takes_minutes`."""
    own, known = frozenset(names), recorded()
    found = {(scene.name, name) for scene in scenes for name in own if takes_minutes(scene, name, own)}
    return frozenset(found | {pair for pair, word in known.items() if word == SLOW and pair[1] in own})


def takes_minutes(scene: Scene, name: str, engines: Collection[str]) -> bool:
    """Whether each run takes minutes: rates in NumPy in a long scene, if the compiled reference is there; compiling."""
    if LONG in scene.tags and COMPILED in engines and name in NUMPY_RATES:
        return True
    solver = name != COMPILED and name in ENGINES and ENGINES[name].needs_kernel
    return scene.bars > MOST_BARS_COMPILED and (solver or (name in ENGINES and ENGINES[name].compiles))


def settings(scene: Scene, name: str, engine: Declarations) -> dict[Role, Setting]:
    """Settings of an engine in a scene, by role; samples may lie too close for a coarser one."""
    main = engine.sweep.setting()
    found = {Role.MAIN: main, Role.FINER: finer_setting(scene, engine.sweep, main)}
    coarse = coarser(scene, main)
    if coarse is not None:
        found[Role.COARSE] = coarse
    if SCIPY.fullmatch(name):
        found[Role.PLAIN] = Setting(AccuracyParameter.RTOL, PLAIN_RTOL)
    return found


def coarser(scene: Scene, main: Setting) -> Setting | None:
    """A hundred times the request, or a quarter of the steps; None where that makes the same steps."""
    if main.parameter is AccuracyParameter.RTOL:
        return Setting(AccuracyParameter.RTOL, COARSER_RTOL * main.value)
    found = Setting(main.parameter, COARSER_STEPS * main.value)
    same = steps_between_samples(scene, found.value) == steps_between_samples(scene, main.value)
    return None if same else found


def exact_jobs(scene: Scene) -> list[Job]:
    """The compiled reference with compensated sums, in a scene whose drifts are followed over time."""
    if LONG not in scene.tags or ENGINES[COMPILED].missing:
        return []
    return [Job(scene, COMPILED, ENGINES[COMPILED], Setting(AccuracyParameter.RTOL, EXACT_RTOL), Role.EXACT)]


PATH = Path(__file__).with_name("expected.toml")
HEADER = "# How each engine fares in each hard scene; written by `barchain stability --accept FILE`.\n"
SLOW = "failed: time"  # a time-out, which another machine may not see
HARM = (
    Stability.STABLE, Stability.DRIFTING, Stability.UNSUPPORTED, Stability.REJECTED, Stability.INACCURATE,
    Stability.UNSTABLE, Stability.FAILED,
)  # fmt: skip
"""From the best to the worst for who relies on it: saying no is better than being wrong"""

Pair = tuple[str, str]


@dataclass(frozen=True)
class OutcomeChange:
    """An outcome that is not the one recorded."""

    scene: str
    engine: str
    before: str
    now: str

    @property
    def direction(self) -> str:
        """Whether it is better or worse."""
        now, before = (HARM.index(stability_of(word)) for word in (self.now, self.before))
        return "better" if now < before else "worse"

    @property
    def words(self) -> str:
        """In one line."""
        return f"{self.scene}  {self.engine}: {self.before} before, {self.now} now ({self.direction})"


def stability_of(word: str) -> Stability:
    """Outcome of a recorded word."""
    return Stability.FAILED if word == SLOW else Stability(word)


def recorded(path: Path = PATH) -> dict[Pair, str]:
    """Recorded words by scene and engine.

    Raises
    ------
    DamagedResultsError
        If the file holds anything else.
    """
    if not path.exists():
        return {}
    try:
        found = tables_of(read_text(path))
    except (LimitError, UnreadableError) as error:
        raise damaged(path, f"it is no TOML ({brief(error)})") from error
    allowed = (*Stability, SLOW)
    for scene, by in found.items():
        if not isinstance(by, dict) or any(word not in allowed for word in by.values()):
            raise damaged(path, f"of {brief(scene)}: expected an engine and one of {', '.join(allowed)} in each line")
    return {(scene, engine): word for scene, by in found.items() for engine, word in by.items()}


def word_of(finding: Finding) -> str:
    """Recorded word of a finding."""
    return SLOW if finding.slow else str(finding.stability)


def change(scene: str, engine: str, before: str | None, finding: Finding) -> OutcomeChange | None:
    """Change of an outcome; None where nothing counts as a change.

    A run that timed out before may finish now, or fail otherwise before its time limit: the cause is the machine. An
    outcome that is replaced by a time-out is a change.
    """
    now = word_of(finding)
    if before is None or before in (now, SLOW) or stability_of(before) is finding.stability:
        return None
    return OutcomeChange(scene, engine, before, now)


def accept(found: Mapping[Pair, Finding], path: Path = PATH) -> None:
    """Record these outcomes, and keep those of other scenes and engines."""
    words = recorded(path) | {pair: word_of(f) for pair, f in found.items()}
    lines = [HEADER]
    for scene in sorted({s for s, _ in words}):
        own = [f'{engine} = "{word}"' for (s, engine), word in sorted(words.items()) if s == scene]
        lines.append("\n".join([f'["{scene}"]', *own, ""]))
    write_atomically(path, "\n".join(lines))
