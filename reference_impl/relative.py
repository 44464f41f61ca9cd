"""The relative formulation: accelerations and reactions of a state, in O(N) and without cancellation.

Global  Z0'' = g(Z0) + sum mu_k (g_k - g(Z0))                          eqs. (9), (11)
Local   d_j'' = (g_j - g_mean) + (R_j - R_{j-1})/m_j                   eqs. (13), (14)
Turning J_j theta_j'' = K_j + tau_j + (l_j/2) n_j·(R_j + R_{j-1})      eq. (15)
Joints  the ends that a joint ties accelerate alike                    eqs. (19), (21)
"""

from __future__ import annotations

import numpy as np

from reference_impl.chain import Accelerations, Array, ChainModel, Prescription, State
from reference_impl.gravity import field_differences, gradient_torques, point_field
from reference_impl.joints import joint_matrix, solve_joints
from reference_impl.kinematics import cross, directions


def accelerations(model: ChainModel, t_s: float, state: State) -> Accelerations:
    """Accelerations, reactions and torques of a state, eqs. (23), (24) and (27).

    Parameters
    ----------
    model : ChainModel
    t_s : float
        Time, for the prescribed laws.
    state : State
        Need not satisfy the joints exactly: a drifted state is taken as it is.

    Returns
    -------
    Accelerations

    Raises
    ------
    numpy.linalg.LinAlgError
        If the joint system is not positive definite in double precision.
    """
    field, tide, spin = external(model, state)
    turning = Turning(model, state, tide, spin)
    torque = prescribed_torques(model, t_s, state, turning) if model.prescriptions else np.empty(0)
    reaction = turning.reaction(torque)
    angular = turning.angular(reaction, torque)
    return Accelerations(field, angular, tide + turning.pull(reaction), reaction, torque)


def external(model: ChainModel, state: State) -> tuple[Array, Array, Array]:
    """Acceleration of the centre of mass (2,), that of each bar relative to it (N, 2), and K_j/J_j (N,)."""
    bars = model.bars
    if model.gravity == "none":
        return np.zeros(2), np.zeros((bars, 2)), np.zeros(bars)
    difference = field_differences(model.mu_m3_s2, state.com_m, state.position_m)
    mean = model.weight @ difference
    field = point_field(model.mu_m3_s2, state.com_m) + mean
    if model.gravity == "point":
        return field, difference - mean, np.zeros(bars)
    along, _ = directions(state.angle_rad)
    torque = gradient_torques(model, state.com_m + state.position_m, along)
    return field, difference - mean, torque / model.inertia_kg_m2


class Turning:
    """Reactions and angular accelerations of one state, as affine functions of the prescribed torques."""

    def __init__(self, model: ChainModel, state: State, tide: Array, spin: Array) -> None:
        along, across = directions(state.angle_rad)
        self.model, self.across, self.spin = model, across, spin
        # what the ends would do without reactions, from each bar's centre to its right end
        end = model.half_m[:, None] * (spin[:, None] * across - (state.rate_rad_s**2)[:, None] * along)
        right = [(tide[1:] - tide[:-1] - end[:-1] - end[1:]).ravel()]
        right += [self.opening(self.unit_torque(p)).ravel() for p in model.prescriptions]
        solved = solve_joints(joint_matrix(model, across), np.stack(right, axis=-1))
        self.free = solved[:, 0].reshape(-1, 2)
        self.by_torque = np.moveaxis(solved[:, 1:], -1, 0).reshape(len(model.prescriptions), model.bars - 1, 2)

    def unit_torque(self, p: Prescription) -> Array:
        """Angular acceleration (N,) that a unit torque of `p` gives its bar and, through a motor, the neighbour."""
        turned = np.zeros(self.model.bars)
        turned[p.bar] = 1.0 / self.model.inertia_kg_m2[p.bar]
        if p.reacts_on is not None:
            turned[p.reacts_on] = -1.0 / self.model.inertia_kg_m2[p.reacts_on]
        return turned

    def opening(self, angular: Array) -> Array:
        """Acceleration (N-1, 2) at which angular accelerations would close the joints."""
        end = (self.model.half_m * angular)[:, None] * self.across
        return -(end[:-1] + end[1:])

    def reaction(self, torque: Array) -> Array:
        """Reactions (N-1, 2) under the prescribed torques (P,)."""
        if not len(torque):
            return self.free
        total: Array = self.free + np.tensordot(torque, self.by_torque, axes=1)
        return total

    def angular(self, reaction: Array, torque: Array) -> Array:
        """Angular accelerations (N,) under reactions and prescribed torques, eq. (15)."""
        total: Array = self.spin + self.levered(reaction)
        for p, value in zip(self.model.prescriptions, torque, strict=True):
            total = total + value * self.unit_torque(p)
        return total

    def levered(self, reaction: Array) -> Array:
        """Angular accelerations (N,) from the reactions alone."""
        sums = both_ends(reaction)
        turned: Array = self.model.half_m / self.model.inertia_kg_m2 * np.sum(self.across * sums, axis=-1)
        return turned

    def pull(self, reaction: Array) -> Array:
        """Accelerations (N, 2) of the bars' centres from the reactions: (R_j - R_{j-1})/m_j."""
        net = np.zeros((self.model.bars, 2))
        net[:-1] += reaction
        net[1:] -= reaction
        return net * self.model.inverse_mass[:, None]


def both_ends(reaction: Array) -> Array:
    """R_j + R_{j-1} for each bar, shape (N, 2), N; R_0 = R_N = 0."""
    sums = np.zeros((len(reaction) + 1, 2))
    sums[:-1] += reaction
    sums[1:] += reaction
    return sums


def prescribed_torques(model: ChainModel, t_s: float, state: State, turning: Turning) -> Array:
    """Torques (P,) that make each prescribed bar follow its law, eqs. (25)-(27)."""
    laws = model.prescriptions
    free = turning.angular(turning.free, np.zeros(len(laws))), turning.pull(turning.free)
    lacking = [wanted(t_s, state, p) - followed(state, p, *free) for p in laws]
    by_torque = [
        (turning.levered(reaction) + turning.unit_torque(p), turning.pull(reaction))
        for p, reaction in zip(laws, turning.by_torque, strict=True)
    ]
    gained = [[followed(state, p, *response) for response in by_torque] for p in laws]
    # without units of inertia, or pivots picked across bars of very different size lose the light bars' laws
    unit = np.sqrt(model.inertia_kg_m2[[p.bar for p in laws]])
    found: Array = unit * np.linalg.solve(unit[:, None] * np.array(gained) * unit, unit * np.array(lacking))
    return found


def followed(state: State, p: Prescription, angular: Array, pull: Array) -> float:
    """Acceleration of the angle that `p` prescribes, from its bar's and (local horizontal) its longitude's.

    Gravity is central, so of the bar's acceleration only the reactions' share turns its longitude:
    no large numbers meet.
    """
    if not p.local_horizontal:
        return float(angular[p.bar])
    place = state.com_m + state.position_m[p.bar]
    return float(angular[p.bar] - cross(place, pull[p.bar]) / (place @ place))


def wanted(t_s: float, state: State, p: Prescription) -> float:
    """Value that :func:`followed` must take: the law's, and the longitude's share -2 (Z·Z')(Z×Z')/r⁴."""
    law = p.acceleration_rad_s2(t_s)
    if not p.local_horizontal:
        return law
    place, motion = state.com_m + state.position_m[p.bar], state.com_velocity_m_s + state.velocity_m_s[p.bar]
    return float(law - 2.0 * (place @ motion) * cross(place, motion) / (place @ place) ** 2)
