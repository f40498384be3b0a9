"""Blocks from and to other programs through the real window."""

from pathlib import Path

import cv2
import numpy as np
from PIL import Image
from PySide6.QtWidgets import QFileDialog

from gui.features.documents.load_blocks import LoadBlocksDialog
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export, Scope
from ilf.io.block_files import read_blocks, write_blocks
from ilf.run.options import ExportOptions


def _dialog(window) -> LoadBlocksDialog:
    window.actions_["load_blocks"].trigger()
    return window.findChild(LoadBlocksDialog)


def _read(dialog: LoadBlocksDialog, qtbot, path: Path):
    dialog.path.setText(str(path))
    dialog.read()
    qtbot.waitUntil(lambda: dialog.message.text() != "Reading…")


def test_blocks_of_another_program_come_in_as_one_step_and_go_out_to_a_third(opened, qtbot, tmp_path, monkeypatch):
    document = opened.workspace.current
    before = document.labels.copy()
    drawn = np.zeros(document.frame.shape, np.int32)
    drawn[5:20, 5:20], drawn[22:28, 5:30] = 4, 7
    write_blocks(tmp_path / "drawn.json", drawn, format="labelme", names={4: "Chair"})

    dialog = _dialog(opened)
    assert not dialog.accept_button.isEnabled()
    cv2.imwrite(str(tmp_path / "labels.png"), np.ones((10, 10), np.uint16))
    _read(dialog, qtbot, tmp_path / "labels.png")
    assert "10 x 10" in dialog.message.text()
    assert not dialog.accept_button.isEnabled()
    _read(dialog, qtbot, tmp_path / "drawn.json")
    assert dialog.message.text().startswith("2 blocks cover 12.2%")
    dialog.fill_gaps.setChecked(True)
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    assert "cover 100.0%" in dialog.message.text()
    np.testing.assert_array_equal(document.labels, before)
    dialog.accept_button.click()

    for label in (4, 7):
        np.testing.assert_array_equal(document.labels == label, drawn == label)
    assert np.all(document.labels > 0)
    assert document.info(4).name == "Chair"
    loaded = document.labels.copy()

    target, asked = tmp_path / "saved.json", []
    target.touch()

    def choose(window, title, path, kinds):
        asked.append(path)
        return (path if asked[1:] else str(tmp_path / "saved")), "COCO, run lengths (*.json)"

    monkeypatch.setattr(QFileDialog, "getSaveFileName", choose)
    opened.actions_["save_blocks"].trigger()
    assert asked[1:] == [str(target)], "it asks before it replaces the file that is there"
    found = read_blocks(target, document.frame.shape)
    np.testing.assert_array_equal(found.labels, loaded)
    assert found.names == {4: "Chair"}
    assert '"counts"' in target.read_text()

    opened.workspace.undo_group.undo()
    np.testing.assert_array_equal(document.labels, before)
    assert document.info(4).name == "Block 4"
    opened.workspace.undo_group.redo()
    np.testing.assert_array_equal(document.labels, loaded)
    assert document.info(4).name == "Chair"


def test_exports_have_the_names_and_colours_of_the_window_and_follow_them(opened, qtbot, tmp_path):
    document, options = opened.workspace.current, ExportOptions(exports=("palette.png", "coco.json"))
    labels, (first, *_) = document.labels, document.counts()
    feature = opened.feature(ExportFeature)
    for name, colour in (("Chair", (1, 2, 3)), ("<b>Table</b>", (250, 0, 9))):
        document.edit_info(first, "Edit", name=name, colour=colour)
        with qtbot.waitSignal(feature.requests.ended):
            feature.start(Export(tmp_path / "out", options, Scope.ALL))
        (folder,) = (tmp_path / "out").iterdir()
        found = read_blocks(folder / "blocks.coco.json", labels.shape)
        np.testing.assert_array_equal(found.labels, labels)
        assert found.names == {first: name}
        with Image.open(folder / "blocks.palette.png") as image:
            np.testing.assert_array_equal(np.asarray(image), labels)
            shown = np.asarray(image.convert("RGB"))
        for label in document.counts():
            assert (shown[labels == label] == document.info(label).colour).all()
    with qtbot.waitSignal(feature.requests.ended):
        feature.start(Export(tmp_path / "out", options, Scope.ALL))
    assert feature.results.topLevelItem(0).text(1) == "unchanged"


def test_what_cannot_be_read_is_said_in_the_dialog_and_nothing_changes(opened, qtbot, tmp_path):
    document = opened.workspace.current
    before = document.labels.copy()
    (tmp_path / "bad.json").write_text('{"shapes": [{"label": "a", "points": [[0, 0], [900, 0], [900, NaN]]}]}')
    masks = tmp_path / "masks"
    masks.mkdir()
    cv2.imwrite(str(masks / "0.png"), np.ones((3, 3), np.uint8))
    dialog = _dialog(opened)
    for path, reason in (
        (tmp_path / "bad.json", "a point that is not finite"),
        (masks, "the mask is 3 x 3"),
        (tmp_path / "gone.png", "there is no such file"),
    ):
        _read(dialog, qtbot, path)
        assert reason in dialog.message.text()
        assert dialog.message.tone() == "error"
        assert not dialog.accept_button.isEnabled()
    # a good file after a bad one, and then given up
    cv2.imwrite(str(masks / "0.png"), np.ones(document.frame.shape, np.uint8))
    _read(dialog, qtbot, masks)
    assert dialog.accept_button.isEnabled()
    dialog.reject()
    np.testing.assert_array_equal(document.labels, before)
    assert document.undo_stack.count() == 0


def test_the_frames_own_files_are_not_written_over(opened, frame_folder, reported):
    content = (frame_folder / "rgb.png").read_bytes()
    assert not opened.documents.save_blocks(str(frame_folder / "rgb.png"))
    assert "rgb.png" in reported[0]
    assert (frame_folder / "rgb.png").read_bytes() == content
    assert not opened.documents.save_blocks(str(frame_folder / "blocks.txt"))
    assert "use .png or .json" in reported[1]
