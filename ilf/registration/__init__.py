"""Registration: colour and depth of two cameras in one image."""

from .pair import Camera, RawPair
from .registering import register

__all__ = ["Camera", "RawPair", "register"]
