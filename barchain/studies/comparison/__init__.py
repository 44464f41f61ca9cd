"""Scenes times engines: the comparison of `barchain compare` and `barchain crossval`, its store and its methodology."""
