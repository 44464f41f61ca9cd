"""Report of the cross-validation: verdict, matrix, scenes, differences over time."""
