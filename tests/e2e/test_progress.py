"""The status bar names what is being done and the share of it that is done."""

import ilf
from gui.features.status import StatusFeature


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
