"""The changelog of values says which version each certified sample has: no value changes under an identifier."""

from __future__ import annotations

import dataclasses
import re
from functools import cache

import numpy as np

from barchain.solutions.case_versions import (
    CaseVersion,
    case_scenes,
    case_solution,
    current,
    data_set_version,
    missing_rows,
    values_digest,
    versions,
)

SCENE = "effects/impulse"


@cache
def digests() -> dict[str, str]:
    return {scene: values_digest(case_solution(scene)) for scene in case_scenes()}


def test_the_changelog_has_the_values_of_every_case_as_they_are() -> None:
    lacking = missing_rows(versions(), digests())
    said = "\n".join(",".join(dataclasses.astuple(row)) for row in lacking)
    assert not lacking, f"rows that case_versions.csv lacks, after a line on what changed:\n{said}"
    assert current().keys() == digests().keys()


def test_identifiers_are_unique_and_count_their_versions() -> None:
    assert len({row.identifier for row in versions()}) == len(versions())
    order = [tuple(map(int, row.data_set.split("."))) for row in versions()]
    assert order == sorted(order)
    found: dict[str, list[int]] = {}
    for row in versions():
        assert re.fullmatch(r"BC-[A-Za-z0-9_-]+-[0-9]+", row.identifier)
        found.setdefault(row.scene, []).append(int(row.identifier.rpartition("-")[2]))
    assert all(counted == [*range(1, len(counted) + 1)] for counted in found.values())


def test_a_value_that_changes_by_its_last_bit_needs_another_version() -> None:
    solution = case_solution(SCENE)
    angle = np.array(solution.trajectory.angle_rad)
    angle[7, 0] = np.nextafter(angle[7, 0], np.inf)
    moved = dataclasses.replace(solution, trajectory=solution.trajectory.replace(angle_rad=angle))
    (row,) = missing_rows(versions(), digests() | {SCENE: values_digest(moved)})
    assert (row.identifier, row.scene) == ("BC-impulse-2", SCENE)
    assert row.data_set != data_set_version()


def test_a_name_that_is_in_several_folders_is_told_apart_by_its_folder_and_an_earlier_case_keeps_its_own() -> None:
    new = missing_rows((), dict.fromkeys(("basics/two_bars_free", "paper/fig05"), "0"))
    assert [row.identifier for row in new] == ["BC-basics-two_bars_free-1", "BC-fig05-1"]
    earlier = CaseVersion("BC-two_bars_free-1", "basics/two_bars_free", "1.0", "0", "first values")
    (row,) = missing_rows((earlier,), {"basics/two_bars_free": "1"})
    assert row.identifier == "BC-two_bars_free-2"
