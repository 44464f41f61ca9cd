"""The scene file: all tables together, checked by pydantic, and their JSON Schema."""

from __future__ import annotations

from pydantic import model_validator

from scenarios.toml.checks import check_all
from scenarios.toml.scene_tables import SceneTables


class SceneFile(SceneTables):
    """A barchain scene: a chain of rigid bars joined by revolute joints in the plane of its orbit."""

    @model_validator(mode="after")
    def consistent(self) -> SceneFile:
        """Check what concerns several tables at once."""
        if self.orbit is None:
            raise ValueError("orbit: missing")
        faults = list(check_all(self))
        if faults:
            raise ValueError("\n".join(faults))
        return self
