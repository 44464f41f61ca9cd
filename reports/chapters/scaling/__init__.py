"""Chapter of the scaling study: cost against the number of bars."""
