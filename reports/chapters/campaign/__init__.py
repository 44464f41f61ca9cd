"""Chapter of the random campaign: rates of false alarms and of missed faults."""
