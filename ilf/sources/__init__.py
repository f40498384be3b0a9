"""Recordings and data sets behind one interface: `open_source`."""

from .source import Calibration, Source, open_source

__all__ = ["Calibration", "Source", "open_source"]
