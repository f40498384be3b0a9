"""Guessing the rest, and what the window says of runs that are opened from a record."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PySide6.QtWidgets import QMessageBox
from pytestqt.qtbot import QtBot

import ilf
from gui.app.main_window import MainWindow
from gui.features.cloud import CloudFeature
from gui.features.export.dialog import Export
from gui.features.export.feature import ExportFeature
from gui.features.status import StatusFeature
from gui.views.cloud.colouring import ColourBy
from gui.work.frame_runs import RunState
from ilf.cli import main as command_line
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef

from .conftest import WAIT_MS, open_frame, write_frame

Run = Callable[[MainWindow], None]


@pytest.fixture
def reported(window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Messages that were shown to the user."""
    texts: list[str] = []
    monkeypatch.setattr(QMessageBox, "open", lambda box: texts.append(box.text()))
    return texts


@pytest.fixture
def margin(window: MainWindow, qtbot: QtBot, small_frame: ilf.RGBDFrame, tmp_path: Path) -> MainWindow:
    """The small frame with a rim that belongs to no block and has no depth."""
    depth = small_frame.depth.copy()
    depth[:3] = np.nan
    folder = write_frame(tmp_path / "rim", ilf.RGBDFrame(small_frame.rgb, depth, small_frame.intrinsics))
    window.workspace.parameters.set_extraction(ilf.BlockParameters(margin=3))
    open_frame(window, qtbot, FrameRef(str(folder)))
    return window


def _extrapolation(window: MainWindow, qtbot: QtBot) -> None:
    with qtbot.waitSignal(window.runs.ended, timeout=WAIT_MS):
        window.actions_["extrapolate"].trigger()
    window.refresh.now()


def _export(window: MainWindow, qtbot: QtBot, folder: Path) -> None:
    with qtbot.waitSignal(window.feature(ExportFeature).ended, timeout=WAIT_MS):
        window.feature(ExportFeature).start(Export(folder, ExportOptions()))


def _open_run(window: MainWindow, qtbot: QtBot, record: Path) -> None:
    window.actions_["close_frame"].trigger()
    with qtbot.waitSignal(window.loader.idle, timeout=WAIT_MS):
        window.documents.open_paths([record])
    window.refresh.now()


def test_guesses_are_striped_named_and_counted(margin: MainWindow, qtbot: QtBot, run_all: Run) -> None:
    assert not margin.actions_["extrapolate"].isEnabled()
    run_all(margin)
    cell = margin.views.cells["depth-out"]
    margin.feature(StatusFeature).readout.point_at((30, 1))
    assert "out missing" in margin.feature(StatusFeature).bar.readout.text()
    before = margin.workspace.current.completion()
    _extrapolation(margin, qtbot)
    completion = margin.workspace.current.completion()
    assert completion.extrapolated[:3].all()
    np.testing.assert_array_equal(completion.depth[~completion.extrapolated], before.depth[~completion.extrapolated])
    assert cell.picture.stripes.isVisible()
    assert not margin.views.cells["depth-in"].picture.stripes.isVisible()
    assert (cell.view.image.image[completion.extrapolated] == 0).all()
    assert (cell.picture.below.image[completion.extrapolated] > 0).all()
    assert "(extrapolated)" in margin.feature(StatusFeature).bar.readout.text()
    margin.feature(StatusFeature).readout.point_at((30, 10))
    assert "extrapolated" not in margin.feature(StatusFeature).bar.readout.text()
    assert not margin.actions_["extrapolate"].isEnabled()
    margin.cloud.set_colour_by(ColourBy.FILLED)
    margin.centre.show_cloud()
    margin.refresh.now()
    qtbot.waitUntil(lambda: not margin.feature(CloudFeature).busy and len(margin.cloud.canvas.scene) > 0)
    legend = [text for _, text in margin.cloud.canvas.scene.colouring.legend]
    assert legend[-1] == f"{np.count_nonzero(completion.extrapolated)} extrapolated"
    margin.centre.show_images()
    margin.actions_["clear_results"].trigger()
    margin.refresh.now()
    assert not cell.picture.stripes.isVisible()
    assert cell.view.image.image is None


