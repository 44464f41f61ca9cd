"""The relative formulation keeps its digits at any size, and a cancelling subtraction put into it is seen."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from barchain.studies.roundoff.evaluation import BOTH, REACTION, errors
from barchain.studies.roundoff.formulations import FORMULATIONS, PRODUCTION, EvaluationCase, StateKind, exact_case
from barchain.studies.roundoff.study import DECADES
from reference_impl.precision.arithmetic import FLOAT32, FLOAT64, exact_numbers
from tests.reference.cancellation import errors_of_all
from tests.support.kernel import needs_kernel
from tests.support.slow import exhaustive_but, one_in

ROOT = Path(__file__).resolve().parents[2]
KEPT = 1e-13
"""Of any quantity of five bars: some 100 u, by the joint system's condition; a cancelling subtraction leaves 1e-7."""


@pytest.mark.parametrize("bars", one_in(6, [2, 3, 5, 10]))
@pytest.mark.parametrize("ratio", DECADES)
def test_relative_coordinates_keep_14_digits_in_double_and_5_in_single_at_any_size(bars, ratio):
    with exact_numbers():
        exact = exact_case(EvaluationCase(StateKind.GENERIC, bars, ratio, 8))
        for formulation in (FORMULATIONS["relative"], FORMULATIONS["minimal"], *PRODUCTION.values()):
            assert errors(formulation, FLOAT64, exact)[BOTH, REACTION].max() < 1e-14, formulation.name
        for name in ("relative", "minimal"):
            assert errors(FORMULATIONS[name], FLOAT32, exact)[BOTH, REACTION].max() < 1e-5, name


@pytest.mark.parametrize("kind", [StateKind.GENERIC, StateKind.STRAIGHT])
@pytest.mark.parametrize("compact", [1.0, 20.0])
def test_everything_the_reference_makes_of_a_tiny_chain_keeps_its_digits(kind, compact):
    assert max(errors_of_all(kind, compact=compact).values()) < KEPT * compact


SUBTRACTIONS = {
    "gravity's differences by subtraction": (
        "model/gravity.py",
        "    return difference\n",
        "    ones = np.ones(np.shape(position_m))\n"
        "    here, there = as_vectors((com_m + position_m) * ones), as_vectors(com_m * ones)\n"
        "    return as_complex(point_field(mu_m3_s2, here) - point_field(mu_m3_s2, there))\n",
    ),
    "one subtracted from a power": ("model/gravity.py", "np.expm1(-1.5 * np.log1p(q))", "(1.0 + q) ** -1.5 - 1.0"),
    "the field and its mean taken whole": (
        "model/relative.py",
        "difference - mean, gradient_angular_accelerations",
        "(difference + as_complex(field)) - (mean + as_complex(field)), gradient_angular_accelerations",
    ),
    "places hung far away and brought back": (
        "model/kinematics.py",
        "np.cumsum(reach[..., :-1] + reach[..., 1:], axis=-1, out=from_first[..., 1:])",
        "from_first[..., 1:] = np.cumsum(reach[..., :-1] + reach[..., 1:], axis=-1) + 7e6\n    from_first -= 7e6\n"
        "    from_first[..., 0] = 0.0",
    ),
    "gaps between absolute places": (
        "integrate/coordinate_sets.py",
        "gap_vectors(self.model, state.position_m, state.angle_rad)",
        "gap_vectors(self.model, state.com_m + state.position_m, state.angle_rad)",
    ),
    "tidal energy with its linear part": (
        "model/invariants.py",
        "curved = q * q * (s + 2.0) / (2.0 * s * (1.0 + s) ** 2) - 0.5 * np.sum(position * position, axis=-1) / r2",
        "curved = np.expm1(-0.5 * np.log1p(q))",
    ),
    "relative velocities by subtraction": (
        "model/kinematics.py",
        "as_vectors(position), as_vectors(velocity))",
        "as_vectors(position), (com_velocity_m_s + as_vectors(velocity)) - com_velocity_m_s)",
    ),
    "angular momentum through the orbit's radius": (
        "model/invariants.py",
        "position, velocity = relative_motion(model, angle_rad, rate_rad_s)",
        "position, velocity = relative_motion(model, angle_rad, rate_rad_s)\n    position = (position + 7e6) - 7e6",
    ),
    "reactions under a law with the weight in them": (
        "model/relative.py",
        "total: ComplexArray = self.torque_free_reactions + torque @ self.reactions_per_torque",
        "total: ComplexArray = (self.torque_free_reactions + 900.0 + torque @ self.reactions_per_torque) - 900.0",
    ),
    "centre-of-mass residual of absolute places": (
        "integrate/simulate.py",
        "np.linalg.norm(weight @ s.position_m)",
        "np.linalg.norm(weight @ (s.com_m + s.position_m) - s.com_m)",
    ),
    "compiled: reactions under a law with the weight in them": (
        "kernel/c/chain/laws.h",
        "free_x[j] += torque[k] * responses[2 * k * n + j];",
        "free_x[j] = (free_x[j] + 900.0 + torque[k] * responses[2 * k * n + j]) - 900.0;",
    ),
    "compiled: one subtracted from a power": (
        "kernel/c/chain/gravity.h",
        "nearer = q * (3.0 + q * (3.0 + q)) * inverse * s;",
        "nearer = 1.0 - 1.0 / cube;",
    ),
    "compiled: relative places by subtraction": (
        "kernel/c/chain/gravity.h",
        "real x = dx[i] - mean_x, y = dy[i] - mean_y;",
        "real x = (com_x + (dx[i] - mean_x)) - com_x, y = (com_y + (dy[i] - mean_y)) - com_y;",
    ),
}


@needs_kernel
@pytest.mark.parametrize("what", exhaustive_but(SUBTRACTIONS, ["gravity's differences by subtraction"]))
def test_a_cancelling_subtraction_put_back_anywhere_is_seen(what, tmp_path):
    """A copy of the reference with the fault in it is asked for the same digits, in a process of its own."""
    file, old, new = SUBTRACTIONS[what]
    shutil.copytree(ROOT / "reference_impl", tmp_path / "reference_impl")
    path = tmp_path / "reference_impl" / file
    source = path.read_text(encoding="utf-8")
    assert source.count(old) == 1, f"{file} no longer has the line that this fault replaces"
    path.write_text(source.replace(old, new), encoding="utf-8")
    for name in ("barchain", "adapters", "reports", "scenarios", "tests"):
        (tmp_path / name).symlink_to(ROOT / name)
    told = subprocess.run(
        [sys.executable, "-m", "tests.reference.cancellation"], cwd=tmp_path, capture_output=True, text=True,
        check=True, env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )  # fmt: skip
    found = json.loads(told.stdout)
    worst = {quantity: error for own in found.values() for quantity, error in own.items() if error > KEPT}
    assert worst, found
    assert all(("compiled" in quantity) == what.startswith("compiled") for quantity in worst)
