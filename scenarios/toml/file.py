"""The scene file: all tables together, checked by pydantic, and their JSON Schema."""

from __future__ import annotations

from pydantic import model_validator

from scenarios.toml.checks import check_above_surface, check_effects, check_run_is_bound, check_size
from scenarios.toml.scene_tables import SceneTables
from scenarios.toml.start import check_start


class SceneFile(SceneTables):
    """A barchain scene: a chain of rigid bars joined by revolute joints in the plane of its orbit."""

    @model_validator(mode="after")
    def consistent(self) -> SceneFile:
        """Check what concerns several tables at once."""
        check_size(self)
        check_run_is_bound(self)
        check_above_surface(self)
        check_start(self.chain)
        check_effects(self)
        return self
