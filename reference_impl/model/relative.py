"""Relative formulation: accelerations and reactions of a state, in O(N) and without cancellation.

Global    Z0'' = g(Z0) + sum mu_k (g_k - g(Z0))                          eqs. (9), (11)
Local     d_j'' = (g_j - g_mean) + (R_j - R_{j-1})/m_j                   eqs. (13), (14)
Rotation  J_j theta_j'' = K_j + tau_j + (l_j/2) n_j·(R_j + R_{j-1})      eq. (15)
Joints    both ends in a joint have equal accelerations                  eqs. (19), (21)

A bar's centre of mass may not be midway: its left end is then alpha_j l_j/2 away from it and its right end
beta_j l_j/2, and (l_j/2) n_j·(beta_j R_j + alpha_j R_{j-1}) turns it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import as_complex, as_vectors, unit_along
from reference_impl.model.effect import EffectState, Modes, total_accelerations
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations, point_field
from reference_impl.model.joints import JointSystem
from reference_impl.model.kinematics import by_levers, cross
from reference_impl.model.state import Accelerations, State

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.chain import ChainModel, Prescription


def accelerations(
    model: ChainModel, t_s: float, state: State, modes: Modes | None = None, *, refine: bool = True
) -> Accelerations:
    """Accelerations, reactions and torques of a state, eqs. (23), (24) and (27).

    Parameters
    ----------
    model : ChainModel
    t_s : float
        Time, for the prescribed laws.
    state : State
        Positions need not satisfy the joints exactly: a state with drift is used unchanged.
    modes : Modes, optional
        Modes of the model's effects; by default they follow from the state.
    refine : bool
        Whether to refine reactions to their last digits. An ill-conditioned chain is always refined. Other chains'
        angular accelerations gain nothing: the last digit of an angle changes them by more.

    Returns
    -------
    Accelerations

    Raises
    ------
    numpy.linalg.LinAlgError
        If the joint system is not positive definite in double precision.
    """
    unit = unit_along(state.angle_rad)
    field, tide, spin = external_accelerations(model, state, unit)
    noncentral_acceleration = None
    if model.effects:
        added, noncentral_acceleration = total_accelerations(
            EffectState(model, t_s, state, unit), modes or (None,) * len(model.effects)
        )
        mean = added.difference @ model.weight
        moved = added.common + mean
        field = field + np.array([moved.real, moved.imag])
        tide, spin = tide + (added.difference - mean), spin + added.angular
    solution = ReactionSolution(model, state, unit, tide, spin, refine=refine)
    torque = (
        prescribed_torques(model, t_s, state, solution, noncentral_acceleration) if model.prescriptions else np.empty(0)
    )
    reaction = solution.reaction(torque)
    return Accelerations(
        field,
        solution.angular_accelerations(reaction, torque),
        as_vectors(tide + solution.translation_from_reactions(reaction)),
        as_vectors(reaction),
        torque,
    )


def external_accelerations(model: ChainModel, state: State, unit: ComplexArray) -> tuple[Array, ComplexArray, Array]:
    """Acceleration of the centre of mass (2,), of each bar relative to the centre of mass (N,), and K_j/J_j (N,)."""
    bars = model.bars
    if model.gravity == "none":
        return np.zeros(2), np.zeros(bars, complex), np.zeros(bars)
    com, position = as_complex(state.com_m), as_complex(state.position_m)
    difference = complex_field_differences(model.mu_m3_s2, com, position)
    mean = difference @ model.weight
    field: Array = point_field(model.mu_m3_s2, state.com_m) + np.array([mean.real, mean.imag])
    if model.gravity == "point":
        return field, difference - mean, np.zeros(bars)
    return field, difference - mean, gradient_angular_accelerations(model, com + position, unit)


class ReactionSolution:
    """Reactions and angular accelerations of one state, as affine functions of the prescribed torques.

    Plane vectors are complex numbers, one for each bar or joint.
    """

    def __init__(
        self,
        model: ChainModel,
        state: State,
        unit: ComplexArray,
        field: ComplexArray,
        spin: Array,
        *,
        refine: bool = True,
    ) -> None:
        """Solve the joint system for zero torque and for a unit of each prescribed torque.

        Parameters
        ----------
        model : ChainModel
        state : State
        unit : ndarray of complex, shape (N,)
            Unit vectors u_j along the bars.
        field : ndarray of complex, shape (N,)
            Accelerations of the bars' centres without reactions, up to a common constant.
        spin : ndarray, shape (N,)
            K_j/J_j.
        refine : bool
            As in :func:`accelerations`.
        """
        self.model, self.unit, self.angular = model, unit, spin
        # accelerations of the right ends relative to the centres, without reactions, of bars with equal levers
        end = model.half_m * unit * (1j * spin - state.rate_rad_s**2)
        right = np.empty((1 + len(model.prescriptions), model.bars - 1), complex)
        of_left, of_right = by_levers(model, end, end)
        right[0] = (field[1:] - field[:-1]) - (of_right[:-1] + of_left[1:])
        for k, p in enumerate(model.prescriptions, start=1):
            turned = 1j * model.half_m * self.rotation_per_unit_torque(p) * unit
            of_left, of_right = by_levers(model, turned, turned)
            right[k] = -(of_right[:-1] + of_left[1:])
        solved = JointSystem(model, unit).solve(right, refine=refine or model.ill_conditioned)
        self.torque_free_reactions: ComplexArray = solved[0]
        self.reactions_per_torque: ComplexArray = solved[1:]

    def rotation_per_unit_torque(self, p: Prescription) -> Array:
        """Angular acceleration (N,) per unit torque of `p`, on its bar and, for a joint motor, on the neighbour."""
        turned = np.zeros(self.model.bars)
        turned[p.bar] = 1.0 / self.model.inertia_kg_m2[p.bar]
        if p.reacts_on is not None:
            turned[p.reacts_on] = -1.0 / self.model.inertia_kg_m2[p.reacts_on]
        return turned

    def reaction(self, torque: Array) -> ComplexArray:
        """Reactions (N-1,) under the prescribed torques (P,)."""
        if not len(torque):
            return self.torque_free_reactions
        total: ComplexArray = self.torque_free_reactions + torque @ self.reactions_per_torque
        return total

    def angular_accelerations(self, reaction: ComplexArray, torque: Array) -> Array:
        """Angular accelerations (N,) under reactions and prescribed torques, eq. (15)."""
        total: Array = self.angular + self.rotation_from_reactions(reaction)
        for p, value in zip(self.model.prescriptions, torque, strict=True):
            total = total + value * self.rotation_per_unit_torque(p)
        return total

    def rotation_from_reactions(self, reaction: ComplexArray) -> Array:
        """Angular accelerations (N,) from the reactions alone: (l_j/2J_j) n_j·(beta_j R_j + alpha_j R_{j-1})."""
        before, after = np.zeros((2, self.model.bars), complex)
        after[:-1] = before[1:] = reaction
        before, after = by_levers(self.model, before, after)
        turned: Array = self.model.lever * (self.unit.conj() * (after + before)).imag
        return turned

    def translation_from_reactions(self, reaction: ComplexArray) -> ComplexArray:
        """Accelerations (N,) of the bars' centres from the reactions: (R_j - R_{j-1})/m_j."""
        net: ComplexArray = np.zeros(self.model.bars, complex)
        net[:-1] += reaction
        net[1:] -= reaction
        pulled: ComplexArray = net * self.model.inverse_mass
        return pulled


