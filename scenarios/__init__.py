"""Scenes: physics only, as TOML files, validated into frozen dataclasses."""

from scenarios.load import SHIPPED as SHIPPED
from scenarios.load import SceneError as SceneError
from scenarios.load import load_scene as load_scene
from scenarios.load import nearest as nearest
from scenarios.load import parse_scene as parse_scene
from scenarios.load import scene_names as scene_names
from scenarios.scene import Actuator as Actuator
from scenarios.scene import Effects as Effects
from scenarios.scene import Frame as Frame
from scenarios.scene import Gravity as Gravity
from scenarios.scene import PrescribedRotation as PrescribedRotation
from scenarios.scene import Scene as Scene
from scenarios.schema import SceneFile as SceneFile
