"""The command line's studies, a module each; what they run is imported when they run."""
