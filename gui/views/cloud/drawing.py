"""Drawing of a cloud: a coarse picture in limited time while it moves, the full one at rest."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QImage

from ilf.drawing.clouds import Look, Splat, splat, splat_steps

from ...work.latest_request import LatestRequest
from .scene import Scene, empty_scene

# Level of detail of a moving cloud, from the drawing speed of this machine. No widgets.

MOVING_S = 0.03
"""Maximum drawing time of a frame of a moving cloud."""

_POINT_S = 12e-9
_PIXEL_S = 22e-9
"""Drawing times of a point and of a pixel of the picture on a typical machine."""

_DETAIL_LEVELS = ((1, 1 << 62), (1, 400_000), (2, 400_000), (2, 150_000), (3, 100_000), (4, 50_000))
"""From fine to coarse: side of a picture pixel in screen pixels, and maximum number of points."""

_MIN_SLOWNESS, _MAX_SLOWNESS = 0.2, 20.0
_SPARE_SHARE = 0.8
_WEIGHT = 0.3


class DetailLevel:
    """Selects the finest level of detail that is fast enough.

    The speed of this machine is measured on the pictures drawn; a finer level is used again only with time to spare,
    so that the picture does not alternate.
    """

    def __init__(self) -> None:
        self._slowness = 1.0
        """Drawing time relative to a typical machine."""
        self._level = 0

    def choose(self, points: int, pixels: int) -> tuple[int, int]:
        """Select the side of a picture pixel [screen px] and the number of points to draw, for a cloud of this many
        points on this many screen pixels."""
        costs = [_cost(min(points, max_points), pixels / side**2) for side, max_points in _DETAIL_LEVELS]
        fitting = [rung for rung, cost in enumerate(costs) if self._slowness * cost <= MOVING_S]
        best = fitting[0] if fitting else len(_DETAIL_LEVELS) - 1
        if best < self._level and self._slowness * costs[best] > _SPARE_SHARE * MOVING_S:
            best = self._level
        self._level = best
        side, max_points = _DETAIL_LEVELS[best]
        return side, min(points, max_points)

    def note(self, seconds: float, points: int, pixels: float) -> None:
        """Record the time that drawing `points` points on `pixels` picture pixels took."""
        found = seconds / _cost(points, pixels)
        self._slowness += _WEIGHT * (min(max(found, _MIN_SLOWNESS), _MAX_SLOWNESS) - self._slowness)


def _cost(points: int, pixels: float) -> float:
    return _POINT_S * points + _PIXEL_S * pixels


IDLE_MS = 120
"""The full picture is drawn when the view has not moved for this long."""


@dataclass(frozen=True, eq=False)
class _Picture:
    """A drawn picture with its scene, or part of one, and look; `side` is that of its pixels [screen px]."""

    image: QImage
    scene: Scene
    look: Look
    nearest: NDArray[np.int32]
    side: int = 1


class CloudDrawing(QObject):
    """The current picture of a cloud.

    Signals
    -------
    ready()
        The full picture has been drawn.
    failed(object)
        The exception that stopped the drawing.
    """

    ready = Signal()
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.scene = empty_scene()
        self.detail = DetailLevel()
        self._look: Look | None = None
        self._picture: _Picture | None = None
        self._subset: Scene | None = None
        """Some of the points, for a coarse picture."""
        self._is_due = False
        """Whether `image` draws a new picture."""
        self._whole = LatestRequest(self, self.failed.emit)
        self._rest = QTimer(self, singleShot=True, interval=IDLE_MS)
        self._rest.timeout.connect(self._ask_whole)

    def set_scene(self, scene: Scene) -> None:
        """Set another cloud, drawn from the next look on."""
        self.scene, self._subset = scene, None
        if not len(scene):
            self._picture = None
            self.pause()

    def look(self, look: Look, moving: bool) -> None:
        """Set the look, in screen pixels.

        The old picture stays until the full one is drawn, unless the cloud moves or is small enough to draw
        immediately.
        """
        self._look = look
        at_once = self.detail.choose(len(self.scene), look.width * look.height) == (1, len(self.scene))
        if moving or at_once or self._picture is None:
            self._whole.cancel()
            self._is_due = True
        else:
            self._ask_whole()

    def image(self) -> QImage | None:
        """The current picture, to be scaled to the screen; None without a cloud."""
        if self._look is not None and len(self.scene) and (self._is_due or self._picture is None):
            self._draw_now(self._look)
        return None if self._picture is None else self._picture.image

    @property
    def is_full(self) -> bool:
        """Whether the picture is the full one for the current look."""
        picture = self._picture
        if picture is None or self._is_due:
            return False
        return picture.scene is self.scene and picture.look == self._look

    def finish(self) -> None:
        """Draw the full picture immediately, in the calling thread."""
        if self._look is not None and len(self.scene) and not self.is_full:
            scene = self.scene
            drawn = splat(scene.points, scene.colours, self._look, scene.spacing)
            self._take_whole(scene, self._look, drawn)

    def pixel_at(self, x: float, y: float, reach: float) -> tuple[int, int] | None:
        """Pixel (x, y) of the visible point nearest to a position, within `reach` [screen px]; None if there is
        none."""
        picture = self._picture
        if picture is None or picture.scene not in (self.scene, self._subset):
            return None
        column, row, around = int(x / picture.side), int(y / picture.side), max(round(reach / picture.side), 1)
        top, left = max(row - around, 0), max(column - around, 0)
        near = picture.nearest[top : row + around + 1, left : column + around + 1]
        rows, columns = np.nonzero(near >= 0)
        if not len(rows):
            return None
        closest = int(np.argmin((rows + top - row) ** 2 + (columns + left - column) ** 2))
        return picture.scene.pixel_of(int(near[rows[closest], columns[closest]]))

    def pause(self) -> None:
        """Stop drawing while the view is hidden."""
        self._rest.stop()
        self._whole.cancel()

    def resume(self) -> None:
        """Resume drawing."""
        if not self.is_full:
            self._rest.start()

    @property
    def busy(self) -> bool:
        """Whether the full picture is pending."""
        return self._rest.isActive() or self._whole.busy

    def _draw_now(self, look: Look) -> None:
        side, count = self.detail.choose(len(self.scene), look.width * look.height)
        coarse = look if side == 1 else _coarse(look, side)
        scene = self.scene if count == len(self.scene) else self._subset_of(count)
        begun = time.perf_counter()
        drawn = splat(scene.points, scene.colours, coarse, scene.spacing)
        self.detail.note(time.perf_counter() - begun, count, coarse.width * coarse.height)
        self._picture = _Picture(_image_of(drawn), scene, coarse, drawn.nearest, side)
        self._is_due = False
        if not self.is_full:
            self._rest.start()

    def _subset_of(self, count: int) -> Scene:
        """An evenly spread part of the scene."""
        if self._subset is None or len(self._subset) != count:
            # one random point per run of points: a fixed stride interferes with the image's rows and shows stripes
            scene, total = self.scene, len(self.scene)
            starts = np.linspace(0, total, count, endpoint=False)
            some = (starts + np.random.default_rng(0).random(count) * (total / count)).astype(np.intp)
            spacing = scene.spacing * math.sqrt(total / count)
            self._subset = Scene(scene.points[some], scene.pixels[some], scene.width, scene.colours[some], spacing)
        return self._subset

    def _ask_whole(self) -> None:
        """Ask for the full picture; an outdated one is cancelled."""
        if self._look is not None and len(self.scene):
            scene, look = self.scene, self._look
            if self._whole.question is None or self._whole.question.key != (scene, look):
                self._whole.cancel()
            self._whole.ask(
                lambda: splat_steps(scene.points, scene.colours, look, scene.spacing),
                partial(self._take_whole, scene, look),
                key=(scene, look),
            )

    def _take_whole(self, scene: Scene, look: Look, drawn: Splat) -> None:
        if (scene, look) == (self.scene, self._look):
            self._picture = _Picture(_image_of(drawn), scene, look, drawn.nearest)
            self._subset = None
            self._is_due = False
            self.ready.emit()


def _coarse(look: Look, side: int) -> Look:
    """The same look with picture pixels of `side` screen pixels."""
    size = None if look.point_size is None else max(round(look.point_size / side), 1)
    return replace(look, width=max(look.width // side, 1), height=max(look.height // side, 1), point_size=size)


def _image_of(drawn: Splat) -> QImage:
    height, width = drawn.nearest.shape
    borrowed = QImage(drawn.picture.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    # the conversion copies, so the image outlives the array
    return borrowed.convertToFormat(QImage.Format.Format_RGB32)
