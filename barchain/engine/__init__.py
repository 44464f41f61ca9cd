"""Public interface for authors of engines: the contract, and helpers that most engines need.

An engine is a class derived from :class:`Engine` in a package of its own, registered by an entry point in the group
``barchain.engines``. ``barchain new-engine NAME`` writes such a package, docs/tutorials/your_own_engine.md builds one
step by step, and docs/explanation/engine_conventions.md states the conventions of results.

All quantities are in SI units and radians. N is the number of bars, n the number of samples. Vectors have inertial
components along z1 and z2, and angles count from z1, counter-clockwise, unless a docstring says otherwise.

======================  ============================================================================================
part of an engine       names
======================  ============================================================================================
contract                `Engine`, `EngineError`, `UnsupportedMotionError`, `Setting`, `AccuracyParameter`,
                        `AccuracySweep`, `Coordinates`
results                 `Trajectory`, `Observable`, `Array`, `ENDED`; ``Trajectory.info["steps"]``: steps of the run
scene                   `Scene`, `Chain`, `Orbit`, `CentralBody`, `Run`, `load_scene`
effects                 `Effects`, `Gravity`, `Oblateness`, `ThirdBody`, `Drag`, `SolarPressure`, `JointSpringDamper`,
                        `JointTorque`, `PrescribedRotation`, `Thrust`, `Impulse`, `all_effect_names`
kinds of effects        `End` and `Axes` of thrusts and impulses, `Frame` and `Actuator` of prescribed rotations
start                   `initial_state`, `InitialState`
joint coordinates       `to_joint_coordinates`, `from_joint_coordinates`, `bar_accelerations`, `bar_angles`,
                        `BarsInFrame`
frame                   `free_fall`, `fall_rate`, `orbit_noise`, `kepler_orbit`, `FrameState`
loads                   `ChainForces`, `FORCE_EFFECTS`, `impulse_jumps`, `bars_of`
reactions               `reaction_from_wrench`, `reactions_from_motion`
accuracy                `accuracy_scales`, `AccuracyScales`, `steps_between_samples`, `step_s`
events                  ``scene.effects.breaks_s``: all instants at which an effect is not smooth, s, impulses' ``at_s``
                        among them, which no step may contain; `misalignment`, `events_by_step`, `face_reversal`
landing                 `LandedError`, `landing_text`, `least_height_m`
======================  ============================================================================================
"""

from adapters.bar_loads.chain_loads import SUPPORTED as _SUPPORTED
from adapters.bar_loads.chain_loads import ChainForces
from adapters.bar_loads.falling_frame import fall_rate, free_fall, orbit_noise
from adapters.bar_loads.forces import impulse_jumps
from adapters.bar_loads.gravity import LandedError
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.common.accuracy_scales import AccuracyScales, accuracy_scales
from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.common.face_reversal import unsupported_motion as face_reversal
from adapters.common.initial_state import InitialState, initial_state
from adapters.common.joint_coordinates import (
    BarsInFrame,
    from_joint_coordinates,
    reaction_from_wrench,
    reactions_from_motion,
    to_joint_coordinates,
)
from adapters.common.joint_coordinates import accelerations as bar_accelerations
from adapters.common.joint_coordinates import angles as bar_angles
from adapters.common.kepler import propagate as kepler_orbit
from adapters.common.landing import landing_text, least_height_m
from adapters.common.step_alignment import events_by_step, misalignment
from adapters.engine import (
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
    UnsupportedMotionError,
)
from adapters.trajectory import ENDED, Array, Observable, Trajectory
from scenarios import (
    Actuator,
    Axes,
    Drag,
    Effects,
    End,
    Frame,
    Gravity,
    Impulse,
    JointSpringDamper,
    JointTorque,
    Oblateness,
    PrescribedRotation,
    Scene,
    SolarPressure,
    ThirdBody,
    Thrust,
    load_scene,
)
from scenarios.effect_types import all_effect_names
from scenarios.scene import CentralBody, Chain, Orbit, Run

FORCE_EFFECTS = _SUPPORTED - {"impulse"}
"""Names of the effects that `ChainForces` supports; impulses, which are no forces, have `impulse_jumps`"""

__all__ = [
    "ENDED",
    "FORCE_EFFECTS",
    "AccuracyParameter",
    "AccuracyScales",
    "AccuracySweep",
    "Actuator",
    "Array",
    "Axes",
    "BarsInFrame",
    "CentralBody",
    "Chain",
    "ChainForces",
    "Coordinates",
    "Drag",
    "Effects",
    "End",
    "Engine",
    "EngineError",
    "Frame",
    "FrameState",
    "Gravity",
    "Impulse",
    "InitialState",
    "JointSpringDamper",
    "JointTorque",
    "LandedError",
    "Oblateness",
    "Observable",
    "Orbit",
    "PrescribedRotation",
    "Run",
    "Scene",
    "Setting",
    "SolarPressure",
    "ThirdBody",
    "Thrust",
    "Trajectory",
    "UnsupportedMotionError",
    "accuracy_scales",
    "all_effect_names",
    "bar_accelerations",
    "bar_angles",
    "bars_of",
    "events_by_step",
    "face_reversal",
    "fall_rate",
    "free_fall",
    "from_joint_coordinates",
    "impulse_jumps",
    "initial_state",
    "kepler_orbit",
    "landing_text",
    "least_height_m",
    "load_scene",
    "misalignment",
    "orbit_noise",
    "reaction_from_wrench",
    "reactions_from_motion",
    "step_s",
    "steps_between_samples",
    "to_joint_coordinates",
]
