"""Bad usage of any command, values that are no numbers and hidden characters: one readable line, and nothing run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click
import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.numbers import RealNumber
from barchain.cli.main import cli, run

if TYPE_CHECKING:
    from pathlib import Path

QUICK = "basics/libration"


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("nonsense", ["nonsense"]),
        ("scenes --tag papr", ["--tag papr", "did you mean paper?"]),
        (f"scenes --tag paper show {QUICK}", ["--tag goes with the list of scenes"]),
        (f"scenes --json show {QUICK}", ["--json goes with the list of scenes"]),
        (f"simulate {QUICK}", ["--out"]),
        ("simulate paper/fig5 --out x.csv", ["no such scene", "did you mean paper/fig05?"]),
        (f"simulate {QUICK} --engine exudin --out x.csv", ["no such engine", "did you mean exudyn?"]),
        (f"simulate {QUICK} --columns joint_angel --out x.csv", ["no such channel", "did you mean joint_angle?"]),
        (f"judge run.csv {QUICK}", [f"{QUICK} is a scene, which comes first: barchain judge {QUICK} run.csv"]),
        (f"simulate {QUICK} --out x.xlsx", ["'.xlsx' given", ".parquet, .csv"]),
        (f"simulate {QUICK} --out nowhere/x.csv", ["no folder nowhere"]),
        (f"simulate {QUICK} --set rtol --out x.csv", ["no value", "[ENGINE:]KEY=VALUE"]),
        (f"simulate {QUICK} --set rtl=1e-9 --out x.csv", ["no setting rtl", "did you mean rtol?"]),
        (f"simulate {QUICK} --set rtol=-1 --out x.csv", ["rtol=-1 given", "allowed"]),
        ("simulate paper/fig17 --engine pymunk --out x.csv", ["pymunk does not support paper/fig17"]),
        ("compare --out x", ["SCENE"]),
        (f"compare {QUICK} --out x --set rtl=1", ["no engine has rtl", "did you mean rtol?"]),
        (f"compare {QUICK} --out x --set exudin:rtol=1", ["--set", "did you mean exudyn?"]),
        (f"compare {QUICK} --engine reference --out x --set rebound:rtol=1", ["rebound does not take part"]),
        (f"compare {QUICK} --engine reference --out x --set rtol=2", ["rtol=2 given", "allowed"]),
        (f"compare {QUICK} --out x --resume --overwrite", ["--resume and --overwrite exclude each other"]),
        ("report nowhere", ["nowhere: no such folder"]),
        ("cost paper/fig5", ["did you mean paper/fig05?"]),
        ("cost --engine exudin", ["did you mean exudyn?"]),
        ("scaling --engine exudin", ["did you mean exudyn?"]),
        ("scaling --bars 1", ["bars"]),
        ("roundoff --part evaluations", ["evaluations", "evaluation"]),
        ("effects", ["SCENE"]),
        ("effects paper/fig13 --rtol 1", ["--rtol"]),
        ("effects paper/fig13 --engine exudyn", ["--engine"]),
        ("stability hard/whi", ["did you mean"]),
        ("stability hard/whip --engine exudin", ["did you mean exudyn"]),
        ("selftest --fault scale-rat", ["did you mean scale-rate"]),
        ("selftest selftest/fal", ["did you mean selftest/fall"]),
        ("selftest --engine refrence", ["did you mean reference"]),
        ("selftest --engine reference-fast --workers 0", ["--workers"]),
        ("certified --check paper/fig5", ["paper/fig5", "did you mean paper/fig05?"]),
        ("certified paper/fig05", ["--out DIR or --check"]),
        ("scenes --folder papr", ["--folder papr", "did you mean paper?"]),
        ("scenes --effect drg", ["--effect drg", "did you mean drag?"]),
        ("scenes paper/fig05", ["barchain scenes show SCENE"]),
    ],
)
def test_bad_usage_gives_one_readable_line_and_exit_code_2(
    typed: str, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(typed.split()) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    assert all(word in error for word in words), error
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


NAN = {
    "--time-limit": ["cost", "compare basics/libration --out x"], "--orbits": ["cost", "ensemble basics/libration"],
    "--rtol": ["effects basics/libration"], "--matters": ["effects basics/libration"], "--minutes": ["scaling"],
    "--repeats": ["cost"],
}  # fmt: skip


@pytest.mark.parametrize("value", ["nan", "-inf", "1e309"])
@pytest.mark.parametrize(("option", "line"), [(option, line) for option, lines in NAN.items() for line in lines])
def test_nan_and_infinity_are_no_number_for_any_option(option, line, value, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run([*line.split(), f"{option}={value}"]) == ExitCode.BAD_INPUT
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert option in error
    assert value in error


@pytest.mark.parametrize(
    ("line", "option"),
    [
        (["ensemble", "basics/libration", "--vary", "angle_deg=normal(1, 1)", "--dask", ""], "--dask"),
        (["compare", "basics/libration", "--out", ""], "--out"),
        (["cost", "--out", " "], "--out"),
        (["simulate", "basics/libration", "--out", ""], "--out"),
    ],
)
def test_an_empty_path_or_address_is_an_error(line, option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(line) == ExitCode.BAD_INPUT
    assert f"'{option}': no text given" in capsys.readouterr().err


@pytest.mark.parametrize("given", ["a\nb", "a\x1b[2J", "a\u202eb", "a\udcffb", "a\0b"])
def test_an_argument_with_a_hidden_character_is_shown_as_its_code(given, capsys):
    assert run(["validate", given]) == ExitCode.BAD_INPUT
    error = capsys.readouterr().err
    assert error.startswith("barchain: argument 2: a\\")
    assert error.count("\n") == 1


def options_of(command: click.Command) -> list[click.Parameter]:
    """Options and arguments of a command and its subcommands."""
    inner = command.commands.values() if isinstance(command, click.Group) else ()
    return [*command.params, *(option for c in inner for option in options_of(c))]


def test_every_number_on_the_command_line_has_finite_bounds():
    numeric = (click.IntRange, click.FloatRange, click.types.IntParamType, click.types.FloatParamType)
    found = [p for p in options_of(cli) if isinstance(p.type, numeric) and not getattr(p, "is_flag", False)]
    assert len(found) >= 20
    for option in found:
        assert isinstance(option.type, (click.IntRange, RealNumber)), option.opts
        assert option.type.min is not None, option.opts
        assert option.type.max is not None, option.opts
        assert math.isfinite(option.type.min), option.opts
        assert math.isfinite(option.type.max), option.opts
