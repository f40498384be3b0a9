"""Folders of frames and recordings: what frames they have, and a look at the first. Without Qt."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ilf.errors import IlfError
from ilf.frame import RGBDFrame
from ilf.io import META_NAME, Listing, list_frames
from ilf.io.doubts import Doubt
from ilf.io.frame_source import FrameSource
from ilf.io.recordings import is_recording


@dataclass(frozen=True, eq=False)
class FirstLook:
    """What is seen of a folder of frames or a recording before it is opened.

    Attributes
    ----------
    listing : Listing
        Its frames.
    frame : RGBDFrame or None
        The first of them; None if it cannot be read.
    problem : str
        Why it cannot be read; "" if it can.
    doubts : tuple of Doubt
        What speaks against the way that its depth is read.
    """

    listing: Listing
    frame: RGBDFrame | None
    problem: str = ""
    doubts: tuple[Doubt, ...] = ()


def holds_frames(path: str) -> bool:
    """Whether a path is a folder of frames or a recording, by names alone; a frame's own folder is not."""
    return is_recording(path) or (Path(path).is_dir() and not (Path(path) / META_NAME).is_file())


def frames_of(how: FrameSource) -> Listing:
    """The frames of the folder or recording that `how.rgb` is, all read as it says; raises what `list_frames` does."""
    return list_frames(
        how.rgb,
        depth_units=how.depth_units,
        encoding=how.encoding,
        invalid=how.invalid,
        intrinsics=how.intrinsics,
        min_confidence=how.min_confidence,
    )


def look_into(how: FrameSource) -> FirstLook:
    """List the frames and read the first; raises what `list_frames` does."""
    listing = frames_of(how)
    first = listing.sources[0]
    try:
        frame = first.load()
        return FirstLook(listing, frame, doubts=first.read_depth().doubts if frame.notes else ())
    except IlfError as error:
        return FirstLook(listing, None, str(error))
