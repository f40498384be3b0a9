"""The status bar names what is being done and the share of it that is done; views do not ask for what is under way."""

import ilf
from gui.features.status import StatusFeature

from .conftest import open_frame, reading, write_frame


def _messages(window) -> set[str]:
    return {cell.view.layer.message for cell in window.views.cells.values() if cell.view.isVisible()}


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


def test_a_frame_can_be_run_while_blocks_of_another_are_extracted(opened, qtbot, tmp_path, small_frame):
    other = opened.workspace.current
    open_frame(opened, qtbot, write_frame(tmp_path / "second", small_frame))
    opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=48.0, use_depth=False))
    with reading(opened, qtbot):
        opened.loader.extract(other)
        assert opened.actions_["run_all"].isEnabled()
        opened.workspace.show(other)
        assert not opened.actions_["run_all"].isEnabled()
        opened.refresh.now()
        assert "Extracting blocks…" in _messages(opened)
    opened.refresh.now()
    assert "Extracting blocks…" not in _messages(opened)
