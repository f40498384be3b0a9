"""The open dialog says what a choice of files is before it is opened."""

import json
import shutil

import cv2
import h5py
import numpy as np
import pytest
from PySide6.QtCore import QMimeData, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from shiboken6 import isValid

from gui.features.documents.frame_files import pair_of
from gui.features.documents.open_dialog import OpenDialog
from gui.widgets.basics import open_once
from gui.work.jobs import stop_workers
from gui.work.latest_request import LatestRequest
from ilf.errors import FormatError
from ilf.sources.reading import read_frame
from tests.ilf.phone_files import write_record3d
from tests.pins.window.hand import dragged


@pytest.fixture
def dialog(qtbot):
    looks = LatestRequest()
    dialog = OpenDialog(looks)
    qtbot.addWidget(dialog)
    dialog.show()
    yield dialog
    dialog.reject()
    assert stop_workers(looks)


@pytest.fixture
def folder(tmp_path):
    """640 x 480 at 2 m in millimetres, a fifth of it missing; without meta.json."""
    depth = np.full((480, 640), 2000, np.uint16)
    depth[:96] = 0
    cv2.imwrite(str(tmp_path / "rgb.png"), np.full((480, 640, 3), 80, np.uint8))
    cv2.imwrite(str(tmp_path / "depth.png"), depth)
    return tmp_path


def test_two_files_beside_a_meta_are_read_as_it_says_and_that_is_said(dialog, folder):
    (folder / "meta.json").write_text(json.dumps({"depth_units_per_m": 500, "K": [525, 525, 320, 240]}))
    dialog.set_files(str(folder / "rgb.png"), str(folder / "depth.png"))
    assert "Median 4.00 m" in dialog.message.text()
    assert "Read from meta.json beside the files: name, depth units, intrinsics." in dialog.message.text()
    dialog.encoding.setCurrentText("1000 (millimetres)")
    dialog.read()
    assert "Median 2.00 m" in dialog.message.text()
    assert "Read from meta.json beside the files: name, intrinsics." in dialog.message.text()


def test_a_file_of_two_cameras_is_a_question_and_an_implausible_camera_a_warning(dialog, folder):
    camera = {"fx": 525.0, "fy": 525.0, "cx": 319.5, "cy": 239.5}
    (folder / "rig.json").write_text(
        json.dumps({"color": camera, "depth": camera | {"fx": 0.8, "fy": 0.9, "cx": 0.5, "cy": 0.5}})
    )
    dialog.set_files(str(folder / "rgb.png"), str(folder / "depth.png"))
    for name, message in (("", "color or depth?"), ("#color", "fx 525"), ("#depth", "0.8 * 640 = 512.0 px")):
        dialog.camera.setEditText(f"{folder / 'rig.json'}{name}")
        dialog.read()
        assert message in dialog.message.text()
        assert dialog.accept_button.isEnabled() == bool(name)
    dialog.camera.setEditText(str(folder / "rig.json"))
    dialog.read()
    dialog.camera.setEditText(dialog.message.text().split()[-1].rstrip("."))
    dialog.read()
    assert "fx 525" in dialog.message.text(), "what it says to write is what it takes"


def test_a_lens_is_undistorted_if_its_file_states_it(dialog, folder):
    lens = {"fx": 525.0, "fy": 525.0, "cx": 319.5, "cy": 239.5}
    (folder / "plain.json").write_text(json.dumps(lens))
    (folder / "lens.json").write_text(json.dumps(lens | {"coeffs": [-0.1, 0.01, 0.0, 0.0]}))
    dialog.set_files(str(folder / "rgb.png"), str(folder / "depth.png"))
    assert not dialog.undistort.isVisible()
    dialog.undistort.click()
    for name, message in (("plain.json", "no lens distortion"), ("lens.json", "fx")):
        dialog.camera.setEditText(str(folder / name))
        dialog.read()
        assert message in dialog.message.text()
    assert dialog.request().options.undistort is True
    dialog.camera.setCurrentIndex(0)
    assert dialog.request().options.undistort is None