def prescribed_torques(
    model: ChainModel,
    t_s: float,
    state: State,
    solution: ReactionSolution,
    noncentral_acceleration: ComplexArray | None = None,
) -> Array:
    """Torques (P,) by which each prescribed bar follows its law, eqs. (25)-(27).

    `noncentral_acceleration` (N,) is the part of the bars' accelerations by effects that are not central.
    """
    asked = np.array([prescribed_angle_acceleration(t_s, state, p) for p in model.prescriptions])
    return torques_for_accelerations(model, state, solution, noncentral_acceleration, asked)


def torques_for_accelerations(
    model: ChainModel,
    state: State,
    solution: ReactionSolution,
    noncentral_acceleration: ComplexArray | None,
    asked: Array,
) -> Array:
    """Torques (P,) that give :func:`actual_angle_acceleration` the values `asked` (P,)."""
    laws = model.prescriptions
    if not laws:
        return np.empty(0)
    pull = solution.translation_from_reactions(solution.torque_free_reactions)
    free = (
        solution.angular_accelerations(solution.torque_free_reactions, np.zeros(len(laws))),
        pull if noncentral_acceleration is None else pull + noncentral_acceleration,
    )
    lacking = [value - actual_angle_acceleration(state, p, *free) for value, p in zip(asked, laws, strict=True)]
    by_torque = [
        (
            solution.rotation_from_reactions(reaction) + solution.rotation_per_unit_torque(p),
            solution.translation_from_reactions(reaction),
        )
        for p, reaction in zip(laws, solution.reactions_per_torque, strict=True)
    ]
    gained = [[actual_angle_acceleration(state, p, *response) for response in by_torque] for p in laws]
    # nondimensional, as pivots chosen across bars of very different size lose the laws of light bars
    unit = np.sqrt(model.inertia_kg_m2[[p.bar for p in laws]])
    found: Array = unit * np.linalg.solve(unit[:, None] * np.array(gained) * unit, unit * np.array(lacking))
    return found


def actual_angle_acceleration(state: State, p: Prescription, angular: Array, pull: ComplexArray) -> float:
    """Acceleration of the angle prescribed by `p`: the bar's, minus the longitude's or that of the bar before.

    Gravity is central. Only reactions and noncentral effects accelerate the bar's longitude, so that no large numbers
    are subtracted.
    """
    if p.frame == "previous_bar":
        return float(angular[p.bar] - angular[p.bar - 1])
    if p.frame == "inertial":
        return float(angular[p.bar])
    place = state.com_m + state.position_m[p.bar]
    return float(angular[p.bar] - (as_complex(place).conj() * pull[p.bar]).imag / (place @ place))


def prescribed_angle_acceleration(t_s: float, state: State, p: Prescription) -> float:
    """Prescribed value of :func:`actual_angle_acceleration`.

    The value is the law's acceleration minus the velocity-dependent part of the longitude's, 2 (Z·Z')(Z×Z')/r⁴.
    """
    law = p.acceleration_rad_s2(t_s)
    if p.frame != "local_horizontal":
        return law
    place, motion = state.com_m + state.position_m[p.bar], state.com_velocity_m_s + state.velocity_m_s[p.bar]
    return float(law - 2.0 * (place @ motion) * cross(place, motion) / (place @ place) ** 2)
