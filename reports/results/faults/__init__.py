"""Tables of the studies that plant faults."""
