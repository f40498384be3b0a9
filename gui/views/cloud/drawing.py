"""Drawing of a cloud: a coarse picture in limited time while it moves, the full one at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QImage

from ilf.drawing.clouds import Sight, Splat, splat, splat_steps

from ...work.latest_request import LatestRequest
from .scene import Scene

MOVING_POINTS, MOVING_PIXELS = 400_000, 1_000_000
"""Most points and picture pixels of a moving cloud: drawn in about 0.03 s."""

IDLE_MS = 120
"""The full picture is drawn when the view has not moved for this long."""


@dataclass(frozen=True, eq=False)
class _Picture:
    """A drawn picture with its scene, or part of one, and look; `side` is that of its pixels [screen px]."""

    image: QImage
    scene: Scene
    look: Sight
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
        self.scene = Scene()
        self._look: Sight | None = None
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

    def look(self, look: Sight, moving: bool) -> None:
        """Set the look, in screen pixels.

        The old picture stays until the full one is drawn, unless the cloud moves or is small enough to draw
        immediately.
        """
        self._look = look
        at_once = detail(len(self.scene), look.width * look.height) == (1, len(self.scene))
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

    def _draw_now(self, look: Sight) -> None:
        side, count = detail(len(self.scene), look.width * look.height)
        coarse = look if side == 1 else _coarse(look, side)
        scene = self.scene if count == len(self.scene) else self._subset_of(count)
        drawn = splat(scene.points, scene.colours, coarse, scene.spacing)
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
            self._subset = replace(
                scene,
                points=scene.points[some],
                pixels=scene.pixels[some],
                colours=scene.colours[some],
                spacing=spacing,
            )
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

    def _take_whole(self, scene: Scene, look: Sight, drawn: Splat) -> None:
        if (scene, look) == (self.scene, self._look):
            self._picture = _Picture(_image_of(drawn), scene, look, drawn.nearest)
            self._subset = None
            self._is_due = False
            self.ready.emit()


def detail(points: int, pixels: int) -> tuple[int, int]:
    """Side of a picture pixel [screen px] and number of points of a moving cloud, of this many points on this many
    screen pixels."""
    return math.ceil(math.sqrt(pixels / MOVING_PIXELS)), min(points, MOVING_POINTS)


def _coarse(look: Sight, side: int) -> Sight:
    """The same look with picture pixels of `side` screen pixels."""
    size = None if look.point_size is None else max(round(look.point_size / side), 1)
    return replace(look, width=max(look.width // side, 1), height=max(look.height // side, 1), point_size=size)


def _image_of(drawn: Splat) -> QImage:
    height, width = drawn.nearest.shape
    borrowed = QImage(drawn.picture.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    # the conversion copies, so the image outlives the array
    return borrowed.convertToFormat(QImage.Format.Format_RGB32)
