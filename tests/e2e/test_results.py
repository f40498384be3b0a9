"""Results that are opened again: the frame that was completed, with the run's blocks, parameters and result."""

import shutil

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

import ilf
from gui.features.documents.open_dialog import OpenDialog
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export, Scope
from gui.views.curves.panel import CurvesPanel
from ilf.cli import main as command_line
from ilf.io.images import read_labels
from ilf.run.options import ExportOptions
from ilf.run.record import read_record
from ilf.sources.frame_ref import FrameRef

from ..ilf.batch_frames import work_in_this_process
from .conftest import answer, loaded, write_frame

NAMES = "far", "near"


@pytest.fixture
def results(small_frame, tmp_path, monkeypatch):
    """The folder of a batch over two frames, in `tmp_path`/frames."""
    work_in_this_process(monkeypatch)
    (tmp_path / "frames").mkdir()
    for number, name in enumerate(NAMES):
        frame = ilf.RGBDFrame(small_frame.rgb, small_frame.depth + np.float32(number), small_frame.intrinsics)
        write_frame(tmp_path / "frames" / name, frame)
    arguments = ["--max-iterations", "30", "--blocks-min-size", "1", "--quiet"]
    assert command_line(["batch", str(tmp_path / "frames"), "--out", str(tmp_path / "out"), *arguments]) == 0
    return tmp_path / "out"


def open_path(window, qtbot, path):
    """Drop a path on the window, and wait."""
    loaded(window, qtbot, window.documents.open_paths, [path])
    window.refresh.now()


def check_result(document, folder):
    """The document is the run whose result is in a folder."""
    record, frame = read_record(folder / "run.json"), ilf.load_frame(folder.parents[1] / "frames" / folder.name)
    np.testing.assert_array_equal(document.frame.depth, frame.depth)
    assert document.frame.missing_share > 0.05
    assert document.state.common == record.parameters
    np.testing.assert_array_equal(document.labels, read_labels(folder / "blocks.png"))
    np.testing.assert_array_equal(document.completion().depth, np.load(folder / "depth.npy"))
    assert not document.changed_blocks()
    assert all(len(document.records_of(one.label)) == one.iterations for one in record.blocks_outcome)


def test_the_results_of_a_batch_are_opened_with_what_they_come_from(window, qtbot, results, reported, run_all):
    open_path(window, qtbot, results)
    check_result(window.workspace.current, results / "far")
    assert window.workspace.parameters.extraction == ilf.BlockParameters(min_size=1.0)
    loaded(window, qtbot, window.actions_["next_frame"].trigger)
    document = window.workspace.current
    check_result(document, results / "near")
    assert not window.actions_["use_neighbours"].isEnabled()
    assert not document.unsaved
    run_all(window)
    assert "near: the result equals the run record." in window.log.text.toPlainText()
    assert not reported


def test_curves_of_a_result_have_iterations_but_no_times(window, qtbot, results, run_all):
    open_path(window, qtbot, results / "far")
    window.panels.reveal("Convergence")
    window.refresh.now()
    panel = window.findChild(CurvesPanel)
    drawn = [line for line in panel.sigma_plot.lines if line.isVisible()]
    assert drawn
    panel.set_by_time(True)
    assert "no times" in panel.hint
    assert not panel.sigma_plot.isVisible()
    run_all(window)
    window.refresh.now()
    assert panel.sigma_plot.isVisible()
    panel.set_by_time(False)


def test_the_dialog_says_what_a_result_is_and_asks_for_no_options(window, qtbot, results):
    window.actions_["open"].trigger()
    dialog = window.findChild(OpenDialog)
    dialog.set_files(str(results / "far"))
    assert dialog.message.text().startswith("A run of far with 2 blocks")
    assert not dialog.encoding.isVisible()
    loaded(window, qtbot, dialog.accept)
    check_result(window.workspace.current, results / "far")
    window.actions_["open"].trigger()
    dialog = window.findChildren(OpenDialog)[-1]
    dialog.set_files(str(results))
    qtbot.waitUntil(lambda: "2 results found" in dialog.message.text())
    assert "missing" in dialog.message.text()
    dialog.reject()


def test_a_frame_that_was_moved_is_asked_for_once(window, qtbot, results, tmp_path, monkeypatch):
    shutil.move(tmp_path / "frames", tmp_path / "moved")
    open_path(window, qtbot, results)
    qtbot.waitUntil(lambda: not window.loader.busy)
    assert window.workspace.shown is None
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "moved"))
    assert str(tmp_path / "frames" / "far" / "rgb.png") in answer(window, "Locate f&older…")
    qtbot.waitUntil(lambda: window.workspace.shown is not None and not window.loader.busy)
    shutil.copytree(tmp_path / "moved", tmp_path / "frames")
    check_result(window.workspace.current, results / "far")
    shutil.rmtree(tmp_path / "frames")
    loaded(window, qtbot, window.actions_["next_frame"].trigger)
    assert window.workspace.current.name == "near"
    assert window.workspace.current.completion() is not None


def test_a_frame_that_has_changed_is_not_taken_for_the_one_that_was_completed(window, qtbot, results, tmp_path):
    depth = tmp_path / "frames" / "far" / "depth.png"
    shutil.copy(tmp_path / "frames" / "near" / "depth.png", depth)
    open_path(window, qtbot, results / "far")
    qtbot.waitUntil(lambda: not window.loader.busy)
    assert f"{depth} has changed" in answer(window, "Cancel")
    assert window.workspace.shown is None


def test_a_result_in_whole_millimetres_is_not_shown_as_it_is_rounded(window, qtbot, results, reported, tmp_path):
    frame = ilf.load_frame(tmp_path / "frames" / "far")
    ilf.complete(frame).save(tmp_path / "png", depth_formats=("png",))
    open_path(window, qtbot, tmp_path / "png")
    assert window.workspace.current.completion() is None
    assert len(window.workspace.current.counts()) > 0
    assert "depth.npy" in reported[0]


def test_reading_options_of_a_result_are_refused(window, qtbot, results):
    far = FrameRef(str(results / "far")).with_options(depth_units=500.0)
    loaded(window, qtbot, window.documents.open_source, far)
    assert window.workspace.shown is None
    assert "Leave the reading options out" in window.log.text.toPlainText()


def test_results_that_were_not_shown_are_exported_as_they_are(window, qtbot, results, tmp_path):
    open_path(window, qtbot, results)
    with qtbot.waitSignal(window.feature(ExportFeature).requests.ended):
        window.feature(ExportFeature).start(Export(tmp_path / "again", ExportOptions(), Scope.ALL))
    for name in ("depth.npy", "run.json"):
        assert (tmp_path / "again" / "near" / name).read_bytes() == (results / "near" / name).read_bytes()
