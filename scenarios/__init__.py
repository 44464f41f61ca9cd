"""Scenes: physics only, as TOML files, validated into frozen dataclasses."""

from scenarios.effect import Actuator as Actuator
from scenarios.effect import Axes as Axes
from scenarios.effect import Drag as Drag
from scenarios.effect import Effects as Effects
from scenarios.effect import End as End
from scenarios.effect import Frame as Frame
from scenarios.effect import Gravity as Gravity
from scenarios.effect import Impulse as Impulse
from scenarios.effect import JointSpringDamper as JointSpringDamper
from scenarios.effect import Oblateness as Oblateness
from scenarios.effect import PrescribedRotation as PrescribedRotation
from scenarios.effect import SolarPressure as SolarPressure
from scenarios.effect import ThirdBody as ThirdBody
from scenarios.effect import Thrust as Thrust
from scenarios.load import SHIPPED as SHIPPED
from scenarios.load import SceneError as SceneError
from scenarios.load import load_scene as load_scene
from scenarios.load import nearest as nearest
from scenarios.load import parse_scene as parse_scene
from scenarios.load import scene_names as scene_names
from scenarios.scene import Scene as Scene
from scenarios.schema import SceneFile as SceneFile
