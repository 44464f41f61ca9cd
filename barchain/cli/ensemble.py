"""`barchain ensemble`: many perturbed copies of a scene."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.record.command import typed


@click.command()
@click.argument("scene", metavar="SCENE")
@click.option("--vary", multiple=True, required=True, metavar="KEY=DISTRIBUTION(...)",
              help="What varies, e.g. 'angle_deg=normal(80, 1)' (all bars alike), 'mass_kg[2]=lognormal(100, 0.1)' "
                   "(bar 2), 'rate_factor[*]=uniform(0.9, 1.1)' (each bar by itself). May be repeated.")  # fmt: skip
@click.option("--runs", type=click.IntRange(min=1), default=1000, show_default=True, help="Number of copies.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("ensemble"), show_default=True,
              help="Folder for tables and page.")  # fmt: skip
@click.option(
    "--orbits", type=click.FloatRange(min=0, min_open=True), help="How much of the scene is run; all by default."
)
@click.option("--samples", type=click.IntRange(min=2), default=101, show_default=True, help="Instants seen.")
@click.option("--rtol", type=click.FloatRange(1e-15, 1.0), default=1e-8, show_default=True, help="Accuracy of a step.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Equal seeds draw equal copies.")
@click.option("--workers", type=click.IntRange(min=1), help="Threads; all cores by default.")
@click.option("--dask", metavar="ADDRESS", help="Dask scheduler that gets the runs, e.g. tcp://10.0.0.1:8786.")
def ensemble(
    scene: str, vary: tuple[str, ...], runs: int, out: Path, orbits: float | None, samples: int, rtol: float,
    seed: int, workers: int | None, dask: str | None,
) -> None:  # fmt: skip
    """Run many perturbed copies of SCENE, compiled and on all cores: quantiles of attitude and reactions over time."""
    from adapters.registry import find_engine  # noqa: PLC0415

    missing = find_engine("reference-fast").missing
    if missing:
        raise click.ClickException(missing)
    from barchain.cli.progress import counted  # noqa: PLC0415
    from barchain.studies.ensemble.plan import EnsembleOptions  # noqa: PLC0415
    from barchain.studies.ensemble.study import EnsembleStudy  # noqa: PLC0415  # compiled code that no other command needs
    from barchain.studies.ensemble.tasks import ClusterError  # noqa: PLC0415
    from barchain.studies.ensemble.variation import VariationError  # noqa: PLC0415
    from barchain.studies.study import Reporter, run_study  # noqa: PLC0415
    from reports.render import render_study  # noqa: PLC0415

    study = EnsembleStudy()
    try:
        plan = study.plan(EnsembleOptions(scene, vary, runs, seed, rtol, orbits, samples, workers=workers, dask=dask))
        result = run_study(study, plan, out, command=typed(), reporter=Reporter(counted=counted))
    except (VariationError, ClusterError) as error:
        raise click.UsageError(str(error)) from error
    page = render_study("ensemble", out).page
    counts = ", ".join(f"{n} {word}" for word, n in result.runs["outcome"].value_counts().items())
    click.echo(f"{runs} runs in {result.seconds['run']:.2f} s: {counts}")
    click.echo(f"ensemble: {page}")
