"""Panels: a new one is one class, made when it is first used; and what changes is drawn once."""

from collections.abc import Generator

import numpy as np
import pytest
from PySide6.QtWidgets import QDockWidget, QLabel, QWidget

from gui.features.frame_list.feature import FramesFeature
from gui.features.panel import Panel
from gui.state.parts import Part
from gui.state.workspace import Entry
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
        if (document := self.workspace.shown) is not None:
            depth = document.frame.depth
            self.requests.ask(lambda: _count_missing(depth), self._show_count)

    def _show_count(self, count: int):
        self.label.setText(f"{count} px")


def _count_missing(depth) -> Generator[float, None, int]:
    yield 0.5
    return int(np.count_nonzero(~np.isfinite(depth)))


def test_a_new_panel_is_one_class(opened, qtbot):
    opened.context.add(_Missing)
    panel = opened.feature(_Missing)
    opened.refresh.now()
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


@pytest.mark.parametrize("title", ["Inspect", "Frames"])
def test_a_panel_outside_the_window_closes_and_comes_back_with_it(another, qtbot, title):
    window = another(persistent=True)
    window.panels.reveal(title)
    dock = window.findChild(QDockWidget, title)
    dock.setFloating(True)
    window.close()
    assert not dock.isVisible()
    dock = another(persistent=True).findChild(QDockWidget, title)
    qtbot.waitUntil(dock.isVisible)
    assert dock.isFloating()


def test_a_window_at_rest_draws_nothing_and_takes_no_turns(opened, qtbot, monkeypatch):
    opened.hide()
    opened.show()
    qtbot.wait(300)
    turns, tell = [], opened.workspace.tell
    monkeypatch.setattr(opened.workspace, "tell", lambda: (turns.append(1), tell()))
    qtbot.wait(200)
    assert len(turns) <= 2


def test_the_film_strip_comes_back_as_the_list_is_closed_behind_another_tab(opened):
    opened.workspace.add_entries([Entry.of(FrameRef("/nowhere/other"))])
    frames = opened.feature(FramesFeature)
    for title in ("Frames", "Blocks"):  # in one place
        opened.panels.reveal(title)
    opened.refresh.now()
    assert frames.bar.isHidden()
    opened.findChild(QDockWidget, "Frames").close()
    opened.refresh.now()
    assert not frames.bar.isHidden()