def test_a_dataset_is_named_behind_the_depth_file_or_for_a_folder(dialog, folder, qtbot):
    with h5py.File(folder / "take.h5", "w") as file:
        file["near/depth"], file["far/depth"] = np.full((480, 640), 1.5), np.full((480, 640), 2.5)
    path = str(folder / "take.h5")
    dialog.set_files(str(folder / "rgb.png"), path)
    assert "take.h5:/far/depth, or" in dialog.message.text().replace("\u200b", "")
    assert not dialog.accept_button.isEnabled()
    assert not dialog.dataset.isVisible()
    dialog.depth_path.setText(f"{path}:/near/depth")
    dialog.read()
    assert dialog.message.text().startswith("Median 1.50 m")
    assert (dialog.request().depth, dialog.request().options.dataset) == (path, "/near/depth")
    for name in ("rgb/1.png", "rgb/2.png", "depth/1.h5", "depth/2.h5"):
        (folder / "set" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path if name.endswith("h5") else folder / "rgb.png", folder / "set" / name)
    dialog.set_files(str(folder / "set"))
    qtbot.waitUntil(lambda: "first frame cannot be read" in dialog.message.text())
    QTest.keyClicks(dialog.dataset, "/far/depth")
    qtbot.waitUntil(lambda: "First frame:\nMedian 2.50 m" in dialog.message.text())
    assert dialog.request().options.dataset == "/far/depth"


def test_a_fisheye_of_a_data_set_is_undistorted(dialog, folder, qtbot):
    for kind, name in (("images", "rgb.png"), ("depth", "depth.png")):
        (folder / kind).mkdir()
        (folder / name).rename(folder / kind / "0.png")
    frame = {"file_path": "images/0.png", "depth_file_path": "depth/0.png", "transform_matrix": np.eye(4).tolist()}
    lens = {"camera_model": "OPENCV_FISHEYE", "fl_x": 400.0, "fl_y": 400.0, "cx": 320.0, "cy": 240.0, "k1": 0.05}
    (folder / "transforms.json").write_text(json.dumps({**lens, "w": 640, "h": 480, "frames": [frame]}))
    dialog.set_files(str(folder))
    qtbot.waitUntil(lambda: "is a fisheye" in dialog.message.text())
    assert "No intrinsics" in dialog.message.text()
    dialog.undistort.click()
    qtbot.waitUntil(lambda: "Intrinsics: fx" in dialog.message.text())
    assert "fisheye" not in dialog.message.text()


def test_a_guide_is_read_with_the_frame_or_refused(dialog, folder):
    np.save(folder / "wide.npy", np.arange(8.0).reshape(2, 4))
    np.save(folder / "half.npy", np.pad(np.arange(1.0, 11), (0, 2))[:, None].repeat(16, 1))
    dialog.set_files(str(folder / "rgb.png"))
    dialog.guide_path.setText(str(folder / "wide.npy"))
    dialog.read()
    assert not dialog.accept_button.isEnabled()
    assert "another aspect" in dialog.message.text()
    dialog.guide_path.setText(str(folder / "half.npy"))
    dialog.read()
    assert "The guide covers 100 % of the missing pixels." in dialog.message.text()
    dialog.guide_gives.setCurrentText("metric depth")
    guide = read_frame(dialog.request()).guide
    assert (guide.path, guide.gives) == (str(folder / "half.npy"), "metric")


def test_absurd_scale_is_refused_with_the_way_out_and_mends(dialog, folder, qtbot):
    dialog.set_files(str(folder / "rgb.png"))
    dialog.encoding.setCurrentText("1 (metres)")
    assert not dialog.accept_button.isEnabled()
    qtbot.waitUntil(lambda: "2000 m" in dialog.message.text())
    assert dialog.message.tone() == "error"
    assert not dialog.depth_preview.picture.pixmap().isNull()
    dialog.accept()
    assert dialog.isVisible()
    dialog.encoding.setCurrentText("1000 (millimetres)")
    qtbot.waitUntil(dialog.accept_button.isEnabled)


def test_a_file_alone_is_judged_before_its_depth_is_asked_for(dialog, folder):
    (folder / "depth.png").unlink()
    dialog.set_files(str(folder / "rgb.png"))
    assert dialog.message.text() == "Choose the depth file that belongs to this colour image."
    (folder / "notes.txt").write_text("no image")
    dialog.set_files(str(folder / "notes.txt"))
    assert dialog.message.tone() == "error"
    assert "notes.txt" in dialog.message.text()
    assert not dialog.accept_button.isEnabled()


@pytest.mark.parametrize(
    ("colour", "depth"),
    [
        ("rgb.jpg", "depth.png"),
        ("0001.jpg", "0001.png"),
        ("cup.png", "cup_depth.png"),
        ("cup_color.png", "cup_depth.tiff"),
        ("frame-000320.color.jpg", "frame-000320.depth.png"),
        ("rgb/17.png", "depth/17.png"),
    ],
)
def test_partners_are_found_both_ways(tmp_path, colour, depth):
    for name in (colour, depth):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    pair = tmp_path / colour, tmp_path / depth
    assert pair_of(pair[0]) == pair
    if "depth" in pair[1].stem:
        assert pair_of(pair[1]) == pair


