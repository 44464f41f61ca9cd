"""Self-test of the harness: faults put in on purpose, and the checks that detect them."""
