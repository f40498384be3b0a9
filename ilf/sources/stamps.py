"""Timestamps of frames that were read."""

from __future__ import annotations

import re
from pathlib import Path

from .._runtime.named_places import named_in
from ..data.frame import FrameInputs
from .opening import opened
from .pairing import time_of

_SECONDS = re.compile(r"(\d+)\.(\d{1,9})")


def stamp_of(inputs: FrameInputs, folder: Path | None = None) -> int | None:
    """Return the timestamp of a frame's colour [ns], from its key in a recording, the recording, or its file name; None
    if unknown. `folder` is that of the record that states these inputs.

    Raises
    ------
    InputError
        If the recording has to be read for it and cannot be read; and as `named_in`.
    """
    if inputs.frame is None:
        time = time_of(inputs.rgb.path)
        return None if time is None else round(time * 1e9)
    found = _SECONDS.fullmatch(inputs.frame.rpartition("/")[2])
    if found is not None:
        return int(found[1]) * 10**9 + int(found[2].ljust(9, "0"))
    with opened(inputs.rgb.path if folder is None else named_in(inputs.rgb.path, folder)) as recording:
        taken = recording.frame(inputs.frame).time
    return None if taken is None else round(taken * 1e9)
