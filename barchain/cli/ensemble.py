"""`barchain ensemble`: many perturbed copies of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import end_study
from barchain.cli.common.numbers import MOST_RUNS, MOST_SAMPLES, ORBITS, SEED, RealNumber
from barchain.cli.common.options import (
    OWN_PAGE,
    executor_options,
    out_option,
    overwrite_option,
    resume_option,
    scene_argument,
)
from barchain.cli.common.result_folder import run_study_in
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.runs.executors import Executor

ENGINE = "reference-fast"


@click.command(short_help="Run perturbed copies of a scene, and take quantiles.")
@scene_argument
@click.option("--vary", multiple=True, required=True, metavar="KEY=DISTRIBUTION(...)",
              help="Draw a value of the scene, e.g. 'angle_deg=normal(80, 1)' (all bars alike), "
                   "'mass_kg[2]=lognormal(100, 0.1)' (bar 2), 'rate_factor[*]=uniform(0.9, 1.1)' (each bar by itself). "
                   "May be repeated.")  # fmt: skip
@click.option("--runs", metavar="N", type=click.IntRange(1, MOST_RUNS), default=1000, show_default=True,
              help="Run N perturbed copies.")  # fmt: skip
@out_option(help_text=OWN_PAGE)
@click.option("--orbits", metavar="N", type=ORBITS, help="Run N orbits; default: the scene's whole run.")
@click.option("--samples", metavar="N", type=click.IntRange(2, MOST_SAMPLES), default=101, show_default=True,
              help="Take quantiles at N instants.")  # fmt: skip
@click.option("--rtol", metavar="R", type=RealNumber(1e-15, 1.0), default=1e-8, show_default=True,
              help="Request this relative accuracy of a step.")  # fmt: skip
@click.option("--seed", metavar="N", type=SEED, default=1, show_default=True,
              help="Draw with this seed; equal seeds draw equal copies.")  # fmt: skip
@executor_options
@resume_option
@overwrite_option
def ensemble(
    scene: str, vary: tuple[str, ...], runs: int, out: Path, orbits: float | None, samples: int, rtol: float,
    seed: int, executor: Executor, resume: bool, overwrite: bool,
) -> None:  # fmt: skip
    """Run many perturbed copies of SCENE, and take quantiles of attitude and reactions over time.

    SCENE is a name or a file. Runs are compiled: the engine reference-fast is needed. Exits with 1 if a run fails,
    or if a Dask cluster fails while runs are on it; --resume goes on from the runs that were done.
    """
    from barchain.cli.common.names import need_loaded  # noqa: PLC0415

    need_loaded(ENGINE)
    from barchain.cli.common.progress import counted  # noqa: PLC0415
    from barchain.studies.ensemble.study import EnsembleOptions, EnsembleStudy  # noqa: PLC0415  # compiled code
    from barchain.studies.ensemble.variation import VariationError  # noqa: PLC0415
    from barchain.studies.study import Reporter  # noqa: PLC0415

    study = EnsembleStudy()
    try:
        options = EnsembleOptions(scene, vary, runs, seed, rtol, orbits, samples, executor=executor)
        plan = study.plan(options)
        result, rendered = run_study_in(out, study, plan, Reporter(counted=counted), resume=resume, overwrite=overwrite)
    except VariationError as error:
        raise click.UsageError(str(error)) from error
    counts = ", ".join(f"{n} {word}" for word, n in result.tally.outcomes.most_common())
    say(f"{runs} runs in {result.seconds['run']:.2f} s: {counts}")
    say(f"ensemble: {rendered.page}")
    end_study(result, result.failures)
