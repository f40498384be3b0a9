"""A host for tools without a window, and what a hand does with them."""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

import ilf
from gui.state.document import Document
from gui.state.workspace import Workspace
from gui.tools.base import EdgeData, Point, Result, Tool, ToolOptions
from gui.tools.kinds import Tools
from gui.views.interaction import PointerEvent, PointerKind, Preview
from ilf.errors import InputError
from ilf.segmentation.editing.patches import LabelPatch


class ToolHost:
    """Keeps what it is told: the last preview and all messages. Changes go to a workspace of its own."""

    def __init__(self, frame: ilf.RGBDFrame, labels: NDArray[np.int32], leash: int = 0) -> None:
        self.options = ToolOptions(brush_radius=3.0, leash=leash)
        self.workspace = Workspace()
        self.workspace.open_document(Document.of(ilf.Run(frame, labels), "origin", "key"))
        strength = np.zeros(frame.shape, np.float32)
        strength[:, 29:31] = 1.0
        regions = np.where(np.arange(frame.shape[1]) < 30, 1, 2) + np.zeros(frame.shape, np.int32)
        self.edge_data: EdgeData | None = EdgeData.of(frame, strength, regions.astype(np.int32))
        self.preview: Preview | None = None
        self.said: list[str] = []
        self.waits = False
        self.waiting: list[Callable[[], None]] = []

    @property
    def document(self) -> Document:
        return self.workspace.current

    @property
    def labels(self) -> NDArray[np.int32]:
        return self.document.labels

    @property
    def steps(self) -> list[str]:
        """What there is to undo."""
        stack = self.document.undo_stack
        return [stack.text(index) for index in range(stack.index())]

    def undo(self) -> None:
        self.document.undo_stack.undo()

    def commit(self, patch: LabelPatch | None, text: str, label: int = 0) -> LabelPatch | None:
        return patch if self.workspace.current.edit(patch, text) else None

    def attempt(self, act: Callable[[], object]) -> bool:
        """Let a tool act, as the editor does."""
        try:
            return bool(act())
        except InputError as error:
            self.show_message(str(error))
            return True

    def set_option(self, name: str, value: float | bool) -> None:
        setattr(self.options, name, value)

    def show_preview(self, preview: Preview | None) -> None:
        self.preview = preview

    def run_in_background(self, find: Callable[[], Result], take: Callable[[Result], None]) -> None:
        """At once, unless a test lets it wait."""

        def answer() -> None:
            self.attempt(lambda: take(find()))

        if self.waits:
            self.waiting.append(answer)
        else:
            answer()

    def show_message(self, message: str) -> None:
        self.said.append(message)


class Hand:
    """Uses a tool. Modifiers are given by their letters: s(hift), c(trl), a(lt)."""

    def __init__(self, tool: Tool, host: ToolHost) -> None:
        self.tool = tool
        self.host = host

    def send(self, kind: PointerKind, at: Point, keys: str = "") -> bool:
        event = PointerEvent(kind, *at, shift="s" in keys, ctrl="c" in keys, alt="a" in keys)
        return self.host.attempt(lambda: self.tool.pointer(event, self.host))

    def press(self, at: Point, keys: str = "") -> bool:
        return self.send(PointerKind.PRESS, at, keys)

    def drag(self, points: Iterable[Point], keys: str = "", release: bool = True) -> None:
        """Press at the first point, go through the others, let go at the last."""
        first, *others = points
        self.press(first, keys)
        for point in others:
            self.send(PointerKind.MOVE, point, keys)
        if release:
            self.send(PointerKind.RELEASE, others[-1] if others else first, keys)

    def click(self, at: Point, keys: str = "") -> None:
        self.drag([at], keys)

    def double_click(self, at: Point) -> None:
        """As a window sends it: the second press comes only if the tool does not want the double click."""
        self.click(at)
        if not self.send(PointerKind.DOUBLE, at):
            self.click(at)

    def hover(self, at: Point, keys: str = "") -> None:
        self.send(PointerKind.HOVER, at, keys)

    def finish(self) -> bool:
        return self.host.attempt(lambda: self.tool.finish(self.host))

    def cancel(self) -> bool:
        """Cancel what the tool does; return whether there was anything to cancel."""
        was_busy = self.tool.busy
        self.tool.cancel(self.host)
        return was_busy


def hand(host: ToolHost, name: str) -> Hand:
    """A hand with a tool."""
    return Hand(Tools()[name], host)
