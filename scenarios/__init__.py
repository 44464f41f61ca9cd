"""Scenes: physics only, from TOML files to validated frozen dataclasses."""

from scenarios.forces import Actuator as Actuator
from scenarios.forces import Axes as Axes
from scenarios.forces import Drag as Drag
from scenarios.forces import Effects as Effects
from scenarios.forces import End as End
from scenarios.forces import Frame as Frame
from scenarios.forces import Gravity as Gravity
from scenarios.forces import Impulse as Impulse
from scenarios.forces import JointSpringDamper as JointSpringDamper
from scenarios.forces import Oblateness as Oblateness
from scenarios.forces import PrescribedRotation as PrescribedRotation
from scenarios.forces import SolarPressure as SolarPressure
from scenarios.forces import ThirdBody as ThirdBody
from scenarios.forces import Thrust as Thrust
from scenarios.load import SHIPPED as SHIPPED
from scenarios.load import SceneError as SceneError
from scenarios.load import load_scene as load_scene
from scenarios.load import nearest as nearest
from scenarios.load import parse_scene as parse_scene
from scenarios.load import scene_names as scene_names
from scenarios.scene import Scene as Scene
from scenarios.toml.file import SceneFile as SceneFile
