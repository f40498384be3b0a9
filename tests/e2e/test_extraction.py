"""The stages of the extraction follow its sliders, the blocks follow "Extract blocks", and work by hand stays."""

import gc
import threading
from weakref import ref

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PySide6.QtWidgets import QCheckBox, QLabel, QSlider, QTabWidget

import ilf
from gui.features.export.feature import ExportFeature
from gui.features.extraction import ExtractionPanel
from ilf.drawing.blocks import block_overlay
from ilf.io.block_files import read_blocks
from ilf.segmentation.extraction import Extraction, extract
from ilf.sources.frame_ref import FrameRef

from .conftest import loaded, open_frame, settle, write_frame
from .hand import drag


@pytest.fixture
def staged(opened, qtbot):
    """The window with the small frame and the view of the extraction beside the others."""
    opened.views.sheet.set_layout("grid-extraction")
    settle(opened, qtbot)
    return opened


def _picture(window) -> NDArray[np.uint8] | None:
    return window.views.cells["extraction"].view.shown


def _pictures_given(window, monkeypatch) -> list[tuple[tuple[int, ...], str]]:
    """Sizes and stages of all pictures that the view is given from now on."""
    given: list[tuple[tuple[int, ...], str]] = []
    show = window.views.show_found

    def noted(**found):
        stage = found.get("stage")
        if stage and stage.picture is not None and stage.picture is not window.views.data.stage.picture:
            given.append((stage.picture.shape[:2], stage.name))
        show(**found)

    monkeypatch.setattr(window.views, "show_found", noted)
    return given


def _panel(window) -> ExtractionPanel:
    """The panel, in front of the other tab."""
    tabs = next(tabs for tabs in window.findChildren(QTabWidget) if tabs.tabText(1) == "Extraction")
    tabs.setCurrentIndex(1)
    return window.feature(ExtractionPanel)


def _slide(window, name: str, value: int):
    _panel(window).form.findChild(QSlider, f"slider_{name}").setValue(value)
    window.refresh.now()


def _click(window, text: str):
    box = next(box for box in _panel(window).widget.findChildren(QCheckBox) if box.text() == text)
    box.click()


def _said(window) -> list[str]:
    texts: list[str] = []
    window.notes.show_message = texts.append
    return texts


def _summary(window) -> str:
    panel = _panel(window)
    window.refresh.now()
    return panel.widget.findChild(QLabel, "summary").text()


def _cut_off_by_hand(window) -> int:
    """Paint a new block, named Mine, with a stroke across the block at the right."""
    window.actions_["new_block"].trigger()
    (label,) = window.workspace.current.selected
    window.editor.options.brush_radius = 3.0
    drag(window, [(44, 24), (56, 24)])
    window.workspace.current.edit_info(label, "Rename block", name="Mine")
    return label


def test_a_slider_moves_the_picture_and_not_the_blocks(staged, qtbot):
    document = staged.workspace.current
    before, steps = document.labels.copy(), document.undo_stack.count()
    staged.feature(ExtractionPanel).show_stage("dilated")
    settle(staged, qtbot)
    pictures = []
    for radius in (0, 1, 4):
        _slide(staged, "dilation", radius)
        settle(staged, qtbot)
        pictures.append(_picture(staged))
        assert staged.workspace.parameters.extraction.dilation == radius
    changes = [int((pictures[0] != other).any(axis=2).sum()) for other in pictures]
    assert changes == sorted(set(changes))
    staged.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=48.0, use_depth=False))
    staged.feature(ExtractionPanel).show_stage("blocks")
    settle(staged, qtbot)
    found = extract(document.frame, staged.workspace.parameters.extraction).blocks
    np.testing.assert_array_equal(_picture(staged), block_overlay(document.frame.rgb, found))
    np.testing.assert_array_equal(document.labels, before)
    assert document.undo_stack.count() == steps


