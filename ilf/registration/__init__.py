"""Registration: colour and depth of two cameras in one image."""

from .pair import Camera, RawPair

__all__ = ["Camera", "RawPair"]
