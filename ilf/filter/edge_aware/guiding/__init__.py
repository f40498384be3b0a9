"""What a frame's guide says in metres, and how far known depth bears it out."""

from .fitted_guide import FittedGuide, fit_guide

__all__ = ["FittedGuide", "fit_guide"]
