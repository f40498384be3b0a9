"""The version, in the one place that has it."""

__version__ = "0.3.0.dev0"
