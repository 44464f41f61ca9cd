"""Scenes: physics only, as TOML files, validated into frozen dataclasses."""

from scenarios.effects import Actuator as Actuator
from scenarios.effects import Axes as Axes
from scenarios.effects import Drag as Drag
from scenarios.effects import Effects as Effects
from scenarios.effects import End as End
from scenarios.effects import Frame as Frame
from scenarios.effects import Gravity as Gravity
from scenarios.effects import Impulse as Impulse
from scenarios.effects import JointSpringDamper as JointSpringDamper
from scenarios.effects import Oblateness as Oblateness
from scenarios.effects import PrescribedRotation as PrescribedRotation
from scenarios.effects import SolarPressure as SolarPressure
from scenarios.effects import ThirdBody as ThirdBody
from scenarios.effects import Thrust as Thrust
from scenarios.load import SHIPPED as SHIPPED
from scenarios.load import SceneError as SceneError
from scenarios.load import load_scene as load_scene
from scenarios.load import nearest as nearest
from scenarios.load import parse_scene as parse_scene
from scenarios.load import scene_names as scene_names
from scenarios.scene import Scene as Scene
from scenarios.schema import SceneFile as SceneFile
