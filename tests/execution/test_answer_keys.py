"""What decides an answer is in its key, one ingredient after the other; documents, reports and studies are not."""

from __future__ import annotations

import dataclasses
import importlib
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from adapters.registry import ENGINES, Registration
from barchain.record import sources
from barchain.runs import kept_answers as keys
from barchain.runs.call import Call
from barchain.runs.job import Job, Role, TimeLimit
from barchain.runs.kept_answers import answer_key
from barchain.runs.run import shared_call
from scenarios import load_scene
from tests.execution import calls

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenarios import Scene

FUNCTIONS = """
from typing import TYPE_CHECKING
from toy.used import step
if TYPE_CHECKING:
    import toy.typed
def make():
    import toy.late
"""
TOY = {
    "functions": FUNCTIONS, "used": "step = 1", "late": "late = 1", "typed": "typed = 1", "document": "text = 1",
    "adapters/one": "from toy.used import step", "adapters/other": "order = 2",
}  # fmt: skip


@pytest.fixture(autouse=True)
def nothing_known() -> Iterator[None]:
    """No digest is known from before, or stays known after the test."""
    known = (keys.machine_parts, keys.distribution_text, keys.closure_digest, keys.known_module, keys.root_of)
    for each in (*known, sources.required_by):
        each.cache_clear()
    yield
    for each in (*known, sources.required_by):
        each.cache_clear()


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Package of sources that counts as one of barchain's."""
    folder = tmp_path / "toy"
    for name, text in TOY.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.py").write_text(text)
    (folder / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(keys, "OURS", (*keys.OURS, "toy"))
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "toy"]:
        del sys.modules[name]


