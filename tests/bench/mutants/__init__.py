"""Mutation testing: deliberate faults, one at a time, that the tests have to find: `python -m tests.bench.mutants`."""
