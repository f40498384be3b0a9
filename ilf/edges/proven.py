"""Which networks have been tried, by content: the bundled ones, and those of which that is remembered; and which were
looking at an image when the program came to a sudden end."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import cv2

from ..assets import asset_path
from ..io.left_over import MADE_BY, is_dead, made_by
from ..models import models_folder
from ..unfinished import unfinished

_TRIED = ".tried"
"""Folder beside the user's own networks: an empty file for each that has been tried."""

_LOOK = ".look"
"""What files are called there as long as a network looks."""

_LONGEST_LOOK_S = 3600.0

Shapes = dict[str, tuple[int, ...]]
"""Of a network's inputs, by their names."""

_proven: set[str] = set()


def is_bundled(sha256: str) -> bool:
    """Whether a network of this content comes with the program."""
    return sha256 in _bundled()


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
    return is_bundled(sha256) or mark in _proven or (models_folder() / _TRIED / mark).exists()


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


@contextmanager
def looking(sha256: str, kind: str, shapes: Shapes) -> Iterator[None]:
    """As long as the block lasts, a file says what shapes a network's inputs have. A program that is crashed by it
    leaves that file behind."""
    mark = models_folder() / _TRIED / f"{_mark(sha256, kind)}-{made_by()}{_LOOK}"
    with unfinished(mark):
        with suppress(OSError):  # then a crash is not remembered
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.write_text(json.dumps(shapes), encoding="ascii")
        try:
            yield
        finally:
            with suppress(OSError):
                mark.unlink(missing_ok=True)


def last_looks(sha256: str, kind: str) -> list[tuple[Path, Shapes]]:
    """What a network was looking at when programs came to a sudden end: the files that say so, and shapes of inputs."""
    named = re.compile(rf"{re.escape(_mark(sha256, kind))}-{MADE_BY}{re.escape(_LOOK)}")
    found = []
    for path in sorted((models_folder() / _TRIED).glob(f"*{_LOOK}")):
        match = named.fullmatch(path.name)
        with suppress(OSError, ValueError):  # gone meanwhile, or cut short: nobody had begun to look
            if match is not None and (is_dead(match) or time.time() - path.stat().st_mtime > _LONGEST_LOOK_S):
                found.append((path, json.loads(path.read_text(encoding="ascii"))))
    return found


def _mark(sha256: str, kind: str) -> str:
    return f"{sha256}-{kind}-{cv2.__version__}"


@cache
def _bundled() -> frozenset[str]:
    sums = asset_path("models/SHA256SUMS").read_text(encoding="ascii")
    return frozenset(line.split()[0] for line in sums.splitlines())