@pytest.fixture
def rotated(folder):
    """As SUN RGB-D stores it, and as 7-Scenes marks what is missing."""
    depth = np.tile(np.linspace(1500, 3500, 640).astype(np.uint16), (480, 1)) << 3
    depth[:48] = 65535
    cv2.imwrite(str(folder / "depth.png"), depth)
    return folder


def test_what_is_doubted_is_said_and_done_by_one_click(dialog, rotated):
    dialog.set_files(str(rotated / "rgb.png"))
    assert dialog.message.tone() == "warning"
    assert "most likely sun, with a median of 2.6" in dialog.message.text()
    assert "65535 fills 10.0% of the pixels" in dialog.message.text()
    assert dialog.accept_button.isEnabled(), "it is asked, not decided"
    dialog.apply_button.click()
    assert dialog.message.text().startswith("Median 2.50 m, range 1.50–3.50 m, 640 x 480, 10.0 % missing, sun,")
    assert dialog.message.tone() == "text", "no intrinsics"
    assert not dialog.apply_button.isVisible()
    assert (dialog.request().options.encoding, dialog.request().options.invalid) == ("sun", 65535)


def test_what_is_doubted_is_offered_where_the_scale_is_refused_too(dialog, rotated):
    cv2.imwrite(str(rotated / "depth.png"), np.tile(np.linspace(7000, 8190, 640).astype(np.uint16), (480, 1)) << 3)
    dialog.set_files(str(rotated / "rgb.png"))
    assert "outside 0.1-50 m" in dialog.message.text()
    assert dialog.apply_button.isVisible()
    dialog.apply_button.click()
    assert dialog.accept_button.isEnabled()


@pytest.mark.parametrize(("field", "text"), [("encoding", "suns"), ("invalid", "none"), ("min_confidence", "high")])
def test_what_is_no_encoding_or_number_is_refused(dialog, rotated, field, text):
    dialog.set_files(str(rotated / "rgb.png"))
    (dialog.encoding.setEditText if field == "encoding" else getattr(dialog, field).setText)(text)
    dialog.read()
    assert repr(text) in dialog.message.text()
    assert not dialog.accept_button.isEnabled()
    assert not dialog.apply_button.isVisible()


def test_low_confidence_is_missing_from_the_preview_on(dialog, folder):
    (folder / "meta.json").write_text('{"depth_units_per_m": 1000}')
    levels = np.full((480, 640), 2, np.uint8)
    levels[:200] = 1
    cv2.imwrite(str(folder / "confidence.png"), levels)
    dialog.set_files(str(folder))
    assert "There is a confidence map" in dialog.message.text()
    dialog.min_confidence.setText("2")
    dialog.read()
    assert "below 2 counts as missing" in dialog.message.text()
    assert np.isnan(read_frame(dialog.request()).depth[:200]).all()


@pytest.fixture
def recording(tmp_path):
    """Two frames of a phone, of 8 x 6 pixels in depth."""
    write_record3d(tmp_path / "scan.r3d")
    return tmp_path / "scan.r3d"


def test_the_first_frame_of_a_recording_is_seen_before_it_is_opened(dialog, recording, qtbot):
    dialog.set_files(str(recording))
    assert dialog.accept_button.isEnabled()
    qtbot.waitUntil(lambda: "found. First frame:" in dialog.message.text())
    assert "Median" in dialog.message.text()
    assert not dialog.colour_preview.picture.pixmap().isNull()
    assert not dialog.depth_preview.picture.pixmap().isNull()
    assert not dialog.depth_path.isVisible()
    assert dialog.accept_button.isEnabled()
    dialog.min_confidence.setText("high")
    dialog.read()
    assert not dialog.accept_button.isEnabled()


def test_a_folder_of_frames_is_looked_into_and_an_empty_one_refused(dialog, folder, tmp_path, qtbot):
    for path in [*folder.iterdir()]:
        path.rename(path.with_name(f"1_{path.name}"))
    dialog.set_files(str(folder))
    qtbot.waitUntil(lambda: dialog.message.text().startswith("1 frame found."))
    assert "Median 2.00 m" in dialog.message.text()
    assert dialog.request().rgb == str(folder)
    (tmp_path / "empty").mkdir()
    dialog.set_files(str(tmp_path / "empty"))
    qtbot.waitUntil(lambda: "contains no frames" in dialog.message.text())
    assert dialog.message.tone() == "error"
    assert not dialog.accept_button.isEnabled()
    assert dialog.depth_preview.picture.pixmap().isNull()


