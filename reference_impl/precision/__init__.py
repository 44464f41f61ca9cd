"""The chain's equations in any floating-point type, for many states at once: round-off errors of each formulation."""
