"""One comparison from its plan to its result: :func:`barchain.compare` and the command line run it."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import pandas as pd

from adapters.registry import ALL
from adapters.registry import engines as registered_engines
from barchain.judge.tolerances import TOLERANCES
from barchain.record.scene_description import scene_facts
from barchain.runs.choices import choose_setting, chosen_engines, engine_facts, unique_names
from barchain.runs.environment import kept_or_temporary
from barchain.runs.estimate import TOLD_S, estimated_run_s, need_runnable, work_words
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S
from barchain.studies.comparison.external_coverage import external_coverage
from barchain.studies.comparison.plan import ComparisonPlan
from barchain.studies.comparison.suite import Suite
from barchain.studies.study import ignore, run_and_render
from reference_impl.kernel.build import why_missing
from reference_impl.paper.misprint_effects import misprint_effects
from reports.results.comparison import ALL_SCENES, FILES, is_engine
from reports.results.outcome import Outcome
from scenarios import Scene, load_scene
from scenarios.hooks import html
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from adapters.registry import Registration
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles

LIMITATIONS = (
    "The motion is planar. The central body's field is spherical unless a scene has its oblateness (J2).",
    "Effects are as docs/effects defines them: a cylindrical shadow that darkens the whole chain at once, an "
    "exponential atmosphere without shading of one bar by another, third bodies on fixed circles.",
    "The paper's gravity gradient has a torque without its counterpart in the force. No method then conserves "
    "energy and angular momentum to O((l/r)²), and they are not judged.",
    "Error estimates come from double precision. On chaotic scenes they end at the predictability limit. Beyond it "
    "a run is compared with the reference restarted from the run's own states.",
    "A scene's facts name the solution that judges it. Where that is a reference solution, the rows of the "
    "reference's forms show convergence, not independence; where it is a certified solution, those of heyoka do.",
    "Index 3 starts with multipliers off by first order in the step and damps that error in some 50 steps. The "
    "tolerance of its first reactions includes that error.",
    "Joint gaps and the distance of the bars' weighted centre from the centre of mass are computed from the places "
    "and angles that an engine gives of its bars, and the engine's reported values must agree. Where an engine "
    "gives no places of its own, they are as reported: joints that do not hold then show in the attitude.",
    "An engine that follows only the centre of mass is judged on the track alone.",
    "Wall times are from worker processes running side by side: they tell orders of magnitude, not rankings.",
)
"""Limitations of the comparison, one sentence or two each"""


@dataclass(frozen=True)
class ComparisonResult:
    """Result of a comparison of engines with the judging solution.

    Attributes
    ----------
    metrics : DataFrame
        One value a row. Columns:

        - ``scene``, ``engine``, ``setting``: names of the run; in parentheses for several engines or scenes together;
        - ``quantity``: ``attitude``, ``rate``, ``reaction``, ``com``, ``com_velocity``, ``gap``, ``com_residual``,
          ``torque``, ``impulse``, ``energy``, ``angular_momentum``, their balances ``energy_about_com`` and
          ``angular_momentum_about_com``, ``relative_energy``, or ``run`` for the
          whole run;
        - ``metric``: ``max``, ``rms``, ``final`` and ``first_orbit_max`` of the difference from the judging solution;
          ``drift``; ``normalised_error``, ``bound_ratio``, ``detection_limit``, and further ones;
        - ``value``, ``unit``: number and SI unit; ``1`` for a ratio;
        - ``tolerance``: largest value that passes; NaN where none is judged;
        - ``outcome``, ``reason``: an :class:`~reports.results.outcome.Outcome` in words, and the reason of a failure;
        - ``limit_s``: end of the pointwise comparison, the predictability limit, s.
    outcomes : dict of tuple of str to Outcome
        Outcome by (scene, engine); a name in parentheses stands for several engines or scenes, see
        :mod:`reports.results.comparison`.
    report : Path or None
        Page, if it was rendered.
    """

    metrics: pd.DataFrame
    outcomes: dict[tuple[str, str], Outcome]
    report: Path | None = None

    @property
    def passed(self) -> bool:
        """Whether every comparison passed or was declared unsupported, and at least one passed.

        An engine that was named, or had several scenes to do, must have been compared on at least one scene.
        """
        found = self.outcomes.values()
        return all(o.ok for o in found) and Outcome.PASS in found

    def to_frame(self) -> pd.DataFrame:
        """Table of outcomes: a row for each scene, a column for each engine; empty cells were not compared."""
        pairs = {pair: str(outcome) for pair, outcome in self.outcomes.items() if is_engine(pair[1])}
        scenes, engines = (list(dict.fromkeys(pair[k] for pair in pairs if pair[0] != ALL_SCENES)) for k in (0, 1))
        cells = [[pairs.get((scene, engine), "") for engine in engines] for scene in scenes]
        return pd.DataFrame(cells, pd.Index(scenes, name="scene"), pd.Index(engines, name="engine"))

    def __repr__(self) -> str:
        """Size, verdict and number of each outcome in one line; :meth:`to_frame` has the table."""
        table = self.to_frame()
        size = ", ".join(map(plural, table.shape, ("scene", "engine")))
        counts = Counter(cell for cell in table.to_numpy().flat if cell)
        found = ", ".join(f"{n} {word}" for word, n in counts.most_common()) or "nothing compared"
        return f"<ComparisonResult of {size}: {'passed' if self.passed else 'not passed'}; {found}>"

    def _repr_html_(self) -> str | None:
        """Verdict, picture and matrix for a notebook; None before any public name of barchain is used."""
        external = {name: registration.external for name, registration in registered_engines().items()}
        return html("comparison", self.metrics, external, self.report)


@dataclass(frozen=True)
class Comparison(ComparisonPlan):
    """The study that :func:`run_comparison` runs."""

    files: ClassVar[StudyFiles] = FILES

    def record(self) -> dict[str, Any]:
        """Engines, scenes, and the methodology; runs are added as they come."""
        return {
            "engines": {name: engine_facts(r) for name, r in self.engines.items()},
            "scenes": {
                scene.name: scene_facts(scene) | {"external_coverage": external_coverage(scene, self.engines)}
                for scene in self.scenes
            },
            "runs": [],
            "misprints": [asdict(row) for row in misprint_effects()],  # on a generic state, just now
            "tolerances": tolerance_rows(),
            "limitations": list(LIMITATIONS),
        }

    def run(self, store: StudyStore, reporter: Reporter) -> ComparisonResult:
        """Make all runs and judge them."""
        for scene in (s for s in self.scenes if estimated_run_s(s) > TOLD_S):
            reporter.note(f"{scene.name}: {work_words(scene)}")
        if reason := why_missing():
            reporter.note(f"{reason}; NumPy serves")
        suite = Suite(self, store, reporter)
        verdicts = suite.run()
        return ComparisonResult(suite.store.read("metrics"), {pair: v.outcome for pair, v in verdicts.items()})


def run_comparison(
    scenes: Iterable[Scene | str | Path],
    engine_names: Iterable[str] | None = None,
    out: Path | str | None = None,
    *,
    time_limit_s: float = TIME_LIMIT_S,
    executor: Executor = ALL_CORES,
    settings: Mapping[str, Mapping[str, float]] | None = None,
    need_external: bool = False,
    certify: bool = False,
    registered: Mapping[str, Registration] | None = None,
    render: Callable[[Path], Path | None] = ignore,
    **how: Any,
) -> ComparisonResult:
    """Run a comparison; :func:`barchain.compare` describes what all callers may choose.

    Parameters
    ----------
    executor : Executor
        Place of the runs; all cores of this machine by default.
    need_external : bool
        Count a scene that no engine with independent physics passes as a failure.
    registered : mapping, optional
        Engines by name, instead of the registry's.
    render : callable, optional
        Writes the report of a result folder, and returns its page; the record says finished only afterwards.
    **how
        Arguments of :func:`barchain.studies.study.run_and_render`.
    """
    names = None if engine_names is None else list(engine_names)
    loaded = [s if isinstance(s, Scene) else load_scene(s) for s in scenes]
    need_runnable(loaded, time_limit_s)
    comparison = Comparison(
        unique_names(loaded),
        dict(registered) if registered is not None else chosen_engines(names),
        time_limit_s,
        executor,
        {name: choose_setting(name, values, registered) for name, values in (settings or {}).items()},
        need_external,
        named=names is not None and ALL not in names,
        certify=certify,
    )
    executor.check()
    with kept_or_temporary(None if out is None else Path(out)) as folder:
        result, page = run_and_render(comparison, folder, render, **how)
    return replace(result, report=page)


def tolerance_rows() -> list[dict[str, str]]:
    """Every tolerance with its derivation, for the report."""
    return [{"quantity": t.quantity, "what": t.name, "value": t.value, "derivation": t.derivation} for t in TOLERANCES]
