"""A whole run compiled by XLA, kept for runs of the same shape in the same process."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from adapters.ode_solvers.diffrax import equations

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.ode_solvers.diffrax.equations import JaxChain, Numbers

jax.config.update("jax_enable_x64", True)

ATOL_SHARE = 1e-3  # absolute tolerance over `rtol`, as of the other libraries' solvers
EVENT_TOLERANCE = 1e-12  # of the instant at the surface
MOST_STEPS = 100_000  # diffrax shortens the steps of a state that is not finite without end; a run takes some hundred
STAGES = 13  # of Dopri8, whose last stage is the next step's first


class Shape(NamedTuple):
    """Everything about a run that its compiled code depends on."""

    bars: int
    gravity: str
    samples: int
    surface: bool


class Solved(NamedTuple):
    """Results of a compiled run."""

    y: Numbers
    """(samples, 2N+4); infinite after the surface"""
    end_s: Numbers
    """(1,)"""
    steps: Numbers
    """Accepted and rejected ones"""
    accepted: Numbers
    failed: Numbers
    """Whether diffrax reports a failure"""


def solve(shape: Shape, chain: JaxChain, y0: Numbers, t_s: Numbers, rtol: Numbers) -> Solved:
    """Integrate over the samples (samples,)."""
    given = chain, shape.gravity
    subs = [diffrax.SubSaveAt(ts=t_s), diffrax.SubSaveAt(t1=True)]
    found = diffrax.diffeqsolve(
        diffrax.ODETerm(lambda t, y, _: equations.rates(t, y, given)),
        diffrax.Dopri8(),
        t_s[0],
        t_s[-1],
        None,
        y0,
        saveat=diffrax.SaveAt(subs=subs),
        stepsize_controller=diffrax.PIDController(rtol=rtol, atol=ATOL_SHARE * rtol),
        event=surface_event(chain) if shape.surface else None,
        max_steps=MOST_STEPS,
        throw=False,
    )
    assert found.ys is not None
    assert found.ts is not None
    good = diffrax.is_successful(found.result) | diffrax.is_event(found.result)
    stats = found.stats
    return Solved(found.ys[0], found.ts[1], stats["num_steps"], stats["num_accepted_steps"], ~good)


def surface_event(chain: JaxChain) -> diffrax.Event:
    """Event that ends a run at the surface."""

    def above(t: Numbers, y: Numbers, args: Any, **_: Any) -> Numbers:
        del t, args
        return equations.height(chain, y)

    return diffrax.Event(above, optimistix.Bisection(EVENT_TOLERANCE, EVENT_TOLERANCE), direction=False)


def double(values: Any) -> Numbers:
    """JAX array in double precision."""
    return jnp.asarray(values, dtype=jnp.float64)


@cache
def compiled_run(shape: Shape) -> Callable[..., Solved]:
    """Run of a shape, compiled here."""
    n = shape.bars
    chain = equations.JaxChain(*(double(np.ones(size)) for size in ((), (), n, n, n)))
    arguments = chain, double(np.ones(2 * n + 4)), double(np.arange(shape.samples)), double(1.0)
    made: Callable[..., Solved] = jax.jit(lambda *given: solve(shape, *given)).lower(*arguments).compile()
    return made


@cache
def compiled_reactions(shape: Shape) -> Callable[..., Numbers]:
    """Reactions (samples, N-1, 2) at states, compiled on first use."""
    found: Callable[..., Numbers] = jax.jit(
        jax.vmap(lambda chain, y: equations.chain_rates(chain, shape.gravity, y).reaction_N, in_axes=(None, 0))
    )
    return found
