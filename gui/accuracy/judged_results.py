"""Judging results against the frame's truth, off the GUI's thread: for the frame, blocks and a rectangle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from gui.state.session import Session
from ilf.blocks import Box
from ilf.confidence import expected_error
from ilf.frame import RGBDFrame
from ilf.judgement import Judgement, judge_blocks, judge_completion, shared_pixels
from ilf.outcomes import Completion


@dataclass(frozen=True, eq=False)
class Entry:
    """A result that is judged: the present one, or that of a run.

    Attributes
    ----------
    name : str
    completion : Completion
    frame : RGBDFrame
        That it is of.
    colour : (int, int, int) or None
        Of the run.
    """

    name: str
    completion: Completion
    frame: RGBDFrame
    colour: tuple[int, int, int] | None = None


@dataclass(frozen=True, eq=False)
class Question:
    """What is to be judged.

    Attributes
    ----------
    session : Session
    truth : ndarray of float32, shape (H, W)
        [m], NaN = unknown.
    entries : tuple of Entry
        The first is the present result.
    labels : ndarray of int32, shape (H, W)
        The label map as it is now.
    areas : mapping of str to (tuple of int or Box or None)
        What a part of the frame is called -> labels of blocks, a rectangle, or None for all of it.
    every : bool
        Whether known pixels count, too.
    with_expected : bool
        Whether the share within the expected error is wanted, which takes longer.
    """

    session: Session
    truth: NDArray[np.float32]
    entries: tuple[Entry, ...]
    labels: NDArray[np.int32]
    areas: Mapping[str, tuple[int, ...] | Box | None]
    every: bool
    with_expected: bool


@dataclass(frozen=True, eq=False)
class Answer:
    """What was asked for.

    Attributes
    ----------
    areas : mapping of str to tuple of Judgement
        Part of the frame -> a Judgement for each entry, over what all of them have filled.
    blocks : mapping of int to Judgement
        Label -> Judgement of all that the present result has filled.
    """

    areas: Mapping[str, tuple[Judgement, ...]] = field(default_factory=dict)
    blocks: Mapping[int, Judgement] = field(default_factory=dict)


class Judge:
    """Answers questions, one at a time. What it has found of a completion's expected error it keeps as long as that."""

    def __init__(self) -> None:
        self._expected: WeakKeyDictionary[Completion, NDArray[np.float32]] = WeakKeyDictionary()

    def __call__(self, question: Question) -> Answer:
        """Judge; called off the GUI's thread."""
        present = question.entries[0]
        areas = {}
        shared = shared_pixels([entry.completion for entry in question.entries], every=question.every)
        for name, area in question.areas.items():
            where = shared & _inside(area, question.labels)
            areas[name] = tuple(self._judged(question, entry, where) for entry in question.entries)
        return Answer(areas, judge_blocks(present.frame, present.completion, question.labels))

    def _judged(self, question: Question, entry: Entry, where: NDArray[np.bool_]) -> Judgement:
        expected = self._expected_error(entry) if question.with_expected else self._expected.get(entry.completion)
        frame = entry.frame if entry.frame.truth is question.truth else entry.frame.with_truth(question.truth)
        return judge_completion(frame, entry.completion, where, every=question.every, expected=expected)

    def _expected_error(self, entry: Entry) -> NDArray[np.float32]:
        found = self._expected.get(entry.completion)
        if found is None:
            found = self._expected[entry.completion] = expected_error(entry.frame, entry.completion)
        return found


def _inside(area: tuple[int, ...] | Box | None, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    if area is None:
        return np.ones(labels.shape, bool)
    if not isinstance(area[0], slice):
        return np.isin(labels, area)
    inside = np.zeros(labels.shape, bool)
    inside[area] = True
    return inside
