"""Thumbnails of frames, made in the background when their rows are visible."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Generator, Hashable
from contextlib import suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QImage, QPixmap

from ilf._runtime.files import FileContent
from ilf.errors import FormatError, IlfError, InputError
from ilf.io.images import read_colour
from ilf.sources.frame_folder import frame_folder
from ilf.sources.frame_ref import FrameRef
from ilf.sources.opening import opened

from ...state.workspace import Entry
from ...views.drawings import rgb_image
from ...work.jobs import Worker

# Thumbnail of a frame's colour image.

THUMBNAIL_WIDTH = 160


def read_thumbnail(source: FrameRef) -> NDArray[np.uint8]:
    """Read a thumbnail of the colour image of a frame that is not open, uint8 (h, `THUMBNAIL_WIDTH`, 3).

    Raises
    ------
    InputError, FormatError
        As `ilf.io.images.read_colour`, and from a recording.
    """
    source = source.allowed()
    if source.frame is not None:
        with opened(source.rgb) as recording:
            return thumbnail_of(recording.colour(source.frame))
    path = frame_folder(source.rgb).rgb if source.depth is None else source.rgb
    return thumbnail_of(read_colour(path, THUMBNAIL_WIDTH))


_MOST_HEIGHT = 8
"""Maximum height of a thumbnail, in widths."""


def stored_thumbnail(content: bytes) -> NDArray[np.uint8]:
    """The thumbnail that a project contains, which may be any image; raises FormatError if it cannot be read."""
    return thumbnail_of(read_colour(FileContent(Path("thumbnail"), np.frombuffer(content, np.uint8))))


def thumbnail_of(rgb: NDArray[Any]) -> NDArray[np.uint8]:
    """Resize a colour image, uint8 (H, W, 3), to `THUMBNAIL_WIDTH` pixels; one that is far higher is shortened.

    Examples
    --------
    >>> thumbnail_of(np.zeros((480, 640, 3), np.uint8)).shape
    (120, 160, 3)
    """
    width = THUMBNAIL_WIDTH
    height = min(max(round(width * rgb.shape[0] / rgb.shape[1]), 1), _MOST_HEIGHT * width)
    small = cv2.resize(np.ascontiguousarray(rgb), (width, height), interpolation=cv2.INTER_AREA)
    return small.astype(np.uint8, copy=False)


def reader_of(entry: Entry, stored: Callable[[str], bytes | None]) -> Callable[[], NDArray[np.uint8]]:
    """Return a function that makes the thumbnail of a frame of the list, in any thread, of its open image, what is
    stored for its id, or its files; it raises IlfError if there is none."""
    document, id, source = entry.document, entry.id, entry.source
    rgb = None if document is None else document.frame.rgb

    def read() -> NDArray[np.uint8]:
        if rgb is not None:
            return thumbnail_of(rgb)
        if (content := stored(id)) is not None:
            with suppress(FormatError):
                return stored_thumbnail(content)
        if source is None:
            raise InputError("There is no picture of this frame.")
        return read_thumbnail(source)

    return read


MAX_THUMBNAILS = 600
"""Maximum number of thumbnails in memory: about 45 MB."""

_MAX_PENDING = 60
"""Maximum number of pending requests; older ones have been scrolled out of view."""


class Thumbnails(QObject):
    """Thumbnails by key, made in the background when they are first asked for.

    Signals
    -------
    arrived()
        More thumbnails are available.
    """

    arrived = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._made: OrderedDict[Hashable, QPixmap | None] = OrderedDict()
        """None while it is pending or being made."""
        self._pending: OrderedDict[Hashable, Callable[[], NDArray[np.uint8]]] = OrderedDict()
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take)
        self._worker.finished.connect(lambda _: self._start())
        self._worker.failed.connect(lambda _: self._start())

    def of(self, key: Hashable, read: Callable[[], NDArray[np.uint8]]) -> QPixmap | None:
        """Return a thumbnail; None while it is pending, an empty one if it cannot be made. `read` makes it in a worker
        thread."""
        if key not in self._made:
            self._made[key] = None
            self._pending[key] = read
            if len(self._pending) > _MAX_PENDING:
                self._made.pop(self._pending.popitem(last=False)[0], None)
            self._start()
        self._made.move_to_end(key)
        return self._made[key]

    def _start(self) -> None:
        if self._pending and not self._worker.busy:
            self._worker.start(self._make)

    def _make(self) -> Generator[tuple[Hashable, QImage], None, None]:
        """Make the requested thumbnails, the latest request first: its row is visible."""
        while True:
            try:
                key, read = self._pending.popitem()
            except KeyError:
                return
            image = QImage()
            with suppress(IlfError, OSError, cv2.error):
                image = rgb_image(read())
            yield key, image

    def _take(self, batch: list[tuple[Hashable, QImage]]) -> None:
        for key, image in batch:
            self._made[key] = QPixmap.fromImage(image)
        while len(self._made) > MAX_THUMBNAILS:
            self._made.popitem(last=False)
        self.arrived.emit()
