"""Drawing a cloud at two speeds: as much as there is time for while it moves, all of it when it is at rest."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QImage

from ilf.drawing.clouds import Look, Splat, splat, splat_in_steps

from ...work.jobs import Worker
from .scene import Points, Rgb, Scene, empty_scene

# How much of a cloud is drawn while it moves, by what drawing takes on this machine. No widgets.

MOVING_S = 0.03
"""Time that a frame of a moving cloud may take."""

_POINT_S = 12e-9
_PIXEL_S = 22e-9
"""What a point and a pixel of the picture take on a usual machine."""

_LADDER = ((1, 1 << 62), (1, 400_000), (2, 400_000), (2, 150_000), (3, 100_000), (4, 50_000))
"""From fine to coarse: side of a pixel of the picture in pixels of the screen, and most points."""

_LEAST, _MOST = 0.2, 20.0
_SETTLED = 0.8
_WEIGHT = 0.3


class Detail:
    """Chooses from a ladder of pictures, from whole to coarse, the finest that is quick enough.

    How quick this machine is follows from the pictures that have been drawn; finer ones are taken up again only when
    there is time to spare, so that the picture does not change to and fro.
    """

    def __init__(self) -> None:
        self._slowness = 1.0
        """Time over what a usual machine takes."""
        self._rung = 0

    def choose(self, points: int, pixels: int) -> tuple[int, int]:
        """For a cloud of so many points on so many pixels of the screen: the side of a pixel of the picture, and how
        many points to draw."""
        costs = [_cost(min(points, most), pixels / side**2) for side, most in _LADDER]
        fitting = [rung for rung, cost in enumerate(costs) if self._slowness * cost <= MOVING_S]
        best = fitting[0] if fitting else len(_LADDER) - 1
        if best < self._rung and self._slowness * costs[best] > _SETTLED * MOVING_S:
            best = self._rung
        self._rung = best
        side, most = _LADDER[best]
        return side, min(points, most)

    def note(self, seconds: float, points: int, pixels: float) -> None:
        """Drawing so many points on so many pixels of the picture took that long."""
        found = seconds / _cost(points, pixels)
        self._slowness += _WEIGHT * (min(max(found, _LEAST), _MOST) - self._slowness)


def _cost(points: int, pixels: float) -> float:
    return _POINT_S * points + _PIXEL_S * pixels


# The picture of all of a cloud, drawn off the GUI's thread when the view is at rest.


class WholePicture(QObject):
    """Draws one picture at a time, the last that was asked for; one that nobody wants any more is given up on its way.

    Signals
    -------
    drawn(object, object, object)
        Scene, look, and their picture.
    failed(object)
        The exception that kept a picture from being drawn.
    """

    drawn = Signal(object, object, object)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker = Worker(self)
        self._worker.finished.connect(self._take)
        self._worker.cancelled.connect(self._start)
        self._worker.failed.connect(self._fail)
        self._wanted: tuple[Scene, Look] | None = None
        self._present: tuple[Scene, Look] | None = None

    @property
    def busy(self) -> bool:
        """Whether a picture is to come."""
        return self._wanted is not None

    def ask(self, scene: Scene, look: Look) -> None:
        """Draw a cloud; `drawn` follows unless something else is asked for before."""
        if self._present is not None and self._present[0] is scene and self._present[1] == look:
            return
        self._wanted = scene, look
        if self._worker.busy:
            self._present = None
            self._worker.cancel()
        else:
            self._start()

    def drop(self) -> None:
        """No picture is wanted."""
        self._wanted = self._present = None
        self._worker.cancel()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._wanted = None
        return self._worker.shutdown()

    def _start(self) -> None:
        self._present = self._wanted
        if self._present is None:
            return
        scene, look = self._present
        self._worker.start(partial(splat_in_steps, scene.points, scene.colouring.colours, look, scene.spacing))

    def _take(self, splat: Splat) -> None:
        if self._present is None:
            return
        scene, look = self._present
        self._wanted = self._present = None
        self.drawn.emit(scene, look, splat)

    def _fail(self, error: Exception) -> None:
        self._wanted = self._present = None
        self.failed.emit(error)


REST_MS = 120
"""All of the cloud is drawn when the view has not moved for this long."""


@dataclass(frozen=True, eq=False)
class _Picture:
    """What has been drawn, of what; `side` is that of its pixels on the screen, and `some` are the points that were
    drawn, None if those were all."""

    image: QImage
    scene: Scene
    look: Look
    nearest: NDArray[np.int32]
    side: int = 1
    some: NDArray[np.intp] | None = None


@dataclass(frozen=True, eq=False)
class _Few:
    """Some of a scene's points, spread evenly."""

    some: NDArray[np.intp]
    points: Points
    colours: Rgb


