"""Chapter of the stability study: outcomes of every engine on hard scenes, and drifts of long runs."""
