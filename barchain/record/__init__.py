"""Records of results: environment, sources, engines and scenes."""
