"""Chapter on the cross-validation: matrix, scenes, differences over time."""
