"""What several engines need: initial state, Kepler's orbit, equal steps, falling frame, joint coordinates."""
