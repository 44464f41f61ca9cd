"""Bad usage of any command: one readable line, exit code 2, and nothing run or written."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run

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
