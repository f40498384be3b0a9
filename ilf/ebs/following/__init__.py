"""Blocks of one frame carried to the next."""

from .follow import Followed, follow

__all__ = ["Followed", "follow"]
