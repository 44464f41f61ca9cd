"""Which of the shipped scenes a test goes through."""

from scenarios import scene_names

ALL = scene_names()
GROUNDED = ("published/pendulum", "published/acrobot")
"""Chains on a bar of 1e12 kg: with that ratio of masses Exudyn's redundant coordinates lose the light bars"""
TAME = [name for name in ALL if not name.startswith(("hard/", "conform/")) and name not in GROUNDED]
"""Those that every engine runs and is judged by; hard ones and those of conformance have tests of their own"""
HARD = [name for name in ALL if name.startswith("hard/")]
MANY = ("bars_100", "bars_1000", "bars_10000", "whip", "long_1000", "long_10000")
STIFF = ("springs_stiff", "damping_heavy")
UNTOLD = [f"hard/{name}" for name in MANY + STIFF]
"""Too many bars or orbits for a certified solution of thirty digits, or too stiff for its explicit steps: judged by
closed forms, by what they conserve and by each other's form"""
TOLD = [name for name in ALL if name not in UNTOLD]
