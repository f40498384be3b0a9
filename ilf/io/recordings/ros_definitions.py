"""Definitions of messages that a ROS recording brings along: those of the kinds that are read must be ROS's own."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ...errors import FormatError

Definitions = Mapping[str, Any]
"""Kind of message -> its constants, and its fields, as rosbags has them."""


def check_definitions(path: Path, brought: Definitions, own: Definitions, kinds: Collection[str]) -> None:
    """That messages of some kinds have all the fields that ROS gives them, those of messages in them too.

    Further fields do not matter.

    Parameters
    ----------
    path : Path
        Of the recording, for the message.
    brought : mapping
        The recording's.
    own : mapping
        ROS's, of its version.
    kinds : collection of str
        Those that the recording has no definition of are not looked at.

    Raises
    ------
    FormatError
        If one has other fields.
    """
    waiting = [kind for kind in kinds if kind in brought]
    seen = set(waiting)
    while waiting:
        kind = waiting.pop()
        there = dict(brought.get(kind, ((), ()))[1])
        for name, form in own[kind][1]:
            if there.get(name) != form:
                raise FormatError(
                    f"{path}: by its own definition, messages of the kind {kind} have no {name} as those of ROS do. "
                    "It is damaged, or of a program with messages of its own."
                )
            new = set(_kinds_in(form)) - seen
            seen |= new
            waiting += new


def _kinds_in(form: Any) -> list[str]:
    """Kinds of messages that a field is made of: its form says what it is, and then of what, and how many."""
    if isinstance(form, tuple):
        return [kind for part in form for kind in _kinds_in(part)]
    return [form] if isinstance(form, str) and "/" in form else []
