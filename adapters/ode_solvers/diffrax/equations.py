"""The relative formulation in JAX: rates of the state [Z0, Z0', theta, theta'], and joint reactions.

Plane vectors are pairs (x, y) of arrays over the bars or joints. Equation numbers are the paper's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp

if TYPE_CHECKING:
    from scenarios import Scene

Numbers = Any
"""JAX array, or a tracer of one"""
MOST_UNROLLED = 32  # joints; longer chains are eliminated in a loop, whose code does not grow


class JaxChain(NamedTuple):
    """Numbers of a chain."""

    mu_m3_s2: Numbers
    body_radius_m: Numbers
    mass_kg: Numbers
    """(N,)"""
    half_m: Numbers
    """(N,)"""
    inertia_kg_m2: Numbers
    """(N,)"""


class ChainRates(NamedTuple):
    """Accelerations and reactions of one state."""

    com_m_s2: Numbers
    """(2,)"""
    angle_rad_s2: Numbers
    """(N,)"""
    reaction_N: Numbers
    """(N-1, 2) force on bar j from bar j+1"""


def jax_chain(scene: Scene) -> JaxChain:
    """Numbers of a scene's chain."""
    half = [0.5 * length for length in scene.chain.length_m]
    body = scene.central_body
    numbers = (body.mu_m3_s2, body.radius_m, scene.chain.mass_kg, half, scene.chain.inertia_kg_m2)
    return JaxChain(*(jnp.asarray(n, dtype=float) for n in numbers))


def bar_centres(chain: JaxChain, along: Numbers) -> Numbers:
    """Bars' centres from the centre of mass, (N, 2), eqs. (6), (7'); `along` are the unit vectors (N, 2)."""
    reach = chain.half_m[:, None] * along
    from_first = jnp.concatenate([jnp.zeros((1, 2)), jnp.cumsum(reach[:-1] + reach[1:], axis=0)])
    return from_first - (chain.mass_kg / chain.mass_kg.sum()) @ from_first


def unit_vectors(angle_rad: Numbers) -> Numbers:
    """Unit vectors along the bars, (N, 2)."""
    return jnp.stack([jnp.cos(angle_rad), jnp.sin(angle_rad)], axis=-1)


def turned(vector: Numbers) -> Numbers:
    """Plane vectors (..., 2) turned by +90 degrees."""
    return jnp.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def field(chain: JaxChain, gravity: str, com: Numbers, position: Numbers, along: Numbers) -> tuple[Numbers, ...]:
    """Acceleration of the centre of mass (2,), of the bars relative to it (N, 2), eqs. (9) to (14), and K_j/J_j (N,).

    Encke's q keeps all digits of the differences between the bars.
    """
    if gravity == "none":
        return jnp.zeros(2), jnp.zeros_like(position), jnp.zeros_like(chain.half_m)
    square = com @ com
    q = jnp.sum((2.0 * com + position) * position, axis=-1) / square
    change = jnp.expm1(-1.5 * jnp.log1p(q))[:, None]
    pull = -chain.mu_m3_s2 / (square * jnp.sqrt(square))
    difference = pull * (position * (1.0 + change) + com * change)
    mean = (chain.mass_kg / chain.mass_kg.sum()) @ difference
    spin = gradient(chain, com + position, along) if gravity == "gradient" else jnp.zeros_like(chain.half_m)
    return pull * com + mean, difference - mean, spin


def gradient(chain: JaxChain, place: Numbers, along: Numbers) -> Numbers:
    """K_j/J_j of eq. (17) with its sign corrected, (N,)."""
    square = jnp.sum(place * place, axis=-1)
    radial, across = jnp.sum(along * place, axis=-1), jnp.sum(turned(along) * place, axis=-1)
    # the place's component across the bar is minus that of the bar across the radial direction
    return 3.0 * chain.mu_m3_s2 * radial * across / (square * square * jnp.sqrt(square))


