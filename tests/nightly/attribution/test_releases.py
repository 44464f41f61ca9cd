"""Releases of an engine: which the index has, what is measured of each, and with which dependencies it is imported."""

from __future__ import annotations

import datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from packaging.version import Version

from barchain.nightly.attribution import environments as dated
from barchain.nightly.attribution import release_runs as study
from barchain.nightly.attribution import releases as index
from barchain.nightly.attribution.environments import PinnedEnvironment, dependencies_at
from barchain.nightly.attribution.release_runs import engine_and_distribution, releases_study
from barchain.nightly.attribution.releases import Release, releases_of
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.runs.processes import Finished
from barchain.studies.study import run_study
from reports.render import render_study
from reports.results.releases import FILES

DAY = datetime.datetime(2026, 1, 2, tzinfo=datetime.UTC)


def file(name: str, **more: Any) -> SimpleNamespace:
    usual = {"filename": name, "requires_python": ">=3.9", "is_yanked": False, "upload_time": DAY, "size": 10}
    return SimpleNamespace(**(usual | more))


@pytest.fixture
def files(monkeypatch: pytest.MonkeyPatch) -> list[SimpleNamespace]:
    found: list[SimpleNamespace] = []
    monkeypatch.setattr(index, "packages", lambda *_, **__: found)
    return found


def test_releases_are_wheels_that_fit_here_in_the_order_of_their_versions(files: list[SimpleNamespace]) -> None:
    files += [
        file("mujoco-3.10.0-py3-none-any.whl"),
        file("mujoco-3.9.0-py3-none-any.whl"),
        file("mujoco-3.11.0-cp27-cp27m-win32.whl"),
        file("mujoco-3.12.0-py3-none-any.whl", requires_python=">=4"),
        file("mujoco-3.13.0-py3-none-any.whl", is_yanked=True),
        file("mujoco-4.0.0rc1-py3-none-any.whl"),
        file("mujoco-3.14.0.tar.gz"),
        file("no wheel at all.whl"),
    ]
    assert releases_of("mujoco") == (
        Release(Version("3.9.0"), "2026-01-02", 10),
        Release(Version("3.10.0"), "2026-01-02", 10),
    )
    assert [str(r.version) for r in releases_of("mujoco", "3.10")] == ["3.10.0"]


@pytest.mark.parametrize(
    ("given", "since", "said"),
    [
        ("mujocco", "", "did you mean mujoco"),
        ("reference", "", "part of barchain"),
        ("mujoco", "latest", "latest given, allowed: a version"),
        ("mujoco", "9", "no wheel for this Python and platform from 9 on"),
    ],
)
def test_an_engine_or_a_version_without_releases_is_told(
    files: list[SimpleNamespace], given: str, since: str, said: str
) -> None:
    assert files == []
    with pytest.raises(PinnedEnvironmentError, match=said):
        releases_study(given, since=since)


def test_an_engine_or_its_distribution_can_be_named() -> None:
    assert engine_and_distribution("exudyn") == ("exudyn", "exudyn")
    assert engine_and_distribution("pin") == ("pinocchio", "pin")


def test_scenes_that_the_engine_does_not_support_are_told(files: list[SimpleNamespace]) -> None:
    files.append(file("rebound-5.0.0-py3-none-any.whl"))
    assert releases_study("rebound").scenes
    with pytest.raises(PinnedEnvironmentError, match="mujoco does not support effects/solar_shadow"):
        releases_study("mujoco", ["effects/solar_shadow"])


def measured(plan: Any, release: Release, *_: Any) -> dict[str, list[dict[str, Any]]]:
    """Rows of a release: 1.0 does not run, 1.2 has other digits than 1.1."""
    version = str(release.version)
    place = {"engine": plan.engine, "version": version}
    own = place | {"released": "2026-01-02", "wheel_B": 1e6, "state": "runs", "import_s": 0.1}
    found: dict[str, list[dict[str, Any]]] = {"errors": [], "runs": [], "times": [], "releases": [own]}
    if version == "1.0":
        own |= {"state": "does not run", "reason": "AttributeError: no <such> name"}
        return found
    for scene in plan.scenes:
        found["errors"].append(place | {
            "scene": scene, "quantity": "attitude", "unit": "rad", "value": 1e-9 * float(version), "rounding": 1e-12,
            "verdict": "pass", "reason": "",
        })  # fmt: skip
        bits = "bb" if version == "1.2" and scene == plan.scenes[0] else "aa"
        found["runs"].append(place | {"scene": scene, "setting": "", "trajectory": bits, "steps": 100})
    found["times"].append(place | {
        "scene": plan.scenes[0], "setting": "attitude<=1e-06", "relative_to": "reference-fast", "ratio": 3.0,
        "low": 2.5, "high": 3.5,
    })  # fmt: skip
    return found


