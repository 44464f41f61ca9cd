"""Scenes: physics only, from TOML files to validated frozen dataclasses."""

from scenarios.effect_types import Actuator as Actuator
from scenarios.effect_types import Axes as Axes
from scenarios.effect_types import Drag as Drag
from scenarios.effect_types import Effects as Effects
from scenarios.effect_types import End as End
from scenarios.effect_types import Frame as Frame
from scenarios.effect_types import Gravity as Gravity
from scenarios.effect_types import Impulse as Impulse
from scenarios.effect_types import JointSpringDamper as JointSpringDamper
from scenarios.effect_types import Oblateness as Oblateness
from scenarios.effect_types import PrescribedRotation as PrescribedRotation
from scenarios.effect_types import SolarPressure as SolarPressure
from scenarios.effect_types import ThirdBody as ThirdBody
from scenarios.effect_types import Thrust as Thrust
from scenarios.load import SHIPPED as SHIPPED
from scenarios.load import SceneError as SceneError
from scenarios.load import change_scene as change_scene
from scenarios.load import check_scene as check_scene
from scenarios.load import go_on as go_on
from scenarios.load import load_scene as load_scene
from scenarios.load import make_scene as make_scene
from scenarios.load import parse_scene as parse_scene
from scenarios.load import scene_names as scene_names
from scenarios.nearest import nearest as nearest
from scenarios.scene import Scene as Scene
from scenarios.toml.file import SceneFile as SceneFile
