"""Whether errors know of the longitude, which no reaction does.

Those of the formulas should not. Rounding the input may: an inertial angle is the larger, and so is the unit in its
last place, the further round the circle the chain starts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import kruskal

from barchain.studies.roundoff.formulations.definitions import FORMULATIONS
from barchain.studies.roundoff.formulations.states import exact_case, longitude_rad
from barchain.studies.roundoff.parts.evaluation import FORMULA, INPUT, REACTION, errors, quantiles
from reference_impl.precision.arithmetic import ARITHMETICS, exact_numbers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.trajectory import Array
    from barchain.studies.roundoff.formulations.states import EvaluationCase

SECTORS = 8


def longitude_rows(
    case: EvaluationCase, formulations: Iterable[str], arithmetics: Iterable[str]
) -> list[dict[str, Any]]:
    """Rows of longitudes.csv: errors in each eighth of the circle, and the chance that all eighths are alike."""
    rows: list[dict[str, Any]] = []
    with exact_numbers():
        exact = exact_case(case)
        sector = np.floor(longitude_rad(exact) / (2.0 * np.pi / SECTORS)).astype(int) % SECTORS
        for name in formulations:
            for arithmetic in arithmetics:
                found = errors(FORMULATIONS[name], ARITHMETICS[arithmetic], exact)
                head = {"state": str(case.kind), "ratio": case.ratio, "formulation": name, "arithmetic": arithmetic}
                for source in (FORMULA, INPUT):
                    groups = [found[source, REACTION][sector == k] for k in range(SECTORS)]
                    rows += sector_rows(head | {"source": source}, groups)
    return rows


def sector_rows(head: dict[str, Any], groups: list[Array]) -> list[dict[str, Any]]:
    """One row for each sector's errors."""
    alike = {"p_value": float(kruskal(*groups).pvalue)}
    return [head | {"sector_deg": 360.0 / SECTORS * k} | quantiles(own) | alike for k, own in enumerate(groups)]
