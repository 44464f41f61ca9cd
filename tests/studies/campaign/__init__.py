"""The random campaign: its scenes are files, its faults change what they say, its rates and its findings are right."""
