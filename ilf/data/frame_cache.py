"""Frame cache: results computed once for a frame, or for its colour image, and cached as long as that exists."""

from __future__ import annotations

import dataclasses
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar, cast

import numpy as np

from .._runtime.long_work import acquired, check_cancelled

_MAX_VALUES = 3
"""Maximum number of cached results per function and frame, for different parameters; the latest are kept."""

_caches: dict[Callable[..., object], FrameCache[Any, Any]] = {}
"""Cached function -> its cache."""

P = ParamSpec("P")
T = TypeVar("T")
Owner = TypeVar("Owner")


def clear_cached(owner: object, *functions: Callable[..., object]) -> None:
    """Clear the cached results of these functions for a frame, or for a colour image; the next call computes anew."""
    for function in functions:
        _caches[function].clear_cached(owner)


class FrameCache(Generic[Owner, T]):
    """Cache of the latest few values of each owner; arrays in them, also in a dataclass or tuple, are read-only.
    Thread-safe."""

    def __init__(self) -> None:
        self._lock = Lock()
        # by identity, since arrays cannot be hashed; an entry is removed when the reference to its owner dies
        self._known: dict[int, tuple[weakref.ref[Any], OrderedDict[Hashable, T], Lock]] = {}

    def find(self, owner: Owner, key: Hashable) -> T | None:
        """Return the cached value of an owner for a key; None if there is none."""
        with self._lock:
            _, known, _ = self._of(owner)
            if key in known:
                known.move_to_end(key)
            return known.get(key)

    def keep(self, owner: Owner, key: Hashable, value: T) -> T:
        """Cache a value of an owner, and drop the least recently used one."""
        _freeze(value)
        with self._lock:
            _, known, _ = self._of(owner)
            known[key] = value
            known.move_to_end(key)
            if len(known) > _MAX_VALUES:
                known.popitem(last=False)
        return value

    def clear_cached(self, owner: Owner) -> None:
        """Clear all values of an owner."""
        with self._lock:
            self._of(owner)[1].clear()

    def lock_of(self, owner: Owner) -> Lock:
        """Return the lock of an owner, to be held while a value is computed, so that no other thread computes it."""
        with self._lock:
            return self._of(owner)[2]

    def _of(self, owner: Owner) -> tuple[weakref.ref[Any], OrderedDict[Hashable, T], Lock]:
        """The values of an owner, and its lock."""
        number = id(owner)
        if number not in self._known:
            gone = weakref.ref(owner, lambda _: self._known.pop(number, None))
            self._known[number] = gone, OrderedDict(), Lock()
        return self._known[number]


def once_per_frame(compute: Callable[Concatenate[Owner, P], T]) -> Callable[Concatenate[Owner, P], T]:
    """Decorate a function so that its results are cached per frame, its first argument. Arrays in the results, also in
    a dataclass or tuple, are read-only. Thread-safe.

    All arguments besides the frame must be hashable; results for the latest few combinations are cached.
    """
    known = FrameCache[Owner, tuple[()] | tuple[T]]()

    @wraps(compute)
    def cached(owner: Owner, *args: P.args, **kwargs: P.kwargs) -> T:
        key = args, tuple(sorted(kwargs.items()))
        with acquired(known.lock_of(owner)):
            found = known.find(owner, key)
            if found is None:
                check_cancelled()
                made = compute(owner, *args, **kwargs)
                # an owner among its own values would never be freed
                found = known.keep(owner, key, () if made is owner else (made,))
                check_cancelled()
            return found[0] if found else cast(T, owner)

    _caches[cached] = known
    return cached


once_per_image = once_per_frame
"""The same for functions of a frame's `rgb` alone: once for all frames that share the array, such as those made by
`RGBDFrame.with_invalid_mask`."""


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
