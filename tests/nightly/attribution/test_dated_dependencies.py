"""A release that no longer imports with today's dependencies is measured with those of its own time, and says so."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from barchain.nightly.attribution import environments as dated
from barchain.nightly.attribution import release_runs as measuring
from barchain.nightly.attribution.environments import PinnedEnvironment, dependencies_at
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.runs.processes import Finished

STUDY: Any = SimpleNamespace(distribution="pin", engine="pinocchio")
RELEASE: Any = SimpleNamespace(version="3.4.0", date="2025-02-13")
MISSING = "ImportError: liburdfdom_sensor.so.4.0: cannot open shared object file"


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Pins of each environment that was made."""
    found: list[tuple[str, ...]] = []

    def make(pins: list[str], **_: Any) -> PinnedEnvironment:
        found.append(tuple(pins))
        return PinnedEnvironment(Path("nowhere"), tuple(pins), ("cmeel-urdfdom 4.0.1 (here 6.0.0)",) * (len(pins) > 1))

    monkeypatch.setattr(measuring, "pinned_environment", make)
    monkeypatch.setattr(measuring, "dependencies_at", lambda *_: ["cmeel-urdfdom==4.0.1"])
    return found


def imports_with(monkeypatch: pytest.MonkeyPatch, *pins: str) -> None:
    """Let a release import only where some versions are pinned."""

    def probe(_: Any, environment: PinnedEnvironment, *__: Any) -> dict[str, Any]:
        facts = {"moved": ", ".join(environment.moved)}
        return facts | ({"import_s": 0.2} if set(pins) <= set(environment.pins) else {"fault": MISSING})

    monkeypatch.setattr(measuring, "probe", probe)


def test_a_release_that_imports_today_keeps_the_dependencies_of_today(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch)
    _, facts, note = measuring.working_environment(STUDY, RELEASE, tmp_path, tmp_path)
    assert made == [("pin==3.4.0",)]
    assert (facts, note) == ({"import_s": 0.2, "moved": ""}, "")


def test_a_release_that_needs_earlier_dependencies_gets_them_and_says_so(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch, "cmeel-urdfdom==4.0.1")
    environment, facts, note = measuring.working_environment(STUDY, RELEASE, tmp_path, tmp_path)
    assert made[1] == environment.pins == ("cmeel-urdfdom==4.0.1", "pin==3.4.0")
    assert facts["moved"] == "cmeel-urdfdom 4.0.1 (here 6.0.0)"
    assert note == f"with the dependencies of its own time; with today's: {MISSING}"


def test_a_release_that_imports_with_neither_has_the_fault_of_today(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch, "no such pin")
    environment, facts, note = measuring.working_environment(STUDY, RELEASE, tmp_path, tmp_path)
    assert environment.pins == made[0]
    assert (facts["fault"], note) == (MISSING, "")


def test_the_index_is_asked_for_versions_up_to_a_month_after_the_release(monkeypatch) -> None:
    asked: list[list[str]] = []

    def run(line: list[str], **_: Any) -> Finished:
        asked.append(line)
        return Finished(0, 1.0, content=b"numpy==2.2.3\npin==3.4.0\n")

    monkeypatch.setattr(dated, "run", run)
    assert dependencies_at("pin==3.4.0", "2025-02-13") == ["numpy==2.2.3"]
    assert asked[0][asked[0].index("--exclude-newer") + 1] == "2025-03-15"


@pytest.mark.parametrize(("day", "said"), [("", "gives no day for pin==3.4.0"), ("2025-02-13", "no versions")])
def test_no_day_and_no_versions_are_told(monkeypatch, day: str, said: str) -> None:
    ended = Finished(1, 1.0, "no versions", said="no versions")
    monkeypatch.setattr(dated, "run", lambda *_, **__: ended)
    with pytest.raises(PinnedEnvironmentError, match=said):
        dependencies_at("pin==3.4.0", day)
