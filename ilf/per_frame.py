"""What is worked out once for a frame and kept as long as the frame is."""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import Any, Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from .frame import RGBDFrame

_KEPT = 3
"""Of what a frame is asked for with ever other parameters, so many of the latest are kept."""

P = ParamSpec("P")
T = TypeVar("T")


def once_per_frame(work_out: Callable[Concatenate[RGBDFrame, P], T]) -> Callable[Concatenate[RGBDFrame, P], T]:
    """The same function with a memory: its arrays, also those in a dataclass or tuple, are read-only. From any thread.

    What it takes beside the frame must be hashable; the latest few such choices are remembered.
    """
    known: WeakKeyDictionary[RGBDFrame, OrderedDict[Hashable, T]] = WeakKeyDictionary()
    lock = Lock()

    @wraps(work_out)
    def remembered(frame: RGBDFrame, *args: P.args, **kwargs: P.kwargs) -> T:
        key = args, tuple(sorted(kwargs.items()))
        with lock:
            of_frame = known.setdefault(frame, OrderedDict())
            if key not in of_frame:
                of_frame[key] = work_out(frame, *args, **kwargs)
                _freeze(of_frame[key])
                if len(of_frame) > _KEPT:
                    of_frame.popitem(last=False)
            of_frame.move_to_end(key)
            return of_frame[key]

    return remembered


def _freeze(value: Any) -> None:
    """Make arrays read-only."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, tuple):
        for part in value:
            _freeze(part)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            _freeze(getattr(value, field.name))
