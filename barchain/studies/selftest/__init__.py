"""Self-test of the harness: faults inserted on purpose, and the checks that detect them."""