def chain_rates(chain: JaxChain, gravity: str, y: Numbers) -> ChainRates:
    """Accelerations and reactions of a state (2N+4,), eqs. (15), (21), (23)."""
    n = chain.half_m.shape[0]
    com, angle, rate = y[:2], y[4 : 4 + n], y[4 + n :]
    along = unit_vectors(angle)
    across = turned(along)
    centre, tide, spin = field(chain, gravity, com, bar_centres(chain, along), along)
    end = chain.half_m[:, None] * (spin[:, None] * across - (rate * rate)[:, None] * along)
    opening = (tide[1:] - tide[:-1]) - (end[:-1] + end[1:])
    reaction = joint_reactions(chain, across, opening)
    padded = jnp.pad(reaction, ((1, 1), (0, 0)))
    sums = padded[1:] + padded[:-1]
    lever = chain.half_m / chain.inertia_kg_m2
    return ChainRates(centre, spin + lever * jnp.sum(across * sums, axis=-1), reaction)


def joint_reactions(chain: JaxChain, across: Numbers, opening: Numbers) -> Numbers:
    """Reactions (N-1, 2) that close the joints, by elimination of 2x2 blocks, eq. (23).

    The blocks are D_j = (1/m_j + 1/m_{j+1}) I + K_j + K_{j+1} and U_j = K_{j+1} - I/m_{j+1}, with K = l²/(4J) n nᵀ.
    """
    joints = across.shape[0] - 1
    if joints == 0:
        return jnp.zeros((0, 2))
    inverse = 1.0 / chain.mass_kg
    k = (chain.half_m**2 / chain.inertia_kg_m2)[:, None, None] * across[:, :, None] * across[:, None, :]
    one = jnp.eye(2)
    diagonal = (inverse[:-1] + inverse[1:])[:, None, None] * one + k[:-1] + k[1:]
    coupling = k - inverse[:, None, None] * one  # of bar j, between joints j-1 and j

    def forward(carry: tuple[Numbers, Numbers], row: tuple[Numbers, ...]) -> tuple[Any, Any]:
        block, right = carry
        own, beside, opened = row
        found = beside @ inverse_2x2(block)
        now = own - found @ beside, opened - found @ right
        return now, now

    def backward(after: Numbers, row: tuple[Numbers, ...]) -> tuple[Numbers, Numbers]:
        block, right, beside = row
        now = inverse_2x2(block) @ (right - beside @ after)
        return now, now

    unroll = joints <= MOST_UNROLLED
    first = (diagonal[0], opening[0])
    _, (blocks, rights) = jax.lax.scan(forward, first, (diagonal[1:], coupling[1:-1], opening[1:]), unroll=unroll)
    blocks, rights = jnp.concatenate([first[0][None], blocks]), jnp.concatenate([first[1][None], rights])
    _, found = jax.lax.scan(backward, jnp.zeros(2), (blocks, rights, coupling[1:]), reverse=True, unroll=unroll)
    return found


def inverse_2x2(block: Numbers) -> Numbers:
    """Inverse of a 2x2 matrix."""
    (a, b), (c, d) = block
    return jnp.array([[d, -b], [-c, a]]) / (a * d - b * c)


def rates(t_s: Numbers, y: Numbers, given: tuple[JaxChain, str]) -> Numbers:
    """Time derivative of a state, as diffrax calls it."""
    del t_s
    chain, gravity = given
    found, n = chain_rates(chain, gravity, y), chain.half_m.shape[0]
    return jnp.concatenate([y[2:4], found.com_m_s2, y[4 + n :], found.angle_rad_s2])


def height(chain: JaxChain, y: Numbers) -> Numbers:
    """Least distance of any point of the chain from the surface, m."""
    n = chain.half_m.shape[0]
    along = unit_vectors(y[4 : 4 + n])
    place = y[:2] + bar_centres(chain, along)
    foot = jnp.clip(-jnp.sum(along * place, axis=-1), -chain.half_m, chain.half_m)
    return jnp.min(jnp.linalg.norm(place + foot[:, None] * along, axis=-1)) - chain.body_radius_m