@pytest.mark.parametrize("layout", ["grid", "grid-extraction"])
def test_extract_keeps_a_block_made_by_hand_again_and_again(opened, qtbot, layout):
    opened.views.sheet.set_layout(layout)
    document, said = opened.workspace.current, _said(opened)
    mine = _cut_off_by_hand(opened)
    before, steps, used = document.labels.copy(), document.undo_stack.count(), document.blocks.extraction
    stays = before == mine
    assert document.blocks.edited
    for smallest in (48.0, 47.0):
        opened.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=smallest, use_depth=False))
        settle(opened, qtbot)
        opened.actions_["extract"].trigger()
        settle(opened, qtbot)
        np.testing.assert_array_equal(document.labels == mine, stays)
        assert len(document.counts()) == 2, "the block that the stroke cut into is extracted anew"
        assert document.info(mine).name == "Mine"
        assert document.blocks.edited
        assert "Kept: 1 made by hand." in said[-1]
    while document.undo_stack.index() > steps:
        opened.workspace.undo_group.undo()
    np.testing.assert_array_equal(document.labels, before)
    assert document.blocks.extraction == used
    while document.undo_stack.canUndo():
        document.undo_stack.undo()
    assert not document.blocks.edited, "as it was extracted"
    _click(opened, "Keep blocks made by hand")
    opened.actions_["extract"].trigger()
    settle(opened, qtbot)
    assert len(document.counts()) == 1
    assert not document.blocks.edited
    assert "Kept" not in said[-1]


def test_a_loaded_map_is_all_by_hand_and_the_message_says_what_to_do(opened, qtbot, tmp_path):
    document, said = opened.workspace.current, _said(opened)
    cv2.imwrite(str(tmp_path / "labels.png"), np.full(document.frame.shape, 5, np.uint16))
    document.replace_blocks(read_blocks(tmp_path / "labels.png", document.frame.shape).labels, "Load blocks")
    assert document.blocks.edited
    opened.actions_["extract"].trigger()
    settle(opened, qtbot)
    assert (document.labels == 5).all()
    assert "switch off 'Keep blocks made by hand'" in said[-1]


def test_with_the_preview_off_the_view_follows_extract_alone(staged, qtbot):
    document = staged.workspace.current
    before = _picture(staged)
    _click(staged, "Preview")
    staged.workspace.parameters.set_extraction(ilf.BlockParameters(min_size=48.0, use_depth=False))
    settle(staged, qtbot)
    np.testing.assert_array_equal(_picture(staged), before)
    assert "With other parameters" in _summary(staged)
    staged.actions_["extract"].trigger()
    settle(staged, qtbot)
    np.testing.assert_array_equal(_picture(staged), block_overlay(document.frame.rgb, document.labels))
    assert len(document.counts()) == 1
    assert "With other parameters" not in _summary(staged)
    staged.workspace.parameters.set_extraction(ilf.BlockParameters())
    staged.views.sheet.set_layout("grid")
    _click(staged, "Preview")
    assert staged.views.shows("stage"), "switching the preview on shows it"
    settle(staged, qtbot)
    np.testing.assert_array_equal(_picture(staged), before)


def test_the_summary_says_around_which_blocks_the_new_ones_would_lie_and_that_a_network_is_missing(staged, qtbot):
    assert "around" not in _summary(staged)
    mine = _cut_off_by_hand(staged)
    assert "around 1 block made by hand" in _summary(staged)
    staged.workspace.current.set_lock(mine, True)
    assert "around 1 block locked" in _summary(staged)
    staged.workspace.current.set_lock(mine, False)
    _click(staged, "Keep blocks made by hand")
    assert "around" not in _summary(staged)

    said = _said(staged)
    staged.workspace.parameters.set_extraction(ilf.BlockParameters(model="elsewhere"))
    settle(staged, qtbot)
    assert "Canny" in _summary(staged)
    assert "elsewhere" in _summary(staged)
    loaded(staged, qtbot, staged.actions_["extract"].trigger)
    assert "elsewhere" in said[-1]
    staged.views.sheet.set_layout("grid")
    staged.workspace.parameters.set_extraction(ilf.BlockParameters(model="elsewhere", min_size=1.0))
    staged.actions_["extract"].trigger()
    settle(staged, qtbot)
    assert "elsewhere" in said[-1]


