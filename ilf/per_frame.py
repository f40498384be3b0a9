"""Pictures that are worked out once for a frame and kept as long as the frame is."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from threading import Lock
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from .frame import RGBDFrame

Picture = Callable[[RGBDFrame], NDArray[Any]]


def once_per_frame(work_out: Picture) -> Picture:
    """The same function with a memory: its arrays are read-only. From any thread."""
    known: WeakKeyDictionary[RGBDFrame, NDArray[Any]] = WeakKeyDictionary()
    lock = Lock()

    @wraps(work_out)
    def remembered(frame: RGBDFrame) -> NDArray[Any]:
        with lock:
            if frame not in known:
                picture = np.asarray(work_out(frame))
                picture.flags.writeable = False
                known[frame] = picture
            return known[frame]

    return remembered
