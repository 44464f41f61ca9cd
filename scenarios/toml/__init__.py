"""From a TOML file to the tables of a scene: keys, checks, defaults, instants on samples."""
