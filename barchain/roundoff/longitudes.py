"""Whether errors know of the longitude, which no reaction does: they should not, inside their own spread."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import kruskal

from barchain.roundoff.evaluation import BOTH, REACTION, errors, quantiles
from barchain.roundoff.formulations import FORMULATIONS
from barchain.roundoff.states import exact_case, longitude_rad
from reference_impl.precision.arithmetic import ARITHMETICS, exact_numbers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.roundoff.states import Case

SECTORS = 8


def longitude_rows(case: Case, formulations: Iterable[str], arithmetics: Iterable[str]) -> list[dict[str, Any]]:
    """Rows of longitudes.csv: errors in each eighth of the circle, and the chance that all eighths are alike."""
    rows: list[dict[str, Any]] = []
    with exact_numbers():
        exact = exact_case(case)
        sector = np.floor(longitude_rad(exact) / (2.0 * np.pi / SECTORS)).astype(int) % SECTORS
        for name in formulations:
            for arithmetic in arithmetics:
                found = errors(FORMULATIONS[name], ARITHMETICS[arithmetic], exact)[BOTH, REACTION]
                groups = [found[sector == k] for k in range(SECTORS)]
                alike = float(kruskal(*groups).pvalue)
                head = {"state": str(case.kind), "ratio": case.ratio, "formulation": name, "arithmetic": arithmetic}
                rows += [
                    head | {"sector_deg": 360.0 / SECTORS * k} | quantiles(own) | {"p_value": alike}
                    for k, own in enumerate(groups)
                ]
    return rows
