"""Wild values on the command line: one line and exit code 2, or a run that begins; no traceback, no stray file."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import click
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.numbers import RealNumber
from barchain.cli.main import cli, run
from barchain.record.folder_lock import LOCK
from tests.cli.wild_lines import NUMBERS, TEXTS, RunReachedError, sample, stop_runs, wild_lines
from tests.support.slow import one_in

if TYPE_CHECKING:
    from pathlib import Path

ENDS = {ExitCode.OK, ExitCode.BAD_INPUT, ExitCode.MISSING_ENGINE}
SECONDS = 20.0


def end_of(line: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """What is wrong with the end of a command line; empty if nothing is."""
    begun, most = time.monotonic(), len(line) if line[0] == "validate" else 1  # a line for each file
    try:
        code = run(line)
    except RunReachedError:
        code = ExitCode.OK
    except BaseException as error:  # a traceback of any kind
        return f"{line!r:.200}: {type(error).__name__}: {error}"
    told = capsys.readouterr()
    if line[0] == "conform" and code == ExitCode.FINDINGS and "✗" in told.out:
        return ""  # a checklist that names the fault of a class which can't be loaded
    wrong = [
        (code not in ENDS, f"exit code {code}"),
        (code != ExitCode.OK and not told.err.strip(), "no line"),
        (code == ExitCode.BAD_INPUT and not 1 <= faults_told(told.err) <= most, "more than one line"),
        ("Traceback" in told.err, "traceback"),
        (any(c in told.err + told.out for c in "\x1b\u202e\0\udcff"), "hidden character"),
        (time.monotonic() - begun > SECONDS, "slow"),
    ]
    found = [words for is_so, words in wrong if is_so]
    return f"{line!r:.200}: {', '.join(found)}: {told.err:.300}" if found else ""


def faults_told(text: str) -> int:
    """Number of lines; those on the keys of one scene file, each with its own fault, are one."""
    lines = text.splitlines()
    return len({line.partition("/dev/null: ")[0] if "/dev/null: " in line else line for line in lines})


def check_lines(
    lines: list[list[str]], folder: Path, patch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    work = folder / "a" / "b"
    work.mkdir(parents=True)
    patch.chdir(work)
    stop_runs(patch)
    ends = [end_of(line, capsys) for line in lines]
    assert not any(ends), "\n".join(filter(None, ends))
    left = {path for path in folder.rglob("*") if path not in {work, work.parent} and path.name != LOCK}
    histories = {path for path in left if is_history(path)}
    assert left - histories - {parent for path in histories for parent in path.parents} == set()


def is_history(path: Path) -> bool:
    """Whether a file is a history of nights, which a command creates before its run, or was exported from one."""
    beginnings = (b"SQLite format 3", b"PAR1")
    return path.name.endswith(("-wal", "-shm")) or (path.is_file() and path.read_bytes().startswith(beginnings))


def test_a_sample_of_wild_lines_ends_in_one_line_each(tmp_path, monkeypatch, capsys):
    check_lines(sample(60), tmp_path, monkeypatch, capsys)


@pytest.mark.exhaustive
def test_every_wild_line_ends_in_one_line(tmp_path, monkeypatch, capsys):
    lines = list(wild_lines())
    assert len(lines) >= 500
    check_lines(lines, tmp_path, monkeypatch, capsys)


@pytest.mark.exhaustive
@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    command=st.sampled_from(sorted(cli.commands)),
    words=st.lists(st.sampled_from(["--out", "--set", "--vary", "--rtol", *NUMBERS, *TEXTS]) | st.text(), max_size=4),
)
def test_words_in_any_order_end_in_one_line(command, words, tmp_path_factory, capsys):
    with pytest.MonkeyPatch.context() as patch:
        check_lines([[command, *words]], tmp_path_factory.mktemp("line"), patch, capsys)


NAN = {
    "--time-limit": ["cost", "compare basics/libration --out x"], "--orbits": ["cost", "ensemble basics/libration"],
    "--rtol": ["effects basics/libration"], "--matters": ["effects basics/libration"], "--minutes": ["cost", "scaling"],
    "--repeats": ["cost"], "--shrink-seconds": ["selftest"],
}  # fmt: skip


@pytest.mark.parametrize("value", one_in(3, ["nan", "inf", "-inf", "NaN", "1e309"]))
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