def test_a_library_of_another_environment_is_known_by_its_distribution(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lib_elsewhere").mkdir()
    (tmp_path / "lib_elsewhere" / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    assert keys.root_of("lib_elsewhere") == tmp_path / "lib_elsewhere"
    keys.root_of.cache_clear()
    (tmp_path / "lib_elsewhere-1.0.dist-info").mkdir()
    assert keys.root_of("lib_elsewhere") is None


def run_of(registration: Registration, scene: Scene | None = None) -> Call:
    setting = ENGINES["reference"].load().sweep.setting()
    job = Job(scene or load_scene("basics/kepler_circular"), "toy", registration, setting, Role.MAIN)
    return Call(calls.echo, (job,), 1.0)


def changed_key(file: Path, call: Call) -> bool:
    """Whether a key is another after a change of a file."""
    before = answer_key(call)
    file.write_text(f"{file.read_text()}\n# changed")
    for known in (keys.closure_digest, keys.known_module, keys.distribution_text):
        known.cache_clear()
    return answer_key(call) != before


def installed(folder: Path, name: str, requires: str = "") -> Path:
    """Source of a distribution that is installed in a folder."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n{requires}")
    (info / "RECORD").write_text(f"{name}.py,,\n")
    source = folder / f"{name}.py"
    source.write_text("step = 1")
    return source


def test_function_arguments_and_repetition_count_and_limits_do_not() -> None:
    call = Call(calls.echo, (b"one",), 1.0)
    others = [
        dataclasses.replace(call, function=calls.slowly), dataclasses.replace(call, given=(b"two",)),
        dataclasses.replace(call, repetition=1),
    ]  # fmt: skip
    assert len({answer_key(each) for each in (call, *others)}) == 1 + len(others)
    assert answer_key(dataclasses.replace(call, limit_s=2.0, pool="other", aside=(3,))) == answer_key(call)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("package_version", lambda _: "0"),
        ("blas", lambda: "other"),
        ("processor", lambda: "other"),
        ("platform.python_version", lambda: "3.99"),
    ],
)
def test_libraries_that_compute_the_processor_and_python_count(
    place: str, value: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    call = Call(calls.echo, (b"",), 1.0)
    before = answer_key(call)
    monkeypatch.setattr(f"{keys.__name__}.{place}", value)
    keys.machine_parts.cache_clear()
    assert answer_key(call) != before


@pytest.mark.parametrize(
    ("file", "counts"), [("functions", True), ("used", True), ("late", True), ("typed", False), ("document", False)]
)
def test_modules_that_a_function_imports_count_and_no_others(file: str, counts: bool, toy: Path) -> None:
    make = importlib.import_module("toy.functions").make
    assert changed_key(toy / f"{file}.py", Call(make, (), 1.0)) is counts


def test_a_changed_adapter_changes_the_keys_of_its_engines_only(toy: Path) -> None:
    one, other = (run_of(Registration(f"toy.adapters.{name}:Toy")) for name in ("one", "other"))
    assert not changed_key(toy / "adapters/one.py", other)
    assert changed_key(toy / "adapters/one.py", one)
    assert changed_key(toy / "used.py", one)


def test_an_engine_that_a_function_knows_by_name_counts(toy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENGINES, "toy-one", Registration("toy.adapters.one:Toy"))
    assert changed_key(toy / "adapters/one.py", Call(calls.echo, (["toy-one", 5],), 1.0))
    assert not changed_key(toy / "adapters/one.py", Call(calls.echo, (["toy-one-more", 5],), 1.0))


@pytest.mark.parametrize("named", ["requires", "distribution"])
def test_contents_of_an_engines_distribution_and_of_what_it_requires_count(
    named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needed = installed(tmp_path, "toy_needed")
    engine = installed(tmp_path, "toy_engine", "Requires-Dist: Toy.Needed>=1\nRequires-Dist: toy-extra; extra == 'x'\n")
    monkeypatch.syspath_prepend(tmp_path)
    call = run_of(Registration("adapters.rebound.adapter:Rebound", **{named: "toy_engine"}))
    assert changed_key(engine, call)
    assert changed_key(needed, call)


def test_a_module_of_a_plug_in_without_a_distribution_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plugged.py").write_text("step = 1")
    monkeypatch.syspath_prepend(tmp_path)
    assert changed_key(tmp_path / "plugged.py", run_of(Registration("plugged:Toy")))


def test_a_module_beside_an_engine_that_it_imports_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "beside_it.py").write_text("FACTOR = 1.0")
    (tmp_path / "within_it.py").write_text("FACTOR = 1.0")
    (tmp_path / "importing.py").write_text(
        "import beside_it\ndef read():\n    import within_it\n    return within_it\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    call = run_of(Registration("importing:Toy"))
    assert changed_key(tmp_path / "beside_it.py", call)
    assert changed_key(tmp_path / "within_it.py", call)


def test_sources_of_the_kernel_count_for_the_compiled_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled, track = (run_of(ENGINES[name]) for name in ("reference-fast", "rebound"))
    before = answer_key(compiled), answer_key(track)
    monkeypatch.setattr(keys, "source_digest", lambda: "other")
    keys.closure_digest.cache_clear()
    assert answer_key(compiled) != before[0]


def test_documents_reports_studies_and_the_command_line_decide_no_run() -> None:
    call = shared_call(run_of(ENGINES["exudyn"]).given[0], TimeLimit(1.0), "runs", 1)
    ahead, found = ["adapters.exudyn.adapter", *keys.Ingredients(call).modules], set[str]()
    while ahead:
        name = ahead.pop()
        if name not in found and keys.source_of(name) is not None:
            found.add(name)
            ahead += keys.known_module(name)[1]
    assert {"adapters.exudyn.adapter", "barchain.runs.run", "scenarios.scene"} <= found
    apart = ("barchain.cli", "barchain.studies", "barchain.judge", "barchain.nightly", "reports")
    assert not [name for name in found if name.startswith(apart)]
    assert not [name for name in found if name.startswith("adapters.") and name.split(".")[1] in {"rebound", "heyoka"}]


def test_a_library_of_linear_algebra_that_an_engine_brings_along_is_no_part_of_a_key() -> None:
    """SUNDIALS' wheel has one of its own: a process that has loaded it finds the answers of one that has not."""
    pytest.importorskip("sksundae")
    code = (
        "from barchain.record.environment import blas\nfound = blas()\nimport sksundae\nassert blas() == found, blas()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
