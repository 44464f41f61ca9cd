"""A small campaign as a whole: tables, page, command."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pandas as pd
import pytest

from barchain.cli.main import run as command
from barchain.cli.selftest import finding_words, rate_words, show_campaign
from barchain.judge.verdict import no_verdict
from barchain.studies.selftest import trial
from barchain.studies.selftest.campaign import Campaign, CampaignStudy, alone_on
from barchain.studies.selftest.faults.catalogue import RANDOM_SCENES
from barchain.studies.selftest.rating import CampaignCell, rate, rates
from barchain.studies.selftest.scenes import draw
from barchain.studies.selftest.shrinking import kept_findings
from barchain.studies.study import run_study
from reports.chapters.campaign import size_rows
from reports.render import render_all
from reports.results.faults.campaign import CellClass
from reports.results.outcome import Outcome
from reports.results.studies import STUDIES
from scenarios import load_scene
from tests.studies.campaign.drawn import FREE, SEED, cells
from tests.support.here import HERE
from tests.support.results import read_record, read_table

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.selftest.shrinking import KeptFinding


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple[Campaign, Path]:
    """Two scenes, three engines, some faults in one of them."""
    out = tmp_path_factory.mktemp("campaign")
    faults = ("garbage-growing-90-finer", "garbage-sudden-50-all", "com-millimetres", "mass", "mu", "declares-order")
    plan = CampaignStudy(1, FREE, ("reference", "exudyn"), ("pymunk",), faults, 1, 0.0, HERE)
    other = dataclasses.replace(plan, seed=SEED)
    found = [run_study(p, out, overwrite=True) for p in (plan, other)]
    both = [c for f in found for c in f.cells]
    return Campaign(other, both, rates(both), []), out


@pytest.mark.slow
def test_a_small_campaign_passes(small: tuple[Campaign, Path]) -> None:
    found, _ = small
    assert found.passed, [c for c in found.cells if c.is_finding]
    assert {c.engine for c in found.cells} == {"reference", "exudyn", "pymunk"}
    assert not [c for c in found.cells if c.kind is CellClass.BROKEN]


@pytest.mark.slow
def test_its_tables_hold_its_cells(small: tuple[Campaign, Path]) -> None:
    found, out = small
    table = read_table(out, "campaign", "campaign")
    last = [c for c in found.cells if c.scene == f"random/{SEED}"]
    assert list(table["class"]) == [str(c.kind) for c in last]
    assert read_record(out, "campaign")["passed"]


@pytest.mark.slow
def test_its_page_is_rendered_from_its_tables_alone(small: tuple[Campaign, Path]) -> None:
    _, out = small
    (page,) = [p for p in render_all(out) if p.name == "campaign.html"]
    said = page.read_text(encoding="utf-8")
    assert "0 of 3 verdicts on unmodified engines are false alarms" in said
    table = read_table(out, "campaign", "campaign")
    caught = sum(table["class"] == "caught")
    assert f"{caught} of {caught} faults above the detection limit are caught" in said
    assert all(name in said for name in ("reference", "exudyn", "pymunk", "garbage-sudden-50-all"))


def test_sizes_are_counted_against_the_detection_limit() -> None:
    table = pd.DataFrame(
        [("caught", 50.0, 1.0), ("below the limit", 0.5, 1.0), ("missed", 2.0, 1.0), ("caught", 3.0, None)],
        columns=["class", "size", "detection_limit"],
    )
    assert size_rows(table) == [
        ("0.1 to 1", [0, 0, 1, 0]),
        ("1 to 10", [0, 1, 0, 0]),
        ("10 to 100", [1, 0, 0, 0]),
        ("not stated", [1, 0, 0, 0]),
    ]


def test_a_folder_of_no_study_is_answered_by_the_studies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["report", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert all(files.study in said for files in STUDIES)


def test_what_is_printed(small: tuple[Campaign, Path], capsys: pytest.CaptureFixture[str]) -> None:
    show_campaign(small[0], kept=True)
    said = capsys.readouterr().out
    for word in ("pymunk", "garbage-sudden-50-all", "false alarm: 0 of 6", "missed: 0 of", "passed"):
        assert word in said, word
    assert (
        rate_words(rate(CellClass.MISSED, "all", "all", cells(CellClass.CAUGHT, 400, "mu"), 2))
        == "missed: 2 of 400, 0.50 % (0.14 % to 1.80 %)"
    )


@pytest.mark.slow
def test_the_command_runs_in_worker_processes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = "--engine reference --host reference --fault sign-reaction --fault declares-noise --workers 1"
    asked = f"selftest --random 1 --seed {SEED} {options} --out {tmp_path} --shrink-seconds 0"
    assert command(asked.split()) == 0
    said = capsys.readouterr().out
    assert "missed: 0 of 1" in said
    assert len(read_table(tmp_path, "campaign", "campaign")) == 3


def test_a_findings_scene_is_written_simpler_and_simpler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a judge that sees nothing, two bars and three samples are enough to miss a sign."""

    def blind(of, results, solution, main):  # type: ignore[no-untyped-def]
        limit = {"quantity": "reaction", "metric": "detection_limit", "value": 1e-9, "limit_s": None}
        verdict = no_verdict(of.scene.name, of.engine, of.setting, Outcome.PASS, "")
        return dataclasses.replace(verdict, rows=[*verdict.rows, verdict.rows[0] | limit])

    monkeypatch.setattr(trial, "verdict_of", blind)
    cell = CampaignCell(f"random/{SEED}", "reference", "sign-reaction", "pass", CellClass.MISSED, "reaction")
    folder = tmp_path / "series" / "scenes"  # neither exists where no fault was inserted

    def kept_within(seconds: float) -> KeptFinding:
        (kept,) = kept_findings([[cell, cell]], folder, alone_on, seconds, HERE, lambda _: None)
        return kept

    kept = kept_within(0.0)
    assert kept.path == folder / f"{SEED}-reference-sign-reaction.toml"
    assert load_scene(kept.path).digest == draw(SEED).digest
    assert kept_within(20.0) == kept
    found = load_scene(kept.path)
    assert (found.bars, found.run.samples) < (draw(SEED).bars, 3)
    assert "sign-reaction" in found.description
    assert str(kept.path) in finding_words(kept, kept=True)
    assert "(2 times)" in finding_words(kept, kept=False)


@pytest.mark.exhaustive
def test_a_campaign_passes(tmp_path: Path) -> None:
    plan = CampaignStudy(6, 100, ("reference-absolute", "exudyn-index3", "rebound", "pymunk-absolute"), shrink_s=0.0)
    found = run_study(plan, tmp_path)
    assert found.passed, [c for c in found.cells if c.is_finding]
    assert not [c for c in found.cells if c.kind is CellClass.BROKEN]


@pytest.mark.parametrize(("line", "word"), [
    ("--seed 3", "--seed goes with --random"), ("--host pymunk", "--host goes with --random"),
    ("--shrink-seconds 3", "--shrink-seconds goes with --random"), ("--random 1 --smallest", "leave out SCENE"),
    ("--random 1 --host pymnk", "did you mean pymunk"), ("--random 1 --fault maas", "did you mean mass"),
    ("--random 0", "--random"), ("--engine exudyn --engine pymunk", "faults are inserted into one engine"),
])  # fmt: skip
def test_bad_usage(line: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["selftest", *line.split()]) == 2
    assert word in capsys.readouterr().err


def test_its_faults_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["selftest", "--random", "1", "--list"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in RANDOM_SCENES)
