"""Where blocks and depth look wrong: places to go to next, and known depth to distrust."""

from .carried import carried_places
from .distrust import suggest_distrust
from .place import KINDS, Place
from .ranking import suspicious_places

__all__ = ["KINDS", "Place", "carried_places", "suggest_distrust", "suspicious_places"]
