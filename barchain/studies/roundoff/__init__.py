"""The round-off study: digits of the joint reactions in absolute and in relative coordinates."""
