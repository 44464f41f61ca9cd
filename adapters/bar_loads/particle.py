"""A particle that falls with all fields of a scene, in plain floats: the origin of the bars' frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.bar_loads.fields import InversePowerField

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene, ThirdBody


def perturbing_fields(scene: Scene) -> tuple[Callable[[float, float, float], tuple[float, float]], ...]:
    """Fields besides the central body's: acceleration (m/s²) at t (s), x and y (m from its centre)."""
    found = []
    if scene.effects.oblateness:
        from adapters.bar_loads.fields import oblateness_field

        j2 = oblateness_field(scene.central_body.mu_m3_s2, scene.effects.oblateness)
        found.append(lambda t_s, x, y: j2.pull(x, y))  # noqa: ARG005
    return (*found, *(tide(body) for body in scene.effects.third_body))


def tide(body: ThirdBody) -> Callable[[float, float, float], tuple[float, float]]:
    """Third body's acceleration of a particle less that of the central body."""
    from adapters.bar_loads.tides import third_body_position

    pull = InversePowerField(body.mu_m3_s2, 3)

    def field(t_s: float, x: float, y: float) -> tuple[float, float]:
        bx, by = third_body_position(body, t_s)
        return pull.difference(-bx, -by, x, y)

    return field
