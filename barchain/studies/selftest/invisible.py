"""Numerical proof of invisibility: equations with and without a fault, at every state of the reference solution.

All that a run shows follows from the accelerations, reactions and torques of the states it goes through. Trajectories
themselves tell less: the first steps are chosen by an error estimate that is nothing but rounding, and two runs whose
equations differ in the last digit part by what their steps then leave.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from barchain.faults.catalogue import CONTROLS, UNMODIFIED
from barchain.judge.scales import MACHINE_EPSILON, ROUNDINGS
from reference_impl.model import relative
from reference_impl.model.kinematics import consistent_state

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.faults.fault import Fault
    from barchain.solutions.reference import ReferenceSolution

COMPARED = ("com_m_s2", "angle_rad_s2", "reaction_N", "torque_N_m")


def moved_beyond_rounding(solution: ReferenceSolution, fault: Fault, size: float) -> float:
    """Largest change of the equations' results by a fault, over their round-off.

    The control's own rounding is what it differs by from the relative formulation, beside a few units in the last
    place of the largest value: sums such as phi'' + omega'' round the parts, which are larger than the sum.
    """
    faulty, control = evaluated(solution, fault, size), evaluated(solution, CONTROLS[fault.like], 0.0)
    unmodified = evaluated(solution, CONTROLS[UNMODIFIED], 0.0)
    shares = [0.0]
    for name, right in control.items():
        allowed = ROUNDINGS * MACHINE_EPSILON * largest(right) + largest(right - unmodified[name])
        apart = largest(faulty[name] - right)
        shares.append(0.0 if apart == 0.0 else apart / allowed)
    return max(shares)


def evaluated(solution: ReferenceSolution, fault: Fault, size: float) -> dict[str, Array]:
    """Results of the equations with a fault in the code, at the reference solution's samples."""
    model, seen = chain_model(solution.scene), solution.trajectory
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    moving = zip(seen.t_s, seen.com_m, seen.com_velocity_m_s, seen.angle_rad, seen.rate_rad_s, strict=True)
    with fault.within(size):
        found = [relative.accelerations(model, t, consistent_state(model, *state)) for t, *state in moving]
    return {name: np.array([getattr(a, name) for a in found]) for name in COMPARED}


def largest(values: Array) -> float:
    """Largest absolute value; 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))
