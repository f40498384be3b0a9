"""Reports out of the real window: the page, the PDF, and an end before either is written."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.app.main_window import MainWindow
from gui.features.report.feature import ALL_FRAMES, ReportFeature, subjects_of
from gui.project.store import WorkStore
from gui.state.entries import Entry
from ilf.data.blocks import Blocks
from ilf.data.frame import RGBDFrame
from ilf.data.presets import preset
from ilf.errors import InputError
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary
from ilf.project.state_codec import Decoded
from ilf.report.subject import Subject, Unreadable

from .conftest import WAIT_MS


class Store:
    """A store that has one frame, and one that cannot be read."""

    def read(self, id: str) -> Decoded:
        if id == "lost":
            raise InputError("depth.png is not there any more.")
        frame = RGBDFrame(np.zeros((20, 30, 3), np.uint8), np.full((20, 30), 2.0), name="put away")
        return Decoded(
            FrameState(id, frame, Blocks(np.ones((20, 30), np.int32)), note="for later"), ("Its names are lost.",)
        )


def test_frames_that_are_not_open_are_read_when_it_is_their_turn() -> None:
    entries = [Entry("stored", "/a/depth.png", "put away", has_state=True), Entry("lost", "/b/depth.png", "gone")]
    entries[0].set_summary(FrameSummary(note="for tomorrow"))  # noted since it was stored
    first, second = subjects_of(entries, cast(WorkStore, Store()), preset("paper"))
    assert isinstance(first, Subject)
    assert (first.note, first.problems) == ("for tomorrow", ("Its names are lost.",))
    assert first.run.parameters == preset("paper")
    assert not first.completion.results
    assert second == Unreadable("gone", "depth.png is not there any more.")


def test_a_report_is_written_as_page_and_as_pdf_or_not_at_all(
    opened: MainWindow,
    qtbot: QtBot,
    run_all: Callable[[MainWindow], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    part = opened.feature(ReportFeature)
    shown: list[str] = []
    monkeypatch.setattr(
        "gui.features.report.feature.QDesktopServices.openUrl", lambda url: shown.append(url.toLocalFile())
    )
    dialog = part.dialog

    def choose(path: Path) -> None:
        monkeypatch.setattr("gui.features.report.feature.ask_path", lambda *_: str(path))

    # extracted only: this frame can be reported on, and it is none that has been worked on
    opened.actions_["report"].trigger()
    assert "two-planes" in dialog.scope.itemText(0)
    assert dialog.scope.itemText(1).endswith(": 0")
    dialog.close()
    document = opened.workspace.current
    label = next(iter(document.counts()))
    opened.workspace.current.edit_info(label, "Rename", name="Wall <of> stone")
    run_all(opened)
    opened.actions_["report"].trigger()
    dialog.scope.setCurrentIndex(dialog.scope.findData(ALL_FRAMES))
    dialog.opens.setChecked(False)
    dialog.hidden.setChecked(True)
    dialog.seeds.setValue(2)

    page = tmp_path / "page.html"
    choose(page)
    with qtbot.waitSignal(part.worker.finished, timeout=WAIT_MS):
        dialog.write_button.click()
        assert not dialog.write_button.isEnabled()
    text = page.read_text(encoding="utf-8")
    assert "Wall &lt;of&gt; stone" in text
    assert "areas; seeds 0, 1" in text
    assert "Run 1" in text  # the kept run
    assert not dialog.isVisible()
    assert not shown

    opened.actions_["report"].trigger()
    assert dialog.scope.currentData() == ALL_FRAMES, "as it was chosen the last time"
    dialog.opens.setChecked(True)
    pdf = tmp_path / "paper.pdf"
    choose(pdf)
    with qtbot.waitSignal(part.worker.finished, timeout=WAIT_MS):
        dialog.write_button.click()
    content = pdf.read_bytes()
    assert content.startswith(b"%PDF")
    assert content.count(b"/Type /Page\n") >= 2
    assert content.count(b"/Subtype /Image") >= 8
    assert shown == [str(pdf)]

    # closed while it is written: what was there stays
    opened.actions_["report"].trigger()
    choose(page)
    with qtbot.waitSignal(part.worker.cancelled, timeout=WAIT_MS):
        dialog.write_button.click()
        dialog.close()
    assert page.read_text(encoding="utf-8") == text
    assert {path.name for path in tmp_path.iterdir() if path.suffix in (".html", ".pdf")} == {"page.html", "paper.pdf"}

    # what cannot be written is said, what was there stays, and so does the dialog for another try
    opened.actions_["report"].trigger()
    monkeypatch.setattr("gui.widgets.notices.warn", lambda *_: None)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    for path, words in (
        (tmp_path / "nowhere" / "page.html", "folder does not exist"),
        (pdf, "disk is full"),
        (page, "disk is full"),
    ):
        choose(path)
        with qtbot.waitSignal(part.worker.failed, timeout=WAIT_MS):
            dialog.write_button.click()
        assert words in dialog.state.text().replace("\u200b", "")
        assert dialog.write_button.isEnabled()
    assert pdf.read_bytes() == content
    assert page.read_text(encoding="utf-8") == text
