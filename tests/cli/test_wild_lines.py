"""Values that are no numbers, empty paths and hidden characters on the command line: one line and exit code 2."""

from __future__ import annotations

import math

import click
import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.numbers import RealNumber
from barchain.cli.main import cli, run

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
