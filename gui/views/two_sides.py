"""Two depths that are compared in the views: which they are, parted by a handle, or one in place of the other."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from .contents.material import Material
from .contents.names import COMPARABLE, capital, short_title
from .image_view import ImageView
from .swipe import Label, Swipe


class TwoSides(QObject):
    """Sides A and B: at first what is compared, or depth in, and the result.

    Parameters
    ----------
    material : Material
    views : list of ImageView
    content_of : callable
        The concrete content of a view.

    Signals
    -------
    changed(str)
        Other pixels are to be shown: the part of the material that has changed.
    """

    changed = Signal(str)

    def __init__(
        self, material: Material, views: list[ImageView], content_of: Callable[[ImageView], str], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._material = material
        self._content_of = content_of
        self.swipe = Swipe(views, self._is_swiped, lambda view: content_of(view) == "result", self)
        self.swipe.moved.connect(self._follow_handle)

    @property
    def names(self) -> tuple[str, str]:
        """Names of the two depths, of `contents.names.COMPARABLE`."""
        return self._material.sides

    @property
    def chosen(self) -> tuple[str, str]:
        """The two as they were chosen; "" for what is best as things are."""
        return self._material.chosen_sides

    def choose(self, first: str = "", second: str = "") -> None:
        """Compare two depths by their names; "" stands for what is best as things are.

        Raises
        ------
        ValueError
            If there is no such depth.
        """
        for name in (first, second):
            if name not in ("", *COMPARABLE):
                raise ValueError(f"a side must be one of {', '.join(COMPARABLE)}, not {name!r}")
        self._material.chosen_sides = first, second
        self.changed.emit("runs")
        self._follow_handle()

    def set_swiping(self, on: bool) -> None:
        """Part the result by a handle: side A left of it, side B right of it."""
        self.swipe.set_on(on)

    def look_at_a(self, on: bool) -> None:
        """Let side A stand in for the result for a while."""
        if on != self._material.looks_at_a:
            self._material.looks_at_a = on
            self.changed.emit("result")

    def set_frame(self, width: int, height: int) -> None:
        """Take another frame, all of which is to be drawn: the handle stands in its middle."""
        self.swipe.set_frame(width, height)
        self._place()

    def write_labels(self) -> None:
        """Say at the handle what its sides are."""
        first, second = (self._label(depth) for depth in self.names)
        self.swipe.set_labels((first, second))

    def _label(self, depth: str) -> Label:
        run = self._material.run(depth)
        return capital(short_title(depth, self._material.names)), None if run is None else run.colour

    def _is_swiped(self, view: ImageView) -> bool:
        """The result, and blocks where the two sides have others; nothing while one of them is missing."""
        if any(self._material.layer(side) is None for side in self.names):
            return False
        shown = {"result", "colour"} if any(self._material.side_blocks) else {"result"}
        return self._content_of(view) in shown

    def _follow_handle(self) -> None:
        self._place()
        self.changed.emit("swipe")

    def _place(self) -> None:
        self._material.swiped_at = round(self.swipe.x) if self.swipe.on else None
