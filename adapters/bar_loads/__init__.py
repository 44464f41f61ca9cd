"""Forces and torques on each bar, for engines that have bodies but no orbital mechanics.

Derived independently of `reference_impl`, so that a comparison detects an error in either.
"""