def test_a_recording_whose_first_frame_is_damaged_can_be_opened(dialog, recording, qtbot, monkeypatch):
    def damaged(*_: object) -> None:
        raise FormatError("The depth of this frame is damaged.")

    monkeypatch.setattr("gui.features.documents.frame_files.measured_frame", damaged)
    dialog.set_files(str(recording))
    qtbot.waitUntil(lambda: "The first frame cannot be read: The depth of this frame" in dialog.message.text())
    assert dialog.accept_button.isEnabled()


def test_a_dialog_after_another_says_why_a_folder_is_refused(tmp_path, qtbot):
    looks = LatestRequest()
    former = OpenDialog(looks)
    open_once(former)
    former.reject()
    qtbot.waitUntil(lambda: not isValid(former))
    dialog = OpenDialog(looks)
    qtbot.addWidget(dialog)
    (tmp_path / "empty").mkdir()
    dialog.set_files(str(tmp_path / "empty"))
    qtbot.waitUntil(lambda: "contains no frames" in dialog.message.text())
    assert stop_workers(looks)


def test_enter_opens_once_wherever_it_is_pressed_and_before_the_change_is_read(dialog, folder, qtbot):
    opened = []
    dialog.accepted.connect(lambda: opened.append(dialog.request().options.encoding))
    for field in (dialog.encoding, dialog.invalid, dialog.path):
        dialog.setResult(0)
        dialog.show()
        dialog.set_files(str(folder / "rgb.png"), str(folder / "depth.png"))
        dialog.activateWindow()
        dialog.encoding.setEditText("")
        dialog.encoding.setFocus()
        QTest.keyClicks(QApplication.focusWidget(), "500")  # nothing has been read since
        field.setFocus()
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Return)
        qtbot.wait(1)
    assert opened == ["500", "500", "500"]
    dialog.setResult(0)
    dialog.show()
    dialog.path.setText(str(folder / "nothing.png"))
    QTest.keyClick(dialog.path, Qt.Key.Key_Return)
    assert dialog.isVisible()
    assert opened == ["500", "500", "500"]


def _type(dialog, path, qtbot):
    dialog.path.clear()
    QTest.keyClicks(dialog.path, str(path))
    qtbot.waitUntil(dialog.accept_button.isEnabled)


def test_typing_a_colour_file_proposes_the_depth_beside_it_and_depth_its_colour(dialog, folder, tmp_path, qtbot):
    _type(dialog, folder / "rgb.png", qtbot)
    assert dialog.depth_path.text() == str(folder / "depth.png")
    (folder / "other_rgb.png").write_bytes((folder / "rgb.png").read_bytes())
    (folder / "other_depth.png").write_bytes((folder / "depth.png").read_bytes())
    _type(dialog, folder / "other_rgb.png", qtbot)
    assert dialog.depth_path.text() == str(folder / "other_depth.png"), "what was proposed follows the path"
    dialog.depth_path.setText(str(folder / "depth.png"))
    _type(dialog, folder / "other_rgb.png", qtbot)
    assert dialog.depth_path.text() == str(folder / "depth.png"), "what was typed stays"
    dialog.depth_path.clear()
    _type(dialog, folder / "depth.png", qtbot)
    assert (dialog.path.text(), dialog.depth_path.text()) == (str(folder / "rgb.png"), str(folder / "depth.png"))


def test_only_the_options_that_apply_are_there(dialog, folder, recording, tmp_path, qtbot):
    def shown() -> list[bool]:
        fields = dialog.depth_path, dialog.encoding, dialog.camera, dialog.guide_path, dialog.depth_preview
        return [field.isVisible() for field in fields]

    assert shown() == [False, False, False, False, True]
    dialog.set_files(str(folder / "rgb.png"))
    assert shown() == [True, False, False, False, True]
    dialog.more.click()
    assert shown() == [True] * 5
    dialog.set_files(str(recording))
    assert shown() == [False, True, True, False, True]
    (tmp_path / "run.json").write_text("{}")
    dialog.set_files(str(tmp_path / "run.json"))
    assert shown() == [False] * 5
    assert dialog.message.tone() == "error"
    assert "run.json" in dialog.message.text()
    dialog.set_files(str(tmp_path / "none.ilf"))
    assert "none.ilf" in dialog.message.text()
    assert not dialog.accept_button.isEnabled()


def test_what_is_dropped_on_the_dialog_is_chosen(dialog, folder):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(folder / name)) for name in ("depth.png", "rgb.png")])
    for event in (dragged(QDragEnterEvent, data), dragged(QDropEvent, data)):
        QApplication.sendEvent(dialog, event)
        assert event.isAccepted()
    assert dialog.path.text() == str(folder / "rgb.png")
    assert dialog.accept_button.isEnabled()
