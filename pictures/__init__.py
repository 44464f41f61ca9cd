"""Pictures and generated pages of README, documents and gallery: one command, `python -m pictures`."""
