"""The data set of all cases: whole, described, citable, and equal in every byte when it is written again."""

from __future__ import annotations

import csv
import hashlib
import json
import re
from typing import TYPE_CHECKING, Any

import pandas as pd
import pytest
from click.testing import CliRunner

from barchain.cli.main import cli
from barchain.result_files.data_set import folder_name
from barchain.solutions import case_versions
from barchain.solutions.case_versions import current

if TYPE_CHECKING:
    from pathlib import Path

SCENES = ("basics/libration", "basics/two_bars_free", "effects/impulse")
"""Without joints, with them, with the columns of an effect"""


def written(out: Path, *options: str) -> Path:
    """Folder of a data set of a few cases."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(case_versions, "case_scenes", lambda: list(SCENES))
        found = CliRunner().invoke(cli, ["export", "--all", "--out", str(out), "--rtol", "1e-6", *options])
    assert found.exit_code == 0, found.output
    return out / folder_name()


@pytest.fixture(scope="module")
def data_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("set"), "--page")


@pytest.fixture(scope="module")
def package(data_set: Path) -> dict[str, Any]:
    return json.loads((data_set / "datapackage.json").read_text())


def files(folder: Path) -> dict[str, str]:
    """Hash of every file in a folder."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}


def test_the_package_names_every_file_with_its_size_and_hash(data_set: Path, package: dict[str, Any]) -> None:
    there = files(data_set)
    del there["datapackage.json"]
    assert {r["path"]: r["hash"] for r in package["resources"]} == {k: f"sha256:{v}" for k, v in there.items()}
    assert all(r["bytes"] == (data_set / r["path"]).stat().st_size for r in package["resources"])
    names = [r["name"] for r in package["resources"]]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z0-9._-]+", name) for name in (package["name"], *names))
    assert package["licenses"][0]["name"] == "CC-BY-4.0"


def test_every_column_has_a_type_that_its_cells_have_and_a_meaning(data_set: Path, package: dict[str, Any]) -> None:
    read = {"number": float, "integer": int, "string": str, "boolean": {"true": True, "false": False}.__getitem__}
    tables = [r for r in package["resources"] if r.get("profile") == "tabular-data-resource"]
    assert len(tables) == 2 + 3 * len(SCENES)
    for resource in tables:
        with (data_set / resource["path"]).open(newline="") as file:
            rows = list(csv.DictReader(file))
        fields = {field["name"]: field for field in resource["schema"]["fields"]}
        assert list(rows[0]) == list(fields)
        for name, field in fields.items():
            assert len(field["description"]) > 3
            assert not name.endswith("_rad_s") or field["description"].endswith("; rad/s")
            assert all(row[name] == "" or read[field["type"]](row[name]) is not None for row in rows)
        assert len({row[resource["schema"]["primaryKey"]] for row in rows}) == len(rows)


def test_equal_input_gives_equal_bytes(data_set: Path, tmp_path: Path) -> None:
    assert files(written(tmp_path, "--page")) == files(data_set)


def test_a_case_can_be_cited_by_its_identifier_and_the_digest_of_its_values(data_set: Path) -> None:
    rows = pd.read_csv(data_set / "cases.csv").set_index("scene")
    assert list(rows.index) == list(SCENES)
    for scene in SCENES:
        assert rows.identifier[scene] == current()[scene].identifier
        assert rows.digest[scene] == current()[scene].digest
        assert rows.identifier[scene] in (data_set / scene / "README.md").read_text()
    changelog = pd.read_csv(data_set / "changelog.csv").set_index("identifier")
    assert (changelog.digest[list(rows.identifier)].to_numpy() == rows.digest.to_numpy()).all()
    assert rows.identifier.iloc[0] in (data_set / "CITING.md").read_text()


def test_the_terms_of_every_case_are_those_of_the_data(data_set: Path, tmp_path: Path) -> None:
    for folder in (data_set, *(data_set / scene for scene in SCENES)):
        text = (folder / "LICENSE").read_text()
        assert "CC-BY-4.0" in text
        assert "MIT License" not in text
    assert "MIT License" in (written(tmp_path, "--mjcf") / SCENES[1] / "LICENSE").read_text()


def test_a_data_set_is_not_overwritten_unasked(tmp_path: Path) -> None:
    folder = written(tmp_path)
    again = CliRunner().invoke(cli, ["export", "--all", "--out", str(tmp_path)])
    assert f"{folder} is there" in str(again.exception)


@pytest.mark.parametrize("words", [[], ["--all", SCENES[0]]])
def test_scenes_or_all_of_them_are_exported(tmp_path: Path, words: list[str]) -> None:
    found = CliRunner().invoke(cli, ["export", *words, "--out", str(tmp_path)])
    assert found.exit_code == 2
    assert "give scenes, or --all" in found.output
