"""Forces and torques on each bar, for engines that have bodies but no orbital mechanics.

Written apart from `reference_impl`: an error in one of them is seen in a comparison.
"""
