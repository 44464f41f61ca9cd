"""Trees of joints in a freely falling frame, for libraries that give accelerations and joint forces of a state."""
