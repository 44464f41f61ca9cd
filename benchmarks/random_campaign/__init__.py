"""Engines and planted faults on random scenes: drawn scenes, ratings of verdicts, simpler scenes of wrong ones."""