class CloudDrawing(QObject):
    """The picture of a cloud as it is looked at.

    Signals
    -------
    ready()
        All of the cloud has been drawn.
    failed(object)
        The exception that kept it from being drawn.
    """

    ready = Signal()
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.scene = empty_scene()
        self.detail = Detail()
        self._look: Look | None = None
        self._picture: _Picture | None = None
        self._few: _Few | None = None
        self._is_due = False
        """Whether the next picture is drawn at once."""
        self._whole = WholePicture(self)
        self._whole.drawn.connect(self._take_whole)
        self._whole.failed.connect(self.failed)
        self._rest = QTimer(self, singleShot=True, interval=REST_MS)
        self._rest.timeout.connect(self._ask_whole)

    def set_scene(self, scene: Scene) -> None:
        """Draw another cloud from the next look on."""
        self.scene, self._few = scene, None
        if not len(scene):
            self._picture = None
            self.pause()

    def look(self, look: Look, moving: bool) -> None:
        """Look at the cloud so, in pixels of the screen. What is shown stays until all of it has been drawn, unless the
        cloud is moving or all of it can be drawn at once."""
        self._look = look
        at_once = self.detail.choose(len(self.scene), look.width * look.height) == (1, len(self.scene))
        if moving or at_once or self._picture is None:
            self._whole.drop()
            self._is_due = True
        else:
            self._ask_whole()

    def image(self) -> QImage | None:
        """The picture as it is to be shown now, scaled to the screen; None without a cloud."""
        if self._look is not None and len(self.scene) and (self._is_due or self._picture is None):
            self._draw_now(self._look)
        return None if self._picture is None else self._picture.image

    @property
    def is_whole(self) -> bool:
        """Whether the picture is of all of the cloud, as it is looked at now."""
        picture = self._picture
        if picture is None or self._is_due or picture.scene is not self.scene:
            return False
        return picture.some is None and picture.look == self._look

    def finish(self) -> None:
        """Draw all of the cloud at once, for those who cannot wait."""
        if self._look is not None and len(self.scene) and not self.is_whole:
            scene = self.scene
            drawn = splat(scene.points, scene.colouring.colours, self._look, scene.spacing)
            self._take_whole(scene, self._look, drawn)

    def point_at(self, x: float, y: float, reach: float) -> int | None:
        """Index of the point seen at a place [px of the screen], or nearest to it within a reach; None if none is."""
        picture = self._picture
        if picture is None or picture.scene is not self.scene:
            return None
        column, row, around = int(x / picture.side), int(y / picture.side), max(round(reach / picture.side), 1)
        top, left = max(row - around, 0), max(column - around, 0)
        near = picture.nearest[top : row + around + 1, left : column + around + 1]
        rows, columns = np.nonzero(near >= 0)
        if not len(rows):
            return None
        closest = int(np.argmin((rows + top - row) ** 2 + (columns + left - column) ** 2))
        index = int(near[rows[closest], columns[closest]])
        return index if picture.some is None else int(picture.some[index])

    def pause(self) -> None:
        """Draw nothing while nobody looks."""
        self._rest.stop()
        self._whole.drop()

    def resume(self) -> None:
        """Go on with what was not drawn when it was paused."""
        if not self.is_whole:
            self._rest.start()

    @property
    def busy(self) -> bool:
        """Whether all of the cloud is to come."""
        return self._rest.isActive() or self._whole.busy

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._rest.stop()
        return self._whole.shutdown()

    def _draw_now(self, look: Look) -> None:
        scene, total = self.scene, len(self.scene)
        side, count = self.detail.choose(total, look.width * look.height)
        coarse = look if side == 1 else _coarse(look, side)
        few = None if count == total else self._few_points(count)
        begun = time.perf_counter()
        if few is None:
            drawn = splat(scene.points, scene.colouring.colours, coarse, scene.spacing)
        else:
            drawn = splat(few.points, few.colours, coarse, scene.spacing * math.sqrt(total / count))
        self.detail.note(time.perf_counter() - begun, count, coarse.width * coarse.height)
        some = None if few is None else few.some
        self._picture = _Picture(_image_of(drawn), scene, coarse, drawn.nearest, side, some)
        self._is_due = False
        if not self.is_whole:
            self._rest.start()

    def _few_points(self, count: int) -> _Few:
        if self._few is None or len(self._few.some) != count:
            # one at random out of each run of points: a fixed stride beats with the image's rows and shows stripes
            total = len(self.scene)
            starts = np.linspace(0, total, count, endpoint=False)
            some = (starts + np.random.default_rng(0).random(count) * (total / count)).astype(np.intp)
            self._few = _Few(some, self.scene.points[some], self.scene.colouring.colours[some])
        return self._few

    def _ask_whole(self) -> None:
        if self._look is not None and len(self.scene):
            self._whole.ask(self.scene, self._look)

    def _take_whole(self, scene: Scene, look: Look, drawn: Splat) -> None:
        if scene is self.scene and look == self._look:
            self._picture = _Picture(_image_of(drawn), scene, look, drawn.nearest)
            self._few = None
            self._is_due = False
            self.ready.emit()


def _coarse(look: Look, side: int) -> Look:
    """The same look with pixels of that many pixels of the screen a side."""
    size = None if look.point_size is None else max(round(look.point_size / side), 1)
    return replace(look, width=max(look.width // side, 1), height=max(look.height // side, 1), point_size=size)


def _image_of(drawn: Splat) -> QImage:
    height, width = drawn.nearest.shape
    borrowed = QImage(drawn.picture.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    # the conversion copies, so the image outlives the array
    return borrowed.convertToFormat(QImage.Format.Format_RGB32)