def test_the_progress_of_a_guess_is_shown_while_it_goes_on(margin: MainWindow, qtbot: QtBot, run_all: Run) -> None:
    run_all(margin)
    with qtbot.waitSignal(margin.runs.ended, timeout=WAIT_MS):
        margin.actions_["extrapolate"].trigger()
        margin.refresh.now()
        assert margin.runs.state is RunState.EXTRAPOLATING
        assert margin.feature(StatusFeature).bar.progress.isVisible()
        assert margin.feature(StatusFeature).bar.progress.format() == "Extrapolating"
        assert margin.actions_["cancel"].isEnabled()
        assert not margin.actions_["run"].isEnabled()
    qtbot.waitUntil(lambda: not margin.feature(StatusFeature).bar.progress.isVisible(), timeout=WAIT_MS)


def test_a_dense_export_is_that_of_the_command_line_and_comes_back_dense(
    margin: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], tmp_path: Path
) -> None:
    run_all(margin)
    _extrapolation(margin, qtbot)
    _export(margin, qtbot, tmp_path / "window")
    assert "Extrapolated, not completed by a block" in margin.log.text.toPlainText()
    arguments = ["complete", str(tmp_path / "rim"), "--out", str(tmp_path / "cli"), "--quiet", "--extrapolate"]
    assert command_line([*arguments, "--blocks-margin", "3"]) == 0
    for path in (tmp_path / "cli").iterdir():
        assert path.read_bytes() == (tmp_path / "window" / path.name).read_bytes(), path.name
    _open_run(margin, qtbot, tmp_path / "window" / "run.json")
    assert not reported, "all is as it was recorded"
    with qtbot.waitSignal(margin.runs.finished, timeout=WAIT_MS):
        margin.actions_["run"].trigger()
    assert margin.workspace.current.extrapolated
    assert "the result equals the run record" in margin.log.text.toPlainText()
    assert not reported


def test_what_differs_from_a_record_is_said_when_it_is_opened(
    opened: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], tmp_path: Path
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "out")
    depth = tmp_path / "out" / "depth.png"
    cv2.imwrite(str(depth), cv2.imread(str(depth), cv2.IMREAD_UNCHANGED) + 1)
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    assert len(reported) == 1
    assert "depth.png has changed since the run was written" in reported[0]
    assert "depth.png has changed" in opened.log.text.toPlainText()


def test_an_input_that_was_replaced_is_refused(
    opened: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], frame_folder: Path, tmp_path: Path
) -> None:
    run_all(opened)
    depth = frame_folder / "depth.png"
    cv2.imwrite(str(depth), cv2.imread(str(depth), cv2.IMREAD_UNCHANGED) + 200)
    _export(opened, qtbot, tmp_path / "out")
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    assert "is not the depth file of the recorded run" in reported[0]
    assert not opened.workspace.has_current


def test_a_run_that_does_not_come_out_as_recorded_says_by_how_much(
    opened: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "out")
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    from ilf.completion import block

    honest = block.block_depth
    monkeypatch.setattr(block, "block_depth", lambda *all_of_it: honest(*all_of_it) + np.float32(0.25))
    run_all(opened)
    assert "differs from the recorded one by up to 2.5e-01 m" in reported[-1]


def test_another_run_than_the_recorded_one_is_not_judged(
    opened: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], tmp_path: Path
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "out")
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    opened.workspace.parameters.set(ilf.preset("paper"))
    run_all(opened)
    assert reported == []
    assert "equals the run record" not in opened.log.text.toPlainText()
    opened.workspace.parameters.set(ilf.preset())
    run_all(opened)
    assert opened.log.text.toPlainText().count("the result equals the run record") == 1


def test_a_run_with_other_distrusted_depth_or_drawn_borders_is_not_judged(
    opened: MainWindow, qtbot: QtBot, run_all: Run, reported: list[str], tmp_path: Path
) -> None:
    run_all(opened)
    _export(opened, qtbot, tmp_path / "out")
    _open_run(opened, qtbot, tmp_path / "out" / "run.json")
    document = opened.workspace.current
    mask = np.zeros(document.frame.shape, bool)
    mask[:4, :4] = True
    opened.workspace.current.set_invalid_mask(mask, "Distrust depth")
    run_all(opened)
    document.undo_stack.undo()
    document.change_blocks(drawn=mask)
    run_all(opened)
    assert reported == []
    assert "equals the run record" not in opened.log.text.toPlainText()
