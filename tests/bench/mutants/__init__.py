"""Deliberate faults, one at a time, which the tests have to find: `python -m tests.bench.mutants`."""
