"""Faults of the kill matrix, by the part of the engine that they change, and the faulty engine."""
