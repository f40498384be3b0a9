"""Which networks have been tried, by content: the bundled ones, and those of which that is remembered."""

from __future__ import annotations

from functools import cache

import cv2

from ..assets import asset_path
from ..models import models_folder

_TRIED = ".tried"
"""Folder beside the user's own networks: an empty file for each that has been tried."""

_proven: set[str] = set()


def is_proven(sha256: str, kind: str) -> bool:
    """Whether a network is bundled, or has been tried by this version of the reader.

    Parameters
    ----------
    sha256 : str
        Of its content.
    kind : str
        Which class of network tried it.
    """
    mark = _mark(sha256, kind)
    return sha256 in _bundled() or mark in _proven or (models_folder() / _TRIED / mark).exists()


def remember(sha256: str, kind: str) -> None:
    """Do not try this network again, in this process; nor in later ones, if that can be written down."""
    mark = _mark(sha256, kind)
    _proven.add(mark)
    folder = models_folder() / _TRIED
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / mark).touch()
    except OSError:  # then the next process tries it anew
        return


def _mark(sha256: str, kind: str) -> str:
    return f"{sha256}-{kind}-{cv2.__version__}"


@cache
def _bundled() -> frozenset[str]:
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())
