"""The status bar names what is being done and the share of it that is done; views do not ask for what is under way."""

import re

import ilf
from gui.base.commands import why_not
from gui.features.filter import FilterPanel
from gui.features.status import StatusFeature
from gui.work.frame_runs import RunState

from .conftest import open_frame, write_frame


def _messages(window) -> set[str]:
    return {cell.view._message for cell in window.views.cells.values() if cell.view.isVisible()}


def test_stages_of_a_run_are_named(opened, qtbot):
    progress, seen = opened.feature(StatusFeature).bar.progress, list[str]()
    assert any(message.startswith("No result yet") for message in _messages(opened))
    opened.actions_["run"].trigger()

    def ended() -> bool:
        """Note what is shown; whether the expected error is there."""
        if progress.isVisible():
            seen.append(progress.text())
            assert not any(message.startswith("No result yet") for message in _messages(opened))
        return opened.workspace.current.expected_error() is not None

    qtbot.waitUntil(ended)
    filtering = re.compile(r"Filtering (0 of \d+|[1-9]\d* of \d+, [1-9]\d* %.*)")
    assert all(filtering.fullmatch(text) for text in seen if text.startswith("Filtering")), "no share of nothing done"
    assert any(text.startswith("Estimating") for text in seen), "named, though its share is not known"
    assert {text.partition(" ")[0] for text in seen} <= {"Preparing", "Filtering", "Correcting", "Estimating"}
    qtbot.waitUntil(lambda: not progress.isVisible())


def test_a_pause_is_told_with_what_is_done_and_a_run_follows_an_extraction_under_way(opened, qtbot):
    opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=48.0, use_depth=False))
    with qtbot.waitSignal(opened.runs.ended):
        opened.actions_["extract"].trigger()
        opened.actions_["run"].trigger()
        assert "as soon as they are extracted" in opened.notes.message
        assert not opened.runs.state.going
    assert not opened.workspace.current.changed_blocks()

    progress = opened.feature(StatusFeature).bar.progress
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.actions_["step"].trigger()
    qtbot.waitUntil(lambda: progress.format().startswith("Paused"))
    with qtbot.waitSignal(opened.runs.ended):
        opened.actions_["cancel"].trigger()


def test_work_that_follows_a_slider_is_named(opened, qtbot, run_all):
    run_all(opened)
    progress = opened.feature(StatusFeature).bar.progress
    qtbot.waitUntil(lambda: not progress.isVisible())
    opened.feature(FilterPanel).form.changed.emit(ilf.preset("released-code", max_iterations=100_000))
    qtbot.waitUntil(lambda: progress.isVisible() and progress.format() == "Completing")
    opened.actions_["cancel"].trigger()
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    assert opened.workspace.current.changed_blocks(), "it is not begun again"
    assert why_not(opened.actions_["cancel"]) == "Nothing is running."


def test_a_frame_can_be_run_while_blocks_of_another_are_extracted(opened, qtbot, tmp_path, small_frame):
    other = opened.workspace.current
    open_frame(opened, qtbot, write_frame(tmp_path / "second", small_frame))
    opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=48.0, use_depth=False))
    with qtbot.waitSignal(opened.loader.idle):
        opened.loader.extract(other)
        assert opened.actions_["run_all"].isEnabled()
        opened.workspace.show(other)
        assert not opened.actions_["run_all"].isEnabled()
        opened.refresh.now()
        assert "Extracting blocks…" in _messages(opened)
    opened.refresh.now()
    assert "Extracting blocks…" not in _messages(opened)
