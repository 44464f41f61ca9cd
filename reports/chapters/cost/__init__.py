"""Chapter of the cost study: work-precision diagrams and the cost of one more digit."""
