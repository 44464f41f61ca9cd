"""Equations of motion: kinematics, gravity, joints, and the accelerations of the chain."""
