"""barchain: a chain of rigid bars in orbit, simulated by many engines and compared honestly."""

from adapters.engine import Engine as Engine
from adapters.engine import EngineError as EngineError
from adapters.engine import Setting as Setting
from adapters.trajectory import Trajectory as Trajectory
from barchain.api import ComparisonResult as ComparisonResult
from barchain.api import SettingError as SettingError
from barchain.api import compare as compare
from barchain.api import simulate as simulate
from scenarios import Scene as Scene
from scenarios import SceneError as SceneError
from scenarios import load_scene as load_scene
