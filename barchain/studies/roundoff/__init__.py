"""The round-off study: what absolute and relative coordinates leave of the joint reactions' digits."""
