"""Scenes as text, runs as tables and a way to diverge, for files that are judged."""

import numpy as np

from barchain import simulate

TRACK = """
title = "A particle that falls around the Earth"
source = "Kepler's equation"
[central_body]
mu_m3_s2 = 3.986004415e14
[orbit]
altitude_m = 387e3
speed_factor = 1.05
[chain]
bars = 1
mass_kg = 1000.0
length_m = 0.001
angle_deg = 0.0
[effects]
gravity = "point"
[run]
duration_s = 29000.0
samples = 301
"""
DRAG = TRACK.replace("length_m = 0.001", "length_m = 10.0").replace('gravity = "point"', """gravity = "point"
[effects.drag]
density_kg_m3 = 1e-11
altitude_m = 387e3
scale_height_m = 5e4
width_m = 10.0""").replace("duration_s = 29000.0\nsamples = 301", "duration_s = 9000.0\nsamples = 91")  # fmt: skip
HINGED = """
title = "Two bars with a spring and a damper"
source = "closed form"
[orbit]
altitude_m = 350e3
speed_factor = 0.0
[chain]
bars = 2
mass_kg = 3.0
length_m = 2.0
angle_deg = 0.0
rate_factor = 0.0
[effects]
gravity = "none"
[effects.joint_spring_damper]
stiffness_N_m_rad = 5.0
damping_N_m_s_rad = 0.25
[run]
duration_s = 1.0
samples = 11
"""
PANEL = """
title = "A panel at 45 degrees to the Sun, a fifth of the light reflected"
source = "closed form"
[orbit]
altitude_m = 350e3
speed_factor = 0.0
[chain]
bars = 1
mass_kg = 10.0
length_m = 2.0
angle_deg = 90.0
rate_factor = 0.0
[effects]
gravity = "none"
[effects.solar_pressure]
width_m = 1.0
reflectivity = 0.2
sun_longitude_deg = 45.0
sun_rate_rad_s = 0.0
shadow = false
[run]
duration_s = 86400.0
samples = 97
"""


def frame_of(scene, engine="reference", **setting):
    """Table of a run, without what follows from its other columns."""
    found = simulate(scene, engine, **setting).to_frame()
    return found.drop(columns=[name for name in found if name.startswith(("gap", "com_residual", "position"))])


def diverged(frame, kind, growth):
    """Frame whose columns of a kind leave the right ones by a factor e at each sample in its second half."""
    grown = np.exp(growth * np.maximum(np.arange(len(frame)) - len(frame) // 2, 0)) - 1.0
    return frame.assign(**{name: frame[name] * (1.0 + grown) + grown for name in frame if name.startswith(kind)})
