"""The real window, offscreen, on small frames that are written to files first."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QMessageBox

from gui.app.main_window import MainWindow
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export
from gui.features.status import StatusFeature
from gui.work.frame_runs import RunState
from gui.work.jobs import Worker
from ilf.data.frame import RGBDFrame
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef
from tests.pins import frames


def write_frame(folder: Path, frame: RGBDFrame) -> Path:
    """A frame folder with colour, 16-bit depth in millimetres and meta.json."""
    return frames.write_frame(folder, frame, units=1000)


@pytest.fixture
def frame_folder(tmp_path, small_frame):
    """`small_frame` on disk."""
    return write_frame(tmp_path / "two-planes", small_frame)


@pytest.fixture
def another(shown):
    """Opens empty main windows that ask for nothing when they are closed in the end."""
    made = []

    def new(persistent: bool = False) -> MainWindow:
        window = MainWindow(persistent)
        window.project.discard_silently = True
        made.append(window)
        return shown(window, 1280, 800)

    yield new
    for window in made:
        window.project.discard_silently = True
        window.close()


@pytest.fixture
def window(another):
    """An empty main window, shown."""
    return another()


@pytest.fixture
def opened(window, qtbot, frame_folder):
    """The window with the small frame opened and its blocks extracted."""
    open_frame(window, qtbot, frame_folder)
    return window


@pytest.fixture
def run_all(qtbot):
    """Runs every block and waits for the end."""

    def run(window):
        with qtbot.waitSignal(window.runs.ended):
            window.actions_["run_all"].trigger()
        assert window.runs.state is RunState.IDLE
        window.refresh.now()

    return run


def activate(window, qtbot):
    """Let the window have the keyboard."""
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)


def readout(window, pixel) -> str:
    """Return what is said of the pixel under the pointer."""
    status = window.feature(StatusFeature)
    window.refresh.now()
    window.views.navigation.point_at(pixel)
    return status.bar.readout.text()


def reading(window, qtbot):
    """Context that waits until all frames are read and all blocks extracted."""
    return qtbot.waitSignal(window.loader.busy_changed, check_params_cb=lambda: not window.loader.busy)


def loaded(window, qtbot, do, *what):
    """Do something that opens frames, and wait until they are there."""
    with reading(window, qtbot):
        do(*what)


def open_frame(window, qtbot, *files: Path | str, **how):
    """Open a frame by its folder or its files, and wait until its blocks are there."""
    loaded(window, qtbot, window.loader.open, FrameRef(*map(str, files), **how))
    window.refresh.now()


def settle(window, qtbot):
    """Draw what is stale, and wait until nothing is worked out any more."""

    def rests() -> bool:
        window.refresh.now()  # which may ask for more
        return not any(worker.busy for worker in window.findChildren(Worker))

    qtbot.waitUntil(rests)
    window.refresh.now()


def save(window, qtbot, path: Path, embed: bool | None = None):
    """Save the project to a file, and wait until that is done."""
    done: list[bool] = []
    window.project.saving.save(path, embed, None, done.append)
    qtbot.waitUntil(lambda: bool(done))
    assert done == [True]


def in_front(owner, kind):
    """Return the open dialog of a kind that belongs to a window or a dialog."""
    (found,) = (one for one in owner.findChildren(kind) if one.isVisible())
    return found


def asked(window, qtbot, words: str = "") -> QMessageBox:
    """Wait for a question, with words in it if any are given, and return it."""

    def questions() -> list[QMessageBox]:
        return [box for box in window.findChildren(QMessageBox) if box.isVisible() and words in box.text()]

    qtbot.waitUntil(lambda: bool(questions()))
    return questions()[0]


def answer(owner, button: str) -> str:
    """Press a button of the question that is open, and return what it asks."""
    box = in_front(owner, QMessageBox)
    next(one for one in box.buttons() if one.text() == button).click()
    return box.text()


@pytest.fixture
def reported(window, monkeypatch):
    """Messages that were shown to the user."""
    texts = []
    monkeypatch.setattr(QMessageBox, "open", lambda box: texts.append(box.text()))
    return texts


def export(window, qtbot, folder: Path, options: ExportOptions | None = None):
    """Export the current frame, and wait for the end."""
    with qtbot.waitSignal(window.feature(ExportFeature).requests.ended):
        window.feature(ExportFeature).start(Export(folder, options or ExportOptions()))
