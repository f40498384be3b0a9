"""Next suspicious place and suggested distrust, through the real window."""

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDockWidget

from gui.features.blocks.feature import BlocksFeature, block_rows
from gui.features.blocks.table import BlockColumn
from gui.features.expected_error import ErrorFeature
from gui.features.frame_list.feature import FramesFeature
from gui.features.quality import QualityPanel
from gui.state.document import Document
from gui.state.results import ErrorEstimate
from ilf.data.frame import RGBDFrame

from ..gui.states import edit
from .conftest import activate, open_frame, settle, write_frame
from .hand import click, key

HEIGHT, WIDTH = 108, 144


def three_walls() -> RGBDFrame:
    """Three walls side by side at 1, 1.5 and 2.2 m, holes across where they meet, and a speckle in the last."""
    columns = np.indices((HEIGHT, WIDTH))[1]
    part = (columns >= 48).astype(int) + (columns >= 96)
    depth = np.array([1.0, 1.5, 2.2])[part]
    depth[12:96, 50:66] = np.nan
    depth[60:96, 90:95] = np.nan
    depth[18:20, 120:122] = 1.1
    return RGBDFrame(np.array([[200, 80, 40], [60, 180, 90], [50, 70, 190]], np.uint8)[part], depth)


def opened_with(window, qtbot, tmp_path, labels: np.ndarray):
    open_frame(window, qtbot, write_frame(tmp_path / "walls", three_walls()))
    window.workspace.current.replace_blocks(labels.astype(np.int32), "Blocks of the test")
    window.refresh.now()


def walls(*limits: int) -> np.ndarray:
    """Blocks 1, 2, ... side by side that end at these columns."""
    return 1 + np.searchsorted(limits, np.indices((HEIGHT, WIDTH))[1], side="right")


def press(window, qtbot, name: str) -> str:
    """Give a command and wait for the position and the message of the strip then."""
    window.actions_[name].trigger()
    return settled(window, qtbot)


def settled(window, qtbot) -> str:
    panel = window.feature(QualityPanel)
    assert panel.widget is not None, "made, though it may be closed"
    settle(window, qtbot)
    return ": ".join(filter(None, (panel.position.text(), panel.reason.text())))


def test_going_through_mending_and_ignoring(window, qtbot, tmp_path):
    opened_with(window, qtbot, tmp_path, walls(WIDTH))
    workspace, panel = window.workspace, window.feature(QualityPanel)
    assert not panel.visible
    assert not window.actions_["ignore_check"].isEnabled()
    assert "2 of 2" in press(window, qtbot, "previous_check")
    assert panel.visible
    assert press(window, qtbot, "next_check") == "1 of 2: Depth jumps by 0.50 m inside Block 1."
    assert workspace.current.selected == [1]
    assert not panel._marks[0].path.isEmpty()
    assert "2 of 2" in press(window, qtbot, "next_check")
    press(window, qtbot, "next_check")

    # what an edit mends is dropped, what undo brings back is there again
    workspace.current.replace_blocks(walls(48, WIDTH).astype(np.int32), "Split")
    assert settled(window, qtbot) == "Fixed. 1 flagged place left to check."
    assert "1 of 1: Depth jumps by 0.70 m inside Block 2." in press(window, qtbot, "next_check")
    assert workspace.current.selected == [2]
    window.actions_["undo"].trigger()
    settled(window, qtbot)
    assert len(window.feature(QualityPanel).review.places) == 2
    window.actions_["redo"].trigger()
    settled(window, qtbot)

    press(window, qtbot, "next_check")
    said = press(window, qtbot, "ignore_check")
    assert said == "No more flagged places. 1 ignored."
    assert not window.actions_["ignore_check"].isEnabled()
    state = workspace.current.snapshot()
    assert Document.of_state(state, None, "again").state.ignored == workspace.current.state.ignored != ()
    workspace.current.replace_blocks(walls(49, WIDTH).astype(np.int32), "Another edit")
    assert settled(window, qtbot) == said, "it stays ignored"
    window.actions_["undo"].trigger()
    settled(window, qtbot)
    window.actions_["undo"].trigger()
    assert settled(window, qtbot) == "1 flagged place left to check.", "ignoring is undone as any step"
    window.actions_["redo"].trigger()
    assert settled(window, qtbot) == said
    workspace.current.replace_blocks(walls(48, 90, WIDTH).astype(np.int32), "An edit there")
    assert settled(window, qtbot) == "1 flagged place left to check.", "it is another place now"
    window.findChild(QDockWidget, "Quality").close()
    assert panel._marks[0].path.isEmpty()
    assert panel.remedy is None


