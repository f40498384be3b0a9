"""What is worked out once for a frame, or for its colour alone, and kept as long as that is."""

from __future__ import annotations

import dataclasses
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from threading import Lock
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import check_stopped, taking
from .frame import RGBDFrame

_KEPT = 3
"""Of what a frame is asked for with ever other parameters, so many of the latest are kept."""

_memories: dict[Callable[..., object], Memory[Any, Any]] = {}
"""Function that remembers -> what it knows."""

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


def forget(owner: object, *functions: Callable[..., object]) -> None:
    """Give up what such functions know of a frame, or of a colour; who asks again waits again."""
    for function in functions:
        _memories[function].forget(owner)


class Memory(Generic[Owner, T]):
    """What is known of owners, of each the latest few; arrays in it, also in a dataclass or tuple, are read-only. From
    any thread."""

    def __init__(self) -> None:
        self._lock = Lock()
        # by identity, since arrays cannot be hashed
        self._known: dict[int, _Known[T]] = {}

    def find(self, owner: Owner, key: Hashable) -> T | None:
        """What is known of an owner under a key; None if nothing is."""
        with self._lock:
            known = self._of(owner).values
            if key in known:
                known.move_to_end(key)
            return known.get(key)

    def keep(self, owner: Owner, key: Hashable, value: T) -> T:
        """Know something of an owner, and no longer what was asked for least lately."""
        _freeze(value)
        with self._lock:
            known = self._of(owner).values
            known[key] = value
            known.move_to_end(key)
            if len(known) > _KEPT:
                known.popitem(last=False)
        return value

    def forget(self, owner: Owner) -> None:
        """Know nothing of an owner any more."""
        with self._lock:
            self._of(owner).values.clear()

    def lock_of(self, owner: Owner) -> Lock:
        """What whoever works something out about an owner may hold, so that nobody else does it at the same time."""
        with self._lock:
            return self._of(owner).lock

    def _of(self, owner: Owner) -> _Known[T]:
        number = id(owner)
        if number not in self._known:
            self._known[number] = _Known(weakref.ref(owner, lambda _: self._known.pop(number, None)))
        return self._known[number]


@dataclasses.dataclass(frozen=True, eq=False)
class _Known(Generic[T]):
    """What is known of one owner, which the reference takes away when the owner goes."""

    owner: weakref.ref[Any]
    values: OrderedDict[Hashable, T] = dataclasses.field(default_factory=OrderedDict)
    lock: Lock = dataclasses.field(default_factory=Lock)


def _once(work_out: Callable[Concatenate[Owner, P], T]) -> Callable[Concatenate[Owner, P], T]:
    known = Memory[Owner, tuple[T]]()

    @wraps(work_out)
    def remembered(owner: Owner, *args: P.args, **kwargs: P.kwargs) -> T:
        key = args, tuple(sorted(kwargs.items()))
        with taking(known.lock_of(owner)):
            found = known.find(owner, key)
            if found is None:
                check_stopped()
                found = known.keep(owner, key, (work_out(owner, *args, **kwargs),))
                check_stopped()
            return found[0]

    _memories[remembered] = known
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
