"""Looking at depth in numbers: profiles along a line, statistics of a surface, distances and angles in space."""

from .measuring import Measured, angle_between, measure, measurements_csv, place_of
from .profile import DepthProfile, depth_profile
from .statistics import SurfaceStatistics, surface_statistics
from .surfaces import PlaneFit, QuadricFit

__all__ = [
    "DepthProfile",
    "Measured",
    "PlaneFit",
    "QuadricFit",
    "SurfaceStatistics",
    "angle_between",
    "depth_profile",
    "measure",
    "measurements_csv",
    "place_of",
    "surface_statistics",
]
