"""What is worked out once for a frame, or for its colour alone, and kept as long as that is."""

from __future__ import annotations

import dataclasses
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .frame import RGBDFrame

_KEPT = 3
"""Of what a frame is asked for with ever other parameters, so many of the latest are kept."""

P = ParamSpec("P")
T = TypeVar("T")
Owner = TypeVar("Owner")
Colour = NDArray[np.uint8]


def once_per_frame(work_out: Callable[Concatenate[RGBDFrame, P], T]) -> Callable[Concatenate[RGBDFrame, P], T]:
    """The same function with a memory: its arrays, also those in a dataclass or tuple, are read-only. From any thread.

    What it takes beside the frame must be hashable; the latest few such choices are remembered.
    """
    return _once(work_out)


def once_per_image(work_out: Callable[Concatenate[Colour, P], T]) -> Callable[Concatenate[Colour, P], T]:
    """As `once_per_frame`, for what depends on a frame's `rgb` alone: once for all frames with the very same array,
    as those have that `RGBDFrame.distrusting` makes of each other."""
    return _once(work_out)


def _once(work_out: Callable[Concatenate[Owner, P], T]) -> Callable[Concatenate[Owner, P], T]:
    # by identity, since arrays cannot be hashed; the reference takes the entry away when its owner goes
    known: dict[int, tuple[weakref.ref[Any], OrderedDict[Hashable, T]]] = {}
    lock = Lock()

    def of(owner: Owner) -> OrderedDict[Hashable, T]:
        number = id(owner)
        if number not in known:
            known[number] = weakref.ref(owner, lambda _: known.pop(number, None)), OrderedDict()
        return known[number][1]

    @wraps(work_out)
    def remembered(owner: Owner, *args: P.args, **kwargs: P.kwargs) -> T:
        key = args, tuple(sorted(kwargs.items()))
        with lock:
            of_owner = of(owner)
            if key not in of_owner:
                of_owner[key] = work_out(owner, *args, **kwargs)
                _freeze(of_owner[key])
                if len(of_owner) > _KEPT:
                    of_owner.popitem(last=False)
            of_owner.move_to_end(key)
            return of_owner[key]

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
