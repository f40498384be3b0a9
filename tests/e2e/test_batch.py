"""A batch out of the real window: its frames, what comes of them, an end before all are done, and results that open."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from gui.features.export.feature import ExportFeature
from gui.features.sequence.playing import PlayFeature
from ilf._runtime.formatting import millimetres
from ilf.batch.frame_record import read_frame_record
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_frame
from tests.gui.naming import unnamed
from tests.ilf.batch_frames import work_in_this_process, write_frames


@pytest.fixture
def part(window, qtbot, tmp_path):
    """The window with three frames in its list, of which the second is damaged."""
    source = write_frames(tmp_path / "in", 3)
    (source / "depth" / "0001.png").write_bytes(b"no image")
    with qtbot.waitSignal(window.loader.listed):
        window.documents.open_source(FrameRef(str(source)))
    qtbot.waitUntil(lambda: not window.loader.busy)
    window.workspace.parameters.set(window.workspace.parameters.current.replace(correction=False, max_iterations=5))
    return window.feature(ExportFeature)


def _done(part, qtbot):
    qtbot.waitUntil(lambda: not part.busy)
    return part.message.text().replace("\u200b", "")


def _rows(part):
    rows = [part.results.topLevelItem(number) for number in range(part.results.topLevelItemCount())]
    return {row.text(0): row.text(1) for row in rows}


def _open_row(part, frame):
    (row,) = part.results.findItems(frame, Qt.MatchFlag.MatchExactly)
    part.results.itemActivated.emit(row, 0)


def test_frames_of_the_list_are_completed_and_open(part, window, qtbot, tmp_path, monkeypatch):
    begun = work_in_this_process(monkeypatch)
    window.actions_["batch"].trigger()
    dialog, out = part, tmp_path / "done"
    assert not list(unnamed(dialog.widget))
    assert dialog.scope.currentText() == "All frames of the list: 3"
    dialog.sheet.setChecked(True)
    dialog.folder_path.setText(str(out))
    dialog.export_button.click()
    assert [way.what for way in part.pending_work()] == ["an export of 3 frames"]
    assert _done(part, qtbot).startswith(f"Exported to {out}: 2 written, 1 failed.\nrgb/0001: ")
    assert _rows(part) == {"rgb/0000": "written", "rgb/0001": "failed", "rgb/0002": "written"}
    (row,) = dialog.results.findItems("rgb/0000", Qt.MatchFlag.MatchExactly)
    stated = read_frame_record(out / "rgb__0000").outcome
    assert row.text(2).startswith("Missing ")
    assert f" {millimetres(stated.expected_error_median_m)} mm, {stated.seconds:.1f} s" in row.text(2)
    assert {path.name for path in out.iterdir()} >= {"manifest.csv", "contact-sheet.png", "rgb__0002"}

    first, _, last = window.workspace.entries
    written = window.feature(PlayFeature).written
    assert written.keys() == {first.id, last.id}
    frame = read_frame(first.source)
    assert np.allclose(written[first.id]()[frame.known], frame.depth[frame.known], atol=0.001)

    dialog.export_button.click()  # again: there is nothing left to do
    assert "2 unchanged, 1 failed." in _done(part, qtbot)
    assert begun == ["rgb/0000", "rgb/0001", "rgb/0002"]

    _open_row(part, "rgb/0001")
    assert dialog.message.text().startswith("rgb/\u200b0001: ")
    _open_row(part, "rgb/0002")
    qtbot.waitUntil(lambda: str(out) in str(window.workspace.current.origin))
    assert window.workspace.current.frame.shape == (24, 32)


def test_a_batch_is_cancelled_and_goes_on_other_values_are_refused(part, window, qtbot, tmp_path, monkeypatch):
    begun = work_in_this_process(monkeypatch)
    window.actions_["batch"].trigger()
    dialog = part
    dialog.folder_path.setText(str(tmp_path / "done"))
    dialog.export_button.click()
    qtbot.waitUntil(lambda: bool(_rows(part)))
    dialog.work.cancel_button.click()
    assert "export again to go on" in _done(part, qtbot) or len(_rows(part)) == 3
    qtbot.waitUntil(lambda: (tmp_path / "done" / "manifest.csv").exists())
    dialog.export_button.click()
    assert "1 failed" in _done(part, qtbot)
    assert sorted(set(begun)) == ["rgb/0000", "rgb/0001", "rgb/0002"]

    window.workspace.parameters.set(window.workspace.parameters.current.replace(max_iterations=4))
    window.refresh.now()  # else the dialog, drawn anew, may say again what it would do
    dialog.export_button.click()
    refused = _done(part, qtbot)
    assert "max_iterations: 5, now 4" in refused
    assert "Redo" in refused, "what to do in the window"
    assert "--" not in refused
    assert dialog.message.tone() == "error"
    dialog.anew.setChecked(True)
    dialog.export_button.click()
    assert "1 failed" in _done(part, qtbot)
