"""Tables of cases: numbers for a test in any language, such a test, and the grades of difficulty."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from barchain.result_files.case import error_bars, settings
from barchain.result_files.difficulty import GRADES
from barchain.result_files.tube import quantities, tube
from barchain.solutions.case_versions import case_scenes, case_solution, current, values
from pictures.pages.words import short, table
from scenarios.channels import TIME, UNITS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from barchain.solutions.reference import ReferenceSolution

SCENES = (
    "basics/two_bars_free", "paper/fig13", "paper/fig15", "effects/joint_springs", "effects/drag", "effects/impulse",
)  # fmt: skip
"""Of free bars, of bars in orbit with and without a law, and of one effect each"""
RTOL = 1e-9
"""Requested error of the method that the tolerance is for"""


def chosen(solution: ReferenceSolution) -> Iterator[tuple[str, int]]:
    """Columns and samples of a scene's numbers: angle and reaction halfway, and the last bar's angle at the end."""
    end = len(solution.amplification) - 1
    yield "angle_1_rad", end // 2
    yield "reaction_1_x_N", end // 2
    yield f"angle_{solution.scene.bars}_rad", end


def numbers(scene: str) -> Iterator[tuple[str, float, float, str, float, float]]:
    """Column, instant in s, value, unit, error bar and tolerance of each of a scene's numbers."""
    solution = case_solution(scene)
    frame, bars, wide = values(solution), error_bars(solution), tube(solution, RTOL).width
    for column, k in chosen(solution):
        name = quantities(solution.scene)[column]
        yield column, float(frame[TIME][k]), float(frame[column][k]), UNITS[name], bars[name][k], wide[name][k]


def check_values() -> str:
    """Numbers of all scenes, in every digit."""
    head = ("case", "scene", "column", "t, s", "value", "unit", "error bar", f"tolerance at rtol={short(RTOL)}")
    return table(head, (
        (current()[scene].identifier, f"`{scene}`", f"`{column}`", t, value, unit, short(bar), short(tolerance))
        for scene in SCENES for column, t, value, unit, bar, tolerance in numbers(scene)
    ))  # fmt: skip


def check_values_test() -> str:
    """Test of the first scene's numbers in Python."""
    rows = [f"    ({t!r}, {column!r}, {value!r}, {short(tol)}),".replace("'", '"')
            for column, t, value, _, _, tol in numbers(SCENES[0])]  # fmt: skip
    return "\n".join([
        "```python", "from barchain import simulate", "",
        f'run = simulate("{SCENES[0]}").to_frame().set_index("t_s")  # your program\'s table here',
        "for t_s, column, value, tolerance in (", *rows, "):",
        '    assert abs(run[column].loc[t_s] - value) < tolerance, f"{column} at {t_s} s"', "```",
    ])  # fmt: skip


def grades() -> str:
    """Grades of difficulty, with the number of cases of each."""
    graded = Counter(settings(case_solution(scene))["difficulty"]["grade"] for scene in case_scenes())
    return table(("grade", "cases:", "what the end of the run demands"), (
        (grade, graded[grade], meaning) for grade, meaning in GRADES.items()
    ))  # fmt: skip


TABLES: dict[str, Callable[[], str]] = {
    "check-values": check_values, "check-values-test": check_values_test, "grades": grades,
}  # fmt: skip
"""Tables by their names"""
