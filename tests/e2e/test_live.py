"""Moving a slider of the filter solves its blocks anew; and several blocks run at once."""

import numpy as np
import pytest
from PySide6.QtWidgets import QSlider

import ilf
from gui.features.blocks.feature import block_rows
from gui.features.blocks.table import BlockColumn
from gui.features.curves import CurvesFeature
from gui.features.filter import FilterPanel
from gui.state.parts import Part
from gui.work.frame_runs import RunState
from ilf.data.results import BlockResult

from .conftest import open_frame


@pytest.fixture
def opened(opened):
    """The window with the small frame, its blocks, and a filter whose padding matters."""
    opened.workspace.parameters.set(ilf.preset("paper"))
    return opened


def _slider(window, name: str) -> QSlider:
    form = window.feature(FilterPanel).form
    form.all_button.setChecked(True)
    return form.findChild(QSlider, f"slider_{name}")


def _results(window) -> dict[int, BlockResult]:
    return dict(window.workspace.current.valid_results())


def _states(window) -> dict[int, str]:
    workspace = window.workspace
    rows = block_rows(workspace.current, window.runs.current)
    return {label: row[BlockColumn.STATE].hint.splitlines()[0] for label, row in rows.items()}


@pytest.mark.parametrize("own", [False, True], ids=["values of all blocks", "values of the chosen block"])
def test_a_slider_solves_the_blocks_anew_whose_values_it_sets(opened, qtbot, run_all, own):
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
    with qtbot.waitSignal(opened.runs.run_ended):
        _slider(opened, "padding").setValue(8)
    after = _results(opened)
    assert after[chosen].parameters.padding == 3.0
    assert not np.array_equal(after[chosen].depth, before[chosen].depth)
    assert (after[other] is before[other]) is own
    alone = ilf.complete(workspace.current.frame, workspace.current.labels, after[chosen].parameters)
    assert np.array_equal(after[chosen].depth, alone.results[chosen].depth)
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    opened.refresh.now()
    assert f"i {after[chosen].outcome.iterations} " in opened.feature(CurvesFeature).widget.readout.text
    assert _states(opened)[chosen] == "completed"
    assert _states(opened)[other] == "completed"
    assert workspace.undo_group.activeStack().count() == steps + 1
    assert not said


def test_a_frame_closes_without_a_question_during_a_re_solve(opened, qtbot):
    opened.project.discard_silently = False
    opened.workspace.select(list(opened.workspace.current.counts())[:1])
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    assert opened.runs.state is RunState.RESOLVING
    document = opened.workspace.current
    document.note_saved(document.stamp)
    opened.actions_["close_frame"].trigger()
    assert opened.workspace.shown is None
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)


def test_with_live_off_nothing_runs_and_the_choice_is_remembered(another, qtbot, run_all, frame_folder):
    opened = another(persistent=True)
    open_frame(opened, qtbot, frame_folder)
    opened.workspace.parameters.set(ilf.preset("paper"))
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
    assert not another(persistent=True).actions_.is_on("live")
    _slider(opened, "padding").setValue(4)
    assert _states(opened)[chosen] == "completed", "the values are those of the result again"


@pytest.mark.parametrize("how", ["left alone", "cancelled"])
def test_a_slider_that_moves_during_a_run_is_followed_after_it(opened, qtbot, how):
    opened.runs.current.start()
    opened.runs.current.toggle_pause()
    _slider(opened, "padding").setValue(8)
    assert opened.runs.state is RunState.PAUSED
    (opened.runs.current.cancel if how == "cancelled" else opened.runs.current.toggle_pause)()
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    qtbot.wait(50)
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    followed = opened.workspace.current.changed_blocks() == []
    assert followed is (how == "left alone")


def test_blocks_that_run_at_once_give_what_they_give_alone(opened, qtbot, monkeypatch):
    monkeypatch.setattr("gui.work.frame_runs.spare_cores", lambda: 3)
    workspace = opened.workspace
    workspace.parameters.set(ilf.preset("released-code", max_iterations=2000))
    labels = list(workspace.current.counts())
    together: list[list[int]] = []
    previews: list[int] = []
    results = workspace.current.results
    workspace.on(Part.RECORDS, lambda: together.append(results.running))
    workspace.changed.connect(lambda parts: previews.append(len(results.previews)) if parts & Part.PREVIEWS else None)
    with qtbot.waitSignal(opened.runs.ended):
        opened.actions_["run"].trigger()
    assert max(map(len, together)) == len(labels)
    assert max(previews) >= 1
    expected = ilf.complete(workspace.current.frame, workspace.current.labels, workspace.parameters.current, threads=1)
    completion = workspace.current.completion()
    assert completion.depth.tobytes() == expected.depth.tobytes()
