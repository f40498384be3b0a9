"""Pictures that are worked out once for a frame and kept as long as the frame is."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import Any, Concatenate, ParamSpec
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from .frame import RGBDFrame

P = ParamSpec("P")
Picture = Callable[Concatenate[RGBDFrame, P], NDArray[Any]]


def once_per_frame(work_out: Picture[P]) -> Picture[P]:
    """The same function with a memory: its arrays are read-only. From any thread.

    What it takes beside the frame must be hashable; there is one picture for each.
    """
    known: WeakKeyDictionary[RGBDFrame, dict[Hashable, NDArray[Any]]] = WeakKeyDictionary()
    lock = Lock()

    @wraps(work_out)
    def remembered(frame: RGBDFrame, *args: P.args, **kwargs: P.kwargs) -> NDArray[Any]:
        key = args, tuple(sorted(kwargs.items()))
        with lock:
            pictures = known.setdefault(frame, {})
            if key not in pictures:
                picture = np.asarray(work_out(frame, *args, **kwargs))
                picture.flags.writeable = False
                pictures[key] = picture
            return pictures[key]

    return remembered
