"""The chain's equations in any floating-point type, for many states at once: what coordinates cost in digits."""
