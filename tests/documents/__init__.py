"""README and documents: paths, commands and scenes in them exist, and everything that they show is carried out."""
