"""Frames of a video by their number."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ...extras import optional
from ..images import check_pixel_count

_FAR = 60
"""Frames after which a jump by the next key frame is likely sooner than decoding what lies between."""


class Video:
    """The first video track of a file, open. Frames that follow one another are decoded as they come.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If the package that reads it is not installed.
    FormatError
        If it is no video, or damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._av = optional("av", "sequences", "Reading video")
        with self._reading():
            self._container = self._av.open(str(path))
        try:
            if not self._container.streams.video:
                raise FormatError(f"{path} has no video track. Is this the right file?")
            self._stream = self._container.streams.video[0]
            self.size: tuple[int, int] = self._stream.codec_context.width, self._stream.codec_context.height
            check_pixel_count(path, *self.size)
        except BaseException:
            self.close()
            raise
        self._times: list[int] | None = None
        self._coming: Iterator[tuple[Any, str]] | None = None
        self._next = 0

    def close(self) -> None:
        """Let go of the file."""
        self._container.close()

    def frame(self, number: int) -> tuple[NDArray[np.uint8], str]:
        """A frame, by its number from 0: uint8 (h, w, 3), red first, as it is stored, never rotated; and the SHA-256 of
        its own bytes in the file.

        Raises
        ------
        FormatError
            If there is no such frame, or it cannot be decoded.
        """
        times = self._frame_times()
        if number >= len(times):
            raise FormatError(f"{self.path} has {len(times)} frames, and none of number {number}: it is cut short.")
        with self._reading():
            if self._coming is None or not 0 <= number - self._next < _FAR:
                self._container.seek(times[number], stream=self._stream)
                self._coming = self._decoded()
            for image, sha256 in self._coming:
                if image.pts == times[number]:
                    self._next = number + 1
                    return image.to_ndarray(format="rgb24"), sha256
        self._coming = None
        raise FormatError(f"{self.path}: frame {number} cannot be decoded: the video is damaged there.")

    def _frame_times(self) -> list[int]:
        """Presentation times of all frames, in their order; the packets are passed over, not decoded."""
        if self._times is None:
            with self._reading():
                packets = self._container.demux(self._stream)
                self._times = sorted(packet.pts for packet in packets if packet.pts is not None)
        return self._times

    def _decoded(self) -> Iterator[tuple[Any, str]]:
        """Frames from where the file stands, with the hashes of their packets."""
        hashes: dict[int, str] = {}
        for packet in self._container.demux(self._stream):
            if packet.pts is not None:
                hashes[packet.pts] = hashlib.sha256(bytes(packet)).hexdigest()
            for image in packet.decode():
                if image.pts in hashes:
                    yield image, hashes.pop(image.pts)

    @contextmanager
    def _reading(self) -> Iterator[None]:
        problems: Any = self._av.FFmpegError
        try:
            yield
        except (problems, ValueError, MemoryError, EOFError) as error:
            raise FormatError(f"{self.path}: this video cannot be read ({error!s:.80}). Copy it again.") from error
