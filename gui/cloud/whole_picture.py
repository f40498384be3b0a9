"""The picture of all of a cloud, drawn off the GUI's thread when the view is at rest."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Signal

from gui.cloud.scene import Scene
from gui.work.worker import Worker
from ilf.drawing.splat import Look, Splat, splat_in_steps


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
