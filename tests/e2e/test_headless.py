"""`ilf-gui FRAME --run --screenshot`: a failure is one line on stderr and a status that is not 0, without a picture."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QSettings, QTimer
from PySide6.QtWidgets import QApplication

from gui.app import start as app
from gui.app.main_window import MainWindow
from gui.base import theme
from gui.features.documents.feature import DocumentsFeature
from gui.work.frame_runs import Work
from ilf import RGBDFrame
from ilf.cli import main as command_line

from .conftest import write_frame

LIMIT_MS = 30_000


@pytest.fixture
def picture(tmp_path):
    return tmp_path / "picture.png"


@pytest.fixture
def start(qtbot, monkeypatch, capsys, picture):
    """Runs the program in this process; gives its exit status and what it said on stderr."""
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)
    monkeypatch.setattr(theme, "apply_theme", lambda *_: None)
    monkeypatch.setattr(theme, "follow_system", lambda *_: None)
    windows: list[MainWindow] = []
    show = MainWindow.show
    monkeypatch.setattr(MainWindow, "show", lambda window: (windows.append(window), show(window)))

    def start(*arguments: object) -> tuple[int, str]:
        hung = []
        limit = QTimer(singleShot=True, interval=LIMIT_MS)
        limit.timeout.connect(lambda: (hung.append(True), QApplication.exit(99)))
        limit.start()
        status = app.main(["--screenshot", str(picture), *map(str, arguments)])
        limit.stop()
        for window in windows:
            qtbot.addWidget(window)
        assert not hung, "the program did not come to an end"
        return status, capsys.readouterr().err

    return start


def refused(outcome: tuple[int, str], picture: Path, *words: str):
    """One line that says what is wrong, status 1, no picture."""
    status, said = outcome
    assert status == 1
    assert not picture.exists()
    assert [line[:16] for line in said.splitlines()] == ["ilf-gui: error: "], said
    for word in words:
        assert word in said


def test_a_run_gives_a_picture_and_status_0(start, frame_folder, picture):
    assert start(frame_folder, "--run", "--size", "900x700") == (0, "")
    assert cv2.imread(str(picture)).shape == (700, 900, 3)


def test_a_frame_of_a_folder_is_named_by_its_key(start, frame_folder, picture):
    assert start(frame_folder.parent, "--frame", frame_folder.name) == (0, "")
    assert picture.exists()


def test_a_run_that_guesses_the_rest_has_its_picture_after_that(start, frame_folder, tmp_path, picture, monkeypatch):
    extrapolate = ["--extrapolate", "--blocks-existence-rate", "0.95", "--out", str(tmp_path / "done"), "--quiet"]
    assert command_line(["complete", str(frame_folder), *extrapolate]) == 0
    extrapolated = []
    take = DocumentsFeature.picture

    def look(self: DocumentsFeature):
        extrapolated.append(self.workspace.current.extrapolated)
        return take(self)

    monkeypatch.setattr(DocumentsFeature, "picture", look)
    status, said = start(tmp_path / "done" / "run.json", "--run")
    assert status == 0
    assert "error" not in said
    assert extrapolated == [True]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the system keeps the settings")
def test_a_picture_leaves_the_settings_as_they_are_and_no_other_user_may_read_them(start, frame_folder):
    settings = Path(QSettings().fileName()).with_name("ilf-studio.ini")
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text("[live]\nfolder=here\n")
    settings.chmod(0o644)
    assert start(frame_folder) == (0, "")
    assert settings.read_text() == "[live]\nfolder=here\n"
    kept = QSettings(str(settings), QSettings.Format.IniFormat)
    kept.setValue("live/folder", "there")
    kept.sync()
    assert stat.S_IMODE(settings.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--run"], ["give a frame"]),
        (["FRAME", "--run", "--intrinsics", "a,b"], ["a,b"]),
        (["EMPTY", "FRAME", "--run"], ["meta.json"]),
    ],
)
def test_what_is_no_frame_to_run(start, frame_folder, tmp_path, picture, arguments, words):
    (tmp_path / "empty").mkdir()
    places = {"FRAME": frame_folder, "EMPTY": tmp_path / "empty"}
    refused(start(*(places.get(word, word) for word in arguments)), picture, *words)


def test_a_truth_that_does_not_fit(start, frame_folder, tmp_path, picture):
    ground_truth = tmp_path / "truth.png"
    cv2.imwrite(str(ground_truth), np.full((48, 64), 30_000, np.uint16))
    refused(start(frame_folder, "--ground-truth", ground_truth), picture, "this ground truth would be", "truth.png")
    with pytest.raises(SystemExit):
        app.main([str(frame_folder), str(tmp_path), "--ground-truth", str(ground_truth)])


@pytest.mark.parametrize("arguments", [("",), ("", "--run"), ("run.json", "--run")])
def test_a_result_whose_frame_is_gone(start, frame_folder, tmp_path, picture, arguments):
    assert command_line(["complete", str(frame_folder), "--out", str(tmp_path / "done"), "--quiet"]) == 0
    (frame_folder / "depth.png").unlink()
    opened, *more = arguments
    refused(start(tmp_path / "done" / opened, *more), picture, "depth.png", "no longer exists")


def test_the_depth_beside_a_colour_file_is_its_own(start, frame_folder, picture):
    assert start(frame_folder / "rgb.png") == (0, "")


def test_a_colour_file_without_its_depth(start, frame_folder, picture):
    (frame_folder / "depth.png").unlink()
    refused(start(frame_folder / "rgb.png", "--run"), picture, "rgb.png", "depth file")


def test_a_frame_without_blocks(start, frame_folder, picture, monkeypatch):
    monkeypatch.setattr("gui.state.frame_data.FrameData.counts", lambda _: {})
    refused(start(frame_folder, "--run"), picture, "two-planes has no blocks")


def test_no_block_that_can_be_completed(start, tmp_path, picture):
    depth = np.full((48, 64), np.nan)
    depth[20, 20:22] = 1.5
    folder = write_frame(tmp_path / "hardly-any", RGBDFrame(np.full((48, 64, 3), 90, np.uint8), depth))
    refused(start(folder, "--run"), picture, "no block could be completed", "2 of")


def test_a_run_that_breaks(start, frame_folder, picture, monkeypatch):
    def broken(*_: object):
        raise MemoryError("no room for the grid")

    monkeypatch.setattr(Work, "due_previews", broken)
    refused(start(frame_folder, "--run"), picture, "The run failed", "no room for the grid")


@pytest.mark.parametrize("name", ["file/picture.png", "."])
def test_a_picture_that_cannot_be_written(start, frame_folder, tmp_path, name):
    (tmp_path / "file").touch()
    status, said = start(frame_folder, "--run", "--screenshot", tmp_path / name)
    assert status == 1
    assert said.startswith("ilf-gui: error: ")
    assert str(tmp_path) in said


def test_the_program_itself(tmp_path):
    """The same in a process of its own: the status arrives, and there is no traceback."""
    root = Path(__file__).resolve().parents[2]
    displays = ("QT_QPA_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY")
    environment = {name: value for name, value in os.environ.items() if name not in displays}
    environment["PYTHONPATH"] = str(root)
    command = [sys.executable, "-m", "gui", str(tmp_path), "--run", "--screenshot", str(tmp_path / "picture.png")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False, timeout=100)
    assert done.returncode == 1
    assert done.stderr.startswith("ilf-gui: error: ")
    assert "meta.json" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "picture.png").exists()
