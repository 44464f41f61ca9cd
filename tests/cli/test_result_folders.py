"""Folders that hold results: never overwritten in silence."""

from __future__ import annotations

import pytest

from barchain.cli.main import cli, run
from barchain.nightly.attribution.release_runs import ReleasesStudy
from barchain.record.claim import ResultsInPlaceError, claim, claim_results
from barchain.solutions.certified_file import read_table, shipped_path
from reports.results import comparison
from tests.support.kernel import skip_without_kernel

QUICK = "basics/libration"
HELD = {
    f"compare {QUICK} --engine reference --out OUT": "record/comparison.json",
    "crossval --out OUT": "rows/comparison.parquet",
    f"cost {QUICK} --out OUT": "rows/cost.parquet",
    "scaling --bars 2 --out OUT": "rows/scaling.parquet",
    "roundoff --part times --out OUT": "rows/roundoff.parquet",
    "stability hard/whip --engine reference --out OUT": "series/stability/long.parquet",
    f"effects {QUICK} --engine reference --out OUT": "record/effects.json",
    f"selftest {QUICK} --fault scale-rate --out OUT": "answers/selftest/x",
    f"ensemble {QUICK} --vary angle_deg=normal(0,1) --runs 2 --out OUT": "series/ensemble/runs.parquet",
    f"sweep {QUICK} --vary run.samples=3 --engine reference --out OUT": "rows/sweep.parquet",
    "releases scipy --out OUT": "rows/releases.parquet",
    f"judge {QUICK} OUT/given.csv --out OUT": "record/comparison.json",
    f"simulate {QUICK} --out OUT/run.csv": "run.csv",
    f"plot {QUICK} --out OUT/run.svg": "run.svg",
    f"export {QUICK} --out OUT": f"{QUICK}/README.md",
    f"certified {QUICK} --out OUT": f"{QUICK}.parquet",
}
NO_RELEASES = ReleasesStudy("scipy", "scipy", (), (QUICK,))
CAN_NOT_GO_ON = {"simulate", "plot", "certified", "judge", "export"}


@pytest.mark.parametrize(("command", "held"), HELD.items(), ids=lambda text: text.partition(" ")[0])
def test_results_that_are_there_are_kept_and_the_command_exits_with_2(command, held, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("barchain.nightly.attribution.release_runs.releases_study", lambda *_: NO_RELEASES)  # no index
    if command.startswith("ensemble"):
        skip_without_kernel()
    if command.startswith("certified"):
        pytest.importorskip("heyoka")
    if command.startswith("judge"):
        read_table(shipped_path(QUICK)).trajectory.to_frame().to_csv(tmp_path / "given.csv", index=False)
    kept = tmp_path / held
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_text("earlier results")
    assert run(command.replace("OUT", str(tmp_path)).split()) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    assert "--overwrite replaces" in error
    assert ("--resume goes on" in error) is (command.split()[0] not in CAN_NOT_GO_ON)
    assert kept.read_text() == "earlier results"


def test_every_command_that_writes_results_can_replace_them():
    writers = {name for name, c in cli.commands.items() if any("--out" in p.opts for p in c.params)}
    writers -= {"nightly", "new-engine", "gate"}  # new folders, and a comment: no option replaces an author's code
    replacers = {name for name, c in cli.commands.items() if any("--overwrite" in p.opts for p in c.params)}
    assert writers == replacers == {command.split()[0] for command in HELD}


def test_overwrite_deletes_what_a_comparison_wrote_and_nothing_else(tmp_path):
    written = ("record/comparison.json", "rows/comparison.parquet", "index.html", "series/comparison/y/x.parquet",
               "answers/comparison/z")  # fmt: skip
    others = ("record/cost.json", "rows/cost.parquet", "series/cost/times.parquet", "note")
    for path in (tmp_path / name for name in written + others):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    claim_results(comparison.FILES, tmp_path, overwrite=True)
    assert {p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*") if p.is_file()} == set(others)


def test_resume_and_overwrite_exclude_each_other_even_in_an_empty_folder(tmp_path):
    with pytest.raises(ResultsInPlaceError, match="exclude"):
        claim([tmp_path / "x"], "x", resume=True, overwrite=True)


@pytest.mark.parametrize("mode", ["--resume", "--overwrite"])
@pytest.mark.parametrize("linked", ["series", "rows", "record", "answers", "series/comparison", "answers/comparison"])
def test_nothing_outside_a_result_folder_is_deleted_or_written_through_a_link(linked, mode, tmp_path, capsys):
    outside, out = tmp_path / "outside", tmp_path / "out"
    precious = outside / "comparison" / "precious.txt"
    precious.parent.mkdir(parents=True)
    precious.write_text("a person's file")
    (out / linked).parent.mkdir(parents=True)
    (out / linked).symlink_to(outside / "comparison" if "/" in linked else outside)
    assert run(["compare", QUICK, "--engine", "reference", "--out", str(out), mode]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    assert f"{out / linked} is a link" in error
    assert [p for p in outside.rglob("*") if p.is_file()] == [precious]
    assert precious.read_text() == "a person's file"