def test_remedies_are_previewed_and_applied_one_after_the_other(window, qtbot, tmp_path):
    opened_with(window, qtbot, tmp_path, walls(WIDTH))
    workspace, checks = window.workspace, window.feature(QualityPanel)
    workspace.current.edit_info(1, "Rename", name="Wall")
    view = window.views.cells["colour"].view

    def enter() -> str:
        view.setFocus()
        QTest.keyClick(view, Qt.Key.Key_Return)
        return settled(window, qtbot)

    steps = workspace.current.undo_stack.count()
    assert enter() == "", "nothing is shown"
    assert press(window, qtbot, "next_check").startswith("1 of 2")
    assert checks.remedy_button.text() == "Split Wall (Enter)"
    assert checks.remedy is not None
    preview = checks._previews[0]
    assert preview.extent is not None

    # while a tool has something to finish, Enter is for the tool, and the button does not promise it
    window.editor.set_tool("smart_select")
    click(window, (60, 54))
    qtbot.waitUntil(lambda: not window.editor.working)
    assert checks.remedy_button.text() == "Split Wall"
    window.editor.set_tool("split")
    assert checks.remedy_button.text() == "Split Wall (Enter)"
    QTest.keyClick(view, Qt.Key.Key_Return)
    assert workspace.current.undo_stack.count() == steps + 1, "Split has no line yet"
    settled(window, qtbot)
    assert window.actions_["undo"].text() == "Undo Split Wall"
    labels = workspace.current.labels
    assert np.mean((labels == labels[0, 0]) == (walls(48, WIDTH) == 1)) > 0.97
    assert "1 of 1" in settled(window, qtbot), "it has gone on to the next place"

    # what is locked has no remedy
    there = checks.review.present.labels[0]
    workspace.current.set_lock(there, True)
    settled(window, qtbot)
    assert checks.remedy_button.text() == "No remedy found"
    assert not window.actions_["apply_remedy"].isEnabled()
    workspace.current.set_lock(there, False)
    settled(window, qtbot)
    window.actions_["apply_remedy"].trigger()
    assert settled(window, qtbot) == "No flagged places."
    assert len(workspace.current.counts()) == 3
    assert checks.remedy is None
    for _ in range(4):
        window.actions_["undo"].trigger()
    assert settled(window, qtbot) == "2 flagged places left to check."


def test_high_expected_error_is_a_place_once_it_is_known(window, qtbot, tmp_path, run_all, monkeypatch):
    opened_with(window, qtbot, tmp_path, walls(48, 96, WIDTH))
    run_all(window)
    assert press(window, qtbot, "next_check") == "No flagged places."
    document = window.workspace.current
    qtbot.waitUntil(lambda: document.expected_error() is not None)  # or it comes after what follows
    error = np.where(document.frame.known, np.float32(np.nan), np.float32(0.3))
    document.store_error_estimate(document.completion(), ErrorEstimate(error, np.zeros(error.shape, bool)))
    settled(window, qtbot)
    first = press(window, qtbot, "next_check")
    assert "Expected error 300 mm" in first
    monkeypatch.setattr(Document, "expected_error", lambda _: None)  # as while an edit is solved
    monkeypatch.setattr(window.feature(ErrorFeature).requests, "ask", lambda *_, **__: None)  # or it is endless
    edit(window.workspace, 1, rows=np.s_[102:], columns=np.s_[138:])
    assert settled(window, qtbot).partition(": ")[2] == first.partition(": ")[2], (
        "high errors of other blocks stay until they are computed again"
    )


