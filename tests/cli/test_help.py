"""Help is printed quickly, with one meaning of each option; `barchain explain` gives the meaning of words."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import defaultdict

import click
import pytest

from barchain.cli.common.meanings import MISTAKES, explain, kinds
from barchain.cli.main import cli, run
from reports.results.outcome import Outcome
from tests.support.slow import one_in

HEAVY = ("numpy", "scipy", "pandas", "pydantic", "matplotlib", "rich", "exudyn", "fsspec", "adapters", "scenarios",
         "reports")  # fmt: skip
COMMANDS = sorted(cli.commands)
OWN_MEANING = {
    "--baseline", "--columns", "--degrees", "--junit", "--list", "--part", "--out", "--engine", "--time-limit",
    "--minutes", "--repeats", "--runs", "--full", "--vary", "--rtol", "--orbits", "--seed", "--tag",
}  # fmt: skip
"""Options of which more is said where it differs"""


def test_barchain_alone_prints_help_on_one_screen_and_exits_with_0(capsys):
    assert run([]) == 0
    shown = capsys.readouterr()
    lines = shown.out.splitlines()
    assert lines[0].startswith("Usage: barchain")
    assert shown.err == ""
    assert len(lines) <= 45
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_begins_its_help_with_an_imperative_and_explains_each_option(name, capsys):
    command = cli.commands[name]
    assert run([name, "--help"]) == 0
    assert f"Usage: barchain {name}" in capsys.readouterr().out
    first = str(command.help).split()[0]
    assert first[0].isupper()
    assert not first.endswith(("s", "ing"))
    options = [p for p in command.params if isinstance(p, click.Option) and not p.hidden]
    assert all(p.help and p.help[0].isupper() and p.help.endswith(".") for p in options)


def test_an_option_means_the_same_in_every_command():
    texts = defaultdict(set)
    for command in cli.commands.values():
        for option in (p for p in command.params if isinstance(p, click.Option) and not p.hidden):
            texts[option.opts[-1]].add(str(option.help))
    several = {name for name, found in texts.items() if len(found) > 1}
    assert several <= OWN_MEANING
    assert all(t.startswith("End a run after this wall time, in seconds") for t in texts["--time-limit"])
    assert all(re.match("Give the (study|night|gate) a budget of", t) for t in texts["--minutes"])
    assert "--budget" not in texts
    assert "--scene" not in texts


@pytest.mark.parametrize("arguments", one_in(9, [["--help"], ["--version"], *([name, "--help"] for name in COMMANDS)]))
def test_help_imports_nothing_that_is_slow_to_import(arguments):
    code = (
        "import sys; from barchain.cli.main import run; run(sys.argv[1:]); "
        f"print('|'.join(m for m in {HEAVY!r} if m in sys.modules), file=sys.stderr)"
    )
    made = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    assert made.stderr.strip() == ""


def test_a_default_in_a_help_is_a_value_that_can_be_typed():
    for command in cli.commands.values():
        for option in (p for p in command.params if isinstance(p, click.Option)):
            if isinstance(option.show_default, str):
                option.type.convert(option.show_default, option, None)


@pytest.mark.parametrize(
    ("word", "kind", "said"),
    [
        ("inconsistent", "outcomes", Outcome.INCONSISTENT.advice),
        ("Exceeds bound", "outcomes", Outcome.EXCEEDS_BOUND.advice),
        ("predictability limit", "terms", "agree to"),
        ("drag.width_m", "keys", "width of each bar"),
        ("effects.drag", "keys", "density_kg_m3"),
        ("reaction-sign", "mistakes", "opposite sign"),
        ("joint_angle", "channels", "Angle of bar j+1 minus that of bar j"),
        ("com_residual", "channels", "com_residual_m"),
        ("130", "exit codes", "interrupted"),
    ],
)
def test_a_word_is_explained(word: str, kind: str, said: str) -> None:
    assert [m.kind for m in explain(word) if said in m.text] == [kind]


def test_a_word_may_have_several_meanings() -> None:
    assert {m.word for m in explain("width_m")} == {"effects.drag.width_m", "effects.solar_pressure.width_m"}
    assert "reaction-sign" in {m.word for m in explain("Your reactions have the opposite sign")}


def test_every_outcome_and_mistake_has_one_meaning() -> None:
    found = kinds()
    assert [m.word for m in found["outcomes"]] == list(Outcome)
    assert {m.word for m in found["mistakes"]} == {m.name for m in MISTAKES}
    assert all(m.text and m.page for every in found.values() for m in every)


@pytest.mark.parametrize(("given", "meant"), [("inconsistant", "inconsistent"), ("altitude_km", "altitude_m")])
def test_a_misspelt_word_leads_to_the_nearest(given: str, meant: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain", given]) == 2
    assert f"did you mean {meant}?" in capsys.readouterr().err


def test_without_a_word_the_kinds_are_listed_and_a_kind_lists_its_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["explain"]) == 0
    listed = capsys.readouterr().out
    assert all(kind in listed for kind in kinds())
    assert run(["explain", "outcomes"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(Outcome)
