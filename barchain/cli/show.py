"""Commands `show` and `report`: the rows of a result folder, what differs between two, and its pages again."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.result_folder import need_writable
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    import pandas as pd

FORM = "COLUMN=VALUE,..."
RESULT = ("value", "low", "high", "unit", "limit", "outcome", "reason", "text", "until_s")
"""Columns that are no part of a row's identity"""
COMPARED = ("outcome", "value", "text", "limit")
"""Columns that make a difference; the first that differs names it"""
SHOWN = ("value", "low", "high", "limit", "outcome", "reason", "text", "was", "now", "ratio")
ORDER = ("outcome", "text", "value", "limit")
"""Changes, the gravest first; of values those that changed most"""
RUN = ("study", "scene", "engine", "setting")
"""Columns by which rows that only one folder has are counted"""
TIMES = "seconds"  # metric of wall times, which differ between any two runs
DIGITS = 4
NARROW = 60  # characters of a cell; --csv has all of it
MOST_SHOWN = 50  # differences


@click.command()
@click.argument("folder", metavar="DIR", required=False, type=NamedPath(path_type=Path))
@click.argument("other", metavar="[OTHER]", required=False, type=NamedPath(path_type=Path))
@click.option("--where", "conditions", metavar=FORM, multiple=True,
              help="Show rows with these values, e.g. engine=exudyn,quantity=reaction; may be repeated.")  # fmt: skip
@click.option("--csv", "file", metavar="FILE", type=NamedPath(path_type=Path, dir_okay=False),
              help="Write the rows with all columns into this file instead.")  # fmt: skip
@click.option("--judge", "judged", is_flag=True,
              help="Judge what differs in OTHER as nights do, and exit with 1 if a figure is worse.")  # fmt: skip
def show(folder: Path | None, other: Path | None, conditions: tuple[str, ...], file: Path | None, judged: bool) -> None:
    """Print what the studies in DIR measured or judged.

    Columns in which all rows agree are left out. With OTHER, print what differs: outcomes, rows that are new or gone,
    and values with the ratio of that in OTHER to that in DIR. Wall times differ always and are counted only; a
    condition on the metric shows them.
    """
    if folder is None:
        raise click.UsageError(f"show prints the rows of a result folder: give its name{folders_here()}")
    if judged:
        if other is None or conditions or file is not None:
            raise click.UsageError("--judge goes with DIR and OTHER alone")
        show_judgement(folder, other)
        return
    if file is not None:
        need_writable(file, "--csv")
    frames = chosen([folder] if other is None else [folder, other], conditions)
    found = frames[0] if other is None else differing(*frames)
    if file is not None:
        found.to_csv(file, index=False)
        say(f"wrote {len(found)} rows: {file}")
    elif other is not None:
        show_differences(found, timed=any("metric=" in given for given in conditions))
    elif len(found):
        show_table(found)
    else:
        say("no rows")


def folders_here() -> str:
    """Result folders in the current folder, as the end of a sentence."""
    from reports.results.rows import FOLDER

    here = sorted(path.name for path in Path().iterdir() if (path / FOLDER).is_dir())
    return f", e.g. {', '.join(here[:3])}" if here else "; compare and the studies write one, see their --out"


def chosen(folders: list[Path], conditions: tuple[str, ...]) -> list[pd.DataFrame]:
    """Rows of each folder that fulfil all conditions, with a column for each tag."""
    import pandas as pd

    from barchain.api import rows
    from reports.results.rows import spread
    from scenarios import nearest

    found = spread(pd.concat([rows(folder) for folder in folders], keys=range(len(folders))))
    for condition in (part for given in conditions for part in given.split(",")):
        column, equals, value = (text.strip() for text in condition.partition("="))
        if not equals or column not in found:
            advice = nearest(column, map(str, found)) if equals else ""
            allowed = f"{FORM}, with a column of these rows: {', '.join(map(str, found))}"
            raise click.UsageError(f"--where {condition}{advice}: allowed: {allowed}")
        found = found[agrees(found[column], column, value)]
    return [found[found.index.get_level_values(0) == k].reset_index(drop=True) for k in range(len(folders))]


def agrees(column: pd.Series[Any], name: str, value: str) -> pd.Series[bool]:
    """Rows whose column has a value; of numbers by their size, so that 1e-6 is 0.000001."""
    import pandas as pd

    from scenarios import nearest

    if pd.api.types.is_numeric_dtype(column):
        try:
            return column == float(value)
        except ValueError:
            raise click.UsageError(f"--where {name}={value}: allowed: a number, as {name} is one") from None
    same = column == value
    if not same.any() and len(column):
        raise click.UsageError(f"--where {name}={value}: no row has this {name}{nearest(value, set(map(str, column)))}")
    return same


