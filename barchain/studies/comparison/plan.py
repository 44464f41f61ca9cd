"""What a comparison shall do: the setting of each engine, and verdicts that it has to give.

An engine of equal steps is compared at the cheapest setting at which it still shows something at a scene's scale. A
verdict that a comparison requires and that no run gave is a failure of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.judge.error_model import ErrorModel
from barchain.judge.verdict import no_verdict
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S
from barchain.solutions.judging import shares_equations
from barchain.solutions.reference import SolutionSource
from reports.results.comparison import ALL_SCENES
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from adapters.engine import Declarations
    from adapters.registry import Registration
    from barchain.judge.verdict import Verdict
    from barchain.runs.executors import Executor
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    Missing = tuple[str, str, Verdict]

WANTED_SHARE = 1e-3
"""Largest expected-error bound over the first orbit, relative to each quantity's scale"""
KEPT_LIMIT = 0.75
"""Least predictability limit of a chaotic scene, relative to that at the engine's default setting"""
STEPS_PER_TURN = 40
"""Least steps in the fastest turn of a bar: bounds hold to the predictability limit, and some chains tumble after it"""
QUANTITIES = ("attitude", "rate", "reaction")
PER_OCTAVE = 2
"""Settings tried for each factor of two in the steps"""
ANY_INDEPENDENT = "(any independent engine)"
SEVERAL = 2
"""Scenes of which an engine must support at least one: its failure is then no accident of one scene"""


@dataclass(frozen=True)
class ComparisonPlan:
    """Scenes and engines to compare, and how."""

    scenes: list[Scene]
    engines: dict[str, Registration]
    time_limit_s: float = TIME_LIMIT_S
    executor: Executor = ALL_CORES
    """Place of the runs and of long verdicts"""
    settings: dict[str, Setting] = field(default_factory=dict)
    """Setting of an engine other than its default"""
    need_external: bool = False
    """Whether a scene that no engine with independent physics passes is a failure"""
    named: bool = False
    """Whether the engines were requested by name: an engine that was compared on no scene is then a failure"""
    certify: bool = False
    """Whether scenes without a shipped solution are judged by one of heyoka's, where it can make one"""

    def setting(
        self, name: str, engine: Declarations, scene: Scene, solution: ReferenceSolution | None = None
    ) -> Setting:
        """Setting at which an engine is judged; `solution` is the scene's, where it is known before the runs."""
        given = self.settings.get(name)
        if given is not None:
            return given
        own = name in ENGINES  # declarations of another package's engine are not asked for a choice
        return comparison_setting(engine, scene, solution) if own else engine.sweep.setting()


@dataclass
class SceneProgress:
    """Results of one scene as they come."""

    scene: Scene
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    source: SolutionSource = SolutionSource.REFERENCE
    """Origin of the solution that judges the scene"""
    solution_failed: str = ""
    """Why no solution judges the scene; empty if one does"""
    unpredictable: str = ""
    """Why no run can be compared, at any setting: samples too far apart; empty where one can"""


def comparison_setting(engine: Declarations, scene: Scene, solution: ReferenceSolution | None) -> Setting:
    """Setting at which an engine of barchain's own registry is compared on a scene, if none is given.

    Methods that choose their steps, and scenes whose solution is not known before the runs, have the engine's default
    setting. Otherwise it is the coarsest setting of an engine of equal steps whose expected-error bound stays below
    :data:`WANTED_SHARE`. Where not even the default setting promises so much in a chaotic scene, it is the coarsest
    that keeps :data:`KEPT_LIMIT` of the predictability limit: each halving of the step of a second-order method buys
    an eighth of an orbit more. The fastest turn of the whole run takes at least :data:`STEPS_PER_TURN` steps, and a
    swing of an end body 2 π: explicit methods are unstable with fewer, and their bounds promise nothing.
    """
    default = engine.sweep.setting()
    if default.parameter is not AccuracyParameter.STEPS_PER_ORBIT:
        return default
    swings = scene.swing_rate_rad_s * scene.step_period_s
    if default.value < swings:
        return Setting(default.parameter, two_digits(swings))
    if solution is None:
        return default
    own = promise(engine, default, solution)
    if expected_share(own) > WANTED_SHARE:
        least_s = KEPT_LIMIT * own.limit_s
        if own.limit_s >= own.t_s[-1]:
            return default
        shows = (s for s in coarse_first(engine, default) if promise(engine, s, solution).limit_s >= least_s)
    else:
        shows = (
            s for s in coarse_first(engine, default) if expected_share(promise(engine, s, solution)) <= WANTED_SHARE
        )
    least = max(STEPS_PER_TURN * turns_per_orbit(solution), swings)
    return next((s for s in shows if s.value >= least), default)


