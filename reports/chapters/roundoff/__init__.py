"""Chapter of the round-off study: errors in absolute and relative coordinates."""
