"""Images of two cameras in the window: opened in the depth camera's view, which is shown, and completed there."""

import json

import numpy as np
from pytestqt.qtbot import QtBot

from gui.features.documents.open_dialog import OpenDialog
from gui.project import loading
from ilf.sources.frame_ref import DEPTH_VIEW, FrameRef, ReadingOptions
from ilf.sources.reading import read_frame
from tests.ilf.two_cameras import write_pair

from .conftest import export, in_front, loaded, readout


def _described(dialog: OpenDialog, qtbot: QtBot, text: str) -> None:
    qtbot.waitUntil(lambda: text in dialog.message.text())


def test_the_open_dialog_asks_for_the_view_and_the_window_shows_it(window, qtbot, tmp_path, run_all):
    pair = write_pair(tmp_path / "desk")
    window.actions_["open"].trigger()
    dialog = in_front(window, OpenDialog)
    dialog.set_files(str(tmp_path / "desk"))
    _described(dialog, qtbot, "96 x 72")
    assert "depth camera's view:" not in dialog.message.text()
    dialog.view.setCurrentText("Depth camera")
    _described(dialog, qtbot, "In the depth camera's view: colour was brought into it, and sees")
    assert "64 x 56" in dialog.message.text()
    loaded(window, qtbot, dialog.accept)
    document = window.workspace.current
    assert document.frame.shape == pair.depth.shape
    qtbot.waitUntil(lambda: "desk 1 (depth camera's view)" in window.windowTitle())
    y, x = np.argwhere(~document.frame.brought.seen)[0]
    assert "not seen by colour" in readout(window, (int(x), int(y)))
    run_all(window)
    export(window, qtbot, tmp_path / "out")
    assert np.load(tmp_path / "out/depth.npy").shape == pair.depth.shape
    assert np.load(tmp_path / "out/depth_aligned.npy").shape == pair.rgb.shape[:2]
    assert json.loads((tmp_path / "out/run.json").read_text())["inputs"]["view"] == "depth"


def test_frames_that_are_open_are_read_again_with_other_options(window, qtbot, tmp_path, monkeypatch):
    reads: list[FrameRef] = []
    monkeypatch.setattr(loading, "read_frame", lambda source: reads.append(source) or read_frame(source))
    pair = write_pair(tmp_path / "desk")
    folder, entries = str(tmp_path / "desk"), window.workspace.entries
    for view, shape in ((None, pair.rgb.shape[:2]), (DEPTH_VIEW, pair.depth.shape), (None, pair.rgb.shape[:2])):
        loaded(window, qtbot, window.documents.open_source, FrameRef(folder, options=ReadingOptions(view=view)))
        assert window.workspace.current.frame.shape == shape
        names = [entry.name for entry in entries]
        assert len(names) == len(set(names))
        assert len(reads) == 1
        reads.clear()
    present = window.workspace.current
    loaded(window, qtbot, window.documents.open_source, FrameRef(folder))
    assert window.workspace.current is present, "the same options: nothing is read again"


def test_work_on_frames_is_asked_about_before_they_are_read_again(window, qtbot, tmp_path):
    write_pair(tmp_path / "desk")
    folder = str(tmp_path / "desk")
    loaded(window, qtbot, window.documents.open_source, FrameRef(folder))
    present = window.workspace.current
    asked: list[str] = []
    window.project.ask_remove = lambda entries, then: asked.extend(entry.name for entry in entries)
    loaded(window, qtbot, window.documents.open_source, FrameRef(folder, options=ReadingOptions(view=DEPTH_VIEW)))
    assert asked == [entry.name for entry in window.workspace.entries]
    assert window.workspace.current is present
