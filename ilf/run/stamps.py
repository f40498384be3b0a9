"""When the frame of a run was taken."""

from __future__ import annotations

import re

from ..frame import FrameInputs
from ..io.recordings import opened
from ..io.time_names import time_of

_SECONDS = re.compile(r"(\d+)\.(\d{1,9})")


def stamp_of(inputs: FrameInputs) -> int | None:
    """The time of a frame's colour [ns], by its key in a recording, by the recording, or by the name of its file; None
    if it is not known.

    Raises
    ------
    InputError
        If it is in a recording whose keys are no times, and that cannot be read.
    """
    if inputs.frame is None:
        time = time_of(inputs.rgb.path)
        return None if time is None else round(time * 1e9)
    found = _SECONDS.fullmatch(inputs.frame.rpartition("/")[2])
    if found is not None:
        return int(found[1]) * 10**9 + int(found[2].ljust(9, "0"))
    with opened(inputs.rgb.path) as recording:
        taken = recording.frame(inputs.frame).time
    return None if taken is None else round(taken * 1e9)
