"""Invariants that every run of the reference must keep, with bounds from the requested accuracy of each step.

The checks detect crashes, nonsense and lost digits in any scene. They may miss wrong physics: under gravity, a step may
change the energy of the centre of mass by more than the whole energy of the bars' relative motion. The comparison and
the self-test detect wrong physics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.reference_model import chain_model
from barchain.judge.scales import MACHINE_EPSILON, ROUNDINGS
from barchain.metrics.quantities import conserved
from reference_impl.model import invariants
from reference_impl.model.joints import DIVERGED
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import accelerations
from scenarios import Actuator, Frame

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

FEW = 10.0  # largest component of a step's error relative to its norm, which is controlled
SHAKES = 4  # number of perturbations of all angles in their last digits
ROUNDED = 64.0 * MACHINE_EPSILON  # of the terms that an invariant is summed from


def broken(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """First violated check of a finished run of the reference, in one line; empty if there is none.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        With attitude and rates, from an engine with the step control of `reference`.
    rtol : float
        Requested accuracy of each step, relative.
    """
    for check in (not_numbers, open_joints, lost_energy, lost_momentum, left_law, other_reactions):
        found = check(scene, trajectory, rtol)
        if found:
            return found
    return ""


def not_numbers(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find values that are not finite."""
    del scene, rtol
    for name, value in vars(trajectory).items():
        if isinstance(value, np.ndarray) and not np.all(np.isfinite(value)):
            return f"{name} is not finite"
    return ""


