"""Command lines with a wild value in the place of a plain one, and the stop before anything is run."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.main import cli

if TYPE_CHECKING:
    from collections.abc import Iterator

    import pytest

SCENE = "basics/libration"
NUMBERS = (
    "nan",
    "NaN",
    "-nan",
    "inf",
    "-inf",
    "1e308",
    "1e309",
    "-1e308",
    "-1",
    "1e-400",
    "0x10",
    "1_0_",
    "٣",
    "",
    " ",
    "1,5",
    "9" * 400,
    "9" * 5000,
    "99999999999999999999",
    "1e",
    "None",
    "true",
    "1.0.0",
    "--",
    "=1+1",
)
TEXTS = (
    "",
    " ",
    ".",
    "..",
    "../../x",
    "/",
    "/dev/null",
    "/nowhere/x.csv",
    "a\0b",
    "a\nb",
    "a\x1b[31m",
    "a\u202eb",
    "a\udcffb",
    "x" * 300,
    "x" * 5000,
    "é",
    "nan",
    "=1+1",
    "@x",
    "-",
    "--",
    "--x",
    "%s%s",
    "{0}",
    "[bold]x",
    "x/../../etc",
    "x:",
    ":",
    "C:x",
)
VARIED = tuple(
    f"{key}={family}"
    for key in ("angle_deg", "mass_kg[1]", "altitude_m", "mass_kg[*]", "speed_factor")
    for family in (
        "normal(nan, 1)",
        "normal(0, inf)",
        "normal(1, -1)",
        "normal(1e308, 1e308)",
        "uniform(2, 1)",
        "uniform(-1e308, 1e308)",
        "lognormal(1, nan)",
        "lognormal(-1, 1)",
        "lognormal(1, 1e29)",
        "triangular(1, 0, 2)",
        "normal(1)",
        "normal(1e31, 0)",
        "normal()",
        "cauchy(0, 1)",
        "normal(1e-40, 0)",
    )
)
NEEDED = {
    "simulate": ["--out", "out.csv"],
    "compare": ["--out", "out"],
    "ensemble": ["--vary", "angle_deg=normal(1, 1)"],
}
SKIPPED = {"doctor", "schema"}  # without a value of their own
RUNNERS = (
    ("barchain.studies.study", "run_and_render"),
    ("barchain.crossval.run", "run_comparison"),
    ("barchain.api", "run_jobs"),
    ("barchain.engine.new_package", "render_into"),
    ("barchain.solutions.certified_commit", "commit"),
    ("barchain.solutions.certified_commit", "check"),
    ("barchain.nightly.running.night", "run_night"),
)


class RunReachedError(Exception):
    """A command line got to its run."""


def stop_runs(patch: pytest.MonkeyPatch) -> None:
    """Replace all that runs engines by the message that it was reached."""

    def reached(*_: Any, **__: Any) -> None:
        raise RunReachedError

    for module, name in RUNNERS:
        patch.setattr(f"{module}.{name}", reached)
    patch.setenv("BARCHAIN_HISTORY", "history.sqlite")  # in the test's folder, never the user's own


def commands() -> Iterator[tuple[str, click.Command]]:
    """Names and commands, those of groups in the group's place."""
    for name, command in cli.commands.items():
        if isinstance(command, click.Group):
            yield from ((f"{name} {inner}", one) for inner, one in command.commands.items())
        else:
            yield name, command


def plain_line(name: str) -> list[str]:
    """Command line of a command whose values are all plain, without its scenes."""
    return [*name.split(), *NEEDED.get(name, [])]


def values(param: click.Parameter) -> tuple[str, ...]:
    """Wild values of an option or an argument."""
    if param.name == "vary":
        return VARIED
    numeric = isinstance(param.type, click.types.FloatParamType | click.types.IntParamType)
    wild = NUMBERS if numeric else TEXTS
    return tuple(f"rtol={v}" for v in NUMBERS) + TEXTS if param.name == "settings" else wild


def wild_lines() -> Iterator[list[str]]:
    """Every option and argument of every command, with each of its wild values."""
    for name, command in commands():
        if name in SKIPPED:
            continue
        takes_scene = any(
            isinstance(p, click.Argument) and p.name in {"scene", "scenes", "files"} for p in command.params
        )
        scene = [SCENE] if takes_scene else ["trial"] if name == "new-engine" else []
        for param in command.params:
            if isinstance(param, click.Argument):
                yield from ([*plain_line(name), "--", value] for value in values(param))
            elif not getattr(param, "is_flag", False):
                option = param.opts[0]
                yield from ([*plain_line(name), *scene, f"{option}={value}"] for value in values(param))


def sample(count: int) -> list[list[str]]:
    """Some of the lines, the same in each session."""
    return random.Random(7).sample(list(wild_lines()), count)
