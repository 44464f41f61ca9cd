"""Plan of a night: a TOML file that names studies, their scenes and engines, and their shares of the time."""
