"""Frames that are played live, of a recording, a folder or a connected camera; and recording what is played."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from functools import partial
from itertools import chain

from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError
from ilf.io.ros_output import StampedDepth
from ilf.sources.reading import read_frame
from ilf.sources.realsense import camera_pairs
from ilf.sources.registration import register
from ilf.sources.source import Source
from ilf.stream.pacing import USUAL_RATE, rate_of
from ilf.stream.recording import StreamRecorder

from .moment import Due, Moment


def live_frames(path: str | None) -> tuple[float, Generator[Due, None, None]]:
    """Open a recording, a folder, or the connected RealSense camera (None); return its frames a second, and its frames
    as they come, each read already. Called in a worker thread.

    Raises
    ------
    IlfError
        If it cannot be opened.
    """
    if path is None:
        return USUAL_RATE, _captured()
    source = Source(path)
    readers = (partial(read_frame, source.ref(key)) for key in source.keys)
    return rate_of(source.timestamps or ()), _moments(path, readers)


def _captured() -> Generator[Due, None, None]:
    """The frames of the connected camera; the first must be valid."""
    with closing(camera_pairs()) as pairs:
        first = register(next(pairs))
        yield from _moments("RealSense camera", chain([lambda: first], (partial(register, pair) for pair in pairs)))


def _moments(place: str, readers: Iterable[Callable[[], RGBDFrame]]) -> Generator[Due, None, None]:
    """The frames, read as they come; what is yielded for one that cannot be read raises its error."""

    def fail(error: IlfError) -> Moment:
        raise error

    for row, read in enumerate(readers):
        try:
            frame = read()
        except IlfError as error:
            yield row, partial(fail, error)
        else:
            yield row, partial(Moment, frame.name, place, frame, None)


class MomentRecorder:
    """Records frames with their completed depth; it may be closed while another thread writes.

    Parameters
    ----------
    path : str
        As of `StreamRecorder`, with its errors.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._recorder: StreamRecorder | None = StreamRecorder(path)
        self._writing = threading.Lock()

    def write(self, moment: Moment) -> int:
        """Record a frame, unless it has no completed depth; return the number of those recorded. Raises ExportError."""
        with self._writing:
            if self._recorder is None:
                return 0
            if moment.depth is not None:
                frame, stamp = moment.frame, time.time_ns()
                written = StampedDepth(moment.depth, frame.intrinsics, stamp, frame.rgb, None, frame.pose, frame.name)
                self._recorder.write(written)
            return self._recorder.count

    def close(self) -> int:
        """End the recording; return the number of its frames."""
        with self._writing:
            recorder, self._recorder = self._recorder, None
            if recorder is None:
                return 0
            recorder.close()
            return recorder.count
