"""Moving a slider of the filter solves the chosen block anew; and several blocks run at once."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest
from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QSlider
from pytestqt.qtbot import QtBot

import ilf
from gui.app.main_window import MainWindow
from gui.features.blocks.feature import block_rows
from gui.features.curves import CurvesFeature
from gui.features.filter import FilterPanel
from gui.state.document import Document
from gui.state.parts import Part
from gui.work.frame_runs import RunState
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult

from .conftest import WAIT_MS

Run = Callable[[MainWindow], None]


@pytest.fixture
def opened(opened: MainWindow) -> MainWindow:
    """The window with the small frame, its blocks, and a filter whose padding matters."""
    opened.workspace.parameters.set(ilf.preset("paper"))
    return opened


def _slider(window: MainWindow, name: str) -> QSlider:
    return window.feature(FilterPanel).form.findChild(QSlider, f"slider_{name}")


def _results(window: MainWindow) -> dict[int, BlockResult]:
    return dict(window.workspace.current.valid_results())


def _states(window: MainWindow) -> dict[int, str]:
    workspace = window.workspace
    return {row.label: row.state for row in block_rows(workspace.current, window.runs)}


@pytest.mark.parametrize("own", [False, True], ids=["values of all blocks", "values of the chosen block"])
def test_a_slider_solves_the_chosen_block_anew_and_no_other(
    opened: MainWindow, qtbot: QtBot, run_all: Run, own: bool
) -> None:
    opened.panels.reveal("Convergence")
    run_all(opened)
    workspace = opened.workspace
    chosen, other = list(workspace.current.counts())[:2]
    workspace.select([chosen])
    opened.feature(FilterPanel).scope.setCurrentIndex(int(own))
    opened.feature(FilterPanel).redraw()
    before = _results(opened)
    steps = workspace.undo_group.activeStack().count()
    said: list[str] = []
    opened.runs.ended.connect(said.append)
    with qtbot.waitSignal(opened.runs.resolved, timeout=WAIT_MS):
        _slider(opened, "padding").setValue(8)
    after = _results(opened)
    assert after[chosen].parameters.padding == 3.0
    assert not np.array_equal(after[chosen].depth, before[chosen].depth)
    assert after[other] is before[other]
    alone = ilf.complete(workspace.current.frame, workspace.current.labels, after[chosen].parameters)
    assert np.array_equal(after[chosen].depth, alone.results[chosen].depth)
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE, timeout=WAIT_MS)
    opened.refresh.now()
    assert len(opened.feature(CurvesFeature).widget.records) == after[chosen].outcome.iterations
    assert _states(opened)[chosen] == "completed"
    assert (_states(opened)[other] == "values changed") is not own
    assert workspace.undo_group.activeStack().count() == steps + 1
    assert not said


def test_of_many_values_the_last_one_stays(opened: MainWindow, qtbot: QtBot) -> None:
    workspace = opened.workspace
    chosen = next(iter(workspace.current.counts()))
    workspace.select([chosen])
    stored: list[int] = []
    workspace.changed.connect(lambda parts: stored.append(0) if parts & Part.RESULTS else None)
    slider = _slider(opened, "padding")
    for position in [*range(12, 0, -1), *range(13)]:
        slider.setValue(position)
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE, timeout=WAIT_MS)
    assert _results(opened)[chosen].parameters.padding == 4.0
    assert set(_results(opened)) == {chosen}
    assert 1 <= len(stored) <= 2, "nothing is queued"


def test_a_long_re_solve_is_replaced(opened: MainWindow, qtbot: QtBot) -> None:
    workspace = opened.workspace
    chosen = next(iter(workspace.current.counts()))
    workspace.select([chosen])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    assert opened.runs.state is RunState.RESOLVING
    assert opened.actions_["run"].isEnabled()
    with qtbot.waitSignal(opened.runs.resolved, timeout=WAIT_MS):
        opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=5))
    assert _results(opened)[chosen].outcome.iterations == 5


def test_a_run_takes_the_place_of_a_re_solve(opened: MainWindow, qtbot: QtBot) -> None:
    workspace = opened.workspace
    labels = list(workspace.current.counts())
    workspace.select(labels[:1])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    assert opened.runs.state is RunState.RESOLVING
    workspace.parameters.set(ilf.preset(max_iterations=4))
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["run"].trigger()
    assert [result.outcome.iterations for result in _results(opened).values()] == [4] * len(labels)


def test_clearing_results_drops_what_a_re_solve_is_about_to_give(
    opened: MainWindow, qtbot: QtBot, run_all: Run
) -> None:
    run_all(opened)
    workspace = opened.workspace
    workspace.select(list(workspace.current.counts())[:1])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("paper", max_iterations=3))
    for thread in threading.enumerate():
        if thread.name == "ilf-worker":
            thread.join()  # the result is there, and waits for the window to take it
    opened.actions_["clear_results"].trigger()
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE, timeout=WAIT_MS)
    assert not _results(opened)
    with qtbot.waitSignal(opened.runs.resolved, timeout=WAIT_MS):
        opened.feature(FilterPanel).form.changed.emit(ilf.preset("paper", max_iterations=4))
    assert len(_results(opened)) == 1


def test_a_frame_closes_without_a_question_during_a_re_solve(opened: MainWindow, qtbot: QtBot) -> None:
    opened.documents.discard_silently = False
    opened.workspace.select(list(opened.workspace.current.counts())[:1])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    assert opened.runs.state is RunState.RESOLVING
    document = opened.workspace.current
    document.note_saved(document.stamp)
    opened.actions_["close_frame"].trigger()
    assert not opened.workspace.has_current
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE, timeout=WAIT_MS)


@pytest.mark.parametrize("what", ["run", "slider"])
def test_what_is_asked_of_another_frame_during_a_re_solve_is_done(
    opened: MainWindow, qtbot: QtBot, small_frame: RGBDFrame, what: str
) -> None:
    workspace = opened.workspace
    workspace.select(list(workspace.current.counts())[:1])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    first = workspace.current
    second = Document.of(ilf.Run(small_frame, first.labels), None, "second")
    workspace.open_document(second)
    chosen = next(iter(second.counts()))
    workspace.select([chosen])
    assert opened.runs.state is RunState.IDLE, "each frame by itself"
    assert opened.runs.of(first).state is RunState.RESOLVING
    workspace.parameters.set(ilf.preset(max_iterations=4))
    if what == "run":
        with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
            opened.actions_["run"].trigger()
    else:
        with qtbot.waitSignal(opened.runs.resolved, timeout=WAIT_MS):
            opened.feature(FilterPanel).form.changed.emit(ilf.preset(max_iterations=5))
    assert not first.valid_results()
    assert set(second.valid_results()) == (set(second.counts()) if what == "run" else {chosen})


def test_nothing_is_solved_anew_during_a_run(opened: MainWindow, qtbot: QtBot) -> None:
    workspace = opened.workspace
    workspace.select(list(workspace.current.counts())[:1])
    workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.actions_["run"].trigger()
    _slider(opened, "padding").setValue(8)
    assert opened.runs.state is RunState.RUNNING
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["cancel"].trigger()
    assert not _results(opened)


def test_with_live_off_nothing_runs_and_the_choice_is_remembered(
    opened: MainWindow, qtbot: QtBot, run_all: Run
) -> None:
    run_all(opened)
    workspace = opened.workspace
    chosen = next(iter(workspace.current.counts()))
    workspace.select([chosen])
    before = _results(opened)
    opened.actions_["live"].trigger()
    _slider(opened, "padding").setValue(8)
    assert opened.runs.state is RunState.IDLE
    assert _results(opened) == before
    assert _states(opened)[chosen] == "values changed"
    assert QSettings().value("live", True, type=bool) is False
    _slider(opened, "padding").setValue(4)
    assert _states(opened)[chosen] == "completed", "the values are those of the result again"


def test_without_a_chosen_block_nothing_runs(opened: MainWindow) -> None:
    opened.workspace.select([])
    _slider(opened, "padding").setValue(8)
    assert opened.runs.state is RunState.IDLE


def test_blocks_that_run_at_once_give_what_they_give_alone(
    opened: MainWindow, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gui.work.frame_runs.spare_cores", lambda: 3)
    workspace = opened.workspace
    workspace.parameters.set(ilf.preset("released-code", max_iterations=2000))
    labels = list(workspace.current.counts())
    together: list[list[int]] = []
    previews: list[int] = []
    opened.runs.records.connect(lambda *_: together.append(opened.workspace.current.results.running))
    results = workspace.current.results
    workspace.changed.connect(lambda parts: previews.append(len(results.previews)) if parts & Part.PREVIEWS else None)
    with qtbot.waitSignal(opened.runs.ended, timeout=WAIT_MS):
        opened.actions_["run"].trigger()
    assert max(map(len, together)) == len(labels)
    assert max(previews) >= 1
    expected = ilf.complete(workspace.current.frame, workspace.current.labels, workspace.parameters.current, threads=1)
    completion = workspace.current.completion()
    assert completion is not None
    assert completion.depth.tobytes() == expected.depth.tobytes()