def open_joints(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find open joints: places follow from the angles, so gaps and eq. (6) are round-off of sums over the bars."""
    del rtol
    if trajectory.gap_m is None or trajectory.com_residual_m is None:
        return ""
    allowed = ROUNDINGS * MACHINE_EPSILON * scene.size_m * scene.bars
    gap, residual = trajectory.gap_m.max(initial=0.0), trajectory.com_residual_m.max()
    return (
        ""
        if max(gap, residual) <= allowed
        else f"gap {gap:.3g} m, centre-of-mass residual {residual:.3g} m, allowed {allowed:.3g} m"
    )


def other_reactions(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find reactions that differ from the NumPy form at the same states by more than refinement and round-off explain.

    Round-off is that of the forces, and the response of the reactions to the last digits of the angles. Scenes with
    prescribed rotations are skipped: their torques and reactions are differences of larger numbers.
    """
    del rtol
    if trajectory.reaction_N is None or scene.bars == 1 or scene.effects.prescribed_rotation:
        return ""
    model, (angle, rate) = chain_model(scene), attitude(trajectory)
    wound = bent_J(scene) * float(np.abs(angle).max()) / min(scene.chain.length_m)
    for k, t in enumerate(trajectory.t_s):
        try:
            own = reactions_at(model, trajectory, k, angle[k])
        except np.linalg.LinAlgError:  # at the limit of double precision one form may fail and the other not
            return ""
        tide = scene.central_body.mu_m3_s2 / float(np.linalg.norm(trajectory.com_m[k])) ** 3
        forces = scene.mass_kg * scene.size_m * (tide + float(np.abs(rate[k]).max()) ** 2) + wound
        off = float(np.abs(own - trajectory.reaction_N[k]).max())
        allowed = 2.0 * DIVERGED * np.abs(own).max() + ROUNDED * forces
        if not off <= allowed:  # rarely: therefore the angles are perturbed only here
            allowed += FEW * moved_by_last_digits(model, trajectory, k, own)
        if not off <= allowed:
            return f"reactions off by {off:.3g} N at t = {t:.6g} s, allowed {allowed:.3g} N"
    return ""


def reactions_at(model: ChainModel, trajectory: Trajectory, k: int, angle_rad: Array) -> Array:
    """Reactions of the NumPy form at sample k with other angles, (N-1, 2), N."""
    state = consistent_state(
        model, trajectory.com_m[k], trajectory.com_velocity_m_s[k], angle_rad, attitude(trajectory)[1][k]
    )
    return accelerations(model, float(trajectory.t_s[k]), state).reaction_N


def moved_by_last_digits(model: ChainModel, trajectory: Trajectory, k: int, own: Array) -> float:
    """Largest change of the reactions at sample k by the last digits of the angles with random signs, N.

    Stiff springs turn light bars so fast that round-off of their directions loads heavy neighbours. The change is
    infinite if the joint system becomes singular.
    """
    angle = attitude(trajectory)[0][k]
    drawn = np.random.default_rng(k).choice([-1.0, 1.0], (SHAKES, len(angle)))
    try:
        shaken = [reactions_at(model, trajectory, k, angle + sign * np.spacing(np.abs(angle))) for sign in drawn]
    except np.linalg.LinAlgError:
        return np.inf
    return float(max(np.abs(found - own).max() for found in shaken))


def lost_energy(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find a change of energy beyond its gradient times the requested accuracy of each step."""
    if not conserved(scene).energy:
        return ""
    model, (angle, rate) = chain_model(scene), attitude(trajectory)
    kinetic = invariants.relative_kinetic_energy(model, angle, rate)
    energy, terms = kinetic.copy(), [kinetic]
    if conserved(scene).relative:
        com = 0.0
    else:
        terms += [0.5 * scene.mass_kg * squared(trajectory.com_velocity_m_s), weight_J(scene, trajectory)]
        energy += invariants.com_energy(model, trajectory.com_m, trajectory.com_velocity_m_s)
        energy += invariants.tidal_energy(model, trajectory.com_m, angle)
        com = scene.mass_kg * com_gradient(scene, trajectory)
    for effect in model.effects:
        terms.append(effect.energy(model, trajectory.com_m, angle))
        energy = energy + terms[-1]
    scale_s = scene_rate(scene)
    spun = np.sqrt(2.0 * kinetic.max() * scene.mass_kg) * scene.size_m  # bounds a momentum conjugate to an angle
    turned = spun * (scale_s + 2.0 * np.abs(rate).max()) + bent_J(scene) + tide_J(scene, trajectory)
    allowed = FEW * steps(trajectory) * rtol * (com + scene.bars * turned) + ROUNDED * walk(trajectory) * biggest(terms)
    off = float(np.abs(energy - energy[0]).max())
    return "" if off <= allowed else f"energy off by {off:.3g} J, allowed {allowed:.3g} J"


def lost_momentum(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find a change of angular momentum beyond its gradient times the requested accuracy of each step."""
    if not conserved(scene).angular_momentum:
        return ""
    model, (angle, rate) = chain_model(scene), attitude(trajectory)
    momentum = invariants.relative_angular_momentum(model, angle, rate)
    size = scene.mass_kg * scene.size_m**2
    terms, com = [np.full(len(momentum), size * np.abs(rate).max())], 0.0
    if not conserved(scene).relative:
        terms.append(invariants.com_angular_momentum(model, trajectory.com_m, trajectory.com_velocity_m_s))
        momentum = momentum + terms[-1]
        speed, distance = np.sqrt(squared(trajectory.com_velocity_m_s).max()), np.sqrt(squared(trajectory.com_m).max())
        com = scene.mass_kg * scene.radius0_m * (speed + distance * scene_rate(scene))
        terms.append(np.full(len(momentum), scene.mass_kg * speed * distance))
    turned = size * (scene_rate(scene) + np.abs(rate).max())
    allowed = FEW * steps(trajectory) * rtol * (com + scene.bars * turned) + ROUNDED * walk(trajectory) * biggest(terms)
    off = float(np.abs(momentum - momentum[0]).max())
    return "" if off <= allowed else f"angular momentum off by {off:.3g} N m s, allowed {allowed:.3g} N m s"


def left_law(scene: Scene, trajectory: Trajectory, rtol: float) -> str:
    """Find bars off a law in inertial axes; errors of a rate grow linearly with time."""
    angle, _ = attitude(trajectory)
    for p in scene.effects.prescribed_rotation:
        if p.frame is not Frame.INERTIAL or p.actuator is not Actuator.EXTERNAL:
            continue
        law = angle[0, p.bar - 1] + np.array([p.law(t)[0] - p.law(0.0)[0] for t in trajectory.t_s])
        off = float(np.abs(angle[:, p.bar - 1] - law).max())
        allowed = FEW * steps(trajectory) * (rtol + ROUNDED) * (1.0 + scene_rate(scene) * trajectory.t_s[-1])
        if off > allowed:
            return f"bar {p.bar} is {off:.3g} rad off its law, allowed {allowed:.3g} rad"
    return ""


def attitude(trajectory: Trajectory) -> tuple[Array, Array]:
    """Angles and rates, (n, N)."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    return trajectory.angle_rad, trajectory.rate_rad_s


def steps(trajectory: Trajectory) -> float:
    """Number of steps."""
    return 1.0 + float(trajectory.info["steps"])


def walk(trajectory: Trajectory) -> float:
    """Sum of round-off over the steps relative to one step, as a random walk."""
    return float(np.sqrt(steps(trajectory)))


def scene_rate(scene: Scene) -> float:
    """Rate that scales the requested accuracy of rates, rad/s: the largest of the circular orbit's and the bars'."""
    circular = np.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m**3)
    own = [abs(a) * scene.orbital_rate_rad_s for a in scene.chain.rate_factor]
    laws = [abs(p.law(0.0)[1]) for p in scene.effects.prescribed_rotation]
    return float(max(circular, *own, *laws, scene.orbital_rate_rad_s))


def com_gradient(scene: Scene, trajectory: Trajectory) -> float:
    """Change of the centre of mass's energy for errors of one radius and of one radius times the rate, J/kg."""
    pull = scene.central_body.mu_m3_s2 / squared(trajectory.com_m).min()
    speed = np.sqrt(squared(trajectory.com_velocity_m_s).max())
    return float(scene.radius0_m * (pull + speed * scene_rate(scene)))


def weight_J(scene: Scene, trajectory: Trajectory) -> Array:
    """Absolute potential energy, (n,) J."""
    found: Array = scene.mass_kg * scene.central_body.mu_m3_s2 / np.sqrt(squared(trajectory.com_m))
    return found


def tide_J(scene: Scene, trajectory: Trajectory) -> float:
    """Bound of the tidal energy, and of its change per radian, J."""
    if conserved(scene).relative:
        return 0.0
    nearest = np.sqrt(squared(trajectory.com_m).min())
    return float(3.0 * scene.mass_kg * scene.central_body.mu_m3_s2 * scene.size_m**2 / nearest**3)


def bent_J(scene: Scene) -> float:
    """Change of the springs' energy per radian, at one radian, J."""
    springs = scene.effects.joint_spring_damper
    return 0.0 if springs is None else 2.0 * sum(springs.stiffness_N_m_rad)


def squared(vectors: Array) -> Array:
    """Squares of vectors (n, 2)."""
    found: Array = np.sum(vectors**2, axis=-1)
    return found


def biggest(terms: list[Array]) -> float:
    """Largest value of any term."""
    return float(max(np.abs(term).max() for term in terms))