def differing(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """Rows that two folders do not share, with ``change``, both values, both outcomes, and the ratio of the values."""
    keys = list(dict.fromkeys(c for frame in (before, after) for c in frame if c not in RESULT))
    both = before.reindex(columns=[*keys, *RESULT]).merge(
        after.reindex(columns=[*keys, *RESULT]), on=keys, how="outer", suffixes=("", "_other"), indicator="change"
    )
    said = both["change"].map({"left_only": "gone", "right_only": "new", "both": ""}).astype(str)
    for name in COMPARED:
        was, now = both[name], both[f"{name}_other"]
        said = said.mask((said == "") & (was != now) & ~(was.isna() & now.isna()), name)
    both["change"], both["ratio"] = said, both["value_other"] / both["value"]
    both["unit"] = both["unit"].fillna(both["unit_other"])
    columns = ["change", *keys, "ratio", "unit", *(name + end for name in COMPARED for end in ("", "_other"))]
    return both.loc[said != "", columns]


def show_differences(found: pd.DataFrame, *, timed: bool) -> None:
    """Print the gravest differences, each with what was and what is; wall times as their number where not asked for."""
    from reports.results.rows import records

    times = found["metric"].eq(TIMES) & found["change"].eq("value") & (not timed)
    apart = found["change"].isin(("gone", "new"))
    if times.any():
        middle = found["ratio"][times].median()
        say(f"{times.sum()} wall times differ, by {middle:.3g} in the median: --where metric={TIMES} shows them")
    whole = Counter(map(tuple, found.loc[apart, ["change", *RUN]].to_numpy().tolist()))
    for (change, *run), count in list(whole.items())[:MOST_SHOWN]:
        say(f"{change}: {', '.join(filter(None, run))} ({count} rows)")
    rows = found[~times & ~apart]
    if not len(rows):
        say("no other difference" if len(found) else "no difference")
        return
    size = (rows["ratio"] - 1.0).abs().where(rows["change"] == "value")
    order = rows["change"].map(ORDER.index)
    rows = rows.assign(order=order, size=-size).sort_values(["order", "size"], kind="stable", na_position="first")
    shown = rows.head(MOST_SHOWN)
    pairs = [[side(row, which) for which in ("", "_other")] for row in records(shown)]
    left = [name for name in map(str, shown) if name.removesuffix("_other") not in (*RESULT, "ratio", "order", "size")]
    table = shown[left].assign(
        was=[was for was, _ in pairs],
        now=[now for _, now in pairs],
        ratio=shown["ratio"].where(shown["change"] == "value"),
    )
    show_table(table)
    if len(rows) > MOST_SHOWN:
        say(f"and {len(rows) - MOST_SHOWN} more: --csv FILE writes all")


def side(row: dict[str, Any], which: str) -> str:
    """What differs on one side of a difference: a number with its unit, an outcome or a text."""
    found = cell(row[f"{row['change']}{which}"])
    return f"{found} {row['unit']}".removesuffix(" 1") if row["change"] in {"value", "limit"} and found else found


def show_table(found: pd.DataFrame) -> None:
    """Print rows: columns that differ, the unit beside each value, and what all rows share above."""
    import pandas as pd

    cells = pd.DataFrame({name: [cell(value) for value in found[name]] for name in found if name != "unit"})
    if "value" in cells:
        units = found["unit"].fillna("").replace("1", "").to_list()
        cells["value"] = [f"{v} {u}".strip() if v else "" for v, u in zip(cells["value"], units, strict=True)]
    same = {name: cells[name].iloc[0] for name in cells if name != "change" and cells[name].nunique() == 1}
    if len(found) > 1:
        shared = ", ".join(f"{name} {value}" for name, value in same.items() if value and name not in SHOWN)
        say(f"{len(found)} rows{f' of {shared}' if shared else ''}")
        cells = cells[[name for name in cells if name not in same or (name in SHOWN and same[name])]]
    else:
        cells = cells[[name for name in cells if cells[name].iloc[0]]]
    right = [str(name) for name in cells if pd.api.types.is_numeric_dtype(found[name])]
    show_rows(list(map(str, cells)), cells.to_numpy().tolist(), right=right)


def show_judgement(before: Path, after: Path) -> None:
    """Print what changed between two folders by the rules of nights; exits with 1 if a figure is worse."""
    from barchain.nightly.figures.changes import results_words
    from barchain.nightly.figures.results import read_night
    from barchain.nightly.history.judging import judge_pair

    earlier, later = read_night(before), read_night(after)
    judged = judge_pair(earlier, later)
    said = f"{judged.same} differ within rounding; {judged.left_out} of {before} are not in {after}"
    say(f"{len(judged.tonight)} changes among {judged.judged} figures; {said}")
    for words in judged.renamed:
        say(f"  {words}")
    for change in judged.tonight:
        was, now = results_words(change)
        said = f"was {was}, is {now}: {change.reason}"
        say(f"  {change.direction}  {change.identity.name}: {said}")
    if judged.worse:
        raise findings()


def cell(value: object) -> str:
    """Text of a cell, a number to four digits."""
    if isinstance(value, float):
        return "" if value != value else f"{value:.{DIGITS}g}"  # noqa: PLR0124  # NaN
    text = "" if value is None else str(value)
    return text if len(text) <= NARROW else f"{text[: NARROW - 3]}..."


@click.command(short_help="Render a result folder again from its tables.")
@click.argument("folder", metavar="DIR", type=NamedPath(path_type=Path))
def report(folder: Path) -> None:
    """Render the pages of DIR again from its stored tables."""
    from barchain.api import render

    pages = render(folder)
    say(f"wrote {', '.join(map(str, pages))}")
