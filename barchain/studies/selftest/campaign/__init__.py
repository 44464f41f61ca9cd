"""Random campaign of the self-test: random scenes, all engines, and faults inserted into them."""
