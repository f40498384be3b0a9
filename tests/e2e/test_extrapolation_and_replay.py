"""Guessing the rest, and what the window says of runs that are opened from a record."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

import ilf
from gui.features.cloud import CloudPanel
from gui.features.status import StatusFeature
from gui.views.cloud.scene import ColourBy
from gui.work.frame_runs import RunState
from ilf.cli import main as command_line

from .conftest import answer, export, loaded, open_frame, readout, write_frame


@pytest.fixture
def margin(window, qtbot, small_frame, tmp_path):
    """The small frame with a rim that belongs to no block and has no depth."""
    depth = small_frame.depth.copy()
    depth[:3] = np.nan
    folder = write_frame(tmp_path / "rim", ilf.RGBDFrame(small_frame.rgb, depth, small_frame.intrinsics))
    window.workspace.parameters.set_extraction(ilf.BlockParameters(margin=3))
    open_frame(window, qtbot, folder)
    return window


def _extrapolation(window, qtbot):
    progress = window.feature(StatusFeature).bar.progress
    with qtbot.waitSignal(window.runs.ended):
        window.actions_["extrapolate"].trigger()
        window.refresh.now()
        assert window.runs.state is RunState.EXTRAPOLATING
        assert (progress.isVisible(), progress.format()) == (True, "Extrapolating")
        assert window.actions_["cancel"].isEnabled()
        assert not window.actions_["run"].isEnabled()
    window.refresh.now()
    qtbot.waitUntil(lambda: not progress.isVisible())


def _open_run(window, qtbot, record: Path):
    window.actions_["close_frame"].trigger()
    loaded(window, qtbot, window.documents.open_paths, [record])
    window.refresh.now()


def _run_and_open(window, qtbot, run_all, folder: Path):
    """Open the record of a run that was just exported."""
    run_all(window)
    export(window, qtbot, folder)
    _open_run(window, qtbot, folder / "run.json")


def test_guesses_are_striped_named_and_counted(margin, qtbot, run_all):
    assert not margin.actions_["extrapolate"].isEnabled()
    run_all(margin)
    cell = margin.views.cells["depth-out"]
    assert "out missing" in readout(margin, (30, 1))
    before = margin.workspace.current.completion()
    _extrapolation(margin, qtbot)
    completion = margin.workspace.current.completion()
    assert completion.extrapolated[:3].all()
    np.testing.assert_array_equal(completion.depth[~completion.extrapolated], before.depth[~completion.extrapolated])
    np.testing.assert_array_equal(cell.view.striped["extrapolated"], completion.extrapolated)
    assert "extrapolated" not in margin.views.cells["depth-in"].view.striped
    assert (cell.view.shown[completion.extrapolated] > 0).all()
    assert "(extrapolated)" in margin.feature(StatusFeature).bar.readout.text()
    assert "extrapolated" not in readout(margin, (30, 10))
    assert re.search(r"out \d\.\d+ m.* [+-]\d+\.\d mm", margin.feature(StatusFeature).bar.readout.text())
    assert not margin.actions_["extrapolate"].isEnabled()
    margin.feature(CloudPanel).view.set_colour_by(ColourBy.FILLED)
    margin.centre.show_cloud()
    margin.refresh.now()
    qtbot.waitUntil(
        lambda: not margin.feature(CloudPanel).busy and len(margin.feature(CloudPanel).view.canvas.scene) > 0
    )
    legend = [text for _, text in margin.feature(CloudPanel).view.canvas.scene.legend]
    assert legend[-1] == f"{np.count_nonzero(completion.extrapolated)} extrapolated"
    margin.centre.show_images()
    margin.actions_["clear_results"].trigger()
    margin.refresh.now()
    assert "extrapolated" not in cell.view.striped
    assert cell.view.shown is None


def test_a_dense_export_is_that_of_the_command_line_and_comes_back_dense(margin, qtbot, run_all, reported, tmp_path):
    run_all(margin)
    _extrapolation(margin, qtbot)
    export(margin, qtbot, tmp_path / "window")
    assert "Extrapolated, not completed by a block" in margin.log.text.toPlainText()
    arguments = ["complete", str(tmp_path / "rim"), "--out", str(tmp_path / "cli"), "--quiet", "--extrapolate"]
    assert command_line([*arguments, "--blocks-margin", "3"]) == 0
    for path in (tmp_path / "cli").iterdir():
        assert path.read_bytes() == (tmp_path / "window" / path.name).read_bytes(), path.name
    _open_run(margin, qtbot, tmp_path / "window" / "run.json")
    assert not reported, "all is as it was recorded"
    assert margin.workspace.current.extrapolated
    with qtbot.waitSignal(margin.runs.finished):
        margin.actions_["run_all"].trigger()
    assert margin.workspace.current.extrapolated
    assert "the result equals the run record" in margin.log.text.toPlainText()
    assert not reported


def test_what_differs_from_a_record_is_said_when_it_is_opened(opened, qtbot, run_all, reported, tmp_path):
    run_all(opened)
    export(opened, qtbot, tmp_path / "out")
    depth = tmp_path / "out" / "depth.png"
    cv2.imwrite(str(depth), cv2.imread(str(depth), cv2.IMREAD_UNCHANGED) + 1)
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    assert len(reported) == 1
    assert "depth.png has changed since the run was written" in reported[0]
    assert "depth.png has changed" in opened.log.text.toPlainText()


@pytest.mark.parametrize("problem", ["changed", "missing"])
def test_a_file_of_the_frame_that_is_not_there_any_more_is_asked_for(
    opened, qtbot, run_all, tmp_path, problem, monkeypatch
):
    run_all(opened)
    frame, completed = opened.workspace.current.frame, opened.workspace.current.completion().depth
    export(opened, qtbot, tmp_path / "out")
    moved = (tmp_path / "two-planes").rename(tmp_path / "moved")
    if problem == "changed":
        write_frame(tmp_path / "two-planes", ilf.RGBDFrame(frame.rgb, frame.depth + 1))
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    assert opened.workspace.shown is None
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(moved))
    loaded(opened, qtbot, answer, opened, "Locate f&older…")
    np.testing.assert_array_equal(opened.workspace.current.completion().depth, completed)


def test_a_run_that_does_not_come_out_as_recorded_says_by_how_much(
    opened, qtbot, run_all, reported, tmp_path, monkeypatch
):
    _run_and_open(opened, qtbot, run_all, tmp_path / "out")
    from ilf.completion import block

    honest = block.block_depth
    monkeypatch.setattr(block, "block_depth", lambda *all_of_it: honest(*all_of_it) + np.float32(0.25))
    run_all(opened)
    assert "differs from the recorded one by up to 2.5e-01 m" in reported[-1]


def test_another_run_than_the_recorded_one_is_not_judged(opened, qtbot, run_all, reported, tmp_path):
    """With other parameters, other distrusted depth or other drawn borders."""
    _run_and_open(opened, qtbot, run_all, tmp_path / "out")
    document, mask = opened.workspace.current, np.zeros(opened.workspace.current.frame.shape, bool)
    mask[:4, :4] = True
    opened.workspace.parameters.set(ilf.preset("paper"))
    run_all(opened)
    opened.workspace.parameters.set(ilf.preset())
    document.set_invalid_mask(mask, "Distrust depth")
    run_all(opened)
    document.undo_stack.undo()
    drawn = document.blocks.drawn
    document.change_blocks(drawn=mask)
    run_all(opened)
    assert reported == []
    assert "equals the run record" not in opened.log.text.toPlainText()
    document.change_blocks(drawn=drawn)
    run_all(opened)
    assert opened.log.text.toPlainText().count("the result equals the run record") == 1