def test_the_study_tells_which_releases_run_and_where_digits_change_and_goes_on_after_an_interruption(
    files: list[SimpleNamespace], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files += [file(f"pymunk-1.{k}-py3-none-any.whl") for k in range(4)]
    asked: list[str] = []

    def until_the_third(plan: Any, release: Release, *more: Any) -> dict[str, list[dict[str, Any]]]:
        asked.append(str(release.version))
        if asked == ["1.0", "1.1", "1.2"]:
            raise KeyboardInterrupt
        return measured(plan, release, *more)

    monkeypatch.setattr(study, "measure", until_the_third)
    own = releases_study("pymunk")
    with pytest.raises(KeyboardInterrupt):
        run_study(own, tmp_path)
    result = run_study(own, tmp_path, resume=True)
    assert asked == ["1.0", "1.1", "1.2", "1.2", "1.3"]
    assert result.passed
    assert list(FILES.contents(tmp_path).releases["version"].astype(str)) == ["1.0", "1.1", "1.2", "1.3"]
    rendered = render_study("releases", tmp_path)
    page = rendered.page.read_text("utf-8")
    assert "3 of 4 releases of pymunk run with this barchain; digits change with 1.2, 1.3." in page
    assert "no &lt;such&gt; name" in page
    assert "other digits in 1 of 3 scenes" in page


@pytest.mark.exhaustive
def test_two_real_releases_of_pymunk_agree_in_every_digit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BARCHAIN_ENVIRONMENTS", str(tmp_path / "environments"))
    own = releases_study("pymunk", ("basics/two_bars_free",), "7.3")
    run_study(own, tmp_path / "out")
    tables = FILES.contents(tmp_path / "out")
    assert set(tables.releases["state"]) == {"runs"}
    assert len(tables.runs) >= 2
    assert tables.runs["trajectory"].nunique() == 1
    assert (tables.releases["import_s"] > 0.0).all()


PIN: Any = SimpleNamespace(distribution="pin", engine="pinocchio")
RELEASE: Any = SimpleNamespace(version="3.4.0", date="2025-02-13")
MISSING = "ImportError: liburdfdom_sensor.so.4.0: cannot open shared object file"


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Pins of each environment that was made."""
    found: list[tuple[str, ...]] = []

    def make(pins: list[str], **_: Any) -> PinnedEnvironment:
        found.append(tuple(pins))
        return PinnedEnvironment(Path("nowhere"), tuple(pins), ("cmeel-urdfdom 4.0.1 (here 6.0.0)",) * (len(pins) > 1))

    monkeypatch.setattr(study, "pinned_environment", make)
    monkeypatch.setattr(study, "dependencies_at", lambda *_: ["cmeel-urdfdom==4.0.1"])
    return found


def imports_with(monkeypatch: pytest.MonkeyPatch, *pins: str) -> None:
    """Let a release import only where some versions are pinned."""

    def probe(_: Any, environment: PinnedEnvironment, *__: Any) -> dict[str, Any]:
        facts = {"moved": ", ".join(environment.moved)}
        return facts | ({"import_s": 0.2} if set(pins) <= set(environment.pins) else {"fault": MISSING})

    monkeypatch.setattr(study, "probe", probe)


def test_a_release_that_imports_today_keeps_the_dependencies_of_today(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch)
    _, facts, note = study.working_environment(PIN, RELEASE, tmp_path, tmp_path)
    assert made == [("pin==3.4.0",)]
    assert (facts, note) == ({"import_s": 0.2, "moved": ""}, "")


def test_a_release_that_needs_earlier_dependencies_gets_them_and_says_so(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch, "cmeel-urdfdom==4.0.1")
    environment, facts, note = study.working_environment(PIN, RELEASE, tmp_path, tmp_path)
    assert made[1] == environment.pins == ("cmeel-urdfdom==4.0.1", "pin==3.4.0")
    assert facts["moved"] == "cmeel-urdfdom 4.0.1 (here 6.0.0)"
    assert note == f"with the dependencies of its own time; with today's: {MISSING}"


def test_a_release_that_imports_with_neither_has_the_fault_of_today(made, monkeypatch, tmp_path) -> None:
    imports_with(monkeypatch, "no such pin")
    environment, facts, note = study.working_environment(PIN, RELEASE, tmp_path, tmp_path)
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
