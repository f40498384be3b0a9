"""Rows of peers from an earlier result: what does not change with this program needs not be run again."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..errors import FormatError, InputError
from ..io.files import read_json
from ..sections import Section
from .methods import METHODS
from .rows import Row, TaskFacts


@dataclass(frozen=True)
class EarlierRows:
    """What an earlier bench found of methods that look at no blocks.

    Attributes
    ----------
    path : str
        The file that it is from.
    methods : tuple of str
    rows : mapping
        (pattern, frame, method) -> Row.
    sha256 : mapping
        (pattern, frame) -> `TaskFacts.sha256`.
    """

    path: str
    methods: tuple[str, ...]
    rows: Mapping[tuple[str, str, str], Row]
    sha256: Mapping[tuple[str, str], str]

    def of(self, facts: TaskFacts) -> dict[str, Row]:
        """Method -> row of what was given then as it is now.

        Raises
        ------
        InputError
            If the frame was not among them, or the methods were given, or scored on, anything else.
        """
        what = f"{facts.frame}, pattern {facts.pattern}"
        known = self.sha256.get((facts.pattern, facts.frame))
        if known is None:
            raise InputError(
                f"{self.path} has no rows of {what}. Take its frames and patterns, or run the peers again."
            )
        if known != facts.sha256:
            raise InputError(
                f"{self.path} does not fit {what}: then, methods were given other colour or depth, or other pixels "
                "were hidden. Take its seed, or run the peers again."
            )
        return {method: self.rows[facts.pattern, facts.frame, method] for method in self.methods}


def read_earlier(path: str | os.PathLike[str], methods: Sequence[str]) -> EarlierRows:
    """Read those methods of a result that need not be run again: peers that look at no blocks.

    Their expected errors are taken over as they were worked out then.

    Parameters
    ----------
    path : path-like
        Written by `write_json`.
    methods : sequence of str
        Those that are to be compared now.

    Raises
    ------
    InputError
        If there is no such file, or it has none of those methods.
    FormatError
        If it is no result of this bench.
    """
    content = read_json(path)
    try:
        result = Section("result", content)
        rows = [Row(**Section("row", row).fields(Row)) for row in result.items("rows", dict)]
        tasks = [TaskFacts(**Section("task", task).fields(TaskFacts)) for task in result.items("tasks", dict)]
    except (FormatError, TypeError) as error:
        raise FormatError(
            f"{path} is no result that `ilf bench --json` of this version has written ({error!s:.120})."
        ) from error
    found = {row.method for row in rows}
    taken = tuple(method for method in methods if method in found and not METHODS[method].needs_blocks)
    if not taken:
        raise InputError(f"{path} has no rows of any peer that is to be compared.")
    return EarlierRows(
        str(path),
        taken,
        {(row.pattern, row.frame, row.method): row for row in rows},
        {(task.pattern, task.frame): task.sha256 for task in tasks},
    )