def turns_per_orbit(solution: ReferenceSolution) -> float:
    """Turns of the fastest bar in the orbit to which steps are counted."""
    rates = solution.trajectory.rate_rad_s
    if rates is None:
        return 0.0
    return float(np.max(np.abs(rates))) * solution.scene.step_period_s / (2.0 * math.pi)


def coarse_first(engine: Declarations, default: Setting) -> Iterator[Setting]:
    """Settings from the coarsest of an engine's accuracy sweep to just below its default."""
    octaves = math.log2(default.value / min(engine.sweep.values))
    for k in range(math.floor(PER_OCTAVE * octaves), 0, -1):
        yield Setting(default.parameter, two_digits(default.value * 2.0 ** (-k / PER_OCTAVE)))


def two_digits(value: float) -> float:
    """Value rounded up to two digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit - 1e-9) * unit


def promise(engine: Declarations, setting: Setting, solution: ReferenceSolution) -> ErrorModel:
    """Error model of an engine at a setting, before it runs."""
    return ErrorModel(engine, setting, solution, solution.trajectory)


def expected_share(errors: ErrorModel) -> float:
    """Largest expected-error bound over the first orbit, relative to the quantity's scale."""
    last = int(np.count_nonzero(errors.t_s <= errors.scene.step_period_s)) - 1
    shares = [float(errors.bound[q][last]) / errors.scale[q] for q in QUANTITIES if q in errors.bound]
    return max(shares, default=math.inf)


def required_verdicts(comparison: ComparisonPlan, progress: Mapping[str, SceneProgress]) -> Iterator[Missing]:
    """Scene, engine and verdict of each lack; a name in parentheses stands for all scenes or any independent engine.

    Later lacks follow from verdicts on earlier ones, so that each verdict has to be stored before the next is taken.
    They are: pairs that were planned and left without a verdict; with `need_external`, scenes that no engine with
    independent physics passes, which have not been cross-validated; and engines compared on no scene, if they were
    requested by name or had several scenes to do.
    """
    solved = {name: own for name, own in progress.items() if not own.solution_failed}
    for name, own in solved.items():
        for engine in [e for e in comparison.engines if e not in own.verdicts]:
            reason = "no verdict was given: a fault of barchain"
            yield name, engine, no_verdict(name, engine, None, Outcome.FAILED, reason)
    for name, own in solved.items() if comparison.need_external else ():
        passed = [
            e for e, verdict in own.verdicts.items()
            if verdict.outcome is Outcome.PASS and comparison.engines[e].external
            and not shares_equations(comparison.engines[e], own.source)  # it is not independent of the solution then
        ]  # fmt: skip
        if not passed:
            reason = "no engine with independent physics was compared and passed on this scene"
            yield name, ANY_INDEPENDENT, no_verdict(name, ANY_INDEPENDENT, None, Outcome.NOTHING_COMPARED, reason)
    for engine in comparison.engines if comparison.named or len(solved) >= SEVERAL else ():
        verdicts = [own.verdicts[engine] for own in progress.values() if engine in own.verdicts]
        if verdicts and all(v.outcome in (Outcome.UNSUPPORTED, Outcome.TOO_COARSE) for v in verdicts):
            deciding = (row for v in verdicts for row in v.rows if row["outcome"] == v.outcome and row["reason"])
            given = dict.fromkeys(row["reason"] for row in deciding)
            reasons = "; ".join(given or dict.fromkeys(str(v.outcome) for v in verdicts))
            reason = f"compared on no scene: {reasons}"
            yield ALL_SCENES, engine, no_verdict(ALL_SCENES, engine, None, Outcome.NOTHING_COMPARED, reason)
