"""Frames of a sequence with their completed depth, read in the background, and each one's change against another."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.evaluation.flicker import flicker
from ilf.project.facts import present_completion
from ilf.project.recorded_frames import recorded_run
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_frame

from ...project.store import WorkStore
from ...state.entries import Entry
from ...views.view_data import Before, Depth
from ..export.result import BatchResult


@dataclass(frozen=True, eq=False)
class Moment:
    """A frame with its completed depth.

    Attributes
    ----------
    name : str
    place : str or None
        The recording or folder that it is from.
    frame : RGBDFrame
    depth : ndarray of float32, shape (H, W), or None
        Depth out [m], NaN = missing; None if the frame has no result.
    text : str
        How it was completed, if not by a run.
    """

    name: str
    place: str | None
    frame: RGBDFrame
    depth: Depth | None
    text: str = ""

    @classmethod
    def of_open(cls, entry: Entry) -> Self | None:
        """The present state of a frame of the list; None if it is not open. Called in the GUI's thread."""
        document = entry.document
        if document is None:
            return None
        depth = document.current_depth()
        return cls(entry.name, place_of(entry), document.frame, None if depth is None else depth.copy())

    @classmethod
    def read(cls, entry: Entry, store: WorkStore) -> Self:
        """Read a frame of the list that is not open: its stored state, or else its files; for any thread.

        Raises
        ------
        IlfError
            If it cannot be read.
        """
        place = place_of(entry)
        if entry.has_state and store.has(entry.id):
            state = store.state(entry.id).state
            depth = present_completion(state).depth if state.results else None
            return cls(entry.name, place, state.frame, depth)
        source = entry.source or FrameRef(entry.key)
        again = recorded_run(source, store.places)
        if again is None:
            return cls(entry.name, place, read_frame(source), None)
        return cls(entry.name, place, again.run.frame, None if again.completion is None else again.completion.depth)

    def or_of_batch(self, result: BatchResult | None) -> Self:
        """The same frame with the depth that a batch has written, if it has no result of its own."""
        depth = result.read() if result is not None and self.depth is None else None
        return self if depth is None or depth.shape != self.frame.shape else replace(self, depth=depth, text="by batch")

    def since(self, other: Moment | None, gap: int = 1) -> Before:
        """Depth of an earlier frame where this one shows its points: by the poses, or else as of a camera that stands
        still.

        Parameters
        ----------
        other : Moment or None
        gap : int
            How many frames it is before this one.
        """
        if other is None or other.place != self.place:
            return Before(text="This is the first frame of its sequence")
        frame, before = self.frame, other.frame
        if frame.shape != before.shape:
            return Before(text="The frame before has another size")
        motion = None
        if frame.pose is not None and before.pose is not None and frame.intrinsics is not None:
            motion = np.linalg.inv(before.pose) @ frame.pose

        def seen(now: Depth, then: Depth) -> Depth:
            return now - flicker(now, then, frame.intrinsics, motion)

        depth_in = seen(frame.own_depth, before.own_depth)
        depth_out = None if self.depth is None or other.depth is None else seen(self.depth, other.depth)
        how = "as if still" if motion is None else "by poses"
        return Before(depth_in, depth_out, f"{counted(gap, 'frame')} before, {how}")


def place_of(entry: Entry) -> str | None:
    """The recording or the folder of a frame; None if it was not opened from one."""
    source = entry.source
    if source is None:
        return None
    return source.rgb if source.frame is not None else os.path.dirname(source.rgb)
