"""One refresh per turn of the event loop: every part at most once, in order, and what can wait waits."""

from collections.abc import Callable

import pytest
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication

from gui.state.parts import NO_PART, Part
from gui.state.workspace import Workspace
from gui.work import refresh as refresh_module
from gui.work.refresh import Refresh


class _Source(QObject):
    urgent = Signal()
    urgent_with_data = Signal(object)


class _Bench:
    """A refresh of three parts that note when they are drawn."""

    def __init__(self):
        self.source = _Source()
        self.workspace = Workspace()
        self.refresh = Refresh(self.workspace)
        self.drawn: list[str] = []
        source = self.source
        also = source.urgent, source.urgent_with_data
        self.refresh.add("first", self._note("first"), Part.LABELS, also=also)
        self.refresh.add("second", self._note("second"), Part.LABELS, Part.PREVIEWS, also=(source.urgent,))
        self.refresh.add("third", self._note("third"), NO_PART, Part.RECORDS)
        self.refresh.now()  # for the first time
        self.drawn.clear()

    def change(self, part: Part) -> None:
        """Change a part of the state, and tell of it."""
        self.workspace.note(part)
        self.workspace.tell()

    def _note(self, name: str) -> Callable[[], None]:
        return lambda: self.drawn.append(name)


@pytest.fixture
def bench(qtbot):
    return _Bench()


def _turn():
    QApplication.processEvents()


def test_what_changes_often_is_drawn_once_and_in_order(bench):
    for _ in range(5):
        bench.source.urgent.emit()
        bench.source.urgent_with_data.emit((1, 2))
    assert bench.drawn == []
    _turn()
    assert bench.drawn == ["first", "second"]
    _turn()
    assert bench.drawn == ["first", "second"], "nothing is stale any more"
    bench.source.urgent_with_data.emit(None)
    _turn()
    assert bench.drawn == ["first", "second", "first"], "and the next change is drawn like the first"


def test_parts_of_the_state_are_drawn_in_the_turn_that_tells_them(bench):
    bench.workspace.note(Part.LABELS)
    bench.workspace.note(Part.RESULTS)
    assert bench.drawn == []
    _turn()
    assert bench.drawn == ["first", "second"]
    assert Part.LABELS | Part.RESULTS in bench.refresh.changed("third"), "also what it was not drawn for"
    assert bench.refresh.changed("third") == NO_PART


def test_a_turn_for_something_else_draws_what_has_changed_meanwhile_too(bench):
    """Else a result would be drawn over the picture of the frame that was shown before."""
    bench.change(Part.RECORDS)
    bench.workspace.note(Part.LABELS)
    bench.refresh.now()
    assert sorted(bench.drawn) == ["first", "second", "third"]
    _turn()
    assert len(bench.drawn) == 3


def test_now_draws_at_once_and_leaves_nothing_for_the_next_turn(bench):
    bench.refresh.mark("third", "first")
    bench.refresh.now()
    assert bench.drawn == ["first", "third"]
    bench.refresh.now()
    _turn()
    assert bench.drawn == ["first", "third"]


def test_what_can_wait_is_drawn_after_a_while_and_not_with_every_other_part(bench, qtbot):
    bench.workspace.note(Part.PREVIEWS)
    qtbot.waitUntil(lambda: bench.drawn == ["second"])
    bench.drawn.clear()
    for _ in range(3):
        bench.workspace.note(Part.PREVIEWS)
        bench.refresh.mark("first")
        bench.refresh.now()
    assert bench.drawn == ["first"] * 3, "the window has just drawn it"
    qtbot.waitUntil(lambda: bench.drawn == ["first"] * 3 + ["second"])


def test_expensive_drawing_leaves_the_window_its_time(bench, monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(refresh_module.time, "perf_counter", lambda: clock[0])

    def draw():
        bench.drawn.append("slow")
        clock[0] += 0.1

    bench.refresh.add("slow", draw, NO_PART, Part.COMPARED)
    bench.change(Part.COMPARED)
    bench.refresh.now()
    assert bench.drawn == ["slow"]
    for pause, drawn in ((0.5, 1), (0.11, 2)):
        bench.change(Part.COMPARED)
        clock[0] += pause
        bench.refresh.now()
        assert bench.drawn == ["slow"] * drawn, "six times what drawing took, from its end on"
    clock[0] += 10
    bench.refresh.now()
    assert bench.drawn == ["slow"] * 2, "it has not changed since"
    bench.refresh.stop()


def test_an_error_in_one_part_keeps_no_other_from_being_drawn(bench, qtbot):
    def broken():
        raise RuntimeError("broken part")

    refresh = Refresh(Workspace())
    refresh.add("broken", broken, NO_PART)
    refresh.add("whole", lambda: bench.drawn.append("whole"), NO_PART)
    refresh.mark("broken", "whole")
    with qtbot.captureExceptions() as met:
        refresh.now()
    assert [str(error) for _, error, _ in met] == ["broken part"]
    qtbot.waitUntil(lambda: bench.drawn == ["whole"])


def test_after_stop_nothing_is_drawn(bench):
    bench.source.urgent.emit()
    bench.workspace.note(Part.RECORDS)
    bench.refresh.stop()
    _turn()
    bench.source.urgent.emit()
    bench.workspace.note(Part.RECORDS)
    bench.refresh.now()
    _turn()
    assert bench.drawn == []
    assert not bench.refresh._later.isActive()