def test_suspect_depth_and_blocks_at_a_limit_are_marked(window, qtbot, tmp_path, run_all):
    """A speck in a hole is striped and counted; a block that could not become steady is amber, with its sentence."""
    rows, columns = np.indices((HEIGHT, WIDTH))
    depth = 1 / (1.0 + 0.002 * columns + 0.05 * (rows // 30 % 2))
    hole = (rows - 54) ** 2 + (columns - 72) ** 2 < 30**2
    speck = (rows - 57) ** 2 + (columns - 69) ** 2 < 12
    depth[hole] = np.nan
    depth[speck] = 12.0
    frame = RGBDFrame(np.full((HEIGHT, WIDTH, 3), 120, np.uint8), depth)
    open_frame(window, qtbot, write_frame(tmp_path / "speck", frame))
    workspace = window.workspace
    workspace.current.replace_blocks(np.ones((HEIGHT, WIDTH), np.int32), "One block")
    workspace.parameters.set(workspace.current.state.common.replace(s_criteria=0.0))
    run_all(window)
    outcome = workspace.current.completion().outcomes[1]
    assert outcome.suspect == np.count_nonzero(speck)
    assert np.array_equal(window.views.cells["depth-out"].view.striped["suspect"], speck)
    said = block_rows(workspace.current, window.runs.current)[1][BlockColumn.STATE].hint
    assert (said.splitlines()[0], outcome.message in said) == ("iteration limit", True)
    assert "limit of steps" in said
    assert workspace.current.summary().not_converged == 1


def test_suggested_distrust_is_shown_then_taken_or_left(window, qtbot, tmp_path):
    opened_with(window, qtbot, tmp_path, walls(48, 96, WIDTH))
    panel, document = window.feature(QualityPanel), window.workspace.current
    assert not window.actions_["apply_remedy"].isEnabled()
    for taken in (False, True):
        assert press(window, qtbot, "suggest_invalid").startswith("4 pixels of known depth may be invalid")
        assert "Mark 4 pixels as invalid" in panel.remedy_button.text()
        assert document.frame.invalid_mask is None
        assert press(window, qtbot, "apply_remedy" if taken else "ignore_check") == "No flagged places."
        assert panel.remedy is None
    wrong = np.zeros((HEIGHT, WIDTH), bool)
    wrong[18:20, 120:122] = True
    assert np.array_equal(document.frame.invalid_mask, wrong)
    window.actions_["undo"].trigger()
    assert document.frame.invalid_mask is None
    window.actions_["redo"].trigger()
    assert press(window, qtbot, "suggest_invalid").startswith("No invalid depth found")
    assert panel.remedy is None


def test_places_and_a_suggestion_are_found_at_once_and_another_frame_has_its_own(window, qtbot, tmp_path, frame_folder):
    opened_with(window, qtbot, tmp_path, walls(WIDTH))
    window.actions_["next_check"].trigger()
    window.actions_["suggest_invalid"].trigger()
    assert "may be invalid" in settled(window, qtbot), "what was asked for last"
    panel = window.feature(QualityPanel)
    assert panel.remedy.kind == "invalid"
    assert press(window, qtbot, "next_check").startswith("1 of 2")

    open_frame(window, qtbot, frame_folder)
    assert settled(window, qtbot) == "No flagged places."
    assert panel._marks[0].path.isEmpty()
    window.actions_["close_frame"].trigger()
    window.actions_["close_frame"].trigger()
    assert settled(window, qtbot) == "Open a frame first."


def test_enter_applies_the_remedy_wherever_the_focus_is(window, qtbot, tmp_path, frame_folder):
    open_frame(window, qtbot, frame_folder)
    opened_with(window, qtbot, tmp_path, walls(WIDTH))
    activate(window, qtbot)
    document, table = window.workspace.current, window.feature(BlocksFeature).table
    strip = window.feature(FramesFeature).panel.view

    def in_the_views() -> bool:
        return window.views.isAncestorOf(QApplication.focusWidget())

    for focus in ("film strip", "panels by keys", "closed panel", "layout"):
        (strip if focus == "film strip" else table).setFocus()
        assert press(window, qtbot, "next_check").startswith("1 of 2")
        assert in_the_views()
        if focus == "film strip":
            strip.setFocus()
        elif focus == "panels by keys":
            while in_the_views():
                key(window, Qt.Key.Key_Tab)
        else:
            table.setFocus()
        if focus == "closed panel":
            blocks = next(toggle for toggle in window.panels.toggles() if toggle.text() == "Blocks")
            blocks.trigger()
        elif focus == "layout":
            window.actions_["layout_correct"].trigger()
            assert not window.feature(QualityPanel).visible
            assert press(window, qtbot, "next_check").startswith("1 of 2"), "the place that was left"
        key(window, Qt.Key.Key_Return)
        settled(window, qtbot)
        assert window.workspace.current is document, "no other frame is opened"
        assert document.undo_stack.undoText() == "Split Block 1"
        if focus in ("closed panel", "layout"):
            assert in_the_views()
        if focus == "closed panel":
            blocks.trigger()
        window.actions_["undo"].trigger()
        settled(window, qtbot)
