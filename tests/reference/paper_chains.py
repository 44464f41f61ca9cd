"""Random chains, and how far two evaluations of their equations differ, in the scale of the terms that go into them."""

from dataclasses import replace

import numpy as np

from reference_impl.model import relative
from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import Accelerations, State

MU, RADIUS = 3.986004418e14, 6378e3
AGREEMENT = 1e-13  # asked for: 450 units of round-off, for systems whose condition number stays below about 1e4
BLOCKS = ("com_m_s2", "angle_rad_s2", "position_m_s2", "reaction_N", "torque_N_m")
LAWS = {
    "none": (),
    "local, external": (Prescription(-1, (BarTurn(0.8, 60.0, 10.0),), frame="local_horizontal", reacts_on=None),),
    "local, joint": (Prescription(-1, (BarTurn(0.8, 60.0, 10.0),), frame="local_horizontal", reacts_on=-2),),
    "inertial, external": (Prescription(0, (BarTurn(-0.8, 60.0, 10.0),), frame="inertial", reacts_on=None),),
    "inertial, joint": (Prescription(0, (BarTurn(-0.8, 60.0, 10.0),), frame="inertial", reacts_on=1),),
    "both ends": (
        Prescription(0, (BarTurn(0.3, 40.0, 0.0),), frame="inertial", reacts_on=None),
        Prescription(-1, (BarTurn(0.8, 60.0, 10.0),), frame="local_horizontal", reacts_on=-2),
    ),
}


def laws_for(name: str, bars: int) -> tuple[Prescription, ...]:
    """The named laws, with bars counted from the end made definite; those that need more bars fall away."""
    definite = []
    for p in LAWS[name]:
        bar = p.bar % bars
        other = None if p.reacts_on is None else p.reacts_on % bars
        if other != bar and bar not in [q.bar for q in definite]:
            definite.append(replace(p, bar=bar, reacts_on=other))
    return tuple(definite)


def chain(seed: int, bars: int, *, equal: bool, laws: str) -> tuple[ChainModel, State]:
    """Random chain and state; masses and lengths within a factor 4 and 3, orbits up to eccentric."""
    random = np.random.default_rng(seed)
    mass = random.uniform(50.0, 200.0, bars)
    length = np.full(bars, 100.0) if equal else random.uniform(40.0, 120.0, bars)
    inertia = mass * length**2 / 12.0 * random.uniform(0.7, 1.5, bars)
    model = ChainModel(MU, mass, length, inertia, "gradient", RADIUS, laws_for(laws, bars))
    longitude, radius = random.uniform(-np.pi, np.pi), RADIUS * random.uniform(1.05, 3.0)
    radial = np.array([np.cos(longitude), np.sin(longitude)])
    speed = np.sqrt(MU / radius)
    velocity = speed * (
        random.uniform(0.5, 1.4) * np.array([-radial[1], radial[0]]) + random.uniform(-0.5, 0.5) * radial
    )
    angle, rate = random.uniform(-np.pi, np.pi, bars), speed / radius * random.uniform(-2.0, 3.0, bars)
    return model, consistent_state(model, radius * radial, velocity, angle, rate)


def scales(model: ChainModel, state: State, found: Accelerations) -> dict[str, float]:
    """What counts as 1 in each block, see the module's docstring."""
    turn2 = MU / np.linalg.norm(state.com_m) ** 3 + float(np.abs(state.rate_rad_s).max()) ** 2
    length, mass, inertia = model.length_m.max(), model.mass_kg.max(), model.inertia_kg_m2.max()
    natural = dict(zip(BLOCKS, (0.0, turn2, turn2 * length, mass * turn2 * length, inertia * turn2), strict=True))
    return {name: max(natural[name], *np.abs(getattr(found, name)).ravel(), 0.0) for name in BLOCKS}


def disagreement(model: ChainModel, state: State, one: Accelerations, other: Accelerations) -> float:
    """Largest difference over all blocks, in their scales."""
    scale = scales(model, state, other)
    differences = [np.abs(getattr(one, name) - getattr(other, name)).max(initial=0.0) / scale[name] for name in BLOCKS]
    return float(max(differences))


def grip(model: ChainModel, state: State) -> float:
    """Grip of the torques on their angles: least singular value of theta'' by torque, in 1/J; at most 1."""
    if not model.prescriptions:
        return 1.0
    nothing = np.zeros(model.bars, complex), np.zeros(model.bars)
    turning = relative.ReactionSolution(model, state, unit_along(state.angle_rad), *nothing)
    response = [
        turning.rotation_from_reactions(reaction) + turning.rotation_per_unit_torque(p)
        for p, reaction in zip(model.prescriptions, turning.reactions_per_torque, strict=True)
    ]
    driven = [p.bar for p in model.prescriptions]
    scaled = np.array(response).T[driven] * model.inertia_kg_m2[driven][:, None]
    return min(1.0, float(np.linalg.svd(scaled, compute_uv=False).min()))
