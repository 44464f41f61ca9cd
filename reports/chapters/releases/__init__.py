"""Chapter of the study of releases: an engine against its release."""
