"""Drag and light on the faces of flat bars."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, final

from adapters.exudyn.loads.interface import ExudynLoad, directions_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.inertial_view import InertialView
    from adapters.exudyn.frames.numbers import Number
    from adapters.exudyn.loads.interface import BarForce
    from adapters.trajectory import Array
    from scenarios import Scene


@final
class ExudynDrag(ExudynLoad):
    """Free-molecular drag in an exponential atmosphere that rotates."""

    def __init__(self, scene: Scene) -> None:
        drag = scene.effects.drag
        assert drag is not None
        self.drag = drag
        self.radius = scene.central_body.radius_m + drag.altitude_m
        self.length = scene.chain.length_m

    def load(self, bar: int, view: InertialView, _inputs: Sequence[Number], xp: Any) -> BarForce:
        """Integrals along the bar, as in docs/effects/drag.md."""
        length = self.length[bar]
        second, fourth = length**3 / 12.0, length**5 / 80.0
        t, v = self.wind(view)
        w = view.rate_rad_s - self.drag.rotation_rad_s
        slope = view.along_m / (xp.sqrt(view.square_m2) * self.drag.scale_height_m)
        push = -0.5 * self.drag.width_m[bar] * self.density(view, xp) * xp.sign(v)
        normal = self.drag.normal_coefficient * push
        along = self.drag.tangential_coefficient * push * t * (length * v - slope * second * w)
        across = normal * (length * v * v + second * w * (w - 2.0 * slope * v))
        torque = normal * (2.0 * second * v * w - slope * (second * v * v + fourth * w * w))
        return *view.to_frame(along, across), torque

    def wind(self, view: InertialView) -> tuple[Number, Number]:
        """Velocity of a bar's centre relative to the air, along the bar and normal to it, m/s."""
        turning = self.drag.rotation_rad_s
        return view.to_bar(view.vx_m_s + turning * view.y_m, view.vy_m_s - turning * view.x_m)

    def density(self, view: InertialView, xp: Any) -> Number:
        """Density in kg/m³ at the bar's centre; the altitude is a quotient without cancellation."""
        square = view.square_m2
        height = (square - self.radius**2) / (xp.sqrt(square) + self.radius)
        return self.drag.density_kg_m3 * xp.exp(height * (-1.0 / self.drag.scale_height_m))


@final
class ExudynSunlight(ExudynLoad):
    """Sunlight without shadow: a force, uniform along the bar."""

    time_input_count = 2

    def __init__(self, scene: Scene, frame: ReferenceFrame) -> None:
        sun = scene.effects.solar_pressure
        assert sun is not None
        self.sun, self.frame = sun, frame
        widths = zip(sun.width_m, scene.chain.length_m, strict=True)
        self.push = [-sun.pressure_Pa * width * length for width, length in widths]

    def time_inputs(self, at_s: Array, _inside_s: Array) -> Array:
        """Direction to the Sun in the frame's axes."""
        return directions_of(self.frame, at_s, self.sun.sun_longitude_rad + self.sun.sun_rate_rad_s * at_s)

    def load(self, bar: int, view: InertialView, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -P b l |n·s| ((1 - rho) s + 2 rho (n·s) n)."""
        x, y = inputs
        _, facing = view.to_bar(x, y)
        even = self.push[bar] * xp.abs(facing)
        mirror = 2.0 * self.sun.reflectivity * facing
        matt = 1.0 - self.sun.reflectivity
        return even * (matt * x - mirror * view.sine), even * (matt * y + mirror * view.cosine), None
