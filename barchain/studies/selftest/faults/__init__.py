"""Mistakes that are planted to try the harness: one catalogue for the self-test, benchmarks and tests.

The diagnosis searches a catalogue of its own, `barchain.judge.diagnosis`. Neither imports the other: a diagnosis that
is tried on the mistakes that it searches says nothing.
"""