@pytest.fixture
def gate(monkeypatch):
    """Previews wait until it is set."""
    opened = threading.Event()

    def waiting(frame: ilf.RGBDFrame, parameters: ilf.BlockParameters) -> Extraction:
        assert opened.wait(20)
        return extract(frame, parameters)

    monkeypatch.setattr("gui.features.extraction.extract", waiting)
    return opened


def test_frames_change_and_close_while_a_preview_is_under_way(staged, qtbot, gate, tmp_path, monkeypatch):
    first = staged.workspace.current.frame
    shown = _pictures_given(staged, monkeypatch)
    folder = write_frame(tmp_path / "other", ilf.RGBDFrame(first.rgb[:40], first.depth[:40]))
    _slide(staged, "dilation", 5)
    assert staged.feature(ExtractionPanel).busy
    open_frame(staged, qtbot, folder)
    second = staged.workspace.current
    gate.set()
    settle(staged, qtbot)
    assert shown
    assert {size for size, _ in shown} == {(40, 64)}, "nothing of the first frame comes after it was left"
    shown.clear()
    gate.clear()
    staged.feature(ExtractionPanel).show_stage("blocks")
    _slide(staged, "dilation", 4)
    staged.workspace.undo_group.undo()
    staged.actions_["close_frame"].trigger()
    staged.refresh.now()
    gate.set()
    settle(staged, qtbot)
    assert second not in staged.workspace.open
    assert shown
    assert {size for size, _ in shown} == {first.shape}
    shown.clear()
    staged.actions_["close_frame"].trigger()
    settle(staged, qtbot)
    assert staged.workspace.shown is None
    assert not shown
    assert _summary(staged) == ""


def test_a_preview_that_fails_says_why_without_a_dialog(staged, qtbot, reported, monkeypatch):
    def broken(*_: object):
        raise MemoryError("no memory for the regions")

    monkeypatch.setattr("gui.features.extraction.extract", broken)
    _slide(staged, "dilation", 5)
    settle(staged, qtbot)
    assert "no memory for the regions" in _summary(staged)
    assert "no memory for the regions" in staged.log.text.toPlainText()
    assert _picture(staged) is None
    assert reported == []
    monkeypatch.undo()
    _slide(staged, "dilation", 4)
    settle(staged, qtbot)
    assert _picture(staged) is not None
    assert "no memory" not in _summary(staged)


@pytest.mark.parametrize("works_meanwhile", [False, True])
def test_a_frame_is_shown_before_its_blocks_are_found(window, qtbot, frame_folder, monkeypatch, works_meanwhile):
    go_on = threading.Event()

    def slow(frame: ilf.RGBDFrame, parameters: ilf.BlockParameters) -> Extraction:
        assert go_on.wait(60)
        return extract(frame, parameters)

    monkeypatch.setattr("gui.project.loading.extract", slow)
    window.loader.open(FrameRef(str(frame_folder)))
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
    window.refresh.now()
    document = window.workspace.current
    assert window.views.cells["colour"].view.shown is not None
    assert (document.counts(), document.unsaved, window.actions_["run_all"].isEnabled()) == ({}, False, False)
    mine = np.zeros(document.labels.shape, np.int32)
    mine[:20] = 7
    if works_meanwhile:
        window.workspace.current.replace_blocks(mine, "Mine")
    loaded(window, qtbot, go_on.set)
    np.testing.assert_array_equal(document.labels > 0, np.ones(document.labels.shape, bool))
    assert document.undo_stack.count() == (2 if works_meanwhile else 0)
    if works_meanwhile:
        document.undo_stack.undo()
        np.testing.assert_array_equal(document.labels, mine)
    else:
        assert not document.blocks.edited
        assert not document.unsaved


def test_a_closed_frame_leaves_memory_though_what_showed_it_is_hidden(staged, qtbot):
    document = staged.workspace.current
    seen = [ref(array) for array in (document.frame.rgb, document.frame.depth)]
    staged.feature(ExportFeature).ask()
    settle(staged, qtbot)
    staged.feature(ExportFeature).widget.reject()
    staged.views.sheet.set_layout("colour")
    settle(staged, qtbot)
    del document
    staged.workspace.remove_entries([staged.workspace.current_entry])
    settle(staged, qtbot)
    gc.collect()
    assert [one() is None for one in seen] == [True, True]
