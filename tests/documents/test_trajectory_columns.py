"""The page on the columns of a trajectory names those that a run with everything has, and no others."""

from __future__ import annotations

import re

import numpy as np

from adapters.trajectory import Trajectory, to_frame
from pictures.paths import DOCS

PAGE = (DOCS / "reference" / "result_tables.md").read_text(encoding="utf-8").split("## Columns of a trajectory")[1]


def test_the_page_names_every_column_and_no_others() -> None:
    n, single = np.zeros(2), np.zeros((2, 1))
    one, pair = np.zeros((2, 1, 2)), np.zeros((2, 2))
    everything = Trajectory(
        n, pair, pair, single, single, one, single, n, position_m=one, torque_N_m=single, impulse_N_s=one, condition=n,
        torque_bars=(1,),
    )  # fmt: skip
    rows = [line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `")]
    assert set(re.findall("`([^`]+)`", " ".join(rows))) == set(to_frame(everything).columns)
