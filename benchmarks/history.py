"""Measure ratios of engines' times at equal error, in one run, and append them to a history."""

from __future__ import annotations

import datetime
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from barchain.record.environment import processor
from barchain.studies.cost.study import CostOptions, CostStudy
from barchain.studies.study import Reporter, run_study
from reports.tables.cost import BASELINE, read_cost

if TYPE_CHECKING:
    import pandas as pd

HISTORY = Path(__file__).with_name("history.csv")
SCENES = ("paper/fig05", "paper/fig09")
ENGINES = ("reference", BASELINE, "exudyn", "exudyn-tree", "pymunk", "heyoka")
KEPT = ["scene", "target", "engine", "status", "over_baseline", "over_baseline_low", "over_baseline_high"]


def commit() -> str:
    """Commit that is measured, marked if the tree differs from it; empty outside a repository."""
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty"],
        cwd=HISTORY.parent, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return told.stdout.strip()


def rows(folder: Path) -> pd.DataFrame:
    """Ratios of a study, and evaluations beside them."""
    reach = read_cost(folder).reach.query("quantity == 'attitude'")
    keys = ["scene", "target", "engine"]
    timed = reach[reach.measure == "seconds"][KEPT]
    counted = reach[reach.measure == "evaluations"][[*keys, "cost"]].rename(columns={"cost": "evaluations"})
    return timed.merge(counted.round(1), on=keys, how="left")


@click.command()
@click.option("--scene", "scenes", multiple=True, default=SCENES, show_default=True, help="Scene; may be repeated.")
@click.option("--engine", "engines", multiple=True, default=ENGINES, show_default=True, help="Engine; may be repeated.")
@click.option("--minutes", default=3.0, show_default=True, help="Time to be kept to.")
@click.option("--out", type=click.Path(path_type=Path), default=HISTORY, help="History to append to.")
def main(scenes: tuple[str, ...], engines: tuple[str, ...], minutes: float, out: Path) -> None:
    """Append one run's ratios to the history."""
    with tempfile.TemporaryDirectory() as folder:
        study = CostStudy()
        plan = study.plan(CostOptions(scenes, engines, minutes=minutes, time_limit_s=1.0))
        run_study(study, plan, Path(folder), reporter=Reporter(lambda *what: click.echo("  ".join(what), err=True)))
        found = rows(Path(folder))
    found.insert(0, "when", datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"))
    found.insert(1, "commit", commit())
    found.insert(2, "cpu", processor())
    found.to_csv(out, mode="a", header=not out.exists(), index=False)
    click.echo(f"{len(found)} rows appended to {out}")


if __name__ == "__main__":  # engines run in worker processes, which import this script
    main()
