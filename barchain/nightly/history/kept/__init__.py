"""Records beside the figures of nights: runs, told changes, attributions."""
