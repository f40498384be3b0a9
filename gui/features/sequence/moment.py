"""Frames of a sequence with their completed depth, read in any thread, and the flicker of one against another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.evaluation.flicker import flicker
from ilf.io.depth import read_depth_values
from ilf.io.encodings import encoding_of
from ilf.project.recorded_frames import recorded_run
from ilf.run.options import DEPTH_FILES
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_frame

from ...project.store import WorkStore
from ...state.workspace import Entry
from ...views.view_data import Before, Depth


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


Due = tuple[int, Callable[[], Moment]]
"""The row of a frame that is to be played, and what reads it; it raises IlfError if it cannot be read."""


def moment_reader(
    entry: Entry, store: WorkStore, written: Callable[[], Depth | None] | None = None
) -> Callable[[], Moment]:
    """Return what reads a frame of the list in any thread: as it is now if it is open, or else its stored state, or
    else its files.

    `written` reads the depth that a batch has written of a frame that has no result of its own. What is returned raises
    IlfError if the frame cannot be read.
    """
    now = None
    if entry.document is not None:
        present = entry.document.current_depth()
        now = entry.document.frame, None if present is None else present.copy()

    def read() -> Moment:
        frame, depth = now or _read(entry, store)
        found = written() if written is not None and depth is None else None
        if found is not None and found.shape == frame.shape:
            return Moment(entry.name, entry.place, frame, found, "by batch")
        return Moment(entry.name, entry.place, frame, depth)

    return read


def _read(entry: Entry, store: WorkStore) -> tuple[RGBDFrame, Depth | None]:
    """Read a frame that is not open, and its completed depth."""
    if entry.has_state and store.has(entry.id):
        state = store.state(entry.id).state
        return state.frame, state.present_completion().depth if state.results else None
    source = entry.source or FrameRef(entry.key)
    again = recorded_run(source, store.places)
    if again is None:
        return read_frame(source), None
    return again.run.frame, None if again.completion is None else again.completion.depth


def written_depth(folder: Path, units: float) -> Depth | None:
    """Read the depth [m] that a batch has written of a frame; None if it was not written.

    Parameters
    ----------
    folder : Path
        That of the frame.
    units : float
        Of a PNG, per metre.

    Raises
    ------
    IlfError
        If it cannot be read.
    """
    for name, per_metre in (("npy", 1.0), ("tiff", 1.0), ("png", units)):
        path = folder / DEPTH_FILES[name]
        if path.exists():
            return encoding_of(per_metre).metres(read_depth_values(path))
    return None
