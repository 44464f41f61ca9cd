"""The chain as an Exudyn system: rigid bodies with joints, or a kinematic tree."""
