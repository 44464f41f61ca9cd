"""Chapter of the effect budget: relevance and cost of each effect in a scene."""
