"""The certified solution's equations evaluated at a single state, rounded to double at the very end."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import heyoka as hy
import numpy as np

from adapters.heyoka.compiled import QUAD, Precision, symbols
from adapters.heyoka.structure import PI, LawShape, Structure
from reference_impl.model.complex_vectors import as_vectors, unit_along
from reference_impl.model.kinematics import bar_centre_vectors
from reference_impl.model.state import Accelerations, State

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel


def shape_of(model: ChainModel) -> Structure:
    """Structure of a chain of the reference's."""
    laws = tuple(LawShape(p.bar, p.frame, p.reacts_on is not None, frozenset({"paper"})) for p in model.prescriptions)
    return Structure(model.bars, model.gravity, laws)


def parameters(model: ChainModel, t_s: float, precision: Precision) -> Array:
    """Parameters of the equations, in SI units."""
    number = precision.number
    mass, half, inertia = ([number(float(x)) for x in a] for a in (model.mass_kg, model.half_m, model.inertia_kg_m2))
    total = sum(mass[1:], mass[0])
    parts = (
        mass,
        [m / total for m in mass],
        half,
        inertia,
        [j + m * h * h for j, m, h in zip(inertia, mass, half, strict=True)],
        [number(3.0) * j / (h * h) for j, h in zip(inertia, half, strict=True)],
    )  # in the order of `BAR`
    found = [number(model.mu_m3_s2), number(model.body_radius_m), *(x for part in parts for x in part)]
    for p in (turn for law in model.prescriptions for turn in law.turns):
        turning = p.start_s < t_s < p.start_s + p.duration_s
        found += [number(PI) / number(p.duration_s), number(p.start_s)]
        found += [number(p.amplitude_rad / 16.0 if turning else 0.0)]
    return np.array(found)


@cache
def compiled(structure: Structure, precision: Precision) -> Any:
    """All accelerations and observables as one function."""
    found = symbols(structure)
    return hy.cfunc(found.rates + found.observables, vars=found.variables, fp_type=precision.type, compact_mode=True)


def certified_accelerations(model: ChainModel, t_s: float, state: State, precision: Precision = QUAD) -> Accelerations:
    """What the reference's `accelerations` gives, by the certified solution's equations."""
    number, n = precision.number, model.bars
    function = compiled(shape_of(model), precision)
    y = np.concatenate([state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s])
    given = {"time": number(t_s)} if function.is_time_dependent else {}
    if function.nparams:
        given["pars"] = parameters(model, t_s, precision)[: function.nparams]
    value = function(np.array([number(float(x)) for x in y]), **given).astype(float)
    angular, seen = value[4 + n : 4 + 2 * n], value[4 + 2 * n :]
    end = model.half_m * unit_along(state.angle_rad) * (1j * angular - state.rate_rad_s**2)
    reaction = seen[: 2 * (n - 1)].reshape(n - 1, 2)
    return Accelerations(value[2:4], angular, bar_centre_vectors(model, as_vectors(end)), reaction, seen[2 * (n - 1) :])
