"""Panels: a new one is one class; the frames' one is a list or a strip."""

from collections.abc import Generator

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QLabel, QWidget

from gui.features.frame_list.feature import FramesFeature
from gui.features.panel import Panel
from gui.state.entries import Entry
from gui.state.parts import Part
from gui.widgets.docks import PanelGroup
from ilf.sources.frame_ref import FrameRef


class _Missing(Panel):
    """Counts the missing pixels of the frame."""

    title = "Missing"
    icon = "ph.target"
    group = PanelGroup.SETTINGS
    parts = Part.FRAME | Part.SELECTION

    def make(self) -> QWidget:
        self.label, self.drawn = QLabel(), list[Part]()
        return self.label

    def refresh(self, parts: Part):
        self.drawn.append(parts)
        workspace = self.context.workspace
        if workspace.has_current:
            depth = workspace.current.frame.depth
            self.requests.ask(lambda: _count_missing(depth), self._show_count)

    def _show_count(self, count: int):
        self.label.setText(f"{count} px")


def _count_missing(depth) -> Generator[float, None, int]:
    yield 0.5
    return int(np.count_nonzero(~np.isfinite(depth)))


def test_a_new_panel_is_one_class(opened, qtbot):
    panel = _Missing(opened.context)
    opened.refresh.draw_all()
    assert not panel.made, "a closed panel is not even made"
    panel.reveal()
    missing = int(np.count_nonzero(~np.isfinite(opened.workspace.current.frame.depth)))
    qtbot.waitUntil(lambda: panel.label.text() == f"{missing} px")
    panel.drawn.clear()
    opened.workspace.select([1])
    opened.workspace.select([1, 2])
    opened.refresh.now()
    assert panel.drawn == [Part.SELECTION], "two changes of one turn are drawn once"
    opened.panels.reveal("Parameters")
    opened.workspace.select([1])
    opened.refresh.now()
    assert panel.drawn == [Part.SELECTION], "behind another tab it is not drawn"
    panel.reveal()
    opened.refresh.now()
    assert panel.drawn == [Part.SELECTION] * 2


def test_frames_are_a_narrow_list_beside_the_images_and_thousands_of_them_are_found(opened, qtbot):
    opened.resize(1100, 700)
    frames = opened.feature(FramesFeature)
    opened.workspace.add_entries([Entry.of(FrameRef(f"/nowhere/frame-{number}")) for number in range(10_000)])
    qtbot.waitUntil(lambda: frames.panel.view.isVisible() and frames.panel.view.is_strip)
    opened.panels.reveal("Frames")
    dock = opened.findChild(QDockWidget, "Frames")
    opened.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
    qtbot.waitUntil(lambda: not frames.panel.view.is_strip and frames.panel.view.isVisible())
    opened.resizeDocks([dock], [170], Qt.Orientation.Horizontal)
    qtbot.waitUntil(lambda: dock.width() == 170)
    assert frames.panel.view.sizeHint().width() < 200
    frames.panel.text.setText("frame-777")
    assert len(frames.panel.model.entries) == 12, "the current one stays"
