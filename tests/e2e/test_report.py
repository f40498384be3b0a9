"""Reports out of the real window: the page, the PDF, and an end before either is written."""

import errno
from pathlib import Path
from typing import cast

import numpy as np

import ilf
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Scope, subjects_of
from gui.project.store import WorkStore
from gui.state.workspace import Entry
from ilf.errors import InputError
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary
from ilf.project.state_codec import Decoded
from ilf.report.subject import Unreadable


class Store:
    """A store that has one frame, and one that cannot be read."""

    def has(self, id):
        return True

    def state(self, id):
        if id == "lost":
            raise InputError("depth.png is not there any more.")
        frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), np.full((20, 30), 2.0), name="put away")
        return Decoded(
            FrameState(id, frame, ilf.Blocks(np.ones((20, 30), np.int32)), note="for later"), ("Its names are lost.",)
        )


def test_frames_that_are_not_open_are_read_when_it_is_their_turn():
    places = ("stored", "/a/depth.png", "put away"), ("lost", "/b/depth.png", "gone")
    entries = [Entry(*place, has_state=True) for place in places]
    entries[0].set_summary(FrameSummary(note="for tomorrow"))  # noted since it was stored
    first, second = (read() for read in subjects_of(entries, cast(WorkStore, Store()), ilf.preset("paper")))
    assert (first.note, first.problems) == ("for tomorrow", ("Its names are lost.",))
    assert first.run.parameters == ilf.preset("paper")
    assert not first.completion.results
    assert second == Unreadable("gone", "depth.png is not there any more.")


def test_a_report_is_written_as_page_and_as_pdf_or_not_at_all(opened, qtbot, run_all, tmp_path, monkeypatch):
    part = opened.feature(ExportFeature)
    shown = []
    monkeypatch.setattr(
        "gui.features.export.feature.QDesktopServices.openUrl", lambda url: shown.append(url.toLocalFile())
    )
    dialog, out = part, tmp_path / "out"

    def write(signal):
        with qtbot.waitSignal(signal):
            dialog.begin_export(dialog.request())  # what would be replaced is asked elsewhere
            assert not dialog.export_button.isEnabled()
        return dialog.message.text().replace("\u200b", "")

    monkeypatch.setattr("gui.features.export.feature.ask", lambda *asked: asked[-1](asked[-2][0][0]))
    # extracted only: this frame can be reported on, and it is none that has been worked on
    opened.actions_["report"].trigger()
    assert dialog.scope.currentText() == "This frame: two-planes"
    assert dialog.scope.itemText(dialog.scope.findData(Scope.WORKED_ON)).endswith(": 0")
    assert "two-planes-report.html." in dialog.message.text()
    dialog.widget.close()
    document = opened.workspace.current
    label = next(iter(document.counts()))
    opened.workspace.current.edit_info(label, "Rename", name="Wall <of> stone")
    run_all(opened)
    opened.actions_["report"].trigger()
    dialog.scope.setCurrentIndex(dialog.scope.findData(Scope.WORKED_ON))
    dialog.folder_path.setText(str(out))
    dialog.opens.setChecked(False)
    dialog.hidden.setChecked(True)
    dialog.hold_out.seeds.setValue(2)

    page = out / "report.html"
    assert write(part.requests.ended) == f"Exported to {out}: report.html."
    text = page.read_text(encoding="utf-8")
    assert "Wall &lt;of&gt; stone" in text
    assert "areas; seeds 0, 1" in text
    assert "Run 1" in text  # the kept run
    assert not shown

    opened.actions_["report"].trigger()
    assert dialog.hold_out.seeds.value() == 2, "as it was chosen the last time"
    dialog.opens.setChecked(True)
    dialog.folder_path.setText(str(out))
    dialog.format.setCurrentIndex(dialog.format.findData("pdf"))
    pdf = out / "two-planes-report.pdf"
    write(part.requests.ended)
    content = pdf.read_bytes()
    assert content.startswith(b"%PDF")
    assert content.count(b"/Type /Page\n") >= 2
    assert content.count(b"/Subtype /Image") >= 8
    assert shown == [str(pdf)]

    # cancelled while it is written: what was there stays
    dialog.scope.setCurrentIndex(dialog.scope.findData(Scope.WORKED_ON))
    dialog.format.setCurrentIndex(0)
    with qtbot.waitSignal(part.requests.ended):
        dialog.export_button.click()
        dialog.work.cancel_button.click()
    assert page.read_text(encoding="utf-8") == text
    assert {path.name for path in out.iterdir()} == {"report.html", "two-planes-report.pdf"}

    # what cannot be written is said, what was there stays, and so does the dialog for another try
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    (tmp_path / "file").touch()
    for folder, words in ((tmp_path / "file" / "below", "cannot be created"), (out, "disk is full")):
        dialog.folder_path.setText(str(folder))
        assert words in write(part.requests.ended)
        assert dialog.export_button.isEnabled()
    assert pdf.read_bytes() == content
    assert page.read_text(encoding="utf-8") == text
