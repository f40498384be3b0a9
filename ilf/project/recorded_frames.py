"""Folders with a result as frames to work on: the frame that was completed, its blocks, parameters and result."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from .._runtime.files import is_address
from ..data.frame import InputFile, RGBDFrame
from ..errors import InputError
from ..run.record import read_record
from ..run.replaying import Replay, replay
from ..sources.frame_ref import AS_STATED, RECORD_FILE, FrameRef, is_result_folder
from ..sources.reading import read_frame
from .sources import MissingSource, Places, located


def recorded_run(ref: FrameRef, places: Places | None = None) -> Replay | None:
    """The recorded run of a folder with a result, its frame read at its present place; None for any other frame.

    Parameters
    ----------
    ref : FrameRef
    places : Places, optional
        Possible locations of files that were moved.

    Raises
    ------
    MissingSource
        If a file of the frame that was completed is missing or has changed.
    InputError
        For reading options, which the record states, and as `replay`.
    """
    if not is_result_folder(ref):
        return None
    if ref.options != AS_STATED:
        raise InputError(
            f"{ref.rgb} is a result: its frame is read as its run has read it. Leave the reading options out, or give "
            "its colour and its depth file to complete the completed depth again."
        )
    folder = Path(ref.rgb).absolute()
    record = folder / RECORD_FILE
    inputs = read_record(record).inputs
    if inputs is None or is_address(inputs.rgb.path) or is_address(inputs.depth.path):
        return replay(record, extract=False)
    known = replace(places or Places(), folders=(*(places or Places()).folders, folder), stated_in=str(folder))
    pair = (inputs.rgb, inputs.depth) if inputs.frame is None else (InputFile(inputs.rgb.path, ""),)
    return replay(record, *(_present(wanted, known, folder) for wanted in pair), extract=False)


def measured_frame(ref: FrameRef, places: Places | None = None) -> RGBDFrame:
    """Read a frame; of a folder with a result, the frame that was completed. Raises as both functions that it calls."""
    again = recorded_run(ref, places)
    return read_frame(ref) if again is None else again.run.frame


def _present(wanted: InputFile, places: Places, folder: Path) -> Path:
    """The present path of a file of the frame that was completed into a folder."""
    same, other = located(wanted, places)
    if same is not None:
        return same
    places.check(wanted)
    what = f"It belongs to the frame whose result is in {folder}"
    if other is not None and not os.path.samefile(other.parent, folder):  # else it is a file of the result
        raise MissingSource(f"{other} has changed. {what}: restore it, or give its new path.", wanted, other)
    raise MissingSource(f"{wanted.path} no longer exists. {what}: give its new path.", wanted)
